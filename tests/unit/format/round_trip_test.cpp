// SPDX-License-Identifier: Apache-2.0
// Writes and reads avatars: precision of what comes back, and the same bytes when it is written again.
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <limits>
#include <numbers>

#include "sdk/format/splat_codec.h"
#include "tests/unit/avatar/clothed_legs.h"
#include "tests/unit/format/sample_avatars.h"
#include "tests/unit/format/sample_correctives.h"

namespace dpl {
namespace {

using test::layeredAvatar;
using test::tinyAvatar;
using test::withCorrectives;

AvatarData throughFile(const AvatarData& a, const WriteOptions& options = {}) {
    auto bytes = writeAvatar(a, options);
    EXPECT_TRUE(bytes) << bytes.error().message;
    if (!bytes) return {};
    auto back = readAvatar(*bytes);
    EXPECT_TRUE(back) << back.error().message;
    return back ? std::move(*back) : AvatarData{};
}

void expectSameBytes(const AvatarData& a) {
    auto first = writeAvatar(a);
    ASSERT_TRUE(first) << first.error().message;
    auto back = readAvatar(*first);
    ASSERT_TRUE(back) << back.error().message;
    auto second = writeAvatar(*back);
    ASSERT_TRUE(second) << second.error().message;
    EXPECT_TRUE(*first == *second);
}

TEST(AvatarRoundTrip, namesStructureAndMetadataComeBackExactly) {
    const AvatarData a = layeredAvatar(1, 1), b = throughFile(a);
    EXPECT_EQ(a.name, b.name);
    EXPECT_EQ(a.generator, b.generator);
    EXPECT_EQ(a.kappaPx2, b.kappaPx2);
    EXPECT_EQ(a.compensated, b.compensated);
    EXPECT_EQ(b.trainedPixelM, 0) << "absent: not known";
    ASSERT_EQ(a.joints.size(), b.joints.size());
    for (size_t j = 0; j < a.joints.size(); ++j) {
        EXPECT_EQ(a.joints[j].name, b.joints[j].name);
        EXPECT_EQ(a.joints[j].parent, b.joints[j].parent);
        EXPECT_EQ(a.joints[j].humanoidBone, b.joints[j].humanoidBone);
        EXPECT_LE(glm::length(a.joints[j].restPosition - b.joints[j].restPosition), kPositionStepM);
    }
    ASSERT_EQ(a.mesh.layers.size(), b.mesh.layers.size());
    for (size_t l = 0; l < a.mesh.layers.size(); ++l) {
        EXPECT_EQ(a.mesh.layers[l].name, b.mesh.layers[l].name);
        EXPECT_EQ(a.mesh.layers[l].role, b.mesh.layers[l].role);
        EXPECT_EQ(a.mesh.layers[l].firstVertex, b.mesh.layers[l].firstVertex);
        EXPECT_EQ(a.mesh.layers[l].triangleCount, b.mesh.layers[l].triangleCount);
    }
    ASSERT_EQ(b.evidence.size(), 2u);
    EXPECT_EQ(b.evidence[0].gainDb, 0.5f);
    EXPECT_EQ(b.evidence[0].bytes, 1234u);
    EXPECT_EQ(b.evidence[1].reason, "not measured");
}

TEST(AvatarRoundTrip, verticesAndTrianglesKeepTheirOrderAndWeightsAreExact) {
    const AvatarData a = layeredAvatar(2, 0), b = throughFile(a);
    ASSERT_EQ(a.mesh.triangles.size(), b.mesh.triangles.size());
    EXPECT_TRUE(a.mesh.triangles == b.mesh.triangles);
    EXPECT_TRUE(a.mesh.colours == b.mesh.colours);
    EXPECT_TRUE(a.mesh.jointWeights == b.mesh.jointWeights);
    ASSERT_EQ(a.mesh.restPositions.size(), b.mesh.restPositions.size());
    for (size_t v = 0; v < a.mesh.restPositions.size(); ++v) {
        for (int k = 0; k < 3; ++k)
            EXPECT_LE(std::abs(a.mesh.restPositions[v][k] - b.mesh.restPositions[v][k]),
                      kPositionStepM / 2 * 1.01f);  // half a step, plus the rounding of float
        for (int k = 0; k < 4; ++k) EXPECT_EQ(a.mesh.jointWeights[v][k] ? a.mesh.jointIndices[v][k] : 0, b.mesh.jointIndices[v][k]);
    }
}

TEST(AvatarRoundTrip, aRegularMeshThatDracoCannotReadAfterCompressingItIsStoredAnotherWay) {
    AvatarData a = test::clothedLegs();  // tubes of few different steps from vertex to vertex
    a.mesh.colours.assign(a.mesh.restPositions.size(), glm::u8vec4(128, 128, 128, 255));
    a.splats.triangleStart.assign(a.mesh.triangles.size() + 1, 0);
    const AvatarData b = throughFile(a);
    EXPECT_TRUE(a.mesh.triangles == b.mesh.triangles);
    EXPECT_TRUE(a.mesh.jointWeights == b.mesh.jointWeights);
    ASSERT_EQ(a.mesh.restPositions.size(), b.mesh.restPositions.size());
    for (size_t v = 0; v < a.mesh.restPositions.size(); ++v)
        for (int k = 0; k < 3; ++k)
            EXPECT_LE(std::abs(a.mesh.restPositions[v][k] - b.mesh.restPositions[v][k]), kPositionStepM / 2 * 1.01f);
    expectSameBytes(a);
}

TEST(AvatarRoundTrip, moreThan256JointsNeedWideIndices) {
    const AvatarData a = layeredAvatar(3, 0, 300, 6), b = throughFile(a);
    EXPECT_TRUE(a.mesh.jointWeights == b.mesh.jointWeights);
    for (size_t v = 0; v < a.mesh.jointIndices.size(); ++v)
        for (int k = 0; k < 4; ++k) ASSERT_EQ(a.mesh.jointWeights[v][k] ? a.mesh.jointIndices[v][k] : 0, b.mesh.jointIndices[v][k]);
}

TEST(AvatarRoundTrip, splatErrorsStayWithinHalfAStep) {
    const AvatarData a = layeredAvatar(4, 3), b = throughFile(a);
    const SplatData &x = a.splats, &y = b.splats;
    ASSERT_EQ(x.count(), y.count());
    EXPECT_TRUE(x.triangleStart == y.triangleStart);
    EXPECT_TRUE(x.flags == y.flags);
    // The range of a chunk is at most that of the generator. Half a step of it, plus 1 % for rounding.
    const double logStep = 4.0 / 2047, uvStep = 1.0 / 1820;
    for (uint32_t i = 0; i < x.count(); ++i) {
        EXPECT_LE(std::abs(x.uv[i].x - y.uv[i].x), uvStep / 2 * 1.01);
        EXPECT_LE(std::abs(x.uv[i].y - y.uv[i].y), uvStep / 2 * 1.01);
        const double turn = std::abs(x.phi[i] - y.phi[i]);
        EXPECT_LE(std::min(turn, std::numbers::pi - turn), std::numbers::pi / 2048 * 1.01);
        EXPECT_LE(std::abs(std::log(std::max(x.scaleM[i].x, kMinSplatScaleM) / y.scaleM[i].x)), logStep / 2 * 1.01);
        EXPECT_LE(std::abs(std::log(std::max(x.scaleM[i].y, kMinSplatScaleM) / y.scaleM[i].y)), logStep / 2 * 1.01);
        EXPECT_LE(std::abs(x.opacity[i] - y.opacity[i]), 0.5 / 255 * 1.01);
        for (int k = 0; k < 3; ++k) EXPECT_LE(std::abs(x.sh[i * 48 + k] - y.sh[i * 48 + k]), 3.4 / (k ? 2047 : 1023) / 2 * 1.01);
        for (int k = 3; k < 48; ++k) EXPECT_LE(std::abs(x.sh[i * 48 + k] - y.sh[i * 48 + k]), 0.3 / 127 / 2 * 1.01);
    }
}

TEST(AvatarRoundTrip, quantisationIsUnbiased) {
    // Floor instead of rounding would shift the mean of u by about 1.4e-4, a quarter of the step 1/1820. The noise of the mean is 5e-6.
    const AvatarData a = layeredAvatar(5, 0, 20, 20, 10), b = throughFile(a);
    double mean = 0, opacity = 0;
    for (uint32_t i = 0; i < a.splats.count(); ++i)
        mean += a.splats.uv[i].x - b.splats.uv[i].x, opacity += a.splats.opacity[i] - b.splats.opacity[i];
    EXPECT_LT(std::abs(mean / a.splats.count()), 2e-5);
    EXPECT_LT(std::abs(opacity / a.splats.count()), 1e-4);
}

TEST(AvatarRoundTrip, clipsComeBack) {
    const AvatarData a = layeredAvatar(6, 0), b = throughFile(a);
    ASSERT_EQ(b.clips.size(), 2u);
    EXPECT_EQ(b.clips[1].name, "clip1");
    EXPECT_TRUE(a.clips[1].timesS == b.clips[1].timesS);
    ASSERT_EQ(a.clips[1].channels.size(), b.clips[1].channels.size());
    for (size_t c = 0; c < a.clips[1].channels.size(); ++c) {
        EXPECT_EQ(a.clips[1].channels[c].joint, b.clips[1].channels[c].joint);
        for (size_t i = 0; i < 5; ++i)
            EXPECT_LT(glm::length(a.clips[1].channels[c].rotations[i] - b.clips[1].channels[c].rotations[i]), 1e-6f);
    }
    for (size_t i = 0; i < 5; ++i)
        EXPECT_LT(glm::length(a.clips[1].rootTranslations[i] - b.clips[1].rootTranslations[i]), 2 * kPositionStepM);
}

TEST(AvatarRoundTrip, writingWhatWasReadGivesTheSameBytes) {
    expectSameBytes(tinyAvatar());
    for (uint32_t degree = 0; degree <= 3; ++degree) expectSameBytes(layeredAvatar(10 + degree, degree));
    expectSameBytes(layeredAvatar(20, 1, 300, 5));
    expectSameBytes(withCorrectives(tinyAvatar(), 1, {.modes = 1, .nodes = 1}));
    for (uint32_t seed = 0; seed < 8; ++seed)
        expectSameBytes(withCorrectives(layeredAvatar(21, 0), seed, {.modes = 1 + 9 * seed, .nodes = 40}));
}

TEST(AvatarRoundTrip, rangesOfAFewUlpsAreIdempotentToo) {
    // 2048 codes over a dozen floats: several codes decode to the same value, and the writer must always choose the same one.
    AvatarData a = layeredAvatar(30, 1);
    for (uint32_t i = 0; i < a.splats.count(); ++i) {
        a.splats.scaleM[i] = Vec2f(std::nextafter(0.01f, 1.0f) + float(i % 13) * 1e-9f, 0.01f);
        for (int k = 0; k < 3; ++k) a.splats.sh[i * 12 + k] = 0.5f + float((i * 7 + k) % 11) * 6e-8f;
        for (int k = 3; k < 12; ++k) a.splats.sh[i * 12 + k] = 1e-7f;
    }
    expectSameBytes(a);
    for (Vec2f& s : a.splats.scaleM) s = Vec2f(0.003f);
    expectSameBytes(a);
}

TEST(AvatarRoundTrip, theTrainedPixelComesBackAndChangesNoVersion) {
    for (const float metres : {1e-6f, 0.00234567f, 1.0f}) {
        AvatarData a = layeredAvatar(1, 1);
        a.trainedPixelM = metres;
        EXPECT_EQ(throughFile(a).trainedPixelM, metres);
        auto info = inspectAvatar(*writeAvatar(a));
        ASSERT_TRUE(info) << info.error().message;
        EXPECT_EQ(info->trainedPixelM, metres);
        EXPECT_EQ(info->version, 1u) << "a reader that does not know it draws one sample a pixel, as ever";
        expectSameBytes(a);
    }
    for (const float impossible : {-0.002f, 1e-7f, 1.5f, std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity()}) {
        AvatarData a = layeredAvatar(1, 1);
        a.trainedPixelM = impossible;
        EXPECT_FALSE(writeAvatar(a)) << impossible;
    }
}

TEST(AvatarRoundTrip, theCaptureMapComesBackAndChangesNoVersion) {
    AvatarData a = layeredAvatar(3, 1);
    const size_t without = writeAvatar(a)->size();
    a.captureMap = test::sampleCaptureMap(a.joints.size());
    const AvatarData b = throughFile(a);
    ASSERT_EQ(b.captureMap.sides.size(), a.captureMap.sides.size());
    for (size_t i = 0; i < a.captureMap.sides.size(); ++i) {
        const CaptureSide &x = a.captureMap.sides[i], &y = b.captureMap.sides[i];
        EXPECT_NEAR(y.pixelM, x.pixelM, 0.022f * x.pixelM) << i;  // half of a step of 2^(1/16)
        EXPECT_NEAR(y.detailM, x.detailM, 0.022f * x.detailM) << i;
        EXPECT_EQ(y.views, x.views) << i;
    }
    const auto info = inspectAvatar(*writeAvatar(a));
    ASSERT_TRUE(info) << info.error().message;
    EXPECT_EQ(info->version, 1u) << "a reader that does not know it draws the same pictures";
    EXPECT_EQ(info->captureMapBytes, 12 * a.joints.size());
    EXPECT_LT(writeAvatar(a)->size(), without + 12 * a.joints.size() + 200);
    expectSameBytes(a);
    for (const float most : {0.0f, 1e-9f, 100.0f}) {  // beyond what codes hold: the nearest code, and not seen stays so
        a.captureMap.sides[0] = {most, most, 0};
        EXPECT_EQ(throughFile(a).captureMap.sides[0].detailM > 0, most > 0);
        expectSameBytes(a);
    }
}

TEST(AvatarRoundTrip, correctivesNearAndBelowTheSmallestFloatsAreIdempotentToo) {
    AvatarData a = withCorrectives(layeredAvatar(31, 0), 1);
    for (size_t e = 0; e < a.correctives.nodes.size(); ++e) {
        const float i = float(e % 7);
        a.correctives.nodes[e] = {i * 1e-45f, i * 3e-39f, i * 1.7e-30f, std::nextafter(1.0f, 2.0f) - i * 6e-8f};
    }
    expectSameBytes(a);
}

TEST(AvatarRoundTrip, correctivesComeBack) {
    const AvatarData a = withCorrectives(
                         layeredAvatar(70, 1), 5,
                         {.modes = 12, .nodes = 100, .offsetM = 0.03f, .light = 0.5f, .reach = 3.25f, .reachOffModes = 0.7f}),
                     b = throughFile(a);
    const PoseCorrectiveData &x = a.correctives, &y = b.correctives;
    EXPECT_EQ(x.modeCount, y.modeCount);
    EXPECT_EQ(x.nodeCount, y.nodeCount);
    EXPECT_EQ(x.reach, y.reach);
    EXPECT_EQ(x.reachOffModes, y.reachOffModes);
    EXPECT_TRUE(x.joints == y.joints);
    EXPECT_TRUE(x.mean == y.mean);
    EXPECT_TRUE(x.modes == y.modes);
    EXPECT_TRUE(x.nodeIndices == y.nodeIndices);
    EXPECT_TRUE(x.nodeWeights == y.nodeWeights);
    // Largest error at a vertex: the sum over the modes of a node with ‖k‖ ≤ reach, at worst √(Σ_i error_i²)·reach. 16 bits are far inside
    // the bars of 0.05 mm and 0.002. 8 bits would miss them (range 0.03 m / 254 per mode: 1 mm).
    double offset = 0, light = 0;
    ASSERT_EQ(x.nodes.size(), y.nodes.size());
    for (uint32_t n = 0; n < x.nodeCount; ++n) {
        Vec4<double> squares(0);
        for (uint32_t i = 0; i < x.modeCount; ++i) {
            const Vec4<double> e = Vec4<double>(x.nodes[n * x.modeCount + i]) - Vec4<double>(y.nodes[n * x.modeCount + i]);
            squares += e * e;
        }
        offset = std::max(offset, std::sqrt(squares.x + squares.y + squares.z) * x.reach),
        light = std::max(light, std::sqrt(squares.w) * x.reach);
    }
    std::printf("[ NUMBERS  ] largest error of a node at reach: %.5f mm, light %.6f\n", offset * 1e3, light);
    EXPECT_GT(offset, 0);
    EXPECT_LE(offset, 0.05e-3);
    EXPECT_LE(light, 0.002);
}

TEST(AvatarRoundTrip, motionModesComeBackInBothEncodings) {
    const AvatarData a = withCorrectives(layeredAvatar(70, 1), 5, {.modes = 12, .nodes = 300, .reach = 3.25f, .motion = 6});
    for (const bool compact : {false, true}) {
        const auto bytes = writeAvatar(a, {.compact = compact});
        ASSERT_TRUE(bytes) << bytes.error().message;
        const auto b = readAvatar(*bytes);
        ASSERT_TRUE(b) << b.error().message;
        const MotionModeData &x = a.correctives.motion, &y = b->correctives.motion;
        ASSERT_EQ(x.groups.size(), 2u);
        ASSERT_EQ(y.groups.size(), 2u);
        EXPECT_EQ(x.movedFromRad, y.movedFromRad);
        EXPECT_EQ(x.movedToRad, y.movedToRad);
        EXPECT_EQ(std::memcmp(x.groups.data(), y.groups.data(), 2 * sizeof(MotionGroupData)), 0);
        EXPECT_TRUE(x.joints == y.joints && x.still == y.still && x.rangeRad == y.rangeRad && x.holdsS == y.holdsS && x.lagsS == y.lagsS &&
                    x.modes == y.modes);
        ASSERT_EQ(a.correctives.nodes.size(), b->correctives.nodes.size());
        for (size_t e = 0; e < a.correctives.nodes.size(); ++e)
            EXPECT_LT(glm::length(a.correctives.nodes[e] - b->correctives.nodes[e]), 1e-4f);
        const auto info = inspectAvatar(*bytes);
        EXPECT_EQ(info->motionModes, 6u);
        EXPECT_LT(info->otherBytes, 100u);
    }
    expectSameBytes(a);
}

TEST(AvatarRoundTrip, onlyFilesWithMotionModesNeedVersion3) {
    AvatarData a = withCorrectives(tinyAvatar(), 1);
    const auto plain = *writeAvatar(a);
    addMotionModes(a.correctives, test::tinyMovingAvatar().correctives.motion);
    EXPECT_EQ(inspectAvatar(*writeAvatar(a))->version, 3u);
    dropMotionModes(a.correctives);
    EXPECT_TRUE(*writeAvatar(a) == plain);
}

TEST(AvatarRoundTrip, lightComesBackAndNeedsVersion3) {
    for (AvatarData a : {test::tinyLitAvatar(), withCorrectives(test::tinyLitAvatar(), 1)}) {
        const auto bytes = writeAvatar(a);
        ASSERT_TRUE(bytes) << bytes.error().message;
        const auto b = readAvatar(*bytes);
        ASSERT_TRUE(b) << b.error().message;
        EXPECT_EQ(a.light.irradiance, b->light.irradiance);
        EXPECT_EQ(inspectAvatar(*bytes)->version, 3u);
        EXPECT_TRUE(inspectAvatar(*bytes)->light);
        expectSameBytes(a);
        a.light.irradiance[3] = NAN;
        EXPECT_EQ(writeAvatar(a).error().code, Code::InvalidArgument);
        a.light = {};
        EXPECT_LT(inspectAvatar(*writeAvatar(a))->version, 3u);
    }
}

TEST(AvatarRoundTrip, onlyFilesWithCorrectivesNeedVersion2) {
    EXPECT_EQ(inspectAvatar(*writeAvatar(tinyAvatar()))->version, 1u);
    EXPECT_EQ(inspectAvatar(*writeAvatar(withCorrectives(tinyAvatar(), 1)))->version, 2u);
    AvatarData leftovers = tinyAvatar();
    leftovers.correctives.joints = {0};  // ignored: an avatar without nodes has no correctives
    EXPECT_TRUE(*writeAvatar(leftovers) == *writeAvatar(tinyAvatar()));
}

TEST(AvatarRoundTrip, decodedAvatarIsAFixedPoint) {
    auto once = decodedAvatar(layeredAvatar(40, 2));
    ASSERT_TRUE(once);
    auto twice = decodedAvatar(*once);
    ASSERT_TRUE(twice);
    EXPECT_TRUE(once->mesh.restPositions == twice->mesh.restPositions);
    EXPECT_TRUE(once->splats.scaleM == twice->splats.scaleM);
    EXPECT_TRUE(once->splats.sh == twice->splats.sh);
    EXPECT_TRUE(once->splats.phi == twice->splats.phi);
}

TEST(AvatarRoundTrip, plainVariantHoldsTheSameAvatar) {
    const AvatarData a = withCorrectives(layeredAvatar(50, 1), 2);
    auto fromPlain = readAvatar(*writeAvatar(a, {.draco = false}));
    ASSERT_TRUE(fromPlain) << fromPlain.error().message;
    EXPECT_TRUE(*writeAvatar(*fromPlain) == *writeAvatar(a));
}

TEST(AvatarRoundTrip, emptyAvatarOneSplatOneTriangle) {
    AvatarData empty;
    empty.joints = {{"root", -1, {0, 0, 0}, ""}};
    empty.splats.triangleStart = {0};
    expectSameBytes(empty);
    AvatarData one = tinyAvatar();
    one.mesh.triangles.resize(1), one.mesh.layers[0].triangleCount = 1, one.mesh.layers[0].vertexCount = 3;
    one.mesh.restPositions.resize(3), one.mesh.colours.resize(3), one.mesh.jointIndices.resize(3), one.mesh.jointWeights.resize(3);
    one.splats = {};
    one.splats.triangleStart = {0, 1}, one.splats.uv = {{0, 1}}, one.splats.phi = {0}, one.splats.scaleM = {{0.01f, 0.01f}},
    one.splats.opacity = {1}, one.splats.flags = {0}, one.splats.sh = {0, 0, 0};
    expectSameBytes(one);
    const AvatarData back = throughFile(one);
    EXPECT_EQ(back.splats.uv[0], Vec2f(0, 1));  // corners of a triangle have exact codes
}

/** Replaces the SH by `rows` different rows, as paletteSh does. */
AvatarData withRepeatedSh(AvatarData a, uint32_t rows) {
    const uint32_t stride = shCoefficientCount(a.splats.shDegree) * 3;
    for (uint32_t i = rows; i < a.splats.count(); ++i)
        for (uint32_t k = 3; k < stride; ++k) a.splats.sh[size_t(i) * stride + k] = a.splats.sh[size_t(i * 7 % rows) * stride + k];
    return a;
}

TEST(AvatarShPalette, writesEachRowOnceAndIsAFixedPoint) {
    for (uint32_t degree = 1; degree <= 3; ++degree) {
        const AvatarData a = withRepeatedSh(layeredAvatar(80 + degree, degree), 37);
        auto bytes = writeAvatar(a, {.shPalette = true});
        ASSERT_TRUE(bytes) << bytes.error().message;
        const uint32_t row = ((degree + 1) * (degree + 1) - 1) * 3, splats = a.splats.count();
        const AvatarInfo info = *inspectAvatar(*bytes);
        EXPECT_EQ(info.shPaletteSize, 37u);
        EXPECT_EQ(info.shBytes, 37u * row + splats * 2u);
        auto back = readAvatar(*bytes);
        ASSERT_TRUE(back) << back.error().message;
        for (size_t k = 0; k < a.splats.sh.size(); ++k)
            if (k % (row + 3) >= 3) {
                ASSERT_LE(std::abs(a.splats.sh[k] - back->splats.sh[k]), 0.3 / 127 / 2 * 1.01) << k;
            }
        EXPECT_TRUE(*writeAvatar(*back, {.shPalette = true}) == *bytes);
        EXPECT_EQ(inspectAvatar(*writeAvatar(*back))->shPaletteSize, 0u);  // no palette unless asked for
    }
}

TEST(AvatarShPalette, valuesBelowEveryRangeAndDegreeZeroNeedNoRows) {
    AvatarData flat = layeredAvatar(90, 1);
    for (size_t k = 0; k < flat.splats.sh.size(); ++k)
        if (k % 12 >= 3) flat.splats.sh[k] = 1e-7f;
    EXPECT_EQ(inspectAvatar(*writeAvatar(flat, {.shPalette = true}))->shPaletteSize, 1u);
    EXPECT_TRUE(*writeAvatar(tinyAvatar(), {.shPalette = true}) == *writeAvatar(tinyAvatar()));
}

TEST(AvatarShPalette, tooManyRowsAreRefusedWithTheRemedy) {
    const AvatarData many = layeredAvatar(91, 1, 4, 60, 5);  // 88,000 splats
    ASSERT_GT(many.splats.count(), kMaxShPalette);
    auto refused = writeAvatar(many, {.shPalette = true});
    ASSERT_FALSE(refused);
    EXPECT_EQ(int(refused.error().code), int(Code::InvalidArgument));
    EXPECT_NE(refused.error().message.find("paletteSh"), std::string::npos) << refused.error().message;
}

TEST(CodedAvatar, holdsTheBytesOfTheFileAndDecodesToTheSameSplats) {
    for (const bool palette : {false, true}) {
        const AvatarData a = withRepeatedSh(layeredAvatar(95, 2), 50);
        auto bytes = writeAvatar(a, {.shPalette = palette});
        auto coded = readCodedAvatar(*bytes);
        ASSERT_TRUE(coded) << coded.error().message;
        const AvatarData whole = *readAvatar(*bytes);
        EXPECT_EQ(coded->avatar.splats.count(), 0u);
        EXPECT_EQ(coded->splats.shIndex.empty(), !palette);
        const SplatData s = decodeSplats(coded->splats, a.mesh.triangles.size());
        EXPECT_TRUE(s.triangleStart == whole.splats.triangleStart);
        EXPECT_TRUE(s.uv == whole.splats.uv && s.phi == whole.splats.phi && s.scaleM == whole.splats.scaleM &&
                    s.opacity == whole.splats.opacity);
        EXPECT_TRUE(s.flags == whole.splats.flags && s.sh == whole.splats.sh);
        // A splat stores its triangle in one byte; a chunk stores the range of its triangles.
        for (const SplatChunk& c : coded->splats.chunks) {
            EXPECT_EQ(coded->splats.parents[c.firstParent + coded->splats.parent[c.firstSplat]], c.firstTriangle);
            EXPECT_EQ(coded->splats.parents[c.firstParent + coded->splats.parent[c.firstSplat + c.splatCount - 1]], c.endTriangle - 1);
        }
        if (palette) {
            EXPECT_LE(coded->splats.bytes(),
                      a.splats.count() * 16u + a.mesh.triangles.size() * 5u + 50u * 24u + coded->splats.chunks.size() * 64u);
        }
    }
}

TEST(AvatarRoundTrip, inspectAddsUpToTheFile) {
    for (bool draco : {true, false}) {
        const AvatarData avatar = withCorrectives(layeredAvatar(60, 1), 1, {.modes = 3, .nodes = 11});
        auto bytes = writeAvatar(avatar, {.draco = draco});
        ASSERT_TRUE(bytes);
        auto info = inspectAvatar(*bytes);
        ASSERT_TRUE(info) << info.error().message;
        EXPECT_EQ(info->fileBytes, bytes->size());
        EXPECT_EQ(info->meshBytes + info->splatBytes + info->shBytes + info->correctiveBytes + info->clipBytes + info->skinBytes +
                      info->jsonBytes + info->otherBytes,
                  bytes->size());
        EXPECT_LT(info->otherBytes, 100u);  // headers and padding only
        EXPECT_EQ(info->shBytes, info->splats * 9u);
        EXPECT_EQ(info->correctiveModes, 3u);
        EXPECT_EQ(info->correctiveNodes, 11u);
        // mean and modes of 20 joints; ranges per mode; values per node and mode; indices and weights per vertex
        EXPECT_EQ(info->correctiveBytes, 20 * 6 * 4 * (1 + 3) + 3 * 16 + 11 * 3 * 8 + info->vertices * 12u);
        EXPECT_TRUE(info->hashMatches);
        EXPECT_GT(info->chunks, 2u);
    }
}

}  // namespace
}  // namespace dpl
