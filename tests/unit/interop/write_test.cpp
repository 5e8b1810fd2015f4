// SPDX-License-Identifier: Apache-2.0
// dplVulkanWriteSplats: the splats in a program's buffer are those of the CPU, in frames that draw the avatar and in others, and mistakes
// get a sentence.
#include <algorithm>

#include "apps/bench/count_allocations.h"
#include "tests/unit/interop/interop_fixture.h"
#include "tests/unit/interop/written_splats.h"

namespace dpl::test {
namespace {

class WriteTest : public Interop {
protected:
    void openWith(const std::vector<uint8_t>& file, bool validation = true) {
        open({.multiview = false, .validation = validation});
        if (IsSkipped() || HasFatalFailure()) return;
        ASSERT_EQ(dplDestroyAvatar(avatar_), DPL_OK);
        ASSERT_EQ(dplLoadAvatar(context_, file.data(), file.size(), &avatar_), DPL_OK) << dplGetLastError();
    }
    void TearDown() override {
        if (app_) app_->waitAll();
        for (AppBuffer& buffer : buffers_) app_->destroy(buffer);
        Interop::TearDown();
    }
    AppBuffer& bufferOf(uint64_t bytes, uint8_t fill = 0xAB) {
        buffers_.push_back(app_->makeBuffer(bytes, VK_BUFFER_USAGE_STORAGE_BUFFER_BIT));
        std::memset(buffers_.back().mapped, fill, bytes);
        return buffers_.back();
    }
    DplResult record(VkCommandBuffer commands, uint32_t slot, const WriteCase& c, const Layout& layout, const AppBuffer& into) {
        const DplSplatOptions options = c.options();
        const DplVulkanBuffer buffer{sizeof buffer, uint32_t(layout.elements.size()), layout.elements.data(), into.buffer, layout.bytes};
        written_ = {sizeof written_};
        return dplVulkanWriteSplats(avatar_, commands, slot, &options, &buffer, &written_);
    }
    /** Submits what is recorded, with a barrier for the CPU's reads, and waits. */
    void finish(VkCommandBuffer commands, uint32_t slot) {
        VkMemoryBarrier memory{VK_STRUCTURE_TYPE_MEMORY_BARRIER};
        memory.srcAccessMask = VK_ACCESS_SHADER_WRITE_BIT, memory.dstAccessMask = VK_ACCESS_HOST_READ_BIT;
        vkCmdPipelineBarrier(commands, VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT, VK_PIPELINE_STAGE_HOST_BIT, 0, 1, &memory, 0, nullptr, 0,
                             nullptr);
        app_->submit(slot);
        app_->waitAll();
    }
    /** What a frame without a picture writes. */
    std::vector<uint8_t> write(uint32_t slot, const WriteCase& c, const Layout& layout) {
        AppBuffer& into = bufferOf(layout.bytes);
        c.pose(avatar_);
        const VkCommandBuffer commands = app_->begin(slot);
        EXPECT_EQ(dplVulkanUpload(context_, commands, slot), DPL_OK) << dplGetLastError();
        EXPECT_EQ(record(commands, slot, c, layout, into), DPL_OK) << dplGetLastError();
        finish(commands, slot);
        return {into.mapped, into.mapped + layout.bytes};
    }
    bool says(const char* text) const { return std::string(dplGetLastError()).find(text) != std::string::npos; }

    DplWritten written_{};
    std::deque<AppBuffer> buffers_;
};

#define OPEN_WITH_OR_SKIP(...) \
    openWith(__VA_ARGS__);     \
    if (IsSkipped() || HasFatalFailure()) return

TEST_F(WriteTest, theGpuWritesTheSplatsOfTheCpu) {
    Differences worst{};
    double leastDb = 1000;
    for (const uint32_t shDegree : {3u, 0u}) {
        const auto file = fileOf(writtenTube(shDegree));
        if (!app_) {
            OPEN_WITH_OR_SKIP(file);
        } else {
            ASSERT_EQ(dplDestroyAvatar(avatar_), DPL_OK);
            ASSERT_EQ(dplLoadAvatar(context_, file.data(), file.size(), &avatar_), DPL_OK) << dplGetLastError();
        }
        const OnCpu cpu(file);
        uint32_t slot = 0;
        for (const WriteCase& c : writeCases()) {
            c.pose(cpu.avatar);
            const uint32_t count = cpu.count(c);
            std::vector<uint8_t> want[2], got[2];
            const Layout layouts[2] = {interleaved(count, c.shDegree), mixed(count, c.shDegree)};
            for (int i = 0; i < 2; ++i, slot = (slot + 1) % DPL_VULKAN_SLOTS) {
                EXPECT_EQ(cpu.write(c, layouts[i], want[i]), 0u);
                got[i] = write(slot, c, layouts[i]);
                EXPECT_EQ(written_.count, count);
                EXPECT_EQ(written_.saturated, 0u);
                expectSameSplats(cpu, c, layouts[i], want[i], got[i], worst);
                if (HasFatalFailure()) return;
            }
            if (!c.transform) {
                Cameraf camera = tubeCamera(96, 96, 0.8f);
                if (c.eye) camera = tubeCamera(96, 96, std::atan2(c.eye->x, c.eye->z), 1.5f);
                leastDb = std::min(leastDb, picturesDb(c, want[0], got[0], camera));
            }
        }
    }
    print("Vulkan", worst);
    std::printf("[  WRITTEN ] pictures of both by the referee: %.1f dB at least\n", leastDb);
    EXPECT_GE(leastDb, 60);
}

TEST_F(WriteTest, aFrameThatDrawsTheAvatarWritesTheSameAndDrawsTheSame) {
    const auto file = fileOf(writtenTube(2));
    OPEN_WITH_OR_SKIP(file);
    const OnCpu cpu(file);
    constexpr VkFormat kFormat = VK_FORMAT_R8G8B8A8_UNORM;
    const AppImage& image = target(kFormat);
    const Passes passes = passesFor(image, false);
    const WriteCase c{"drawn", 0.6f, 0.3f, {}, Vec3f(0, 1, -2), 0, 2}, other{"drawn, another eye", 0.6f, 0.3f, {}, Vec3f(1, 1, 2), 900, 1};
    c.pose(avatar_), c.pose(cpu.avatar);
    const Cameraf from = tubeCamera(kWidth, kHeight, 0.4f);
    DplCamera camera{sizeof(DplCamera), kWidth, kHeight, from.fx, from.fy, from.cx, from.cy, {}};
    for (int row = 0; row < 3; ++row) {
        for (int column = 0; column < 3; ++column) camera.viewFromWorld[row * 4 + column] = from.viewFromWorldRotation[column][row];
        camera.viewFromWorld[row * 4 + 3] = from.viewFromWorldTranslation[row];
    }
    app_->upload(image, 0, background(kFormat));
    ASSERT_EQ(frame(0, image, passes, {&avatar_, 1}, {&camera, 1}), DPL_OK) << dplGetLastError();
    app_->waitAll();
    const auto without = app_->download(image, 0);
    const Layout layout = interleaved(cpu.count(c), 2), second = mixed(cpu.count(other), 1);
    std::vector<uint8_t> want, wantSecond;
    cpu.write(c, layout, want), cpu.write(other, second, wantSecond);
    // Twice: the second frame follows one whose writes have posed the mesh that its picture reads.
    for (uint32_t slot : {1u, 2u}) {
        AppBuffer &into = bufferOf(layout.bytes), &intoSecond = bufferOf(second.bytes);
        app_->upload(image, 0, background(kFormat));
        const VkCommandBuffer commands = app_->begin(slot);
        ASSERT_EQ(dplVulkanPrepare(context_, commands, slot, &avatar_, 1, &camera, 1, nullptr), DPL_OK) << dplGetLastError();
        ASSERT_EQ(record(commands, slot, c, layout, into), DPL_OK) << dplGetLastError();
        ASSERT_EQ(record(commands, slot, other, second, intoSecond), DPL_OK) << dplGetLastError();
        app_->barrier(commands, image, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL, VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL);
        beginPass(commands, image, passes, 0);
        ASSERT_EQ(dplVulkanCompose(context_, passes.composer, commands, slot, 0, 0, 0), DPL_OK) << dplGetLastError();
        endPass(commands, passes);
        app_->barrier(commands, image, VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL);
        finish(commands, slot);
        EXPECT_EQ(app_->download(image, 0), without);
        Differences worst{};
        expectSameSplats(cpu, c, layout, want, {into.mapped, into.mapped + layout.bytes}, worst);
        expectSameSplats(cpu, other, second, wantSecond, {intoSecond.mapped, intoSecond.mapped + second.bytes}, worst);
    }
}

TEST_F(WriteTest, hiddenLayersHaveOpacityZero) {
    const auto file = fileOf(dressed());
    OPEN_WITH_OR_SKIP(file);
    const OnCpu cpu(file);
    for (const DplAvatar avatar : {avatar_, cpu.avatar}) ASSERT_EQ(dplHideLayer(avatar, kCoat, DPL_TRUE), DPL_OK) << dplGetLastError();
    const WriteCase c{"without a coat"};
    c.pose(cpu.avatar);
    const Layout layout = interleaved(cpu.count(c), 0);
    std::vector<uint8_t> want;
    cpu.write(c, layout, want);
    Differences worst{};
    expectSameSplats(cpu, c, layout, want, write(0, c, layout), worst);
    const auto opacity = cpu.property(c, DPL_SPLAT_OPACITY);
    EXPECT_GT(std::count(opacity.begin(), opacity.end(), 0.0f), 100);
}

TEST_F(WriteTest, halvesSaturateAndAreNotCounted) {
    const auto file = fileOf(writtenTube(0));
    OPEN_WITH_OR_SKIP(file);
    const OnCpu cpu(file);
    const WriteCase c{"at 80 km", 0, 0, placedAt(0, 1, {80000, 0, -80000})};
    c.pose(cpu.avatar);
    const Layout layout{{at(DPL_SPLAT_POSITION, 0, 8, DPL_NUMBER_HALF)}, 8ull * cpu.count(c)};
    std::vector<uint8_t> want;
    EXPECT_EQ(cpu.write(c, layout, want), 2u * cpu.count(c));
    const auto got = write(0, c, layout);
    EXPECT_EQ(written_.saturated, 0u);
    for (size_t row = 0; row < got.size(); row += 8) {
        uint16_t xyz[3];
        std::memcpy(xyz, &got[row], 6);
        ASSERT_EQ(xyz[0], 0x7BFF);
        ASSERT_EQ(xyz[2], 0xFBFF);
        ASSERT_TRUE(got[row + 6] == 0xAB && got[row + 7] == 0xAB);
    }
}

TEST_F(WriteTest, countsWithoutCommands) {
    const auto file = fileOf(writtenTube(1));
    OPEN_WITH_OR_SKIP(file);
    const OnCpu cpu(file);
    for (const uint32_t budget : {0u, 1u, 300u, 1000u, 100000u, 2000u, 0u}) {  // more budgets than are kept
        const WriteCase c{"", 0, 0, {}, {}, budget};
        const DplSplatOptions options = c.options();
        DplWritten written{sizeof written};
        ASSERT_EQ(dplVulkanWriteSplats(avatar_, VK_NULL_HANDLE, 99, &options, nullptr, &written), DPL_OK) << dplGetLastError();
        EXPECT_EQ(written.count, cpu.count(c)) << budget;
    }
}

TEST_F(WriteTest, warmWritesAllocateNothing) {
    OPEN_WITH_OR_SKIP(fileOf(writtenTube(3)), false);
    const WriteCase c{"warm", 0.3f, 0, {}, Vec3f(0, 1, 2), 0, 3}, thin{"warm, thin", 0.3f, 0, {}, {}, 500, 0};
    c.pose(avatar_);
    const DplCamera camera = frontCamera(kWidth, kHeight);
    const uint64_t count = 5 * 2 * 12 * 16;
    const Layout layout = interleaved(count, 3), small = mixed(count, 0);
    AppBuffer &into = bufferOf(layout.bytes), &intoSmall = bufferOf(small.bytes);
    uint64_t allocations = 0;
    for (uint32_t n = 0; n < 12; ++n) {
        const uint32_t slot = n % DPL_VULKAN_SLOTS;
        const VkCommandBuffer commands = app_->begin(slot);
        ASSERT_EQ(dplVulkanPrepare(context_, commands, slot, &avatar_, 1, &camera, 1, nullptr), DPL_OK) << dplGetLastError();
        AllocationCount counted(CountedThreads::Own);
        const bool recorded = record(commands, slot, c, layout, into) == DPL_OK && record(commands, slot, thin, small, intoSmall) == DPL_OK;
        if (n >= DPL_VULKAN_SLOTS) allocations += counted.stop();
        ASSERT_TRUE(recorded) << dplGetLastError();
        app_->submit(slot);
    }
    EXPECT_EQ(allocations, 0u);
}

TEST_F(WriteTest, mistakesGetASentenceAndWriteNothing) {
    const auto file = fileOf(writtenTube(1));
    OPEN_WITH_OR_SKIP(file);
    const uint64_t count = 5 * 2 * 12 * 16;
    AppBuffer& into = bufferOf(count * 64);
    const VkCommandBuffer commands = app_->begin(0);
    const WriteCase plain{"plain"};
    const Layout good{{at(DPL_SPLAT_POSITION, 0)}, count * 64};
    EXPECT_EQ(record(commands, 0, plain, good, into), DPL_ERROR_INVALID_ARGUMENT);
    EXPECT_TRUE(says("slot 0 was not begun; call dplVulkanPrepare, or dplVulkanUpload")) << dplGetLastError();
    ASSERT_EQ(dplVulkanUpload(context_, commands, 0), DPL_OK) << dplGetLastError();
    const struct {
        const char* sentence;
        std::vector<DplBufferElement> elements;
        uint64_t bytes = ~0ull;
    } mistakes[] = {
        {"on a GPU both must be multiples of 4", {at(DPL_SPLAT_POSITION, 2, 16)}},
        {"on a GPU both must be multiples of 4", {at(DPL_SPLAT_ROTATION, 0, 30)}},
        {"with 6 bytes from row to row; on a GPU both must be multiples of 4", {at(DPL_SPLAT_SCALE, 0, 0, DPL_NUMBER_HALF)}},
        {"position (element 0) and opacity (element 1) overlap", {at(DPL_SPLAT_POSITION, 0, 16), at(DPL_SPLAT_OPACITY, 8, 16)}},
        {"has a stride of 8 bytes, but takes 12", {at(DPL_SPLAT_POSITION, 0, 8)}},
        {"does not fit", {at(DPL_SPLAT_POSITION, 0)}, 12 * count - 4},
        {"does not fit: 1920 rows of 8 bytes", {at(DPL_SPLAT_POSITION, 0, 8, DPL_NUMBER_HALF)}, 8 * count - 2},
        {"is of property 8, which does not exist", {at(DplSplatProperty(8), 0)}},
        {"the buffer has 0 elements", {}},
    };
    for (const auto& m : mistakes) {
        EXPECT_EQ(record(commands, 0, plain, {m.elements, std::min(m.bytes, good.bytes)}, into), DPL_ERROR_INVALID_ARGUMENT) << m.sentence;
        EXPECT_TRUE(says(m.sentence)) << dplGetLastError();
        EXPECT_EQ(written_.count, 0u);
    }
    const auto expectRefused = [&](const char* sentence, DplResult result) {
        EXPECT_EQ(result, DPL_ERROR_INVALID_ARGUMENT) << sentence;
        EXPECT_TRUE(says(sentence)) << dplGetLastError();
    };
    expectRefused("slot 3 does not exist", record(commands, 3, plain, good, into));
    expectRefused("slot 1 was not begun", record(commands, 1, plain, good, into));
    expectRefused("commands is NULL", record(VK_NULL_HANDLE, 0, plain, good, into));
    expectRefused("buffer of the buffer is NULL", record(commands, 0, plain, good, {}));
    expectRefused("SH of degree 4", record(commands, 0, {"", 0, 0, {}, {}, 0, 4}, good, into));
    expectRefused("the eye is at", record(commands, 0, {"", 0, 0, {}, Vec3f(NAN)}, good, into));
    const OnCpu cpu(file);
    const DplVulkanBuffer buffer{sizeof buffer, 1, good.elements.data(), into.buffer, good.bytes};
    expectRefused("make it with dplCreateVulkanContext", dplVulkanWriteSplats(cpu.avatar, commands, 0, nullptr, &buffer, &written_));
    for (int n = 0; n < 16; ++n) ASSERT_EQ(record(commands, 0, plain, good, into), DPL_OK) << dplGetLastError();
    expectRefused("has 16 writes of this avatar already", record(commands, 0, plain, good, into));
    ASSERT_EQ(dplVulkanDropSlot(context_, 0), DPL_OK);
    expectRefused("slot 0 was not begun", record(commands, 0, plain, good, into));
    app_->submit(0);
    app_->waitAll();
}

}  // namespace
}  // namespace dpl::test
