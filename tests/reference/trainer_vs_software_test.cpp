// SPDX-License-Identifier: Apache-2.0
// The trainer's forward pass against the software renderer of the public SDK, on avatars decoded from a file.
#include <gtest/gtest.h>

#include <doppel/doppel.hpp>

#include "reconstruction/base/sdk_camera.h"
#include "reconstruction/training/trainer/frame_pass.h"
#include "sdk/avatar/scene_light.h"
#include "sdk/format/avatar_file.h"
#include "tests/reference/image_compare.h"
#include "tests/reference/random_avatar.h"

namespace dpl {
namespace {

constexpr double kRequiredDb = 60;

/** Draws with the SDK: premultiplied RGBA8. */
std::vector<uint8_t> drawWithSdk(const std::vector<uint8_t>& bytes, const Pose& pose, const Cameraf& camera) {
    auto context = doppel::Context::create(DPL_RENDERER_SOFTWARE, 2);
    if (!context) return {};
    auto avatar = context->loadAvatar(bytes);
    if (!avatar || !avatar->setPose({&pose.localRotations[0].x, pose.localRotations.size() * 4}, {&pose.rootTranslation.x, 3})) return {};
    const DplCamera view = sdkCamera(camera);
    std::vector<uint8_t> rgba(size_t(camera.widthPx) * camera.heightPx * 4);
    DplImage image{};
    image.structSize = sizeof image;
    image.rgba = rgba.data(), image.rgbaBytes = rgba.size();
    return avatar->render({&view, 1}, {&image, 1}) ? rgba : std::vector<uint8_t>{};
}

/** Draws the same with the trainer, rounded to RGBA8. */
std::vector<uint8_t> drawWithTrainer(const AvatarData& avatar, const Pose& pose, const Cameraf& camera) {
    Jobs jobs(2);
    TrainableSplats splats = TrainableSplats::fromSplatData(avatar.splats, std::vector<float>(avatar.mesh.triangles.size(), 0.0f));
    splats.activateAll(jobs);
    const std::vector<RestTriangle<float>> bind = restTriangles(avatar.mesh);
    const VertexIncidence incidence(avatar.mesh.triangles, avatar.mesh.restPositions.size());
    LevelFrame level;
    level.used = true, level.widthPx = camera.widthPx, level.heightPx = camera.heightPx, level.kappaPx2 = avatar.kappaPx2,
    level.camera = camera;
    const size_t pixels = size_t(camera.widthPx) * camera.heightPx;
    level.rgb.resize(pixels * 3), level.mask.resize(pixels);
    FramePass pass(jobs);
    const std::vector<Vec3f> normals = restVertexNormals(avatar.mesh);
    pass.run({splats, avatar.mesh, avatar.correctives, avatar.joints, {bind}, incidence, avatar.light, normals}, pose, level, {}, Vec3f(0),
             false);
    std::vector<uint8_t> rgba;
    for (size_t i = 0; i < pixels; ++i) {
        for (size_t c = 0; c < 3; ++c) rgba.push_back(uint8_t(std::clamp(pass.image().rgb[i * 3 + c], 0.0f, 1.0f) * 255.0f + 0.5f));
        rgba.push_back(uint8_t(pass.image().alpha[i] * 255.0f + 0.5f));
    }
    return rgba;
}

TEST(TrainerVsSoftware, agreesOnDecodedAvatars) {
    for (const uint32_t seed : {1u, 2u, 3u}) {
        AvatarData made = randomAvatar(seed, 10, 5, seed % 3);
        for (Vec2f& s : made.splats.scaleM) s = glm::min(s, Vec2f(0.095f));  // the trainer's own limit is 10 cm
        if (seed > 1) made.light.irradiance = {-0.6f, 0.3f, -0.2f, 0.1f, -0.15f, -0.2f, 0.1f, 0.05f};
        const auto bytes = writeAvatar(made);
        ASSERT_TRUE(bytes) << bytes.error().message;
        const auto avatar = readAvatar(*bytes);
        ASSERT_TRUE(avatar) << avatar.error().message;
        for (const uint32_t view : {0u, 1u}) {
            const Pose pose = randomPose(*avatar, 10 * seed + view);
            const Cameraf camera =
                lookAt(view ? Vec3f(0.2f, 1.2f, 1.1f) : Vec3f(-1.4f, 1.5f, 1.7f), Vec3f(0, 1, 0), 230, 310, view ? 350.0f : 260.0f);
            const std::vector<uint8_t> sdk = drawWithSdk(*bytes, pose, camera), trainer = drawWithTrainer(*avatar, pose, camera);
            ASSERT_EQ(sdk.size(), trainer.size());
            std::vector<double> a, b, alpha;
            for (size_t i = 0; i < sdk.size(); ++i) a.push_back(sdk[i] / 255.0), b.push_back(trainer[i] / 255.0);
            for (size_t i = 3; i < b.size(); i += 4) alpha.push_back(b[i]);
            ASSERT_GT(coverage(alpha), 0.1) << "the avatar must be in the picture";
            const ImageDifference d = compareImages(a, b);
            std::printf("seed %u view %u: %.1f dB, largest error %.4f\n", seed, view, d.psnrDb, d.maxError);
            EXPECT_GE(d.psnrDb, kRequiredDb);
            EXPECT_LE(d.maxError, 2.1 / 255) << "value " << d.worst;
        }
    }
}

}  // namespace
}  // namespace dpl
