// SPDX-License-Identifier: Apache-2.0
// Both renderers draw the same pictures through the API. DPL_RENDERER_AUTO never picks an emulated GPU.
#include <algorithm>
#include <cmath>

#include "sdk/format/ply.h"
#include "tests/reference/random_avatar.h"
#include "tests/unit/api/api_fixture.h"

namespace dpl::test {
namespace {

double psnrDb(const std::vector<uint8_t>& a, const std::vector<uint8_t>& b) {
    double sum = 0;
    for (size_t i = 0; i < a.size(); ++i) sum += (double(a[i]) - double(b[i])) * (double(a[i]) - double(b[i]));
    return 10 * std::log10(255.0 * 255.0 * double(a.size()) / std::max(sum, 1e-9));
}

/** Each test runs with the fill that the self-test chooses, with quads and with tiles. */
class ApiVulkan : public ApiTest, public testing::WithParamInterface<DplFill> {
protected:
    DplContextInfo info{sizeof(DplContextInfo), DPL_RENDERER_VULKAN, 1, 0, GetParam(), nullptr};
};
INSTANTIATE_TEST_SUITE_P(Fill, ApiVulkan, testing::Values(DPL_FILL_AUTO, DPL_FILL_QUADS, DPL_FILL_TILES));

TEST_P(ApiVulkan, drawsWhatTheCpuDraws) {
    DplContext context = nullptr;
    const DplResult made = dplCreateContext(&info, &context);
    if (made == DPL_ERROR_UNSUPPORTED) {
        EXPECT_EQ(context, nullptr);
        EXPECT_TRUE(errorSays("DPL_RENDERER_SOFTWARE")) << "the sentence names the way out: " << dplGetLastError();
        GTEST_SKIP() << dplGetLastError();
    }
    ASSERT_EQ(made, DPL_OK) << dplGetLastError();
    const char* name = nullptr;
    ASSERT_EQ(dplGetRendererName(context, &name), DPL_OK);
    EXPECT_EQ(std::string(name).find("vulkan: "), 0u) << name;
    const bool tiles = std::string(name).ends_with(" (tiles)"), quads = std::string(name).ends_with(" (quads)");
    EXPECT_NE(tiles, quads) << "the name says what was chosen: " << name;
    if (GetParam() != DPL_FILL_AUTO) {
        EXPECT_EQ(tiles, GetParam() == DPL_FILL_TILES) << name;
    }
    const auto bytes = tinyFile();
    DplAvatar avatar = nullptr;
    ASSERT_EQ(dplLoadAvatar(context, bytes.data(), bytes.size(), &avatar), DPL_OK) << dplGetLastError();
    DplWritten written{sizeof written};
    EXPECT_EQ(dplWriteSplats(avatar, nullptr, nullptr, &written), DPL_ERROR_UNSUPPORTED);
    EXPECT_TRUE(errorSays("memory of the GPU")) << dplGetLastError();
    EXPECT_EQ(dplWriteMesh(avatar, nullptr, &written), DPL_OK) << dplGetLastError();
    const DplCamera cameras[2] = {frontCamera(96, 80, 0.03f), frontCamera(96, 80, -0.03f)};
    std::vector<uint8_t> cpu[2], gpu[2];
    std::vector<float> cpuDepth[2], gpuDepth[2], cpuMesh[2], gpuMesh[2];
    for (const double t : {0.0, 0.4}) {
        DplImage cpuImages[2] = {imageFor(cameras[0], cpu[0], &cpuDepth[0]), imageFor(cameras[1], cpu[1], &cpuDepth[1])};
        DplImage gpuImages[2] = {imageFor(cameras[0], gpu[0], &gpuDepth[0]), imageFor(cameras[1], gpu[1], &gpuDepth[1])};
        for (int v = 0; v < 2; ++v) {
            for (auto* mesh : {&cpuMesh[v], &gpuMesh[v]}) mesh->assign(96 * 80, -1.0f);
            cpuImages[v].meshDepthM = cpuMesh[v].data(), gpuImages[v].meshDepthM = gpuMesh[v].data();
            cpuImages[v].meshDepthCount = gpuImages[v].meshDepthCount = 96 * 80;
        }
        ASSERT_EQ(dplSetPoseFromClip(avatar_, 0, t, DPL_FALSE), DPL_OK);
        ASSERT_EQ(dplSetPoseFromClip(avatar, 0, t, DPL_FALSE), DPL_OK);
        ASSERT_EQ(dplRender(context_, avatar_, cameras, 2, cpuImages), DPL_OK) << dplGetLastError();
        ASSERT_EQ(dplRender(context, avatar, cameras, 2, gpuImages), DPL_OK) << dplGetLastError();
        for (int v = 0; v < 2; ++v) {
            EXPECT_GT(*std::max_element(cpu[v].begin(), cpu[v].end()), 200);
            EXPECT_GT(psnrDb(cpu[v], gpu[v]), 45.0)
                << "view " << v << ": 8-bit blending of 128 splats rounds each one, half a level at a time";
            size_t compared = 0;
            for (size_t p = 0; p < cpuDepth[v].size(); ++p) {
                if (cpu[v][p * 4 + 3] < 128 || gpu[v][p * 4 + 3] < 128) continue;
                ++compared;
                EXPECT_NEAR(cpuDepth[v][p], gpuDepth[v][p], 0.02f) << "pixel " << p;
            }
            EXPECT_GT(compared, 200u);
            size_t differ = 0;
            for (size_t p = 0; p < cpuMesh[v].size(); ++p) differ += std::abs(cpuMesh[v][p] - gpuMesh[v][p]) > 1e-4f;
            EXPECT_LT(differ, 5u) << "a centre on an edge may go either way";
            EXPECT_GT(std::count_if(gpuMesh[v].begin(), gpuMesh[v].end(), [](float z) { return z > 2; }), 400);
        }
    }
    EXPECT_EQ(dplDestroyAvatar(avatar), DPL_OK);
    EXPECT_EQ(dplDestroyContext(context), DPL_OK);
}

TEST_P(ApiVulkan, drawsGeneralSplatsAsTheCpuDoes) {
    DplContext context = nullptr;
    const DplResult made = dplCreateContext(&info, &context);
    if (made == DPL_ERROR_UNSUPPORTED) GTEST_SKIP() << dplGetLastError();
    ASSERT_EQ(made, DPL_OK) << dplGetLastError();
    const auto bytes = *writePly(randomStaticSplats(3, 800, 2));
    DplAvatar cpu = nullptr, gpu = nullptr;
    ASSERT_EQ(dplLoadAvatar(context_, bytes.data(), bytes.size(), &cpu), DPL_OK) << dplGetLastError();
    ASSERT_EQ(dplLoadAvatar(context, bytes.data(), bytes.size(), &gpu), DPL_OK) << dplGetLastError();
    const DplCamera cameras[2] = {frontCamera(96, 80, 0.03f), frontCamera(96, 80, -0.03f)};
    std::vector<uint8_t> cpuPixels[2], gpuPixels[2];
    const DplImage cpuImages[2] = {imageFor(cameras[0], cpuPixels[0]), imageFor(cameras[1], cpuPixels[1])};
    const DplImage gpuImages[2] = {imageFor(cameras[0], gpuPixels[0]), imageFor(cameras[1], gpuPixels[1])};
    ASSERT_EQ(dplRender(context_, cpu, cameras, 2, cpuImages), DPL_OK) << dplGetLastError();
    ASSERT_EQ(dplRender(context, gpu, cameras, 2, gpuImages), DPL_OK) << dplGetLastError();
    for (int v = 0; v < 2; ++v) {
        EXPECT_GT(*std::max_element(cpuPixels[v].begin(), cpuPixels[v].end()), 200);
        EXPECT_GT(psnrDb(cpuPixels[v], gpuPixels[v]), 45.0) << "view " << v;
    }
    DplFrameStats stats{};
    stats.structSize = sizeof stats;
    ASSERT_EQ(dplGetFrameStats(gpu, &stats), DPL_OK) << dplGetLastError();
    if (GetParam() != DPL_FILL_AUTO) {
        EXPECT_EQ(stats.tileEntries > 0, GetParam() == DPL_FILL_TILES);
    }
    EXPECT_EQ(stats.tilesOverflowed, 0u);
    EXPECT_EQ(dplDestroyAvatar(cpu), DPL_OK);
    EXPECT_EQ(dplDestroyAvatar(gpu), DPL_OK);
    EXPECT_EQ(dplDestroyContext(context), DPL_OK);
}

TEST_F(ApiTest, autoIsARealGpuOrTheCpu) {
    DplContext context = nullptr;
    ASSERT_EQ(dplCreateContext(nullptr, &context), DPL_OK) << dplGetLastError();
    const char* name = nullptr;
    ASSERT_EQ(dplGetRendererName(context, &name), DPL_OK);
    EXPECT_EQ(std::string(name).find("llvmpipe"), std::string::npos) << name;
    EXPECT_EQ(dplDestroyContext(context), DPL_OK);
}

}  // namespace
}  // namespace dpl::test
