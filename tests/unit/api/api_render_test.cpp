// SPDX-License-Identifier: Apache-2.0
// Pictures through the public API: a red square 3 m away, whose correct picture is known.
#include <algorithm>
#include <cstring>
#include <limits>

#include "sdk/format/ply.h"
#include "tests/not_finite.h"
#include "tests/unit/api/api_fixture.h"

namespace dpl::test {
namespace {

TEST_F(ApiTest, redSquareIsRedHasDepthAndLeavesTheCornerEmpty) {
    const DplCamera camera = frontCamera();
    std::vector<uint8_t> pixels;
    std::vector<float> depth;
    const DplImage image = imageFor(camera, pixels, &depth);
    ASSERT_EQ(dplRender(context_, avatar_, &camera, 1, &image), DPL_OK) << dplGetLastError();
    const size_t middle = 30 * 64 + 32;
    EXPECT_GT(pixels[middle * 4], 220);
    EXPECT_LT(pixels[middle * 4 + 1], 12) << "colour is quantised in the file";
    EXPECT_GT(pixels[middle * 4 + 3], 220);
    EXPECT_NEAR(depth[middle], 3.0f, 0.01f);
    for (int c = 0; c < 4; ++c) EXPECT_EQ(pixels[size_t(c)], 0);
    EXPECT_EQ(depth[0], 0.0f);
    // The square is 1 m wide at 3 m with f = 60 px, so it covers 20 × 20 pixels in the middle.
    const auto covered = std::count_if(depth.begin(), depth.end(), [](float z) { return z > 0; });
    EXPECT_GT(covered, 400);
    EXPECT_LT(covered, 1600);
    for (size_t p = 0; p < 4096; ++p)
        for (size_t c = 0; c < 3; ++c) ASSERT_LE(pixels[p * 4 + c], pixels[p * 4 + 3]) << "premultiplied";
}

/** A plain PLY of one large red splat and a green one behind it. */
std::vector<uint8_t> splatFile(const PlyWriteOptions& options = {}) {
    StaticSplatData s;
    s.position = {{0, 1, 0}, {0, 1, -0.5f}}, s.rotation = {{1, 0, 0, 0}, {1, 0, 0, 0}};
    s.scaleM = {{0.3f, 0.3f, 0.01f}, {0.6f, 0.6f, 0.01f}}, s.opacity = {0.95f, 0.95f};
    s.sh = {1.7f, -1.7f, -1.7f, -1.7f, 1.7f, -1.7f};
    return *writePly(s, options);
}

TEST_F(ApiTest, generalSplatsAreDrawnByTheSameCalls) {
    const auto bytes = splatFile();
    DplAvatar splats = nullptr;
    ASSERT_EQ(dplLoadAvatar(context_, bytes.data(), bytes.size(), &splats), DPL_OK) << dplGetLastError();
    DplAvatarInfo info{};
    info.structSize = sizeof info;
    ASSERT_EQ(dplGetAvatarInfo(splats, &info), DPL_OK);
    EXPECT_STREQ(info.name, "PLY");
    EXPECT_EQ(info.splatCount, 2u);
    EXPECT_EQ(info.jointCount + info.triangleCount + info.vertexCount + info.clipCount, 0u);
    // The splats are larger than what lies between them: three deviations from the middle.
    EXPECT_FLOAT_EQ(info.restMin[2], -0.25f - 3 * 0.6f);
    EXPECT_FLOAT_EQ(info.restMax[2], -0.25f + 3 * 0.6f);
    const DplCamera cameras[2] = {frontCamera(64, 64, 0.03f), frontCamera(64, 64, -0.03f)};
    std::vector<uint8_t> both[2], alone;
    std::vector<float> depth;
    const DplImage images[2] = {imageFor(cameras[0], both[0], &depth), imageFor(cameras[1], both[1])};
    ASSERT_EQ(dplRender(context_, splats, cameras, 2, images), DPL_OK) << dplGetLastError();
    const size_t middle = 32 * 64 + 32;
    EXPECT_GT(both[0][middle * 4], 200);
    EXPECT_LT(both[0][middle * 4 + 1], 40);
    EXPECT_NEAR(depth[middle], 3.0f, 0.05f);
    const DplImage image = imageFor(cameras[1], alone);
    ASSERT_EQ(dplRender(context_, splats, &cameras[1], 1, &image), DPL_OK);
    EXPECT_EQ(both[1], alone);
    EXPECT_EQ(dplDestroyAvatar(splats), DPL_OK);
}

/** A file that states its axes stands upright, and the matrix says how it was turned; so a program may turn it back. */
TEST_F(ApiTest, fileAxesSayHowLoadingTurnedAFile) {
    DplFileAxes axes{};
    axes.structSize = sizeof axes;
    const float same[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1};
    ASSERT_EQ(dplGetFileAxes(avatar_, &axes), DPL_OK) << dplGetLastError();
    EXPECT_EQ(axes.stated, uint32_t(DPL_TRUE)) << "avatars are y up";
    EXPECT_TRUE(std::equal(same, same + 9, axes.loadedFromFile));
    struct Case {
        const char* letters;
        bool stated;
        float loadedFromFile[9];
    };
    const Case table[] = {{"", false, {1, 0, 0, 0, 1, 0, 0, 0, 1}},
                          {"RUB", true, {1, 0, 0, 0, 1, 0, 0, 0, 1}},
                          {"RDF", true, {1, 0, 0, 0, -1, 0, 0, 0, -1}},
                          {"RFU", true, {1, 0, 0, 0, 0, -1, 0, 1, 0}},   // z up: y lies along -z
                          {"LUB", true, {-1, 0, 0, 0, 1, 0, 0, 0, 1}}};  // mirrored
    for (const Case& c : table) {
        SCOPED_TRACE(c.letters);
        const auto bytes = splatFile({.axes = c.letters});
        DplAvatar splats = nullptr;
        ASSERT_EQ(dplLoadAvatar(context_, bytes.data(), bytes.size(), &splats), DPL_OK) << dplGetLastError();
        ASSERT_EQ(dplGetFileAxes(splats, &axes), DPL_OK) << dplGetLastError();
        EXPECT_EQ(axes.stated != 0, c.stated);
        for (int i = 0; i < 9; ++i) EXPECT_EQ(axes.loadedFromFile[i], c.loadedFromFile[i]) << i;
        EXPECT_EQ(dplDestroyAvatar(splats), DPL_OK);
    }
}

TEST_F(ApiTest, generalSplatsCannotBePosedAndSaySo) {
    const auto bytes = splatFile();
    DplAvatar splats = nullptr;
    ASSERT_EQ(dplLoadAvatar(context_, bytes.data(), bytes.size(), &splats), DPL_OK) << dplGetLastError();
    const float root[3] = {0, 1, 0};
    uint32_t clip = 0;
    EXPECT_EQ(dplSetPose(splats, root, 0, root), DPL_ERROR_INVALID_ARGUMENT);
    EXPECT_TRUE(errorSays("no joints")) << dplGetLastError();
    EXPECT_EQ(dplSetPoseFromClip(splats, 0, 0, DPL_FALSE), DPL_ERROR_INVALID_ARGUMENT);
    EXPECT_TRUE(errorSays("no joints")) << dplGetLastError();
    EXPECT_EQ(dplLoadClip(splats, bytes.data(), bytes.size(), nullptr, &clip), DPL_ERROR_INVALID_ARGUMENT);
    EXPECT_TRUE(errorSays("no joints")) << dplGetLastError();
    EXPECT_EQ(dplGetJointPositions(splats, nullptr, 0), DPL_ERROR_INVALID_ARGUMENT);
    EXPECT_EQ(dplDestroyAvatar(splats), DPL_OK);
    DplAvatar none = nullptr;
    EXPECT_EQ(dplLoadAvatar(context_, bytes.data(), bytes.size() - 1, &none), DPL_ERROR_CORRUPT_DATA);
    EXPECT_TRUE(errorSays("truncated")) << dplGetLastError();
    EXPECT_EQ(none, nullptr);
}

TEST_F(ApiTest, twoViewsAtOnceEqualEachAlone) {
    const DplCamera cameras[2] = {frontCamera(64, 48, 0.03f), frontCamera(64, 48, -0.03f)};
    std::vector<uint8_t> both[2], alone[2];
    std::vector<float> depth[2];
    const DplImage images[2] = {imageFor(cameras[0], both[0], &depth[0]), imageFor(cameras[1], both[1])};
    ASSERT_EQ(dplSetPoseFromClip(avatar_, 0, 0.3, DPL_FALSE), DPL_OK);
    ASSERT_EQ(dplRender(context_, avatar_, cameras, 2, images), DPL_OK) << dplGetLastError();
    for (int v = 0; v < 2; ++v) {
        const DplImage image = imageFor(cameras[v], alone[v]);
        ASSERT_EQ(dplRender(context_, avatar_, &cameras[v], 1, &image), DPL_OK);
        EXPECT_EQ(both[v], alone[v]);
    }
    EXPECT_NE(both[0], both[1]);
    EXPECT_TRUE(std::any_of(both[0].begin(), both[0].end(), [](uint8_t b) { return b > 200; }));
}

TEST_F(ApiTest, aContextInfoWithoutFlagsIsStillRead) {
    DplContextInfo info{12, DPL_RENDERER_SOFTWARE, 1, 0xFFFFFFFFu};  // version 0.1 ends before flags; the library must not read on
    DplContext context = nullptr;
    ASSERT_EQ(dplCreateContext(&info, &context), DPL_OK) << dplGetLastError();
    EXPECT_EQ(dplDestroyContext(context), DPL_OK);
    info.structSize = sizeof info;
    EXPECT_EQ(dplCreateContext(&info, &context), DPL_ERROR_INVALID_ARGUMENT);
    EXPECT_TRUE(errorSays("unknown flags"));
    info.flags = 1;  // a measuring switch until 0.1
    EXPECT_EQ(dplCreateContext(&info, &context), DPL_ERROR_INVALID_ARGUMENT) << "no flag is defined";
    info.flags = 0;
    ASSERT_EQ(dplCreateContext(&info, &context), DPL_OK) << dplGetLastError();
    EXPECT_EQ(dplDestroyContext(context), DPL_OK);
    const int32_t unknown = 7;
    std::memcpy(&info.fill, &unknown, sizeof unknown);
    EXPECT_EQ(dplCreateContext(&info, &context), DPL_ERROR_INVALID_ARGUMENT);
    EXPECT_TRUE(errorSays("there is no fill 7"));
    info.structSize = offsetof(DplContextInfo, fill);  // the struct before `fill` was added; the library must not read on
    ASSERT_EQ(dplCreateContext(&info, &context), DPL_OK) << dplGetLastError();
    EXPECT_EQ(dplDestroyContext(context), DPL_OK);
}

TEST_F(ApiTest, statsWithoutTilesAreStillWritten) {
    DplFrameStats stats{};
    stats.structSize = offsetof(DplFrameStats, tileEntries);
    stats.tileEntries = 77;
    ASSERT_EQ(dplGetFrameStats(avatar_, &stats), DPL_OK) << dplGetLastError();
    EXPECT_GT(stats.residentBytes, 0u);
    EXPECT_EQ(stats.tileEntries, 77u) << "beyond the caller's struct";
}

TEST_F(ApiTest, statsOfTheLastFrameAreThereAfterIt) {
    DplFrameStats stats{};
    EXPECT_EQ(dplGetFrameStats(avatar_, &stats), DPL_ERROR_INVALID_ARGUMENT) << "structSize is not set";
    stats.structSize = sizeof stats;
    ASSERT_EQ(dplGetFrameStats(avatar_, &stats), DPL_OK) << dplGetLastError();
    EXPECT_EQ(stats.viewCount, 0u);
    EXPECT_EQ(stats.splatsDrawn, 0u);
    EXPECT_GT(stats.residentBytes, 0u);
    const DplCamera camera = frontCamera();
    std::vector<uint8_t> pixels;
    const DplImage image = imageFor(camera, pixels);
    ASSERT_EQ(dplRender(context_, avatar_, &camera, 1, &image), DPL_OK);
    ASSERT_EQ(dplGetFrameStats(avatar_, &stats), DPL_OK);
    EXPECT_EQ(stats.viewCount, 1u);
    EXPECT_GT(stats.splatsDrawn, 0u);
    EXPECT_EQ(stats.passCount, 0u) << "the CPU has no GPU passes";
    EXPECT_GT(stats.splatBytes, 15u);
    EXPECT_GT(stats.avatarBytes, stats.splatBytes);
    EXPECT_GT(stats.residentBytes, stats.avatarBytes);
    EXPECT_GT(stats.bytesDecided, 0u);
    EXPECT_GE(stats.bytesDecoded, 13u * stats.splatsDrawn);
    DplFrameStats first{};
    first.structSize = 64;  // size in a program built with version 0.1
    ASSERT_EQ(dplGetFrameStats(avatar_, &first), DPL_OK) << dplGetLastError();
    EXPECT_EQ(first.splatsDrawn, stats.splatsDrawn);
    EXPECT_EQ(first.avatarBytes, 0u);
    DplPassTime time{sizeof(DplPassTime), nullptr, 0};
    EXPECT_EQ(dplGetPassTime(avatar_, 0, &time), DPL_ERROR_NOT_FOUND);
    EXPECT_TRUE(errorSays("there is no pass 0"));
}

TEST_F(ApiTest, drawAndReadAreTheHalvesOfRender) {
    const DplCamera cameras[2] = {frontCamera(64, 48, 0.03f), frontCamera(64, 48, -0.03f)};
    std::vector<uint8_t> whole[2], halves[2];
    std::vector<float> depth[2], halvesDepth[2];
    const DplImage images[2] = {imageFor(cameras[0], whole[0], &depth[0]), imageFor(cameras[1], whole[1], &depth[1])};
    const DplImage read[2] = {imageFor(cameras[0], halves[0], &halvesDepth[0]), imageFor(cameras[1], halves[1], &halvesDepth[1])};
    EXPECT_EQ(dplReadImages(context_, avatar_, read, 2), DPL_ERROR_INVALID_ARGUMENT);
    EXPECT_TRUE(errorSays("nothing was drawn")) << dplGetLastError();
    ASSERT_EQ(dplRender(context_, avatar_, cameras, 2, images), DPL_OK) << dplGetLastError();
    ASSERT_EQ(dplDraw(context_, avatar_, cameras, 2, DPL_DRAW_DEPTH), DPL_OK) << dplGetLastError();
    ASSERT_EQ(dplReadImages(context_, avatar_, read, 2), DPL_OK) << dplGetLastError();
    for (int v = 0; v < 2; ++v) {
        EXPECT_EQ(whole[v], halves[v]);
        EXPECT_EQ(depth[v], halvesDepth[v]);
    }
    EXPECT_EQ(dplReadImages(context_, avatar_, read, 1), DPL_ERROR_INVALID_ARGUMENT) << "a frame with two views";
    ASSERT_EQ(dplDraw(context_, avatar_, cameras, 2, 0), DPL_OK);
    EXPECT_EQ(dplReadImages(context_, avatar_, read, 2), DPL_ERROR_INVALID_ARGUMENT);
    EXPECT_TRUE(errorSays("DPL_DRAW_DEPTH")) << dplGetLastError();
    EXPECT_EQ(dplDraw(context_, avatar_, cameras, 2, 64), DPL_ERROR_INVALID_ARGUMENT) << "an unknown flag";
}

TEST_F(ApiTest, theBackOfSingleFaceSplatsIsInvisibleAndThePoseTurnsThem) {
    const DplCamera camera = frontCamera();
    std::vector<uint8_t> pixels;
    const DplImage image = imageFor(camera, pixels);
    const float turned[8] = {0, 1, 0, 0, 0, 0, 0, 1};  // half a turn about y
    ASSERT_EQ(dplSetPose(avatar_, turned, 2, nullptr), DPL_OK);
    ASSERT_EQ(dplRender(context_, avatar_, &camera, 1, &image), DPL_OK);
    EXPECT_EQ(*std::max_element(pixels.begin(), pixels.end()), 0);
    const float straight[8] = {0, 0, 0, 1, 0, 0, 0, 1};
    ASSERT_EQ(dplSetPose(avatar_, straight, 2, nullptr), DPL_OK);
    ASSERT_EQ(dplRender(context_, avatar_, &camera, 1, &image), DPL_OK);
    EXPECT_GT(*std::max_element(pixels.begin(), pixels.end()), 220);
}

TEST_F(ApiTest, straightAlphaUndoesThePremultiplication) {
    const DplCamera camera = frontCamera();
    std::vector<uint8_t> premultiplied, straight;
    DplImage image = imageFor(camera, premultiplied);
    ASSERT_EQ(dplRender(context_, avatar_, &camera, 1, &image), DPL_OK);
    image = imageFor(camera, straight);
    image.flags = DPL_IMAGE_STRAIGHT_ALPHA;
    ASSERT_EQ(dplRender(context_, avatar_, &camera, 1, &image), DPL_OK);
    int translucent = 0;
    for (size_t p = 0; p < 4096; ++p) {
        const int alpha = premultiplied[p * 4 + 3];
        ASSERT_EQ(straight[p * 4 + 3], alpha);
        if (alpha > 20 && alpha < 200) {
            ++translucent;
            EXPECT_GT(straight[p * 4], 230) << "red everywhere, 1 of 255 over alpha 20 is 6 %";
        }
    }
    EXPECT_GT(translucent, 10);
}

TEST_F(ApiTest, depthOfTheMeshIsThereWhereTheSquareIs) {
    const DplCamera camera = frontCamera();
    std::vector<uint8_t> pixels;
    std::vector<float> splats, mesh(4096, -1);
    DplImage image = imageFor(camera, pixels, &splats);
    image.meshDepthM = mesh.data(), image.meshDepthCount = mesh.size();
    ASSERT_EQ(dplRender(context_, avatar_, &camera, 1, &image), DPL_OK) << dplGetLastError();
    size_t covered = 0;
    for (size_t p = 0; p < mesh.size(); ++p) {
        ASSERT_TRUE(mesh[p] == 0 || std::abs(mesh[p] - 3) < 1e-5f) << p << ": " << mesh[p];
        covered += mesh[p] > 0;
        if (mesh[p] > 0) {
            EXPECT_NEAR(splats[p], mesh[p], 0.01f) << "its splats lie on it";
        }
    }
    EXPECT_EQ(covered, 400u) << "1 m at 3 m with f = 60 px";
    // dplDraw and dplReadImages; the depth of the mesh alone.
    ASSERT_EQ(dplDraw(context_, avatar_, &camera, 1, DPL_DRAW_DEPTH), DPL_OK);
    std::vector<float> again(4096, -1);
    image = {sizeof(DplImage), 0, nullptr, 0, 0, nullptr, 0, DPL_FORMAT_RGBA8, again.data(), again.size()};
    EXPECT_EQ(dplReadImages(context_, avatar_, &image, 1), DPL_ERROR_INVALID_ARGUMENT);
    EXPECT_TRUE(errorSays("DPL_DRAW_MESH_DEPTH")) << dplGetLastError();
    ASSERT_EQ(dplDraw(context_, avatar_, &camera, 1, DPL_DRAW_MESH_DEPTH), DPL_OK);
    ASSERT_EQ(dplReadImages(context_, avatar_, &image, 1), DPL_OK) << dplGetLastError();
    EXPECT_EQ(again, mesh);
    image.meshDepthCount -= 1;
    EXPECT_EQ(dplReadImages(context_, avatar_, &image, 1), DPL_ERROR_INVALID_ARGUMENT);
    image.meshDepthCount += 1;
    const auto bytes = splatFile();
    DplAvatar general = nullptr;
    ASSERT_EQ(dplLoadAvatar(context_, bytes.data(), bytes.size(), &general), DPL_OK);
    EXPECT_EQ(dplRender(context_, general, &camera, 1, &image), DPL_ERROR_INVALID_ARGUMENT);
    EXPECT_TRUE(errorSays("no mesh")) << dplGetLastError();
    EXPECT_EQ(dplDraw(context_, general, &camera, 1, DPL_DRAW_MESH_DEPTH), DPL_ERROR_INVALID_ARGUMENT);
    EXPECT_EQ(dplDestroyAvatar(general), DPL_OK);
}

TEST_F(ApiTest, theAppsSceneHidesWhatIsBehindIt) {
    DplCamera camera = frontCamera();
    std::vector<uint8_t> alone, behind, halves;
    DplImage image = imageFor(camera, alone);
    ASSERT_EQ(dplRender(context_, avatar_, &camera, 1, &image), DPL_OK);
    std::vector<float> scene(4096, 0.0f);
    for (size_t y = 0; y < 64; ++y) std::fill_n(scene.begin() + std::ptrdiff_t(y * 64), 32, 2.5f);  // a wall in front of the left half
    scene[30 * 64 + 10] = kNan;
    camera.sceneDepthM = scene.data(), camera.sceneDepthCount = scene.size();
    image = imageFor(camera, behind);
    ASSERT_EQ(dplRender(context_, avatar_, &camera, 1, &image), DPL_OK) << dplGetLastError();
    for (size_t p = 0; p < 4096; ++p)
        for (size_t c = 0; c < 4; ++c) ASSERT_EQ(behind[p * 4 + c], p % 64 < 32 && p != 30 * 64 + 10 ? 0 : alone[p * 4 + c]) << p;
    ASSERT_EQ(dplDraw(context_, avatar_, &camera, 1, 0), DPL_OK) << dplGetLastError();
    std::fill(scene.begin(), scene.end(), 0.1f);
    image = imageFor(camera, halves);
    ASSERT_EQ(dplReadImages(context_, avatar_, &image, 1), DPL_OK);
    EXPECT_EQ(halves, behind) << "the scene is read by dplDraw";
    camera.sceneDepthCount -= 1;
    EXPECT_EQ(dplDraw(context_, avatar_, &camera, 1, 0), DPL_ERROR_INVALID_ARGUMENT);
    EXPECT_TRUE(errorSays("4095 depths of the scene")) << dplGetLastError();
    camera.structSize = 76;  // size in version 0.1; the library must not read on
    image = imageFor(camera, behind);
    ASSERT_EQ(dplRender(context_, avatar_, &camera, 1, &image), DPL_OK) << dplGetLastError();
    EXPECT_EQ(behind, alone);
}

TEST_F(ApiTest, imagesAreDrawnOverWhatTheyHoldInTheirOwnLight) {
    const DplCamera camera = frontCamera();
    std::vector<uint8_t> layer, display(4096 * 4), srgb(4096 * 4), linear(4096 * 8);
    DplImage image = imageFor(camera, layer);
    ASSERT_EQ(dplRender(context_, avatar_, &camera, 1, &image), DPL_OK);
    const auto over = [&](std::vector<uint8_t>& pixels, DplImageFormat format, const std::vector<uint8_t>& background) {
        for (size_t i = 0; i < pixels.size(); ++i) pixels[i] = background[i % background.size()];
        DplImage to{sizeof(DplImage), DPL_IMAGE_OVER, pixels.data(), pixels.size(), 0, nullptr, 0, format};
        ASSERT_EQ(dplRender(context_, avatar_, &camera, 1, &to), DPL_OK) << dplGetLastError();
    };
    over(display, DPL_FORMAT_RGBA8, {0, 0, 255, 255});
    over(srgb, DPL_FORMAT_RGBA8_SRGB, {0, 0, 255, 255});
    over(linear, DPL_FORMAT_RGBA16F, {0, 0, 0, 0, 0, 0x3C, 0, 0x3C});
    int between = 0;
    for (size_t p = 0; p < 4096; ++p) {
        const int alpha = layer[p * 4 + 3];
        for (const auto* pixels : {&display, &srgb}) ASSERT_EQ((*pixels)[p * 4 + 3], 255);
        ASSERT_EQ(linear[p * 8 + 7], 0x3C);
        if (alpha == 0) {
            ASSERT_EQ(display[p * 4 + 2], 255);
            ASSERT_EQ(srgb[p * 4 + 2], 255);
            ASSERT_EQ(linear[p * 8 + 5], 0x3C);
        }
        if (alpha < 40 || alpha > 215) continue;
        ++between;
        EXPECT_NEAR(display[p * 4 + 2], 255 - alpha, 3);
        EXPECT_GT(srgb[p * 4 + 2], display[p * 4 + 2] + 10) << "half the light is more than half the code";
    }
    EXPECT_GT(between, 10);
    image = imageFor(camera, srgb);  // the layer alone, premultiplied in linear light
    image.format = DPL_FORMAT_RGBA8_SRGB;
    ASSERT_EQ(dplRender(context_, avatar_, &camera, 1, &image), DPL_OK);
    for (size_t p = 0; p < 4096; ++p) {
        ASSERT_EQ(srgb[p * 4 + 3], layer[p * 4 + 3]);
        ASSERT_GE(srgb[p * 4], layer[p * 4]);
    }
}

TEST_F(ApiTest, anImageOfVersion01IsStillReadAndItsFormatIsNot) {
    const DplCamera camera = frontCamera();
    std::vector<uint8_t> now, then;
    DplImage image = imageFor(camera, now);
    ASSERT_EQ(dplRender(context_, avatar_, &camera, 1, &image), DPL_OK);
    image = imageFor(camera, then);
    image.structSize = offsetof(DplImage, format);
    image.format = DPL_FORMAT_RGBA16F;
    ASSERT_EQ(dplRender(context_, avatar_, &camera, 1, &image), DPL_OK) << dplGetLastError();
    EXPECT_EQ(now, then);
}

TEST_F(ApiTest, rowsMayBeWiderThanThePicture) {
    const DplCamera camera = frontCamera(16, 16);
    std::vector<uint8_t> tight, wide(16 * 100, 0xAA);
    DplImage image = imageFor(camera, tight);
    ASSERT_EQ(dplRender(context_, avatar_, &camera, 1, &image), DPL_OK);
    image = {sizeof(DplImage), 0, wide.data(), wide.size(), 100, nullptr, 0};
    ASSERT_EQ(dplRender(context_, avatar_, &camera, 1, &image), DPL_OK) << dplGetLastError();
    for (size_t y = 0; y < 16; ++y) {
        EXPECT_TRUE(std::equal(tight.begin() + std::ptrdiff_t(y * 64), tight.begin() + std::ptrdiff_t(y * 64 + 64),
                               wide.begin() + std::ptrdiff_t(y * 100)));
        for (size_t x = 64; x < 100; ++x) EXPECT_EQ(wide[y * 100 + x], 0xAA) << "padding is the caller's";
    }
}

TEST_F(ApiTest, hostileCamerasAndImagesAreRefusedByASentence) {
    std::vector<uint8_t> pixels;
    const DplCamera good = frontCamera();
    const DplImage goodImage = imageFor(good, pixels);
    const auto refusedCamera = [&](auto&& change) {
        DplCamera camera = good;
        change(camera);
        const DplResult result = dplRender(context_, avatar_, &camera, 1, &goodImage);
        EXPECT_NE(dplGetLastError()[0], 0);
        return result == DPL_ERROR_INVALID_ARGUMENT;
    };
    EXPECT_TRUE(refusedCamera([](DplCamera& c) { c.structSize = 0; }));
    EXPECT_TRUE(refusedCamera([](DplCamera& c) { c.widthPx = 0; }));
    EXPECT_TRUE(refusedCamera([](DplCamera& c) { c.heightPx = 8193; }));
    EXPECT_TRUE(refusedCamera([](DplCamera& c) { c.widthPx = c.heightPx = 0xFFFFFFFFu; }));
    EXPECT_TRUE(refusedCamera([](DplCamera& c) { c.fx = 0; }));
    EXPECT_TRUE(refusedCamera([](DplCamera& c) { c.fy = kNan; }));
    EXPECT_TRUE(refusedCamera([](DplCamera& c) { c.fx = std::numeric_limits<float>::infinity(); }));
    EXPECT_TRUE(refusedCamera([](DplCamera& c) { c.cx = kNan; }));
    EXPECT_TRUE(refusedCamera([](DplCamera& c) { c.cy = 1e30f; }));
    EXPECT_TRUE(refusedCamera([](DplCamera& c) { c.viewFromWorld[3] = kNan; }));
    EXPECT_TRUE(refusedCamera([](DplCamera& c) { c.viewFromWorld[0] = kNan; }));
    EXPECT_TRUE(refusedCamera([](DplCamera& c) { c.viewFromWorld[0] = 2; }));
    EXPECT_TRUE(refusedCamera([](DplCamera& c) { c.viewFromWorld[0] = -1; })) << "a mirror";
    EXPECT_TRUE(refusedCamera([](DplCamera& c) {
        for (float& f : c.viewFromWorld) f = 0;
    }));
    const auto refusedImage = [&](auto&& change) {
        DplImage image = goodImage;
        change(image);
        return dplRender(context_, avatar_, &good, 1, &image) == DPL_ERROR_INVALID_ARGUMENT;
    };
    EXPECT_TRUE(refusedImage([](DplImage& i) { i.structSize = 3; }));
    EXPECT_TRUE(refusedImage([](DplImage& i) { i.flags = 0x10; }));
    EXPECT_TRUE(refusedImage([](DplImage& i) { i.flags = DPL_IMAGE_STRAIGHT_ALPHA | DPL_IMAGE_OVER; }));
    EXPECT_TRUE(errorSays("only premultiplied")) << dplGetLastError();
    EXPECT_TRUE(refusedImage([](DplImage& i) {
        const int32_t unknown = -1;
        std::memcpy(&i.format, &unknown, sizeof unknown);
    }));
    EXPECT_TRUE(errorSays("there is no format")) << dplGetLastError();
    EXPECT_TRUE(refusedImage([](DplImage& i) { i.format = DPL_FORMAT_RGBA16F; })) << "4 bytes a pixel are too few";
    EXPECT_TRUE(refusedImage([](DplImage& i) { i.format = DPL_FORMAT_RGBA16F, i.rowBytes = 511; }));
    EXPECT_TRUE(refusedImage([](DplImage& i) { i.rgba = nullptr; }));
    EXPECT_TRUE(refusedImage([](DplImage& i) { i.rgbaBytes -= 1; }));
    EXPECT_TRUE(refusedImage([](DplImage& i) { i.rowBytes = 255; }));
    EXPECT_TRUE(refusedImage([](DplImage& i) { i.rowBytes = ~size_t(0); }));
    float depth[4];
    EXPECT_TRUE(refusedImage([&](DplImage& i) { i.depthM = depth, i.depthCount = 4; }));
    EXPECT_EQ(dplRender(context_, avatar_, nullptr, 1, &goodImage), DPL_ERROR_INVALID_ARGUMENT);
    EXPECT_EQ(dplRender(context_, avatar_, &good, 1, nullptr), DPL_ERROR_INVALID_ARGUMENT);
    EXPECT_EQ(dplRender(context_, avatar_, &good, 0, &goodImage), DPL_ERROR_INVALID_ARGUMENT);
    EXPECT_EQ(dplRender(context_, avatar_, &good, 3, &goodImage), DPL_ERROR_INVALID_ARGUMENT);
    const DplCamera differ[2] = {good, frontCamera(32, 32)};
    const DplImage images[2] = {goodImage, goodImage};
    EXPECT_EQ(dplRender(context_, avatar_, differ, 2, images), DPL_ERROR_INVALID_ARGUMENT);
    EXPECT_TRUE(std::all_of(pixels.begin(), pixels.end(), [](uint8_t b) { return b == 0xAA; })) << "a refused call writes nothing";
}

TEST_F(ApiTest, onePixelAndACameraInsideTheBodyAreFine) {
    DplCamera camera = frontCamera(1, 1);
    camera.cx = camera.cy = 0.5f;
    camera.fx = camera.fy = 1;
    std::vector<uint8_t> pixels;
    DplImage image = imageFor(camera, pixels);
    EXPECT_EQ(dplRender(context_, avatar_, &camera, 1, &image), DPL_OK) << dplGetLastError();
    for (const float z : {0.0f, 0.01f, 0.05f, 0.1f, -3.0f}) {
        camera = frontCamera();
        camera.viewFromWorld[11] = z;
        image = imageFor(camera, pixels);
        EXPECT_EQ(dplRender(context_, avatar_, &camera, 1, &image), DPL_OK);
        const bool empty = *std::max_element(pixels.begin(), pixels.end()) == 0;
        EXPECT_TRUE(empty || z >= DPL_NEAR_LIMIT_M) << "nothing nearer than the near limit, z " << z;
    }
}

TEST_F(ApiTest, picturesDoNotDependOnTheThreadCount) {
    const DplCamera camera = frontCamera(200, 150);
    std::vector<uint8_t> one, three;
    DplImage image = imageFor(camera, one);
    ASSERT_EQ(dplRender(context_, avatar_, &camera, 1, &image), DPL_OK);
    const DplContextInfo info{sizeof(DplContextInfo), DPL_RENDERER_SOFTWARE, 3};
    DplContext context = nullptr;
    DplAvatar avatar = nullptr;
    ASSERT_EQ(dplCreateContext(&info, &context), DPL_OK);
    const auto bytes = tinyFile();
    ASSERT_EQ(dplLoadAvatar(context, bytes.data(), bytes.size(), &avatar), DPL_OK);
    image = imageFor(camera, three);
    ASSERT_EQ(dplRender(context, avatar, &camera, 1, &image), DPL_OK);
    EXPECT_EQ(one, three);
    EXPECT_EQ(dplDestroyAvatar(avatar), DPL_OK);
    EXPECT_EQ(dplDestroyContext(context), DPL_OK);
}

}  // namespace
}  // namespace dpl::test
