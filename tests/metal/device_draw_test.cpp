// SPDX-License-Identifier: Apache-2.0
// The software device draws triangles by Metal's rules, and finds planted faults in passes and pipelines.
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <random>

#include "tests/metal/cpu/msl_entry.h"
#include "tests/metal/software/software_device.h"

namespace dpl::mtl {
namespace {

constexpr uint32_t kSizePx = 16;

struct Corner {
    float x, y, z, w;  // x, y: pixels, divided by w like z
    float value[4];
};
Corner at(float x, float y, float value = 1) {
    return {x, y, 0, 1, {value, 0, 0, 1}};
}

/** A target of floats, and a pipeline that adds what it draws. */
class MetalDraw : public testing::Test {
protected:
    struct Setup {
        uint32_t samples = 1, layers = 1;
        bool layered = false, depth = false;
        PipelineColour first{PixelFormat::RGBA16Float, true, true, BlendFactor::One, BlendFactor::One, BlendFactor::One};
        PixelFormat pipelineFormat = PixelFormat::RGBA16Float;
        uint32_t usage = kUsageRenderTarget | kUsageShaderRead;
        PrimitiveType type = PrimitiveType::Triangle;
        uint32_t instances = 1;
        CompareFunction nearer = CompareFunction::Less;
        const char* fragment = "triangle.frag";
    };

    ~MetalDraw() override {
        device_.finish();
        EXPECT_EQ(device_.takeFaults(), std::vector<std::string>());
        EXPECT_EQ(device_.alive(), std::vector<std::string>());
    }

    FunctionRef function(const char* name) {
        std::string error;
        LibraryRef library = seam_->newLibrary(msl::entryNamed(name)->text, error);
        EXPECT_TRUE(library) << error;
        const FunctionRef made = seam_->newFunction(library, "main0");
        seam_->release(library);
        return made;
    }

    RenderPipelineRef pipeline(const Setup& how, std::string& error) {
        RenderPipelineDesc desc;
        desc.label = "triangles";
        desc.vertex = function("triangle.vert"), desc.fragment = function(how.fragment);
        desc.colours[0] = how.first;
        desc.colours[0].format = how.pipelineFormat;
        desc.colours[1].format = PixelFormat::RG32Float;
        if (how.depth) desc.depth = PixelFormat::Depth32Float;
        desc.samples = how.samples;
        desc.layered = true;  // the vertex shader writes a layer
        const RenderPipelineRef made = seam_->newRenderPipeline(desc, error);
        seam_->release(desc.vertex);
        seam_->release(desc.fragment);
        return made;
    }

    TextureRef texture(PixelFormat format, const Setup& how, uint32_t samples) {
        return seam_->newTexture({samples == 1 ? TextureType::Array : TextureType::ArraySamples, format, kSizePx, kSizePx, how.layers,
                                  samples, StorageMode::Private, how.usage},
                                 "target");
    }

    /** Draws, then reads the first component of every pixel of colour (0) or the flat values (1), layer after layer. */
    std::vector<float> draw(const Setup& how, const std::vector<Corner>& corners, int output = 0) {
        std::string error;
        RenderPipelineRef made = pipeline(how, error);
        EXPECT_TRUE(made) << error;
        TextureRef targets[2] = {texture(PixelFormat::RGBA16Float, how, 1), texture(PixelFormat::RG32Float, how, 1)};
        TextureRef many[2] = {}, depth = how.depth ? texture(PixelFormat::Depth32Float, how, how.samples) : TextureRef{};
        if (how.samples > 1) many[0] = texture(PixelFormat::RGBA16Float, how, 4), many[1] = texture(PixelFormat::RG32Float, how, 4);
        BufferRef vertices = seam_->newBuffer(32 * corners.size(), StorageMode::Shared, "vertices");
        auto* to = reinterpret_cast<float*>(seam_->contents(vertices));
        for (const Corner& c : corners) {
            const float place[4] = {(c.x / kSizePx * 2 - 1) * c.w, (1 - c.y / kSizePx * 2) * c.w, c.z * c.w, c.w};
            std::memcpy(to, place, 16), std::memcpy(to + 4, c.value, 16);
            to += 8;
        }
        DepthStencilRef state = how.depth ? seam_->newDepthStencil(how.nearer, true) : DepthStencilRef{};
        const uint32_t bytes = kSizePx * kSizePx * 8;
        BufferRef pixels = seam_->newBuffer(bytes * how.layers, StorageMode::Shared, "pixels");

        CommandsRef commands = seam_->commandBuffer();
        RenderPassDesc pass;
        for (int i = 0; i < 2; ++i) {
            pass.colours[i].texture = many[i] ? many[i] : targets[i];
            if (many[i]) pass.colours[i].resolve = targets[i], pass.colours[i].store = StoreAction::Resolve;
        }
        if (how.depth) pass.depth.texture = depth, pass.depth.clear[0] = how.nearer == CompareFunction::Less ? 1 : 0;
        pass.layers = how.layered ? how.layers : 0;
        FenceRef fence = seam_->newFence();
        RenderEncoderRef encoder = seam_->renderEncoder(commands, pass);
        if (encoder) {
            seam_->setPipeline(encoder, made);
            if (state) seam_->setDepthStencil(encoder, state);
            seam_->setVertexBuffer(encoder, vertices, 0, 0);
            if (how.fragment == std::string_view("discard.frag")) seam_->setFragmentBuffer(encoder, vertices, 0, 0);
            seam_->draw(encoder, how.type, uint32_t(corners.size()), how.instances);
            seam_->updateFence(encoder, fence, kStageFragment);
            seam_->end(encoder);
            seam_->release(encoder);
        }
        BlitEncoderRef blit = seam_->blitEncoder(commands);
        seam_->waitFence(blit, fence);
        for (uint32_t layer = 0; layer < how.layers; ++layer)
            seam_->copyTexture(blit, targets[output], layer, kSizePx, kSizePx, pixels, layer * bytes, kSizePx * 8);
        seam_->end(blit);
        seam_->release(blit);
        seam_->commit(commands);
        seam_->wait(commands);
        std::vector<float> values;
        for (uint32_t i = 0; i < kSizePx * kSizePx * how.layers; ++i) {
            float value;
            std::memcpy(&value, seam_->contents(pixels) + 8 * i, 4);
            if (output == 0) {
                uint16_t half;
                std::memcpy(&half, seam_->contents(pixels) + 8 * i, 2);
                value = half == 0 ? 0 : std::ldexp(1 + float(half & 1023) / 1024, (half >> 10) - 15);
            }
            values.push_back(value);
        }
        for (TextureRef t : {targets[0], targets[1], many[0], many[1], depth}) seam_->release(t);
        seam_->release(vertices), seam_->release(pixels), seam_->release(fence), seam_->release(state), seam_->release(made);
        seam_->release(commands);
        return values;
    }

    void expectFault(const std::string& text) {
        const std::vector<std::string> faults = device_.takeFaults();
        ASSERT_EQ(faults.size(), 1u) << testing::PrintToString(faults);
        EXPECT_NE(faults[0].find(text), std::string::npos) << faults[0];
    }

    SoftwareDevice device_;
    std::unique_ptr<Seam> seam_ = device_.seam();
};

TEST_F(MetalDraw, coversPixelsWhoseCentresLieInside) {
    const auto pixels = draw({}, {at(0, 0), at(8, 0), at(0, 8)});
    for (uint32_t y = 0; y < kSizePx; ++y)
        for (uint32_t x = 0; x < kSizePx; ++x)  // centres on the slanted edge, which is neither top nor left, are outside
            EXPECT_EQ(pixels[y * kSizePx + x], x + y < 7 ? 1 : 0) << x << " " << y;
}

/** Triangles around a point share all inner edges. A pixel that two draw, or none, breaks the top-left rule. */
TEST_F(MetalDraw, neighboursShareNoPixelAndLeaveNone) {
    std::mt19937 random(3);
    for (const uint32_t samples : {1u, 4u}) {
        for (int round = 0; round < 12; ++round) {
            const float halves[4] = {5.5f, 8, 7.375f, 9.125f};  // on pixel centres, corners and sample positions
            const float x = halves[random() % 4], y = halves[random() % 4];
            const Corner around[] = {at(-1, -1), at(8, -1), at(17, -1), at(17, 8.5f), at(17, 17), at(3.5f, 17), at(-1, 17)};
            std::vector<Corner> corners;
            for (size_t i = 0; i < std::size(around); ++i) {
                Corner of[3] = {at(x, y), around[i], around[(i + 1) % std::size(around)]};
                if (round % 2) std::swap(of[1], of[2]);  // either winding
                corners.insert(corners.end(), of, of + 3);
            }
            for (const float value : draw({.samples = samples}, corners)) ASSERT_EQ(value, 1) << samples << " samples, round " << round;
        }
    }
}

TEST_F(MetalDraw, fourSamplesLieWhereMetalPutsThem) {
    for (int eighths = 0; eighths <= 8; ++eighths) {  // the part of a pixel left of an edge holds the samples at 1, 3, 5 and 7 eighths
        const float edge = 4 + float(eighths) / 8;
        const auto pixels = draw({.samples = 4}, {at(-20, -20), at(edge, -20), at(edge, 60), at(-20, -20), at(edge, 60), at(-20, 60)});
        EXPECT_EQ(pixels[5 * kSizePx + 4], float(eighths / 2) / 4) << edge;
        EXPECT_EQ(pixels[5 * kSizePx + 3], 1);
    }
}

TEST_F(MetalDraw, interpolatesWithPerspectiveAndKeepsTheFirstVertexWhereFlat) {
    const std::vector<Corner> corners = {
        {0, 0, 0, 1, {0, 0, 0, 1}}, {16, 0, 0, 4, {1, 0, 0, 1}}, {0, 16, 0, 1, {0, 0, 0, 1}}, {16, 16, 0, 4, {1, 0, 0, 1}}};
    const Setup strip{.type = PrimitiveType::Strip};
    const auto value = draw(strip, corners), first = draw(strip, corners, 1);
    for (uint32_t x = 0; x < kSizePx; ++x) {
        const float t = (float(x) + 0.5f) / kSizePx, want = t / 4 / (1 - t + t / 4);  // value/w over 1/w, linear on the screen
        EXPECT_NEAR(value[3 * kSizePx + x], want, 1e-3) << x;                         // of a 16-bit float below 1: 5e-4
    }
    EXPECT_EQ(first[0], 0);
    EXPECT_EQ(first[15 * kSizePx + 15], 1) << "the second triangle of a strip begins with the second vertex";
}

TEST_F(MetalDraw, eachInstanceDrawsIntoItsLayer) {
    const std::vector<Corner> all = {at(-1, -1), at(40, -1), at(-1, 40)};
    const auto pixels = draw({.layers = 2, .layered = true, .instances = 2}, all);
    EXPECT_EQ(pixels.front(), 1);
    EXPECT_EQ(pixels.back(), 1);
    draw({.layers = 2, .layered = true, .instances = 3}, all);
    expectFault("draws into layer 2 of 2");
}

TEST_F(MetalDraw, depthHidesWhatIsFarther) {
    const auto with = [](float z, float value) {
        std::vector<Corner> list = {at(-1, -1, value), at(40, -1, value), at(-1, 40, value)};
        for (Corner& c : list) c.z = z;
        return list;
    };
    std::vector<Corner> both = with(0.5f, 1), farther = with(0.7f, 2);
    both.insert(both.end(), farther.begin(), farther.end());
    EXPECT_EQ(draw({.depth = true}, both)[0], 1);
    EXPECT_EQ(draw({.depth = true, .nearer = CompareFunction::Greater}, both)[0], 3) << "reversed: both, one after the other";
    EXPECT_EQ(draw({}, both)[0], 3);
}

TEST_F(MetalDraw, discardedFragmentsChangeNothing) {
    std::vector<Corner> corners = {at(-1, -1), at(40, -1), at(-1, 40)};
    for (Corner& c : corners) c.value[3] = -1;
    EXPECT_EQ(draw({}, corners)[0], 0);
    EXPECT_EQ(draw({}, corners, 1)[0], 0);
}

TEST_F(MetalDraw, findsAnIndexBeyondABufferInADiscardedFragment) {
    Setup how;
    how.fragment = "discard.frag";
    const auto reading = [](float element) { return std::vector<Corner>{at(-1, -1, element), at(40, -1, element), at(-1, 40, element)}; };
    EXPECT_EQ(draw(how, reading(5)).front(), 0) << "the last of the six elements is there, and nothing is drawn";
    draw(how, reading(6));
    expectFault("discard.frag uses an element beyond the 96 bytes of buffer(0)");
}

TEST_F(MetalDraw, findsPassesAndPipelinesThatDoNotFit) {
    const std::vector<Corner> all = {at(-1, -1), at(40, -1), at(-1, 40)};
    draw({.pipelineFormat = PixelFormat::RGBA8Unorm}, all);
    expectFault("color(0) has MTLPixelFormat 115, and the pipeline was made for 70");
    draw({.usage = kUsageShaderRead}, all);
    expectFault("no MTLTextureUsageRenderTarget");
    std::string error;
    EXPECT_FALSE(pipeline({.samples = 3}, error));
    EXPECT_NE(error.find("no 3 samples"), std::string::npos) << error;
}

TEST_F(MetalDraw, findsAMissingViewMaskAndAVertexBeyondTheBuffer) {
    std::string error;
    RenderPipelineDesc desc;
    desc.vertex = function("compose.vert.multiview"), desc.fragment = function("triangle.frag");
    desc.colours[0].format = PixelFormat::RGBA16Float, desc.colours[1].format = PixelFormat::RG32Float;
    EXPECT_FALSE(seam_->newRenderPipeline(desc, error));
    EXPECT_NE(error.find("inputPrimitiveTopology is not set"), std::string::npos) << error;
    desc.layered = true;
    error.clear();
    RenderPipelineRef made = seam_->newRenderPipeline(desc, error);
    ASSERT_TRUE(made) << error;
    TextureRef targets[2] = {texture(PixelFormat::RGBA16Float, {}, 1), texture(PixelFormat::RG32Float, {}, 1)};
    CommandsRef commands = seam_->commandBuffer();
    RenderPassDesc pass;
    pass.colours[0].texture = targets[0], pass.colours[1].texture = targets[1];
    RenderEncoderRef encoder = seam_->renderEncoder(commands, pass);
    seam_->setPipeline(encoder, made);
    seam_->draw(encoder, PrimitiveType::Triangle, 3, 1);
    expectFault("needs buffer(24) 'spvViewMask', which is not bound");
    RenderPipelineRef own = pipeline({}, error);
    BufferRef vertices = seam_->newBuffer(64, StorageMode::Shared, "two vertices");
    const float two[16] = {0, 0, 0, 1, 0, 0, 0, 1, 1, 0, 0, 1, 0, 0, 0, 1};
    std::memcpy(seam_->contents(vertices), two, sizeof two);
    seam_->setPipeline(encoder, own);
    seam_->setVertexBuffer(encoder, vertices, 0, 0);
    seam_->draw(encoder, PrimitiveType::Triangle, 3, 1);
    seam_->end(encoder);
    seam_->commit(commands);
    seam_->wait(commands);
    const std::vector<std::string> faults = device_.takeFaults();
    ASSERT_FALSE(faults.empty());
    EXPECT_NE(faults[0].find("triangle.vert uses an element beyond the 64 bytes of buffer(0)"), std::string::npos) << faults[0];
    seam_->release(encoder), seam_->release(commands), seam_->release(made), seam_->release(own), seam_->release(vertices);
    seam_->release(desc.vertex), seam_->release(desc.fragment), seam_->release(targets[0]), seam_->release(targets[1]);
}

TEST_F(MetalDraw, findsTexturesThatCannotBe) {
    const auto make = [&](TextureDesc desc) { return bool(seam_->newTexture(desc, "odd")); };
    EXPECT_FALSE(make({.layers = 0}));
    expectFault("a size is zero");
    EXPECT_FALSE(make({.type = TextureType::Flat, .layers = 2}));
    expectFault("arrayLength 2");
    EXPECT_FALSE(make({.samples = 4}));
    expectFault("sampleCount 4");
    EXPECT_FALSE(make({.format = PixelFormat::Depth32Float, .storage = StorageMode::Shared}));
    expectFault("must be private or memoryless");
    EXPECT_FALSE(make({.storage = StorageMode::Memoryless, .usage = kUsageRenderTarget | kUsageShaderRead}));
    expectFault("can only be a render target");
}

TEST_F(MetalDraw, findsMemorylessAttachmentsThatAreStored) {
    TextureRef target = seam_->newTexture({.widthPx = 4, .heightPx = 4, .storage = StorageMode::Memoryless}, "tile memory");
    CommandsRef commands = seam_->commandBuffer();
    RenderPassDesc pass;
    pass.colours[0].texture = target;
    EXPECT_FALSE(seam_->renderEncoder(commands, pass));
    expectFault("is memoryless and cannot be stored");
    pass.colours[0].store = StoreAction::DontCare, pass.colours[0].load = LoadAction::Load;
    EXPECT_FALSE(seam_->renderEncoder(commands, pass));
    expectFault("is memoryless and cannot be loaded");
    seam_->release(commands);
    seam_->release(target);
}

}  // namespace
}  // namespace dpl::mtl
