// SPDX-License-Identifier: Apache-2.0
// The surface fit on a known subject: the posed, swaying mesh must take the shape in the masks, including a bump.
#include "reconstruction/subject/surface/fit_surface.h"

#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include "reconstruction/subject/surface/mesh_raster.h"
#include "tests/unit/heard_task.h"

namespace dpl {
namespace {

constexpr int kRings = 48, kSides = 48;

/** An upright egg of 1.6 m height and `radius(y, angle)` on two joints: the lower half on the root, the upper on a joint at 0.8 m. */
template <class Radius>
MeshData egg(Radius radius) {
    MeshData m;
    const auto add = [&](double y, double angle, double r) {
        m.restPositions.push_back(Vec3f(float(r * std::sin(angle)), float(y), float(r * std::cos(angle))));
        const float blend = std::min(1.0f, std::max(0.0f, float((y - 0.7) / 0.2)));
        const auto upper = uint8_t(std::lround(255 * blend));
        m.jointIndices.push_back({0, 1, 0, 0});
        m.jointWeights.push_back({uint8_t(255 - upper), upper, 0, 0});
    };
    for (int i = 0; i < kRings; ++i) {
        const double t = 3.14159265358979 * (i + 0.5) / kRings, y = 0.8 - 0.8 * std::cos(t);
        for (int k = 0; k < kSides; ++k) {
            const double angle = 6.283185307179586 * k / kSides;
            add(y, angle, radius(y, angle) * std::sin(t));
        }
    }
    add(0, 0, 0), add(1.6, 0, 0);
    const auto at = [](int i, int k) { return uint32_t(i * kSides + k % kSides); };
    for (int i = 0; i + 1 < kRings; ++i)
        for (int k = 0; k < kSides; ++k) {
            m.triangles.push_back({at(i, k), at(i, k + 1), at(i + 1, k)});
            m.triangles.push_back({at(i + 1, k), at(i, k + 1), at(i + 1, k + 1)});
        }
    const uint32_t low = kRings * kSides, high = low + 1;
    for (int k = 0; k < kSides; ++k)
        m.triangles.push_back({low, at(0, k + 1), at(0, k)}), m.triangles.push_back({high, at(kRings - 1, k), at(kRings - 1, k + 1)});
    return m;
}

std::vector<JointData> joints() {
    return {{"root", -1, {0, 0, 0}, ""}, {"upper", 0, {0, 0.8f, 0}, ""}};
}

MeshData bare() {
    return egg([](double, double) { return 0.22; });
}
/** Wider below, with a bump in front at chest height: a garment and something carried. */
MeshData clothed() {
    return egg([](double y, double angle) {
        const double front = std::exp(-std::pow((y - 1.1) / 0.15, 2) - std::pow(std::remainder(angle, 6.283185307179586) / 0.6, 2));
        return 0.22 + 0.06 * std::exp(-std::pow((y - 0.5) / 0.25, 2)) + 0.15 * front;
    });
}

/** Taller by a hat of up to 18 cm; below 1.25 m nothing differs. */
MeshData hatted() {
    MeshData m = bare();
    for (Vec3f& p : m.restPositions)
        if (p.y > 1.25f) p.y += 0.18f * (p.y - 1.25f) / 0.35f;
    return m;
}

std::vector<SurfaceView> views(int count, const MeshData& truth = clothed()) {
    std::vector<SurfaceView> out;
    Jobs jobs(1);
    for (int i = 0; i < count; ++i) {
        SurfaceView view;
        const double a = 6.283185307179586 * i / count, c = std::cos(a), s = std::sin(a), height = i % 2 ? 1.3 : 0.7;
        view.camera = {160, 220, 200, 200, 80, 110};
        const Vec3d eye(2.4 * s, height, 2.4 * c);
        view.camera.viewFromWorldRotation = glm::transpose(Mat3d(Vec3d(c, 0, -s), Vec3d(0, -1, 0), Vec3d(-s, 0, -c)));
        view.camera.viewFromWorldTranslation = -(view.camera.viewFromWorldRotation * eye);
        view.camera.cy = 110 - 200 * (height - 0.8) / 2.4;  // centres the egg in the picture
        view.pose = Pose::rest(2);
        view.pose.localRotations[1] = glm::angleAxis(0.3f, Vec3f(0, 0, 1));  // bent sideways, and swaying
        view.pose.rootTranslation = {0.004f * float(i % 3 - 1), 0, 0.003f * float(i % 5 - 2)};
        std::vector<Mat3x4f> worldFromRest;
        std::vector<Vec3f> posed;
        const auto rig = joints();
        jointTransforms(rig, view.pose, worldFromRest);
        skin(truth, worldFromRest, jobs, posed);
        const auto image = rasteriseMesh(posed, truth.triangles, view.camera);
        view.mask = {160, 220, std::vector<uint8_t>(160 * 220, 0)};
        for (size_t k = 0; k < image.triangle.size(); ++k) view.mask.pixels[k] = image.triangle[k] != kNoTriangle ? 255 : 0;
        out.push_back(std::move(view));
    }
    return out;
}

TEST(FitSurface, fillsTheMasksAndFindsTheTrueShape) {
    const auto shots = views(24);
    const auto rig = joints();
    Jobs jobs(2);
    const MeshData mesh = bare();
    const auto fit = fitSurface(mesh, rig, shots, {}, jobs);
    ASSERT_TRUE(fit) << fit.error().message;
    EXPECT_LT(fit->meanIouBefore, 0.9);
    EXPECT_GT(fit->meanIouAfter, 0.98);  // one pixel of outline is 1 % of this area
    // Radial distance to the truth, ring by ring: the same mesh layout, so the offset is the difference of radii.
    const MeshData truth = clothed();
    double worst = 0, mean = 0;
    for (size_t v = 0; v < mesh.restPositions.size(); ++v) {
        const Vec3f got = mesh.restPositions[v] + fit->restOffsets[v];
        float nearest = 1e9f;  // to the true surface, by its vertices: they are 3 cm apart
        for (const Vec3f& p : truth.restPositions) nearest = std::min(nearest, glm::length(p - got));
        worst = std::max(worst, double(nearest));
        mean += nearest / double(mesh.restPositions.size());
    }
    EXPECT_LT(mean, 0.012);
    EXPECT_LT(worst, 0.05);
    EXPECT_GT(fit->largestOffsetM, 0.1) << "the bump of 15 cm is reached";
}

/** Lets every view mark where the true vertex is, whether or not it sees it. */
void mark(std::vector<SurfaceView>& views, const MeshData& truth, uint32_t vertex) {
    Jobs jobs(1);
    for (SurfaceView& view : views) {
        std::vector<Mat3x4f> worldFromRest;
        std::vector<Vec3f> posed;
        jointTransforms(joints(), view.pose, worldFromRest);
        skin(truth, worldFromRest, jobs, posed);
        view.marks.push_back({{{vertex, 1.0f}}, Vec3f(0), view.camera.pixelOf(view.camera.toView(Vec3d(posed[vertex]))), 1});
    }
}

TEST(FitSurface, marksKeepTheFaceFromSlidingBelowAHat) {
    const MeshData mesh = bare(), truth = hatted();
    const uint32_t eye = 32 * kSides;  // in front, 1.2 m up
    ASSERT_LT(mesh.restPositions[eye].y, 1.25f);
    ASSERT_GT(mesh.restPositions[eye].y, 1.15f);
    const auto rig = joints();
    Jobs jobs(2);
    auto shots = views(24, truth);
    const auto slides = fitSurface(mesh, rig, shots, {}, jobs);
    mark(shots, truth, eye);
    const auto held = fitSurface(mesh, rig, shots, {}, jobs);
    ASSERT_TRUE(slides && held);
    EXPECT_GT(glm::length(slides->restOffsets[eye]), 0.020f) << "else this test shows nothing";
    EXPECT_LT(glm::length(held->restOffsets[eye]), 0.008f);
    EXPECT_GT(held->meanIouAfter, slides->meanIouAfter - 0.001) << "the outline is filled as well as without marks";
}

TEST(FitSurface, marksOfTheFarSideAndMistakesMoveNothing) {
    const MeshData mesh = clothed();
    const auto rig = joints();
    Jobs jobs(2);
    auto shots = views(12);
    mark(shots, mesh, 32 * kSides);
    for (SurfaceView& view : shots) {
        const Vec3d front = glm::transpose(view.camera.viewFromWorldRotation) * Vec3d(0, 0, -1);
        if (front.z < -0.3) view.marks.front().px += Vec2d(9, -7);  // seen from behind, so the network guesses
        if (front.z > 0.3) view.marks.front().px += Vec2d(0, 60);   // 70 cm off
    }
    const auto fit = fitSurface(mesh, rig, shots, {}, jobs);
    ASSERT_TRUE(fit) << fit.error().message;
    EXPECT_LT(fit->largestOffsetM, 0.001);
}

TEST(FitSurface, refusesMarksOnVerticesThatAreNotThere) {
    auto shots = views(2);
    const MeshData mesh = bare();
    const auto rig = joints();
    Jobs jobs(1);
    mark(shots, mesh, 5);
    shots[1].marks[0].vertices = {{uint32_t(mesh.restPositions.size()), 1.0f}};
    const auto refused = fitSurface(mesh, rig, shots, {}, jobs);
    ASSERT_FALSE(refused);
    EXPECT_NE(refused.error().message.find("view 1"), std::string::npos) << refused.error().message;
}

TEST(FitSurface, sameBytesOnAnyNumberOfThreads) {
    const auto shots = views(6);
    const auto rig = joints();
    SurfaceFitSettings few;
    few.levels = 2, few.roundsPerLevel = 2;
    Jobs one(1), three(3);
    const auto a = fitSurface(bare(), rig, shots, few, one), b = fitSurface(bare(), rig, shots, few, three);
    ASSERT_TRUE(a && b);
    EXPECT_TRUE(a->restOffsets == b->restOffsets);
}

TEST(FitSurface, aMeshThatFitsAlreadyStaysPut) {
    const auto shots = views(12);
    const auto rig = joints();
    Jobs jobs(2);
    const auto fit = fitSurface(clothed(), rig, shots, {}, jobs);
    ASSERT_TRUE(fit) << fit.error().message;
    EXPECT_DOUBLE_EQ(fit->meanIouBefore, 1);
    EXPECT_EQ(fit->largestOffsetM, 0);
}

TEST(FitSurface, refusesWhatCannotBeFitted) {
    auto shots = views(2);
    const auto rig = joints();
    Jobs jobs(1);
    EXPECT_FALSE(fitSurface(bare(), rig, {}, {}, jobs));
    EXPECT_FALSE(fitSurface(MeshData{}, rig, shots, {}, jobs));
    MeshData nan = bare();
    nan.restPositions[7].y = std::numeric_limits<float>::quiet_NaN();
    EXPECT_FALSE(fitSurface(nan, rig, shots, {}, jobs));
    MeshData unskinned = bare();
    unskinned.jointWeights.clear();
    const auto refused = fitSurface(unskinned, rig, shots, {}, jobs);
    ASSERT_FALSE(refused);
    EXPECT_NE(refused.error().message.find("skin weights"), std::string::npos);
    auto wrongSize = shots;
    wrongSize[1].mask.pixels.pop_back();
    EXPECT_FALSE(fitSurface(bare(), rig, wrongSize, {}, jobs));
    auto badPose = shots;
    badPose[0].pose.localRotations[0] = Quatf(0, 0, 0, 0);
    EXPECT_FALSE(fitSurface(bare(), rig, badPose, {}, jobs));
    for (auto& s : shots) std::fill(s.mask.pixels.begin(), s.mask.pixels.end(), 0);
    const auto empty = fitSurface(bare(), rig, shots, {}, jobs);
    ASSERT_FALSE(empty);
    EXPECT_EQ(empty.error().code, Code::CorruptData);
    test::HeardTask cancelled(1);
    const TaskScope scope(&cancelled);
    const auto stopped = fitSurface(bare(), rig, views(2), {}, jobs);
    ASSERT_FALSE(stopped);
    EXPECT_EQ(stopped.error().code, Code::Cancelled);
}

}  // namespace
}  // namespace dpl
