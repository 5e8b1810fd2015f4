// SPDX-License-Identifier: Apache-2.0
// Handles, queries, poses, clips, and wrong arguments of every kind.
#include <limits>
#include <thread>

#include "tests/not_finite.h"
#include "tests/unit/api/api_fixture.h"
#include "tests/unit/format/sample_correctives.h"

namespace dpl::test {
namespace {

TEST_F(ApiTest, answersWhatIsInTheAvatar) {
    DplAvatarInfo info{};
    info.structSize = sizeof info;
    ASSERT_EQ(dplGetAvatarInfo(avatar_, &info), DPL_OK) << dplGetLastError();
    EXPECT_STREQ(info.name, "tiny");
    EXPECT_EQ(info.jointCount, 2u);
    EXPECT_EQ(info.splatCount, 128u);
    EXPECT_EQ(info.triangleCount, 2u);
    EXPECT_EQ(info.vertexCount, 4u);
    EXPECT_EQ(info.clipCount, 1u);
    EXPECT_NEAR(info.restMin[1], 0.5f, 1e-4);
    EXPECT_NEAR(info.restMax[0], 0.5f, 1e-4);
    DplJointInfo joint{};
    joint.structSize = sizeof joint;
    ASSERT_EQ(dplGetJointInfo(avatar_, 1, &joint), DPL_OK);
    EXPECT_STREQ(joint.name, "left_shoulder");
    EXPECT_STREQ(joint.humanoidBone, "leftUpperArm");
    EXPECT_EQ(joint.parent, 0);
    EXPECT_NEAR(joint.restPosition[1], 1.25f, 1e-4);
    EXPECT_EQ(dplGetJointInfo(avatar_, 2, &joint), DPL_ERROR_NOT_FOUND);
    uint32_t index = 99;
    EXPECT_EQ(dplFindJoint(avatar_, "leftUpperArm", &index), DPL_OK);
    EXPECT_EQ(index, 1u);
    EXPECT_EQ(dplFindJoint(avatar_, "tail", &index), DPL_ERROR_NOT_FOUND);
    EXPECT_TRUE(errorSays("pelvis, left_shoulder")) << dplGetLastError();
    EXPECT_EQ(dplFindJoint(avatar_, "", &index), DPL_ERROR_NOT_FOUND);
    DplClipInfo clip{};
    clip.structSize = sizeof clip;
    ASSERT_EQ(dplGetClipInfo(avatar_, 0, &clip), DPL_OK);
    EXPECT_STREQ(clip.name, "turn");
    EXPECT_DOUBLE_EQ(clip.durationS, 1.0);
    EXPECT_EQ(dplGetClipInfo(avatar_, 1, &clip), DPL_ERROR_NOT_FOUND);
}

TEST_F(ApiTest, poseMovesTheJointsAndComesBackNormalised) {
    const float rotations[8] = {0, 0, 2, 2, 0, 0, 0, 1};  // a quarter turn about z, not normalised
    const float root[3] = {0, 0, 1};
    ASSERT_EQ(dplSetPose(avatar_, rotations, 2, root), DPL_OK) << dplGetLastError();
    float positions[6];
    ASSERT_EQ(dplGetJointPositions(avatar_, positions, 2), DPL_OK);
    EXPECT_NEAR(positions[3], -0.25f, 1e-4);  // the joint 25 cm above the pelvis swings to −x
    EXPECT_NEAR(positions[4], 1.0f, 1e-4);
    EXPECT_NEAR(positions[5], 1.0f, 1e-4);
    float back[8], backRoot[3];
    ASSERT_EQ(dplGetPose(avatar_, back, 2, backRoot), DPL_OK);
    EXPECT_NEAR(back[2], std::sqrt(0.5f), 1e-6);
    EXPECT_NEAR(back[3], std::sqrt(0.5f), 1e-6);
    EXPECT_EQ(backRoot[2], 1.0f);
}

TEST_F(ApiTest, nanPoseIsRefusedByJointNameAndTheOldPoseStays) {
    const float good[8] = {0, 0, 1, 0, 0, 0, 0, 1};
    ASSERT_EQ(dplSetPose(avatar_, good, 2, nullptr), DPL_OK);
    const float bad[8] = {0, 0, 0, 1, 0, kNan, 0, 1};
    EXPECT_EQ(dplSetPose(avatar_, bad, 2, nullptr), DPL_ERROR_INVALID_ARGUMENT);
    EXPECT_TRUE(errorSays("left_shoulder")) << dplGetLastError();
    EXPECT_NE(log_.find("left_shoulder"), std::string::npos) << "a caller's mistake is logged";
    const float badRoot[3] = {0, std::numeric_limits<float>::infinity(), 0};
    EXPECT_EQ(dplSetPose(avatar_, good, 2, badRoot), DPL_ERROR_INVALID_ARGUMENT);
    EXPECT_EQ(dplSetPose(avatar_, good, 1, nullptr), DPL_ERROR_INVALID_ARGUMENT);
    EXPECT_EQ(dplSetPose(avatar_, good, 0xFFFFFFFFu, nullptr), DPL_ERROR_INVALID_ARGUMENT);
    EXPECT_EQ(dplSetPose(avatar_, nullptr, 2, nullptr), DPL_ERROR_INVALID_ARGUMENT);
    float back[8];
    ASSERT_EQ(dplGetPose(avatar_, back, 2, nullptr), DPL_OK);
    EXPECT_EQ(back[2], 1.0f);
}

TEST_F(ApiTest, trustFallsAwayFromTheTrainedPosesAndNamesTheJoint) {
    DplPoseTrust trust{};
    trust.structSize = sizeof trust;
    EXPECT_EQ(dplGetPoseTrust(avatar_, &trust, nullptr, 0), DPL_ERROR_UNSUPPORTED) << "no correctives, no record of poses";
    AvatarData data = withCorrectives(tinyAvatar(), 3, {.reach = 1, .reachOffModes = 0.5f});
    std::fill(data.correctives.mean.begin(), data.correctives.mean.end(), 0.0f);
    sortSplats(data);
    const auto bytes = writeAvatar(data);
    ASSERT_TRUE(bytes) << bytes.error().message;
    DplAvatar avatar = nullptr;
    ASSERT_EQ(dplLoadAvatar(context_, bytes->data(), bytes->size(), &avatar), DPL_OK) << dplGetLastError();
    float distances[2] = {7, 7};
    ASSERT_EQ(dplGetPoseTrust(avatar, &trust, distances, 2), DPL_OK) << dplGetLastError();
    EXPECT_EQ(trust.offsets, 1);
    EXPECT_EQ(distances[0], 0);
    EXPECT_EQ(distances[1], 0);
    const float pose[8] = {0, 0, 0, 1, 0, 1, 0, 0};  // the second joint turned by 180 degrees
    ASSERT_EQ(dplSetPose(avatar, pose, 2, nullptr), DPL_OK);
    ASSERT_EQ(dplGetPoseTrust(avatar, &trust, distances, 2), DPL_OK);
    EXPECT_LT(trust.offsets, 0.5f);
    EXPECT_EQ(trust.farthestJoint, 1u);
    EXPECT_EQ(trust.farthestDistance, distances[1]);
    EXPECT_GT(distances[1], 2);
    const float limit = 0.5f * distances[1];
    ASSERT_EQ(dplHoldPose(avatar, limit), DPL_OK) << dplGetLastError();
    ASSERT_EQ(dplGetPoseTrust(avatar, &trust, distances, 2), DPL_OK);
    EXPECT_NEAR(distances[1], limit, 0.01f * limit);
    for (const float wrong : {0.0f, -1.0f, std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity()})
        EXPECT_EQ(dplHoldPose(avatar, wrong), DPL_ERROR_INVALID_ARGUMENT);
    EXPECT_EQ(dplHoldPose(avatar_, 4), DPL_ERROR_UNSUPPORTED);
    EXPECT_EQ(dplGetPoseTrust(avatar, &trust, distances, 3), DPL_ERROR_INVALID_ARGUMENT);
    EXPECT_EQ(dplGetPoseTrust(avatar, nullptr, distances, 2), DPL_ERROR_INVALID_ARGUMENT);
    EXPECT_EQ(dplGetPoseTrust(nullptr, &trust, nullptr, 0), DPL_ERROR_INVALID_ARGUMENT);
    EXPECT_EQ(dplDestroyAvatar(avatar), DPL_OK);
}

TEST_F(ApiTest, clipsPlayLoopAndClamp) {
    float root[3];
    ASSERT_EQ(dplSetPoseFromClip(avatar_, 0, 0.5, DPL_FALSE), DPL_OK);
    ASSERT_EQ(dplGetPose(avatar_, nullptr, 0, root), DPL_OK);
    EXPECT_NEAR(root[1], 0.25f, 1e-4);
    ASSERT_EQ(dplSetPoseFromClip(avatar_, 0, 7.5, DPL_TRUE), DPL_OK);
    ASSERT_EQ(dplGetPose(avatar_, nullptr, 0, root), DPL_OK);
    EXPECT_NEAR(root[1], 0.25f, 1e-4);
    ASSERT_EQ(dplSetPoseFromClip(avatar_, 0, -0.25, DPL_TRUE), DPL_OK);
    ASSERT_EQ(dplGetPose(avatar_, nullptr, 0, root), DPL_OK);
    EXPECT_NEAR(root[1], 0.375f, 1e-4);
    ASSERT_EQ(dplSetPoseFromClip(avatar_, 0, 7.5, DPL_FALSE), DPL_OK);
    ASSERT_EQ(dplGetPose(avatar_, nullptr, 0, root), DPL_OK);
    EXPECT_NEAR(root[1], 0.5f, 1e-4);
    EXPECT_EQ(dplSetPoseFromClip(avatar_, 0, std::numeric_limits<double>::infinity(), DPL_TRUE), DPL_ERROR_INVALID_ARGUMENT);
    EXPECT_EQ(dplSetPoseFromClip(avatar_, 9, 0, DPL_TRUE), DPL_ERROR_NOT_FOUND);
}

TEST_F(ApiTest, aBvhWithoutHumanBonesIsUnsupportedAndListsIts) {
    const std::string bvh =
        "HIERARCHY\nROOT box\n{\nOFFSET 0 0 0\nCHANNELS 3 Zrotation Xrotation Yrotation\nEnd Site\n{\nOFFSET 0 1 0\n}\n}\n"
        "MOTION\nFrames: 1\nFrame Time: 0.1\n0 0 0\n";
    const auto* bytes = reinterpret_cast<const uint8_t*>(bvh.data());
    uint32_t clip = 77;
    EXPECT_EQ(dplLoadClip(avatar_, bytes, bvh.size(), nullptr, &clip), DPL_ERROR_UNSUPPORTED);
    EXPECT_TRUE(errorSays("box")) << dplGetLastError();
    EXPECT_EQ(dplLoadClip(avatar_, bytes, bvh.size() / 2, nullptr, &clip), DPL_ERROR_CORRUPT_DATA);
    EXPECT_EQ(dplLoadClip(avatar_, nullptr, 3, nullptr, &clip), DPL_ERROR_INVALID_ARGUMENT);
    EXPECT_EQ(dplLoadClip(avatar_, bytes, bvh.size(), nullptr, nullptr), DPL_ERROR_INVALID_ARGUMENT);
    DplClipOptions named{sizeof(DplClipOptions), 0, nullptr, 0, "walk"};
    EXPECT_EQ(dplLoadClip(avatar_, bytes, bvh.size(), &named, &clip), DPL_ERROR_NOT_FOUND) << "a BVH has no animations by name";
    named.structSize = offsetof(DplClipOptions, animationName);
    EXPECT_EQ(dplLoadClip(avatar_, bytes, bvh.size(), &named, &clip), DPL_ERROR_UNSUPPORTED) << "callers that do not know the name";
    const DplClipOptions unknown{sizeof(DplClipOptions), 0x80, nullptr, 0};
    EXPECT_EQ(dplLoadClip(avatar_, bytes, bvh.size(), &unknown, &clip), DPL_ERROR_INVALID_ARGUMENT);
    EXPECT_EQ(clip, 77u) << "outputs are written only on DPL_OK";
}

TEST_F(ApiTest, staleForeignAndInventedHandlesAreDetected) {
    DplAvatarInfo info{};
    info.structSize = sizeof info;
    const auto invented = [](uintptr_t n) { return reinterpret_cast<DplAvatar>(n); };
    for (const uintptr_t n : {uintptr_t(0), uintptr_t(1), uintptr_t(0xdeadbeef), reinterpret_cast<uintptr_t>(context_),
                              reinterpret_cast<uintptr_t>(&info), ~uintptr_t(0)})
        EXPECT_EQ(dplGetAvatarInfo(invented(n), &info), DPL_ERROR_INVALID_ARGUMENT);
    EXPECT_EQ(dplDestroyContext(reinterpret_cast<DplContext>(avatar_)), DPL_ERROR_INVALID_ARGUMENT);
    EXPECT_EQ(dplDestroyAvatar(invented(0xdeadbeef)), DPL_ERROR_INVALID_ARGUMENT);
    const auto bytes = tinyFile();
    DplAvatar second = nullptr;
    ASSERT_EQ(dplLoadAvatar(context_, bytes.data(), bytes.size(), &second), DPL_OK);
    EXPECT_EQ(dplDestroyAvatar(second), DPL_OK);
    EXPECT_EQ(dplDestroyAvatar(second), DPL_ERROR_INVALID_ARGUMENT);
    EXPECT_EQ(dplDestroyAvatar(nullptr), DPL_OK);
    EXPECT_EQ(dplDestroyContext(nullptr), DPL_OK);
}

TEST_F(ApiTest, structSizesAreHeld) {
    DplAvatarInfo info{};
    for (const uint32_t size : {0u, 4u, uint32_t(offsetof(DplAvatarInfo, fileSplatCount)) - 1, 0xFFFFFFFFu}) {
        info.structSize = size;
        EXPECT_EQ(dplGetAvatarInfo(avatar_, &info), DPL_ERROR_INVALID_ARGUMENT) << size;
        EXPECT_TRUE(errorSays("structSize")) << dplGetLastError();
        EXPECT_EQ(info.structSize, size);
    }
    info = {}, info.structSize = 72;  // of version 0.1
    info.fileShDegree = 7;
    EXPECT_EQ(dplGetAvatarInfo(avatar_, &info), DPL_OK) << dplGetLastError();
    EXPECT_GT(info.splatCount, 0u);
    EXPECT_EQ(info.fileShDegree, 7u) << "behind the shorter struct";
    struct {
        DplAvatarInfo info;
        uint32_t fromTheFuture[2];
    } newer{{}, {7, 7}};
    newer.info.structSize = sizeof newer;
    EXPECT_EQ(dplGetAvatarInfo(avatar_, &newer.info), DPL_OK);
    EXPECT_EQ(newer.info.structSize, sizeof newer);
    EXPECT_EQ(newer.fromTheFuture[0], 7u) << "fields this library does not know are left alone";
    EXPECT_EQ(dplGetAvatarInfo(avatar_, nullptr), DPL_ERROR_INVALID_ARGUMENT);
}

TEST_F(ApiTest, contextsRefuseInvalidSettings) {
    DplContext other = nullptr;
    EXPECT_EQ(dplCreateContext(nullptr, nullptr), DPL_ERROR_INVALID_ARGUMENT);
    DplContextInfo info{sizeof info, DPL_RENDERER_SOFTWARE, 100000};
    EXPECT_EQ(dplCreateContext(&info, &other), DPL_ERROR_INVALID_ARGUMENT);
    info = {sizeof info, DplRenderer(77), 1};
    EXPECT_EQ(dplCreateContext(&info, &other), DPL_ERROR_INVALID_ARGUMENT);
#ifndef __APPLE__
    info = {sizeof info, DPL_RENDERER_METAL, 1};
    EXPECT_EQ(dplCreateContext(&info, &other), DPL_ERROR_UNSUPPORTED);
    EXPECT_NE(std::string(dplGetLastError()).find("without Metal"), std::string::npos) << dplGetLastError();
#endif
    info = {1, DPL_RENDERER_SOFTWARE, 1};
    EXPECT_EQ(dplCreateContext(&info, &other), DPL_ERROR_INVALID_ARGUMENT);
    EXPECT_EQ(other, nullptr);
    const char* name = nullptr;
    EXPECT_EQ(dplGetRendererName(context_, nullptr), DPL_ERROR_INVALID_ARGUMENT);
    EXPECT_EQ(dplGetRendererName(nullptr, &name), DPL_ERROR_INVALID_ARGUMENT);
    EXPECT_EQ(dplGetRendererName(context_, &name), DPL_OK);
    EXPECT_STREQ(name, "software (1 thread)");
    EXPECT_STREQ(dplGetResultName(DPL_ERROR_DEVICE), "DPL_ERROR_DEVICE");
    EXPECT_STREQ(dplGetResultName(DplResult(12345)), "unknown result");
}

TEST_F(ApiTest, damagedFilesGiveASentenceAndNoAvatar) {
    const auto good = tinyFile();
    DplAvatar avatar = nullptr;
    for (size_t size = 1; size < good.size(); size += 37) {
        const std::vector<uint8_t> cut(
            good.begin(),
            good.begin() + std::ptrdiff_t(size));  // an allocation of its own, so that ASan sees reads past its end
        EXPECT_NE(dplLoadAvatar(context_, cut.data(), cut.size(), &avatar), DPL_OK) << size;
        EXPECT_NE(dplGetLastError()[0], 0);
    }
    for (size_t at = 0; at < good.size(); at += 11) {
        std::vector<uint8_t> flipped = good;
        flipped[at] ^= 0x40;
        avatar = nullptr;
        dplLoadAvatar(context_, flipped.data(), flipped.size(), &avatar);  // may fail or not; must not crash or leak
        EXPECT_EQ(dplDestroyAvatar(avatar), DPL_OK);
    }
    EXPECT_EQ(dplLoadAvatar(context_, nullptr, 10, &avatar), DPL_ERROR_INVALID_ARGUMENT);
    EXPECT_EQ(dplLoadAvatar(context_, good.data(), 0, &avatar), DPL_ERROR_INVALID_ARGUMENT);
    EXPECT_EQ(dplLoadAvatar(context_, good.data(), good.size(), nullptr), DPL_ERROR_INVALID_ARGUMENT);
    EXPECT_EQ(dplLoadAvatar(nullptr, good.data(), good.size(), &avatar), DPL_ERROR_INVALID_ARGUMENT);
}

TEST_F(ApiTest, avatarsOutliveTheirContextButAreNotDrawn) {
    const DplContextInfo info{sizeof(DplContextInfo), DPL_RENDERER_SOFTWARE, 1};
    DplContext context = nullptr;
    DplAvatar avatar = nullptr;
    ASSERT_EQ(dplCreateContext(&info, &context), DPL_OK);
    const auto bytes = tinyFile();
    ASSERT_EQ(dplLoadAvatar(context, bytes.data(), bytes.size(), &avatar), DPL_OK);
    ASSERT_EQ(dplDestroyContext(context), DPL_OK);
    EXPECT_EQ(dplSetPoseFromClip(avatar, 0, 0.5, DPL_FALSE), DPL_OK);
    DplCamera camera = frontCamera();
    std::vector<uint8_t> pixels;
    const DplImage image = imageFor(camera, pixels);
    EXPECT_EQ(dplRender(context, avatar, &camera, 1, &image), DPL_ERROR_INVALID_ARGUMENT);
    EXPECT_EQ(dplRender(context_, avatar, &camera, 1, &image), DPL_ERROR_INVALID_ARGUMENT);
    EXPECT_TRUE(errorSays("another context")) << dplGetLastError();
    EXPECT_EQ(dplDestroyAvatar(avatar), DPL_OK);
}

TEST_F(ApiTest, errorsBelongToTheirThread) {
    EXPECT_EQ(dplGetAvatarInfo(nullptr, nullptr), DPL_ERROR_INVALID_ARGUMENT);
    std::string other = "unset";
    std::thread([&] { other = dplGetLastError(); }).join();
    EXPECT_EQ(other, "");
    EXPECT_TRUE(errorSays("dplGetAvatarInfo"));
}

TEST_F(ApiTest, manyThreadsOnOneContextWaitForOneAnother) {
    std::vector<std::thread> threads;
    for (int i = 0; i < 4; ++i)
        threads.emplace_back([this, i] {
            const DplCamera camera = frontCamera(16, 16);
            std::vector<uint8_t> pixels;
            const DplImage image = imageFor(camera, pixels);
            for (int k = 0; k < 20; ++k) {
                EXPECT_EQ(dplSetPoseFromClip(avatar_, 0, 0.1 * i + 0.01 * k, DPL_TRUE), DPL_OK);
                EXPECT_EQ(dplRender(context_, avatar_, &camera, 1, &image), DPL_OK);
            }
        });
    for (std::thread& t : threads) t.join();
}

}  // namespace
}  // namespace dpl::test
