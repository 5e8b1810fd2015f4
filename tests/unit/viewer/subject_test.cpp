// SPDX-License-Identifier: Apache-2.0
#include "apps/viewer/subject.h"

#include <gtest/gtest.h>

#include "apps/shared/pictures.h"
#include "sdk/format/avatar_file.h"
#include "sdk/format/ply.h"
#include "tests/package/tiny_avatar.h"
#include "tests/unit/format/sample_correctives.h"

namespace {

using namespace dpl;

class SubjectTest : public ::testing::Test {
protected:
    ViewedSubject load(const AvatarData& data) { return load(*writeAvatar(data)); }
    ViewedSubject load(const std::vector<uint8_t>& bytes) {
        auto avatar = context_->loadAvatar(bytes);
        EXPECT_TRUE(avatar) << avatar.error().message;
        auto subject = ViewedSubject::of(std::move(*avatar), "tiny.glb");
        EXPECT_TRUE(subject);
        return std::move(*subject);
    }
    static AvatarData tiny() {
        AvatarData data = test::tinyAvatar();
        sortSplats(data);
        return data;
    }
    static Vec3f jointAt(const ViewedSubject& subject, size_t joint) {
        const auto positions = subject.avatar.jointPositions();
        return {(*positions)[3 * joint], (*positions)[3 * joint + 1], (*positions)[3 * joint + 2]};
    }
    static void expectNear(const Vec3f& a, const Vec3f& b) { EXPECT_LT(glm::length(a - b), 1e-5f) << a.x << ' ' << a.y << ' ' << a.z; }

    static Playback at(double timeS) { return {.timeS = timeS}; }

    doppel::Result<doppel::Context> context_ = doppel::Context::create(DPL_RENDERER_SOFTWARE, 1);
};

TEST(RotationOfAngles, turnsAboutXThenYThenZ) {
    const Vec3f turned = rotationOfAngles({90, 90, 90}) * Vec3f(0, 1, 0);  // x: +Z, y: +X, z: +Y
    EXPECT_LT(glm::length(turned - Vec3f(0, 1, 0)), 1e-6f);
    EXPECT_LT(glm::length(rotationOfAngles({90, 0, 0}) * Vec3f(0, 1, 0) - Vec3f(0, 0, 1)), 1e-6f);
    EXPECT_LT(glm::length(rotationOfAngles({90, 90, 0}) * Vec3f(0, 1, 0) - Vec3f(1, 0, 0)), 1e-6f);
}

TEST_F(SubjectTest, playsItsFirstClipAndStandsAside) {
    ViewedSubject subject = load(tiny());
    ASSERT_EQ(subject.clips.size(), 1u);
    ASSERT_EQ(subject.clip, 0u);
    EXPECT_EQ(subject.joints, (std::vector<std::string>{"pelvis", "left_shoulder"}));
    ASSERT_TRUE(subject.pose(at(0.5), 0));  // half way: the root is 0.25 m up
    expectNear(jointAt(subject, 0), {0, 1.25f, 0});
    subject.asideM = -2;
    ASSERT_TRUE(subject.pose(at(1.5), 0));  // the clip repeats after 1 s
    expectNear(jointAt(subject, 0), {-2, 1.25f, 0});
    EXPECT_FLOAT_EQ(float(subject.box().low.x), -2.5f);
    subject.movedM = {0.5f, 3};
    ASSERT_TRUE(subject.pose(at(1.5), 0));
    expectNear(jointAt(subject, 0), {-1.5f, 1.25f, 3});
    EXPECT_FLOAT_EQ(float(subject.box().low.x), -2);
    EXPECT_FLOAT_EQ(float(subject.box().high.z), 3);
}

TEST_F(SubjectTest, theCameraStaysWhereTheScanHasDetails) {
    AvatarData data = tiny();
    ViewedSubject plain = load(data);
    EXPECT_EQ(plain.nearestM({0, 1, 0}, {0, 1, 3}, 1000, 8), 0) << "no map, no limit";
    data.captureMap.sides.assign(data.joints.size() * kCaptureSides, {0.008f, 0.008f, 3});
    std::vector<ViewedSubject> subjects;
    subjects.push_back(std::move(plain));
    subjects.push_back(load(data));
    subjects[0].asideM = -2;
    ASSERT_TRUE(subjects[0].pose(at(0), 0));
    EXPECT_NEAR(nearestM(subjects, {0, 1, 0}, {0, 1, 3}, 1000, 8), 1, 0.02) << "of the avatar that is looked at";
    EXPECT_EQ(nearestM(subjects, {-2, 1, 0}, {0, 1, 3}, 1000, 8), 0);
    EXPECT_EQ(nearestM({}, {0, 1, 0}, {0, 1, 3}, 1000, 8), 0);
}

TEST_F(SubjectTest, anglesByHandTurnAJointOnTopOfTheClip) {
    ViewedSubject subject = load(tiny());
    subject.clip.reset();
    ASSERT_TRUE(subject.pose(at(0.5), 0));
    expectNear(jointAt(subject, 1), {0, 1.25f, 0});
    subject.byHandDeg[0] = {0, 0, 90};  // the shoulder, 0.25 m above, goes to the avatar's right
    ASSERT_TRUE(subject.pose(at(0.5), 0));
    expectNear(jointAt(subject, 1), {-0.25f, 1, 0});
    subject.clip = 0;
    ASSERT_TRUE(subject.pose(at(0), 0));
    expectNear(jointAt(subject, 1), {-0.25f, 1, 0});
    subject.byHandDeg[0] = Vec3f(0);
    ASSERT_TRUE(subject.pose(at(0), 0));
    expectNear(jointAt(subject, 1), {0, 1.25f, 0});
}

TEST_F(SubjectTest, clothesRememberTheClipAsideToo) {
    AvatarData data = test::withCorrectives(tiny(), 3, {.motion = 2});
    data.correctives.motion.movedFromRad = 0.01f, data.correctives.motion.movedToRad = 0.02f;
    ViewedSubject subject = load(data);
    subject.asideM = -2;
    ASSERT_TRUE(subject.pose(at(0.5), 0));
    const auto remembered = subject.avatar.motionState();
    std::vector<float> rotations(8), root(3);
    ASSERT_TRUE(subject.avatar.pose(rotations, root));
    ASSERT_TRUE(subject.avatar.setPose(rotations, root));
    const auto forgotten = subject.avatar.motionState();
    ASSERT_TRUE(remembered && forgotten);
    EXPECT_NE(*remembered, *forgotten);
}

TEST_F(SubjectTest, twoClipsCrossFade) {
    AvatarData data = tiny();
    ClipData high = data.clips[0];
    high.name = "high";
    high.channels.clear();
    high.rootTranslations.assign(2, {0, 1, 0});
    data.clips.push_back(high);
    ViewedSubject subject = load(data);
    const auto heightAt = [&](double nowS) {
        EXPECT_TRUE(subject.pose(at(0), nowS));
        return jointAt(subject, 0).y;
    };
    ASSERT_NEAR(heightAt(10), 1, 1e-5);
    subject.play(1, 20);
    EXPECT_NEAR(heightAt(20), 1, 1e-5);
    EXPECT_NEAR(heightAt(20.15), 1.5, 1e-5);
    EXPECT_NEAR(heightAt(20.3), 2, 1e-5);
    EXPECT_NEAR(heightAt(20.1), 2, 1e-5) << "a fade that has ended stays ended";
    subject.play(std::nullopt, 30);
    EXPECT_NEAR(heightAt(30), 1, 1e-5) << "to the rest pose at once";
    subject.play(1, 30);
    EXPECT_NEAR(heightAt(30.15), 2, 1e-5);
}

TEST_F(SubjectTest, withoutLoopAClipEndsWhereItEnds) {
    ViewedSubject subject = load(tiny());
    ASSERT_TRUE(subject.pose({.timeS = 7.25, .loop = false}, 0));
    expectNear(jointAt(subject, 0), {0, 1.5f, 0});
    ASSERT_TRUE(subject.pose({.timeS = 7.25}, 0));
    expectNear(jointAt(subject, 0), {0, 1.125f, 0});
}

TEST_F(SubjectTest, turnsWhereItStands) {
    ViewedSubject subject = load(tiny());
    subject.clip.reset();
    subject.asideM = 2, subject.turnedDeg = 90;
    ASSERT_TRUE(subject.pose(at(0), 0));
    const auto rows = subject.avatar.transform();
    ASSERT_TRUE(rows);
    expectNear({(*rows)[2], (*rows)[6], (*rows)[10]}, {1, 0, 0});  // +Z goes to +X
    expectNear(jointAt(subject, 1), {2, 1.25f, 0});
    const WorldBox box = subject.box();  // a board across x, seen from its edge
    EXPECT_NEAR(box.low.x, 2, 0.05);
    EXPECT_NEAR(box.high.x, 2, 0.05);
    EXPECT_NEAR(box.high.z, 0.5, 0.05);
}

TEST_F(SubjectTest, anAvatarWithoutClipsRests) {
    AvatarData data = tiny();
    data.clips.clear();
    ViewedSubject subject = load(data);
    EXPECT_TRUE(subject.clips.empty());
    EXPECT_FALSE(subject.clip);
    EXPECT_TRUE(subject.pose(at(3), 0));
    expectNear(jointAt(subject, 0), {0, 1, 0});
}

TEST(PlacesInRow, areApartAndAroundTheOrigin) {
    EXPECT_TRUE(placesInRow(0).empty());
    EXPECT_EQ(placesInRow(1), std::vector<double>{0});
    EXPECT_EQ(placesInRow(2), (std::vector<double>{-0.5, 0.5}));
    EXPECT_EQ(placesInRow(3), (std::vector<double>{-1, 0, 1}));
}

/** --axes is the user's word for the file. It takes the place of what the file states and does not add to it. */
TEST_F(SubjectTest, axesReplaceWhatTheFileStates) {
    StaticSplatData one;
    one.position = {{0, 1, 0}}, one.scaleM = {Vec3f(0.1f)}, one.rotation = {{1, 0, 0, 0}}, one.opacity = {0.9f}, one.sh = {0, 0, 0};
    const auto shown = [&](const char* stated, const char* axes) {  // where the splat's place in the file, (0, 0.75, 0.25), is shown
        ViewedSubject subject = load(*writePly(one, {.axes = stated}));
        subject.upright = uprightFromLoaded(axes, loadedFromFile(subject.axes));
        EXPECT_TRUE(subject.pose(at(0), 0));
        const auto rows = subject.avatar.transform();
        EXPECT_TRUE(rows);
        const Vec3d loaded = loadedFromFile(subject.axes) * Vec3d(0, 0.75, 0.25);
        Vec3f out;
        for (int r = 0; r < 3 && rows; ++r) {
            const float* row = &(*rows)[size_t(4 * r)];
            out[r] = float(row[0] * loaded.x + row[1] * loaded.y + row[2] * loaded.z + row[3]);
        }
        return out;
    };
    expectNear(shown("", ""), {0, 0.75f, 0.25f});
    expectNear(shown("RDF", ""), {0, -0.75f, -0.25f});
    for (const char* stated : {"", "RUB", "RDF", "LDB", "RFU"}) {
        expectNear(shown(stated, "y-up"), {0, 0.75f, 0.25f});
        expectNear(shown(stated, "y-down"), {0, -0.75f, -0.25f});
        expectNear(shown(stated, "z-up"), {0, 0.25f, -0.75f});
    }
}

TEST_F(SubjectTest, theBoxHoldsAllSubjects) {
    EXPECT_GT(boxOf({}).high.y, 1.5) << "an empty viewer shows the place of a person";
    std::vector<ViewedSubject> row;
    row.push_back(load(tiny()));
    row.push_back(load(tiny()));
    row[0].asideM = -0.5, row[1].asideM = 0.5;
    const WorldBox box = boxOf(row);
    EXPECT_FLOAT_EQ(float(box.low.x), -1);
    EXPECT_FLOAT_EQ(float(box.high.x), 1);
    EXPECT_GT(box.high.y, 1);
    row[0].upright = row[1].upright = uprightFromLoaded("y-down", Mat3d(1));
    EXPECT_LT(boxOf(row).high.y, 0) << "upside down";
}

}  // namespace
