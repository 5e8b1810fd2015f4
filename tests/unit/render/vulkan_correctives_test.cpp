// SPDX-License-Identifier: Apache-2.0
// Deformation and brightness in the output of the skin pass (the `posed` buffer, read back) against the referee.
#include <cstring>

#include "sdk/format/splat_codec.h"
#include "sdk/render/passes/skin.h"
#include "tests/reference/corrective_cases.h"
#include "tests/unit/render/palette_of.h"
#include "tests/unit/render/vulkan_test_device.h"

namespace dpl {
namespace {

/** skinned: with the joints of the pose. Otherwise every joint is at rest, and the result is the corrected rest surface. */
std::vector<Vec4f> skinOnDevice(Backend& backend, const AvatarData& avatar, const Pose& pose, bool skinned) {
    const CodedSplats coded = *codeSplats(avatar.mesh, avatar.splats);
    const AvatarRecords records = packAvatar(avatar, coded);
    const std::vector<gpu::vec4> palette = paletteOf(avatar, skinned ? pose : Pose::rest(avatar.joints.size()), pose);
    const Cameraf camera = lookAt({0, 1, 3}, {0, 1, 0}, 16, 16, 16);
    const gpu::FrameData frameBlock = packFrame(splatSetOf(avatar, coded), {&camera, 1});

    FrameIds ids;
    SubjectIds subject;
    subject.vertexCount = uint32_t(avatar.mesh.restPositions.size()), subject.jointCount = uint32_t(avatar.joints.size()),
    subject.corrected = true, subject.firstLight = firstLightRow(avatar);
    std::vector<BufferId> owned;
    const auto make = [&](const char* label, uint64_t bytes, BufferMemory memory = BufferMemory::Device) {
        auto buffer = backend.createBuffer({label, bytes, memory});
        EXPECT_TRUE(buffer);
        return owned.emplace_back(*buffer);
    };
    const auto upload = [&](const char* label, std::span<const std::byte> bytes) {
        const BufferId id = make(label, bytes.size());
        EXPECT_TRUE(backend.write(id, 0, bytes));
        return id;
    };
    const gpu::FrameCounts counts{};
    subject.uniforms = make("frame", sizeof(frameBlock), BufferMemory::Upload);
    std::memcpy(backend.mapped(subject.uniforms).data(), &frameBlock, sizeof(frameBlock));
    subject.palette = upload("palette", std::as_bytes(std::span(palette)));
    subject.vertices = upload("vertices", std::as_bytes(std::span(records.correctedVertices)));
    ids.counts = upload("counts", std::as_bytes(std::span(&counts, 1)));
    subject.posed = make("posed", subject.vertexCount * 16ull);
    const BufferId result = make("result", subject.vertexCount * 16ull, BufferMemory::Readback);
    FramePlan plan(backend);
    addSkin(plan, ids, subject);
    plan.copy("result", subject.posed, result);
    auto frame = plan.finish();
    EXPECT_TRUE(frame) << (frame ? "" : frame.error().message);
    std::vector<Vec4f> out(subject.vertexCount);
    if (frame) {
        EXPECT_TRUE(backend.run(*frame));
        std::memcpy(out.data(), backend.mapped(result).data(), out.size() * sizeof(Vec4f));
        backend.destroyFrame(*frame);
    }
    for (BufferId id : owned) backend.destroyBuffer(id);
    return out;
}

TEST(VulkanCorrectives, deviceVerticesAreTheRefereesToAThousandthOfTheirRange) {
    VulkanTestOptions options = testVulkanOptions();
    auto backend = createTestBackend(options);
    if (!backend) GTEST_SKIP() << backend.error().message;
    const auto verticesOf = [&](const AvatarData& avatar, const Pose& pose, bool skinned) {
        return skinOnDevice(**backend, avatar, pose, skinned);
    };
    expectCorrectivesMatch("Vulkan", verticesOf);
    expectExpressionsMatch("Vulkan", verticesOf);
    expectSceneLightMatches("Vulkan", verticesOf);
    backend->reset();
    EXPECT_EQ(options.validationMessages->load(), 0u);
}

}  // namespace
}  // namespace dpl
