// SPDX-License-Identifier: Apache-2.0
// A fault gives the same code and the same sentence on the CPU renderer and on the GPU renderer (null backend).
#include <gtest/gtest.h>

#include <array>
#include <cmath>

#include "sdk/backend/null/null_backend.h"
#include "sdk/render/gpu_renderer.h"
#include "sdk/splat/software_renderer.h"
#include "tests/reference/random_avatar.h"
#include "tests/unit/format/sample_correctives.h"
#include "tests/unit/render/tube_avatar.h"

namespace dpl {
namespace {

std::string textOf(const Status& status) {
    return status ? "no error" : formatText("code {}: {}", int(status.error().code), status.error().message);
}
template <class T>
std::string textOf(const Result<T>& result) {
    return result ? "no error" : formatText("code {}: {}", int(result.error().code), result.error().message);
}

/** Both renderers, each with two tubes and a cloud of general splats that have the same ids. */
class SameFaults : public testing::Test {
protected:
    void SetUp() override {
        auto backend = createNullBackend(nullptr);
        ASSERT_TRUE(backend) << backend.error().message;
        renderers_[0] = createSoftwareRenderer(1);
        renderers_[1] = std::make_unique<GpuRenderer>(std::move(*backend), "null");
        const auto tube = std::make_shared<const AvatarData>(makeTube({.splatsPerTriangle = 1, .rings = 3}));
        for (auto& renderer : renderers_) {
            const auto first = renderer->addAvatar(tube), second = renderer->addAvatar(tube),
                       general = renderer->addSplats(randomStaticSplats(1, 10, 0));
            ASSERT_TRUE(first && second && general);
            ASSERT_EQ((std::array{*first, *second, *general}), (std::array{tube_, other_, general_}));
        }
    }

    /** Expects that `act` fails on both renderers with this code and the same sentence, which contains `words`. */
    template <class Act>
    void expectFault(const char* what, Code code, const char* words, Act&& act) {
        const std::string cpu = textOf(act(*renderers_[0])), gpu = textOf(act(*renderers_[1]));
        EXPECT_EQ(cpu, gpu) << what;
        EXPECT_EQ(cpu.find(formatText("code {}: ", int(code))), 0u) << what << ": " << cpu;
        EXPECT_NE(cpu.find(words), std::string::npos) << what << ": " << cpu;
    }
    void expectDrawFault(const char* what, const char* words, const std::vector<Drawn>& subjects, const std::vector<Cameraf>& views,
                         const FrameWants& wants = {}) {
        expectFault(what, Code::InvalidArgument, words, [&](Renderer& r) { return r.drawTogether(subjects, views, wants); });
    }

    const RenderAvatarId tube_ = 1, other_ = 2, general_ = 3, absent_ = 9;
    const Pose pose_ = tubePose(0.2f);
    const Cameraf camera_ = tubeCamera(32, 16, 0);
    std::unique_ptr<Renderer> renderers_[2];
};

TEST_F(SameFaults, ofViews) {
    const auto refused = [&](const char* what, const char* words, auto&& spoil) {
        std::vector<Cameraf> views(2, camera_);
        spoil(views);
        expectDrawFault(what, words, {{tube_, &pose_}}, views);
    };
    const float nan = std::nanf(""), infinity = INFINITY;
    refused("no view", "0 views", [](auto& v) { v.clear(); });
    refused("three views", "3 views", [](auto& v) { v.push_back(v[0]); });
    refused("two sizes", "view 1 differs", [](auto& v) { v[1].widthPx = 31; });
    refused("no width", "view 0 is 0 x 16", [](auto& v) { v[0].widthPx = 0; });
    refused("too high", "view 1 is 32 x 8193", [](auto& v) { v[1].heightPx = 8193; });
    refused("no focal length", "focal lengths 0", [](auto& v) { v[0].fx = 0; });
    refused("negative focal length", "focal lengths", [](auto& v) { v[1].fy = -3; });
    refused("infinite focal length", "focal lengths", [&](auto& v) { v[1].fx = infinity; });
    refused("NaN principal point", "principal point", [&](auto& v) { v[1].cy = nan; });
    refused("NaN translation", "translation", [&](auto& v) { v[1].viewFromWorldTranslation.z = nan; });
    refused("far away", "translation", [](auto& v) { v[0].viewFromWorldTranslation.x = 2e5f; });
    refused("NaN rotation", "not a rotation", [&](auto& v) { v[1].viewFromWorldRotation[1].y = nan; });
    refused("scaled rotation", "not a rotation", [](auto& v) { v[0].viewFromWorldRotation *= 1.1f; });
    refused("mirror", "mirrors", [](auto& v) { v[0].viewFromWorldRotation = -v[0].viewFromWorldRotation; });
}

TEST_F(SameFaults, ofSubjects) {
    const std::vector<Cameraf> views{camera_};
    expectDrawFault("none", "0 avatars", {}, views);
    expectDrawFault("too many", "17 avatars", std::vector<Drawn>(kMaxDrawnTogether + 1, Drawn{tube_, &pose_}), views);
    expectDrawFault("one twice", "named twice", {{tube_, &pose_}, {other_, &pose_}, {tube_, &pose_}}, views);
    expectDrawFault("absent", "avatar 9 is not in this renderer", {{tube_, &pose_}, {absent_, &pose_}}, views);
    expectDrawFault("no pose", "without a pose", {{tube_, nullptr}}, views);
    Pose shortPose = pose_, nanPose = pose_, zeroPose = pose_, farPose = pose_;
    shortPose.localRotations.pop_back();
    nanPose.localRotations[1].y = NAN;
    zeroPose.localRotations[0] = Quatf(0, 0, 0, 0);
    farPose.rootTranslation.x = INFINITY;
    expectDrawFault("short pose", "rotations, the rig has", {{tube_, &shortPose}}, views);
    expectDrawFault("NaN pose", "not finite", {{other_, &pose_}, {tube_, &nanPose}}, views);
    expectDrawFault("zero rotation", "has length 0", {{tube_, &zeroPose}}, views);
    expectDrawFault("infinite root", "root translation", {{tube_, &farPose}}, views);
    for (auto& renderer : renderers_) renderer->removeAvatar(other_);
    expectDrawFault("removed", "avatar 2 is not in this renderer", {{other_, &pose_}}, views);
}

TEST_F(SameFaults, ofWants) {
    const std::vector<float> tooFew(32 * 16 - 1, 1.0f);
    FrameWants scene, mesh;
    scene.sceneDepthM[1] = tooFew;
    mesh.meshDepth = true;
    expectDrawFault("short scene depth", "view 1 has 511 depths", {{tube_, &pose_}}, {camera_, camera_}, scene);
    expectDrawFault("mesh of general splats", "have no mesh", {{general_, nullptr}}, {camera_}, mesh);
}

TEST_F(SameFaults, ofReading) {
    expectFault("nothing drawn", Code::InvalidArgument, "nothing was drawn of avatar 1", [&](Renderer& r) { return r.read(tube_); });
    expectFault("absent", Code::InvalidArgument, "avatar 9 is not", [&](Renderer& r) { return r.read(absent_); });
    expectFault("stats of absent", Code::InvalidArgument, "avatar 9 is not", [&](Renderer& r) { return r.stats(absent_); });
}

TEST_F(SameFaults, ofLoading) {
    const auto refused = [&](const char* what, Code code, const char* words, auto&& spoil) {
        AvatarData a = makeTube({.splatsPerTriangle = 1, .rings = 3});
        spoil(a);
        const auto shared = std::make_shared<const AvatarData>(std::move(a));
        expectFault(what, code, words, [&](Renderer& r) { return r.addAvatar(shared); });
    };
    const Code bad = Code::InvalidArgument;
    refused("no joints", bad, "0 joints", [](AvatarData& a) { a.joints.clear(); });
    refused("child first", bad, "parents come first", [](AvatarData& a) { a.joints[0].parent = 1; });
    refused("NaN joint", bad, "not finite", [](AvatarData& a) { a.joints[1].restPosition.y = NAN; });
    refused("weights missing", bad, "skin weights", [](AvatarData& a) { a.mesh.jointWeights.pop_back(); });
    refused("joint index", bad, "follows joint 7", [](AvatarData& a) { a.mesh.jointIndices[0].x = 7, a.mesh.jointWeights[0].x = 255; });
    refused("vertex index", bad, "names vertex 9999", [](AvatarData& a) { a.mesh.triangles[1].z = 9999; });
    refused("corrective node", bad, "corrective",
            [](AvatarData& a) { a.correctives = test::randomCorrectives(a, 1), a.correctives.nodeIndices[3].z = 12; });
    refused("SH degree", Code::Unsupported, "SH degree 4", [](AvatarData& a) { a.splats.shDegree = 4; });
    refused("short array", bad, "differ in length", [](AvatarData& a) { a.splats.opacity.pop_back(); });
    refused("start falls", bad, "triangleStart", [](AvatarData& a) { a.splats.triangleStart[1] = 60; });
    refused("start ends early", bad, "triangleStart", [](AvatarData& a) { a.splats.triangleStart.back() -= 1; });
    expectFault("no avatar", bad, "no avatar", [](Renderer& r) { return r.addAvatar(nullptr); });
    StaticSplatData ragged = randomStaticSplats(1, 3, 0), wide = randomStaticSplats(1, 3, 0);
    ragged.rotation.pop_back(), wide.shDegree = 4;
    expectFault("ragged general splats", bad, "differ in length", [&](Renderer& r) { return r.addSplats(ragged); });
    expectFault("SH degree of general splats", Code::Unsupported, "SH degree 4", [&](Renderer& r) { return r.addSplats(wide); });
    expectFault("prepared by nobody", bad, "another renderer", [](Renderer& r) { return r.add(std::make_unique<PreparedSubject>()); });
    expectFault("prepared by the other", bad, "another renderer", [&](Renderer& r) {
        auto prepared = renderers_[&r == renderers_[0].get() ? 1 : 0]->prepareSplats(randomStaticSplats(1, 3, 0));
        return prepared ? r.add(std::move(*prepared)) : Result<RenderAvatarId>(prepared.error());
    });
}

/** An entry of weight 0 may have any joint index, because no renderer reads that joint. */
TEST_F(SameFaults, butSlotsOfWeightZeroAreFree) {
    AvatarData a = makeTube({.splatsPerTriangle = 1, .rings = 3});
    a.mesh.jointIndices[0] = {0, 9, 9, 9}, a.mesh.jointWeights[0] = {255, 0, 0, 0};
    const auto shared = std::make_shared<const AvatarData>(std::move(a));
    for (auto& renderer : renderers_) {
        const auto id = renderer->addAvatar(shared);
        ASSERT_TRUE(id) << id.error().message;
        const Status drawn = renderer->draw(*id, pose_, {&camera_, 1}, {});
        EXPECT_TRUE(drawn) << drawn.error().message;
    }
}

}  // namespace
}  // namespace dpl
