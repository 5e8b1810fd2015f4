// SPDX-License-Identifier: Apache-2.0
// dplMetalWriteSplats on the software device: the splats in a program's buffer are those of the CPU, and no hazard, index or binding is
// wrong. What it refuses is shared with Vulkan (tests/unit/interop/write_test.cpp), but for what is Metal's own.
#include "tests/metal/metal_app.h"
#include "tests/unit/interop/written_splats.h"

namespace dpl::mtl {
namespace {

using namespace dpl::test;

class MetalWrite : public MetalApp {
protected:
    void load(const std::vector<uint8_t>& file) {
        ASSERT_EQ(dplDestroyAvatar(avatar_), DPL_OK);
        ASSERT_EQ(dplLoadAvatar(context_, file.data(), file.size(), &avatar_), DPL_OK) << dplGetLastError();
    }
    void TearDown() override {
        if (device_) device_->finish();
        for (BufferRef& buffer : buffers_) app_->release(buffer);
        MetalApp::TearDown();
    }
    BufferRef bufferOf(uint64_t bytes) {
        buffers_.push_back(app_->newBuffer(bytes, StorageMode::Shared, "rows"));
        std::memset(app_->contents(buffers_.back()), 0xAB, bytes);
        return buffers_.back();
    }
    DplResult encode(CommandsRef commands, uint32_t slot, const WriteCase& c, const Layout& layout, BufferRef into) {
        const DplSplatOptions options = c.options();
        const DplMetalBuffer buffer{sizeof buffer, uint32_t(layout.elements.size()), layout.elements.data(), into.object, layout.bytes};
        written_ = {sizeof written_};
        return dplMetalWriteSplats(avatar_, commands.object, slot, &options, &buffer, &written_);
    }
    std::vector<uint8_t> held(BufferRef buffer, uint64_t bytes) {
        const auto* data = reinterpret_cast<const uint8_t*>(app_->contents(buffer));
        return {data, data + bytes};
    }

    DplWritten written_{};
    std::vector<BufferRef> buffers_;
};

TEST_F(MetalWrite, theShaderWritesTheSplatsOfTheCpu) {
    open();
    Differences worst{};
    double leastDb = 1000;
    for (const uint32_t shDegree : {3u, 0u}) {
        const auto file = fileOf(writtenTube(shDegree));
        load(file);
        const OnCpu cpu(file);
        uint32_t slot = 0;
        for (const WriteCase& c : writeCases()) {
            c.pose(cpu.avatar), c.pose(avatar_);
            const uint32_t count = cpu.count(c);
            std::vector<uint8_t> want[2], got[2];
            const Layout layouts[2] = {interleaved(count, c.shDegree), mixed(count, c.shDegree)};
            CommandsRef commands = app_->commandBuffer();
            ASSERT_EQ(dplMetalUpload(context_, commands.object, slot), DPL_OK) << dplGetLastError();
            BufferRef into[2];
            for (int i = 0; i < 2; ++i) {
                into[i] = bufferOf(layouts[i].bytes);
                ASSERT_EQ(encode(commands, slot, c, layouts[i], into[i]), DPL_OK) << dplGetLastError();
                EXPECT_EQ(written_.count, count);
                EXPECT_EQ(written_.saturated, 0u);
            }
            app_->commit(commands);
            app_->wait(commands);
            app_->release(commands);
            slot = (slot + 1) % DPL_METAL_SLOTS;
            for (int i = 0; i < 2; ++i) {
                cpu.write(c, layouts[i], want[i]);
                got[i] = held(into[i], layouts[i].bytes);
                expectSameSplats(cpu, c, layouts[i], want[i], got[i], worst);
                if (HasFatalFailure()) return;
            }
            if (c.name == "joint at 180 degrees" || c.name == "one splat a group")
                leastDb = std::min(leastDb, picturesDb(c, want[0], got[0], tubeCamera(96, 96, std::atan2(c.eye->x, c.eye->z), 1.5f)));
        }
    }
    print("Metal", worst);
    std::printf("[  WRITTEN ] pictures of both by the referee: %.1f dB at least\n", leastDb);
    EXPECT_GE(leastDb, 60);
}

TEST_F(MetalWrite, aFrameThatDrawsTheAvatarWritesAndDrawsTheSame) {
    open();
    const OnCpu cpu(tubeFile());
    const WriteCase c{"drawn", 0.5f, 0.2f, {}, Vec3f(0, 1, -2), 900, 1};
    c.pose(cpu.avatar), c.pose(avatar_);
    const DplCamera view = camera();
    const Picture picture = pictureOf(view);
    const uint32_t into = composer(PixelFormat::RGBA8Unorm);
    const TextureRef colour = texture(PixelFormat::RGBA8Unorm);
    const Layout layout = mixed(cpu.count(c), 1);
    std::vector<uint8_t> want;
    cpu.write(c, layout, want);
    for (uint32_t slot = 0; slot < 2; ++slot) {
        const BufferRef rows = bufferOf(layout.bytes);
        const CommandsRef commands = prepared(slot, {&view, 1});
        ASSERT_EQ(encode(commands, slot, c, layout, rows), DPL_OK) << dplGetLastError();
        const RenderEncoderRef encoder = begin(commands, {.colour = colour});
        EXPECT_EQ(dplMetalCompose(context_, into, encoder.object, slot, 0, 0, 0), DPL_OK) << dplGetLastError();
        end(encoder), commit(commands);
        EXPECT_GT(reference::psnrDb(TargetFormat::Rgba8, download(colour, 0, 4), over(picture, TargetFormat::Rgba8)), 60);
        Differences worst{};
        expectSameSplats(cpu, c, layout, want, held(rows, layout.bytes), worst);
    }
}

TEST_F(MetalWrite, mistakesGetASentence) {
    open();
    const Layout good{{at(DPL_SPLAT_POSITION, 0)}, 1 << 20};
    const BufferRef rows = bufferOf(good.bytes);
    CommandsRef commands = app_->commandBuffer();
    const WriteCase plain{"plain"};
    const auto expectRefused = [&](const char* sentence, DplResult result) {
        EXPECT_EQ(result, DPL_ERROR_INVALID_ARGUMENT) << sentence;
        EXPECT_NE(std::string(dplGetLastError()).find(sentence), std::string::npos) << dplGetLastError();
    };
    expectRefused("slot 0 was not begun; call dplMetalPrepare, or dplMetalUpload", encode(commands, 0, plain, good, rows));
    ASSERT_EQ(dplMetalUpload(context_, commands.object, 0), DPL_OK);
    expectRefused("on a GPU both must be multiples of 4", encode(commands, 0, plain, {{at(DPL_SPLAT_POSITION, 1)}, good.bytes}, rows));
    expectRefused("buffer of the buffer is NULL", encode(commands, 0, plain, good, {}));
    expectRefused("commands is NULL", encode({}, 0, plain, good, rows));
    const auto untouched = held(rows, good.bytes);
    app_->commit(commands);
    app_->wait(commands);
    app_->release(commands);
    EXPECT_EQ(held(rows, good.bytes), untouched);
}

}  // namespace
}  // namespace dpl::mtl
