// SPDX-License-Identifier: Apache-2.0
// The coach on the procedural subject, filmed well but for one thing: that thing comes first.
#include "reconstruction/judging/coach/shots.h"

#include <cmath>
#include <memory>
#include <numbers>

#include <gtest/gtest.h>
#include <opencv2/imgproc.hpp>

#include "reconstruction/judging/coach/imagined_shots.h"
#include "reconstruction/subject/body/fit_body.h"
#include "reconstruction/subject/sample/raycast.h"
#include "reconstruction/subject/sample/scan_plan.h"
#include "reconstruction/subject/sample/skinning.h"
#include "tests/unit/must.h"

namespace dpl {
namespace {

struct Shown {
    FrameKind kind = FrameKind::StaticFull;
    std::string closeUpOf;
    double azimuthDeg = 0;
    Camerad camera;
    Pose pose;
    FramePicture picture;
};

/** The subject and its still pictures, drawn once for all tests: 24 full-body pictures and 24 close-ups of 189 × 252 pixels. */
class Coach : public testing::Test {
protected:
    static void SetUpTestSuite() {
        jobs_ = std::make_unique<Jobs>();
        subject_ = std::make_unique<Subject>(makeSubject(1, *jobs_));
        SampleScanOptions options = SampleScanOptions::small();
        options.closeupFrames = 24, options.dynamicFrames = 0, options.samplesPerPixel = 4;
        const std::vector<PlannedFrame> plan = planScan(*subject_, options);
        stills_.resize(plan.size());
        std::vector<std::unique_ptr<PersonTracer>> tracers(jobs_->threadCount());
        jobs_->forBlocks(plan.size(), [&](size_t i, uint32_t worker) {
            if (!tracers[worker]) tracers[worker] = std::make_unique<PersonTracer>(*subject_);
            const PlannedFrame& frame = plan[i];
            tracers[worker]->setVertices(poseSubject(*subject_, frame.pose, nullptr));
            RaycastFrame drawn = tracers[worker]->render(frame.camera, {.samplesPerPixel = 4, .seed = i + 1});
            const Vec3d eye = frame.camera.eye();
            const uint32_t w = frame.camera.widthPx, h = frame.camera.heightPx;
            stills_[i] = {frame.kind,   frame.closeupOf,    std::atan2(eye.x, eye.z) * 180 / std::numbers::pi,
                          frame.camera, poseOf(frame.pose), {{w, h, std::move(drawn.rgb)}, {w, h, std::move(drawn.mask)}, {}}};
        });
        places_ = placesOf(subject_->joints, subject_->mesh);
    }
    static void TearDownTestSuite() { stills_.clear(), subject_.reset(), jobs_.reset(); }

    static std::vector<PosedPicture> pictures(const std::vector<Shown>& of, const std::function<bool(const Shown&)>& keep) {
        std::vector<PosedPicture> out;
        for (const Shown& s : of)
            if (keep(s))
                out.push_back({std::make_shared<const FramePicture>(s.picture), s.camera, s.pose, s.kind == FrameKind::StaticCloseup});
        return out;
    }
    static std::vector<SeenTriangle> mapOf(const std::vector<PosedPicture>& of) {
        return must(mapBody(subject_->mesh, subject_->joints, of, *jobs_));
    }
    static FilmAgain advise(const std::vector<PosedPicture>& of) {
        return bestShots(subject_->mesh, subject_->joints, places_, mapOf(of), of, *jobs_);
    }
    static std::vector<Shown> blurred(const std::function<bool(const Shown&)>& which, double sigmaPx) {
        std::vector<Shown> out = stills_;
        for (Shown& s : out) {
            if (!which(s)) continue;
            cv::Mat rgb(int(s.picture.image.heightPx), int(s.picture.image.widthPx), CV_8UC3, s.picture.image.pixels.data());
            cv::GaussianBlur(rgb, rgb, {}, sigmaPx);
        }
        return out;
    }
    static bool all(const Shown&) { return true; }
    static std::string told(const FilmAgain& advice) { return describeShots(advice); }

    static std::unique_ptr<Jobs> jobs_;
    static std::unique_ptr<Subject> subject_;
    static std::vector<Shown> stills_;
    static std::vector<BodyPlace> places_;
};
std::unique_ptr<Jobs> Coach::jobs_;
std::unique_ptr<Subject> Coach::subject_;
std::vector<Shown> Coach::stills_;
std::vector<BodyPlace> Coach::places_;

TEST_F(Coach, withoutCloseUpsOfTheHandsAsksForTheHands) {
    const FilmAgain advice = advise(pictures(stills_, [](const Shown& s) { return !s.closeUpOf.starts_with("hand"); }));
    ASSERT_GE(advice.shots.size(), 2u) << told(advice);
    EXPECT_NE(advice.shots[0].key.find("_hand"), std::string::npos) << told(advice);
    EXPECT_NE(advice.shots[1].key.find("_hand"), std::string::npos) << told(advice);
    EXPECT_NE(advice.shots[0].key, advice.shots[1].key);
    EXPECT_NE(advice.shots[0].sentence.find("mm a pixel; "), std::string::npos) << told(advice);
}

TEST_F(Coach, withoutTheLeftSideOfTheWalkAsksForIt) {
    const FilmAgain advice =
        advise(pictures(stills_, [](const Shown& s) { return s.kind != FrameKind::StaticFull || std::abs(s.azimuthDeg - 90) > 65; }));
    ASSERT_FALSE(advice.shots.empty());
    EXPECT_EQ(advice.shots[0].key, "walk left") << told(advice);
}

TEST_F(Coach, withABlurredWalkAsksForTheWalkAgain) {
    const std::vector<Shown> soft = blurred([](const Shown& s) { return s.kind == FrameKind::StaticFull; }, 3);
    const FilmAgain advice = advise(pictures(soft, all));
    ASSERT_FALSE(advice.shots.empty());
    EXPECT_EQ(advice.shots[0].key, "walk around") << told(advice);
    EXPECT_NE(advice.shots[0].sentence.find("slower or in more light"), std::string::npos) << told(advice);
}

TEST_F(Coach, withBlurredCloseUpsOfTheFaceAsksForTheFace) {
    const std::vector<Shown> soft = blurred([](const Shown& s) { return s.closeUpOf == "face" || s.closeUpOf == "logo"; }, 4);
    const FilmAgain advice = advise(pictures(soft, all));
    ASSERT_FALSE(advice.shots.empty());
    EXPECT_EQ(advice.shots[0].key, "closeup face") << told(advice);
}

TEST_F(Coach, aShotThatWasAskedForRaisesTheMapThereAndLowersItNowhere) {
    std::vector<PosedPicture> some = pictures(stills_, [](const Shown& s) { return !s.closeUpOf.starts_with("hand"); });
    const std::vector<SeenTriangle> before = mapOf(some);
    const FilmAgain advice = bestShots(subject_->mesh, subject_->joints, places_, before, some, *jobs_);
    ASSERT_FALSE(advice.shots.empty());
    std::vector<ImaginedShot> imagined = imagineShots(subject_->mesh, subject_->joints, places_, some, *jobs_);
    const auto asked =
        std::find_if(imagined.begin(), imagined.end(), [&](const ImaginedShot& shot) { return shot.key == advice.shots[0].key; });
    ASSERT_NE(asked, imagined.end());
    std::vector<Shown> taken;  // the shot is taken: its pictures are drawn and measured like the others
    PersonTracer tracer(*subject_);
    tracer.setVertices(poseSubject(*subject_, staticPose(1, 0), nullptr));
    for (const Camerad& camera : asked->cameras) {
        RaycastFrame drawn = tracer.render(camera, {.samplesPerPixel = 4, .seed = 99});
        taken.push_back({FrameKind::StaticCloseup,
                         "",
                         0,
                         camera,
                         poseOf(staticPose(1, 0)),
                         {{camera.widthPx, camera.heightPx, drawn.rgb}, {camera.widthPx, camera.heightPx, drawn.mask}, {}}});
    }
    for (const PosedPicture& picture : pictures(taken, all)) some.push_back(picture);
    const std::vector<SeenTriangle> after = mapOf(some);
    double halvings = 0, area = 0;
    for (size_t t = 0; t < after.size(); ++t) {
        EXPECT_GE(after[t].views, before[t].views);
        EXPECT_TRUE(!before[t].seen() || after[t].detailM <= before[t].detailM);
        if (!before[t].seen() || !(asked->pixelM[t] > 0) || std::find(asked->of.begin(), asked->of.end(), places_[t]) == asked->of.end())
            continue;
        halvings += std::log2(before[t].detailM / after[t].detailM), area += 1;
    }
    EXPECT_GT(area, 100);
    EXPECT_GT(halvings / area, 1) << "on the hand";
    const FilmAgain next = bestShots(subject_->mesh, subject_->joints, places_, after, some, *jobs_);
    for (const Shot& shot : next.shots) EXPECT_NE(shot.key, asked->key) << "it was just filmed\n" << told(next);
}

/** The same pictures in a world of another up, origin and unit, with the body fitted there: metres_B = turn · metres_A + shift. */
std::vector<Shown> inWorld(std::vector<Shown> stills, const Vec3f& restOfRoot, const Quatd& turn, const Vec3d& shift,
                           double metresPerUnit) {
    for (Shown& s : stills) {
        Camerad& camera = s.camera;  // of the scan: its translation is in units
        camera.viewFromWorldRotation = camera.viewFromWorldRotation * glm::mat3_cast(glm::conjugate(turn));
        camera.viewFromWorldTranslation = (camera.viewFromWorldTranslation - camera.viewFromWorldRotation * shift) / metresPerUnit;
        camera = metricCamera(camera, metresPerUnit);
        const Vec3d root = turn * Vec3d(restOfRoot + s.pose.rootTranslation) + shift;
        s.pose.localRotations[0] = Quatf(turn) * s.pose.localRotations[0];
        s.pose.rootTranslation = Vec3f(root) - restOfRoot;
    }
    return stills;
}

TEST_F(Coach, adviceIsThePersonsInAnyWorld) {
    const auto leftMissing = [](const Shown& s) { return s.kind != FrameKind::StaticFull || std::abs(s.azimuthDeg - 90) > 65; };
    const auto farAndBare = [](const Shown& s) { return s.kind == FrameKind::StaticFull; };
    const Quatd turns[] = {glm::angleAxis(std::numbers::pi, Vec3d(1, 0, 0)), glm::angleAxis(0.5 * std::numbers::pi, Vec3d(1, 0, 0)),
                           glm::angleAxis(2.1, glm::normalize(Vec3d(0.3, -0.8, 0.5)))};
    for (const std::function<bool(const Shown&)>& keep : {std::function<bool(const Shown&)>(leftMissing), {farAndBare}}) {
        const FilmAgain upright = advise(pictures(stills_, keep));
        ASSERT_FALSE(upright.shots.empty());
        for (const Quatd& turn : turns) {
            const auto turned = inWorld(stills_, subject_->joints[0].restPosition, turn, {0.4, -1.3, 2}, 1 / 3.0);
            const FilmAgain advice = advise(pictures(turned, keep));
            EXPECT_EQ(told(advice), told(upright));
            for (size_t i = 0; i < std::min(advice.shots.size(), upright.shots.size()); ++i)
                EXPECT_NEAR(advice.shots[i].gain / upright.shots[i].gain, 1, 0.02);  // floats hide other triangles at outlines
        }
    }
}

/** Hips of many fits lean by up to 14°, and what hangs on them leans back. */
TEST_F(Coach, leaningHipsTiltNoShot) {
    std::vector<PosedPicture> some = pictures(stills_, all);
    const Quatf lean = glm::angleAxis(0.24f, Vec3f(1, 0, 0));
    for (PosedPicture& p : some) {
        p.pose.localRotations[0] = p.pose.localRotations[0] * lean;
        for (size_t j = 1; j < subject_->joints.size(); ++j)
            if (subject_->joints[j].parent == 0) p.pose.localRotations[j] = glm::conjugate(lean) * p.pose.localRotations[j];
    }
    const std::vector<ImaginedShot> shots = imagineShots(subject_->mesh, subject_->joints, places_, some, *jobs_);
    const auto chest = std::find_if(shots.begin(), shots.end(), [](const ImaginedShot& shot) { return shot.key == "closeup chest"; });
    ASSERT_NE(chest, shots.end());
    const Vec3d back = -(glm::transpose(chest->cameras[2].viewFromWorldRotation) * Vec3d(0, 0, 1));
    EXPECT_NEAR(std::asin(back.y) * 180 / std::numbers::pi, 5, 4) << "the chest is filmed from 5 degrees above it";
}

TEST_F(Coach, tellsLeftFromRightAndEveryTriangleHasAPlace) {
    const std::vector<Vec3f> normals = restNormals(subject_->mesh);
    std::array<double, kBodyPlaces> x{}, y{}, count{};
    for (size_t t = 0; t < places_.size(); ++t) {
        const Vec3f& p = subject_->mesh.restPositions[subject_->mesh.triangles[t].x];
        x[size_t(places_[t])] += double(p.x), y[size_t(places_[t])] += double(p.y), count[size_t(places_[t])] += 1;
    }
    for (size_t p = 0; p < kBodyPlaces; ++p) EXPECT_GT(count[p], 10) << wordsOf(BodyPlace(p)).name;
    const auto meanX = [&](BodyPlace p) { return x[size_t(p)] / count[size_t(p)]; };
    EXPECT_GT(meanX(BodyPlace::LeftHand), 0.2);
    EXPECT_LT(meanX(BodyPlace::RightHand), -0.2);
    EXPECT_GT(meanX(BodyPlace::LeftFoot), 0.03);
    EXPECT_LT(meanX(BodyPlace::RightFoot), -0.03);
    EXPECT_GT(y[size_t(BodyPlace::Face)] / count[size_t(BodyPlace::Face)], 1.3);
    EXPECT_LT(y[size_t(BodyPlace::LeftFoot)] / count[size_t(BodyPlace::LeftFoot)], 0.2);
}

TEST_F(Coach, withoutFullBodyPicturesImaginesNothing) {
    const FilmAgain advice = advise(pictures(stills_, [](const Shown& s) { return s.closeUpOf == "face"; }));
    EXPECT_TRUE(advice.shots.empty());
}

}  // namespace
}  // namespace dpl
