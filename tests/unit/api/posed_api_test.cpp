// SPDX-License-Identifier: Apache-2.0
// dplWriteSplats and dplWriteMesh: what they write, where, and what they refuse. tests/reference/posed_splats_test.cpp draws it.
#include <cmath>
#include <cstring>
#include <numeric>

#include "sdk/format/ply.h"
#include "sdk/include/doppel/doppel.hpp"
#include "sdk/math/half.h"
#include "tests/unit/api/api_fixture.h"
#include "tests/unit/render/tube_avatar.h"
#include "tests/unit/surface/dressed.h"

namespace dpl::test {
namespace {

using doppel::bufferElement, doppel::SplatOptions;

constexpr uint32_t kNumbers[] = {3, 4, 3, 6, 1, 3, 0, 4};

class PosedTest : public ApiTest {
protected:
    void SetUp() override {
        ApiTest::SetUp();
        tube_ = load(makeTube({.splatsPerTriangle = 4, .rings = 10}));
        bend(0.8f);
    }
    void TearDown() override {
        for (const DplAvatar avatar : loaded_) EXPECT_EQ(dplDestroyAvatar(avatar), DPL_OK);
        ApiTest::TearDown();
    }
    DplAvatar load(AvatarData avatar) {
        sortSplats(avatar);
        const auto bytes = writeAvatar(avatar);
        EXPECT_TRUE(bytes);
        DplAvatar made = nullptr;
        EXPECT_EQ(dplLoadAvatar(context_, bytes->data(), bytes->size(), &made), DPL_OK) << dplGetLastError();
        loaded_.push_back(made);
        return made;
    }
    void bend(float angle) {
        const float rotations[8] = {0, 0, 0, 1, std::sin(angle / 2), 0, 0, std::cos(angle / 2)}, root[3] = {0.1f, 0.2f, 0.3f};
        ASSERT_EQ(dplSetPose(tube_, rotations, 2, root), DPL_OK) << dplGetLastError();
    }
    /** One property alone, as floats. */
    std::vector<float> property(DplAvatar avatar, DplSplatProperty what, const SplatOptions& options = {}) {
        const uint32_t numbers = what == DPL_SPLAT_SH ? 3 * (options.shDegree + 1) * (options.shDegree + 1) : kNumbers[what];
        DplWritten written{sizeof written};
        EXPECT_EQ(dplWriteSplats(avatar, &options, nullptr, &written), DPL_OK) << dplGetLastError();
        std::vector<float> out(size_t(written.count) * numbers, NAN);
        const DplBufferElement place = bufferElement(what, 0);
        const DplBuffer buffer{sizeof buffer, 1, &place, out.data(), out.size() * 4};
        EXPECT_EQ(dplWriteSplats(avatar, &options, &buffer, &written), DPL_OK) << dplGetLastError();
        for (const float x : out) EXPECT_TRUE(std::isfinite(x));
        return out;
    }
    DplResult write(const std::vector<DplBufferElement>& places, uint64_t bytes, const DplSplatOptions* options = nullptr) {
        bytes_.assign(1 << 20, 0xAB);
        const DplBuffer buffer{sizeof buffer, uint32_t(places.size()), places.data(), bytes_.data(), bytes};
        written_ = {sizeof written_};
        return dplWriteSplats(tube_, options, &buffer, &written_);
    }
    void expectRefused(const char* sentence, const std::vector<DplBufferElement>& places, uint64_t bytes = 1 << 20) {
        EXPECT_EQ(write(places, bytes), DPL_ERROR_INVALID_ARGUMENT) << sentence;
        EXPECT_TRUE(errorSays(sentence)) << dplGetLastError();
        EXPECT_EQ(std::count(bytes_.begin(), bytes_.end(), 0xAB), std::ptrdiff_t(bytes_.size())) << "something was written";
        EXPECT_EQ(written_.count, 0u);
    }

    DplAvatar tube_ = nullptr;
    std::vector<DplAvatar> loaded_;
    std::vector<uint8_t> bytes_;
    DplWritten written_{};
};

TEST_F(PosedTest, covarianceIsThatOfRotationAndScale) {
    const auto rotation = property(tube_, DPL_SPLAT_ROTATION), scale = property(tube_, DPL_SPLAT_SCALE),
               covariance = property(tube_, DPL_SPLAT_COVARIANCE);
    ASSERT_GT(rotation.size(), 4000u);
    for (size_t i = 0; i < rotation.size() / 4; ++i) {
        const float* q = &rotation[4 * i];
        ASSERT_NEAR(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3], 1, 1e-5f);
        Mat3d r = glm::mat3_cast(glm::dquat(q[3], q[0], q[1], q[2]));
        for (int k = 0; k < 3; ++k) r[k] *= double(scale[3 * i + size_t(k)]);
        const Mat3d sum = r * glm::transpose(r);
        const double largest = double(scale[3 * i]) * double(scale[3 * i]);
        for (int row = 0, k = 0; row < 3; ++row)
            for (int column = row; column < 3; ++column, ++k)
                ASSERT_NEAR(double(covariance[6 * i + size_t(k)]), sum[column][row], 2e-6 * largest)
                    << i;  // floats, relative to the largest
    }
}

TEST_F(PosedTest, rotationsWithWFirstAreTheSame) {
    const auto last = property(tube_, DPL_SPLAT_ROTATION), first = property(tube_, DPL_SPLAT_ROTATION_WXYZ);
    ASSERT_EQ(last.size(), first.size());
    for (size_t i = 0; i < last.size(); i += 4)
        for (size_t k = 0; k < 4; ++k) ASSERT_EQ(first[i + (k + 1) % 4], last[i + k]);
}

TEST_F(PosedTest, anInterleavedBufferHoldsTheSameNumbersAndKeepsItsGaps) {
    const auto position = property(tube_, DPL_SPLAT_POSITION), opacity = property(tube_, DPL_SPLAT_OPACITY),
               rotation = property(tube_, DPL_SPLAT_ROTATION);
    const uint64_t stride = 29, first = 3;  // no alignment is needed
    ASSERT_EQ(
        write({bufferElement(DPL_SPLAT_POSITION, first, stride), bufferElement(DPL_SPLAT_ROTATION, first + 14, stride, DPL_NUMBER_HALF),
               bufferElement(DPL_SPLAT_OPACITY, first + 22, stride)},
              first + stride * opacity.size()),
        DPL_OK)
        << dplGetLastError();
    EXPECT_EQ(written_.count, opacity.size());
    EXPECT_EQ(written_.saturated, 0u);
    for (size_t i = 0; i < opacity.size(); ++i) {
        const uint8_t* row = &bytes_[first + i * stride];
        float xyz[3], alpha;
        uint16_t q[4];
        std::memcpy(xyz, row, 12), std::memcpy(q, row + 14, 8), std::memcpy(&alpha, row + 22, 4);
        for (size_t k = 0; k < 3; ++k) ASSERT_EQ(xyz[k], position[3 * i + k]);
        for (size_t k = 0; k < 4; ++k) ASSERT_EQ(q[k], halfFromFloat(rotation[4 * i + k]));
        ASSERT_EQ(alpha, opacity[i]);
        ASSERT_TRUE(row[12] == 0xAB && row[13] == 0xAB && row[26] == 0xAB && row[28] == 0xAB);
    }
    EXPECT_TRUE(bytes_[0] == 0xAB && bytes_[2] == 0xAB && bytes_[first + stride * opacity.size()] == 0xAB);
}

TEST_F(PosedTest, separateArraysInOneBufferAreALayoutToo) {
    const auto position = property(tube_, DPL_SPLAT_POSITION), opacity = property(tube_, DPL_SPLAT_OPACITY);
    const uint64_t count = opacity.size();
    ASSERT_EQ(write({bufferElement(DPL_SPLAT_OPACITY, 12 * count), bufferElement(DPL_SPLAT_POSITION, 0)}, 16 * count), DPL_OK);
    EXPECT_EQ(std::memcmp(bytes_.data(), position.data(), 12 * count), 0);
    EXPECT_EQ(std::memcmp(bytes_.data() + 12 * count, opacity.data(), 4 * count), 0);
}

TEST_F(PosedTest, theGateNeedsAnEyeAndLeavesCountAndOrder) {
    const float front[3] = {0, 0.5f, 5}, back[3] = {0, 0.5f, -5};
    SplatOptions options;
    const auto all = property(tube_, DPL_SPLAT_OPACITY, options);
    options.eye = front;
    const auto seen = property(tube_, DPL_SPLAT_OPACITY, options);
    options.eye = back;
    const auto fromBehind = property(tube_, DPL_SPLAT_OPACITY, options);
    ASSERT_EQ(all.size(), seen.size());
    size_t gone = 0, kept = 0, both = 0;
    for (size_t i = 0; i < all.size(); ++i) {
        EXPECT_LE(seen[i], all[i]);
        gone += seen[i] == 0 && all[i] > 0, kept += seen[i] == all[i], both += seen[i] > 0 && fromBehind[i] > 0;
    }
    EXPECT_GT(gone, all.size() / 8);  // half of the rings are single-face; the eye is before half of these
    EXPECT_GT(kept, all.size() / 2);
    EXPECT_GT(both, all.size() / 3) << "splats with two faces show from both sides";
}

TEST_F(PosedTest, colourIsThatOfShSeenFromTheEye) {
    const float eye[3] = {0.4f, 0.7f, 2};
    SplatOptions options;
    options.eye = eye, options.shDegree = 3;  // the tube has 2: the band above is 0
    const auto colour = property(tube_, DPL_SPLAT_COLOUR, options), sh = property(tube_, DPL_SPLAT_SH, options),
               position = property(tube_, DPL_SPLAT_POSITION, options);
    for (size_t i = 0; i < colour.size() / 3; ++i) {
        const Vec3f centre(position[3 * i], position[3 * i + 1], position[3 * i + 2]);
        const Vec3f seen = shColour(&sh[48 * i], 3, glm::normalize(centre - Vec3f(eye[0], eye[1], eye[2])));
        for (size_t c = 0; c < 3; ++c) ASSERT_NEAR(colour[3 * i + c], seen[int(c)], 2e-6f * 16) << i;  // sums of 9 products of about 1
        for (size_t k = 27; k < 48; ++k) ASSERT_EQ(sh[48 * i + k], 0);
    }
}

TEST_F(PosedTest, aBudgetFixesTheCountForAllPoses) {
    SplatOptions options;
    const size_t all = property(tube_, DPL_SPLAT_OPACITY).size();
    options.splatBudget = uint32_t(all / 3);
    const size_t some = property(tube_, DPL_SPLAT_OPACITY, options).size();
    EXPECT_LE(some, all / 3);
    EXPECT_GT(some, all / 4);
    const auto scale = property(tube_, DPL_SPLAT_SCALE, options), whole = property(tube_, DPL_SPLAT_SCALE);
    const auto mean = [](const std::vector<float>& s) { return std::accumulate(s.begin(), s.end(), 0.0) / double(s.size()); };
    EXPECT_GT(mean(scale), 1.1 * mean(whole)) << "kept splats grow";
    bend(-0.5f);
    EXPECT_EQ(property(tube_, DPL_SPLAT_OPACITY, options).size(), some);
    options.splatBudget = 1;
    EXPECT_GE(property(tube_, DPL_SPLAT_OPACITY, options).size(), all / 128);
    options.splatBudget = uint32_t(all);
    EXPECT_EQ(property(tube_, DPL_SPLAT_OPACITY, options).size(), all);
}

TEST_F(PosedTest, splatsAndVerticesStandInTheWorld) {
    const auto own = property(tube_, DPL_SPLAT_POSITION), ownScale = property(tube_, DPL_SPLAT_SCALE);
    const float placed[12] = {0, 0, 2, 1, 0, 2, 0, -3, -2, 0, 0, 0.5f};  // a quarter turn about y, twice as large
    ASSERT_EQ(dplSetTransform(tube_, placed), DPL_OK) << dplGetLastError();
    const auto world = property(tube_, DPL_SPLAT_POSITION), worldScale = property(tube_, DPL_SPLAT_SCALE);
    for (size_t i = 0; i < own.size() / 3; ++i) {
        EXPECT_NEAR(world[3 * i], 2 * own[3 * i + 2] + 1, 1e-5f);
        EXPECT_NEAR(world[3 * i + 1], 2 * own[3 * i + 1] - 3, 1e-5f);
        EXPECT_NEAR(world[3 * i + 2], -2 * own[3 * i] + 0.5f, 1e-5f);
        EXPECT_NEAR(worldScale[3 * i], 2 * ownScale[3 * i], 1e-5f * ownScale[3 * i] + 1e-8f);
    }
    std::vector<float> vertices(2 * 3 * 11 * 16);
    const DplBufferElement places[2] = {bufferElement(DPL_VERTEX_POSITION, 0, 24), bufferElement(DPL_VERTEX_NORMAL, 12, 24)};
    const DplBuffer buffer{sizeof buffer, 2, places, vertices.data(), vertices.size() * 4};
    DplWritten written{sizeof written};
    ASSERT_EQ(dplWriteMesh(tube_, &buffer, &written), DPL_OK) << dplGetLastError();
    ASSERT_EQ(written.count, 11u * 16);
    const float* lowest = vertices.data();  // the first vertex: (0.18, 0, 0) at rest
    constexpr float kGridM = 1e-4f;         // files keep vertices on a grid of 1.5e-5 m
    EXPECT_NEAR(lowest[0], 2 * 0.3f + 1, kGridM);
    EXPECT_NEAR(lowest[1], 2 * 0.2f - 3, kGridM);
    EXPECT_NEAR(lowest[2], -2 * (0.18f + 0.1f) + 0.5f, kGridM);
    EXPECT_LT(lowest[5], -0.9f) << "its normal points away from the tube's axis";
    for (uint32_t v = 0; v < written.count; ++v)
        EXPECT_NEAR(glm::length(Vec3f(vertices[6 * v + 3], vertices[6 * v + 4], vertices[6 * v + 5])), 1, 1e-5f);
}

TEST_F(PosedTest, numbersTooLargeForAHalfSaturateAndAreCounted) {
    const float far[12] = {1, 0, 0, 70000, 0, 1, 0, 0, 0, 0, 1, -80000};
    ASSERT_EQ(dplSetTransform(tube_, far), DPL_OK) << dplGetLastError();
    ASSERT_EQ(write({bufferElement(DPL_SPLAT_POSITION, 0, 0, DPL_NUMBER_HALF)}, 1 << 20), DPL_OK) << dplGetLastError();
    EXPECT_EQ(written_.saturated, 2u * written_.count);
    uint16_t first[3];
    std::memcpy(first, bytes_.data(), 6);
    EXPECT_EQ(floatFromHalf(first[0]), 65504);
    EXPECT_EQ(floatFromHalf(first[2]), -65504);
}

TEST_F(PosedTest, wrongLayoutsAreRefusedAndNothingIsWritten) {
    const uint64_t count = property(tube_, DPL_SPLAT_OPACITY).size();
    expectRefused("element 1 is of property 8", {bufferElement(DPL_SPLAT_POSITION, 0), bufferElement(8, 1 << 19)});
    DplBufferElement odd = bufferElement(DPL_SPLAT_POSITION, 0);
    odd.number = DplNumber(2);
    expectRefused("is of number 2", {odd});
    expectRefused("a stride of 15 bytes, but takes 16", {bufferElement(DPL_SPLAT_ROTATION, 0, 15)});
    expectRefused("a stride of 7 bytes, but takes 8", {bufferElement(DPL_SPLAT_ROTATION, 0, 7, DPL_NUMBER_HALF)});
    expectRefused("do not lie within the buffer", {bufferElement(DPL_SPLAT_POSITION, 0)}, 12 * count - 1);
    expectRefused("do not lie within the buffer", {bufferElement(DPL_SPLAT_POSITION, 1)}, 12 * count);
    expectRefused("do not lie within the buffer", {bufferElement(DPL_SPLAT_POSITION, UINT64_MAX - 5)});
    expectRefused("do not lie within the buffer", {bufferElement(DPL_SPLAT_POSITION, 0, UINT64_MAX / 2)});
    const auto position = bufferElement(DPL_SPLAT_POSITION, 0, 20);
    expectRefused("position (element 0) and opacity (element 1) overlap", {position, bufferElement(DPL_SPLAT_OPACITY, 11, 20)});
    expectRefused("overlap", {position, bufferElement(DPL_SPLAT_ROTATION, 12, 20)});  // into the next splat's position
    expectRefused("overlap", {bufferElement(DPL_SPLAT_OPACITY, 20 * 7 + 3, 20), position});
    expectRefused("different strides (20 and 24 bytes)", {position, bufferElement(DPL_SPLAT_OPACITY, 12, 24)});
    EXPECT_EQ(write({position, bufferElement(DPL_SPLAT_OPACITY, 20 * 7 + 12, 20)}, 1 << 20), DPL_OK) << dplGetLastError();
    EXPECT_EQ(write({position, bufferElement(DPL_SPLAT_OPACITY, 20 * (count - 1) + 12)}, 1 << 20), DPL_OK) << dplGetLastError();
    expectRefused("the buffer has 0 elements", {});
    expectRefused("the buffer has 17 elements", std::vector<DplBufferElement>(17, position));
}

TEST_F(PosedTest, wrongCallsSayWhatIsWrong) {
    const float nowhere[3] = {0, NAN, 0};
    SplatOptions options;
    options.eye = nowhere;
    DplWritten written{sizeof written};
    EXPECT_EQ(dplWriteSplats(tube_, &options, nullptr, &written), DPL_ERROR_INVALID_ARGUMENT);
    EXPECT_TRUE(errorSays("the eye is at")) << dplGetLastError();
    options = {}, options.shDegree = 4;
    EXPECT_EQ(dplWriteSplats(tube_, &options, nullptr, &written), DPL_ERROR_INVALID_ARGUMENT);
    EXPECT_TRUE(errorSays("degree 4")) << dplGetLastError();
    const DplBufferElement place = bufferElement(DPL_SPLAT_POSITION, 0);
    const DplBuffer nothing{sizeof nothing, 1, &place, nullptr, 100};
    EXPECT_EQ(dplWriteSplats(tube_, nullptr, &nothing, &written), DPL_ERROR_INVALID_ARGUMENT);
    EXPECT_TRUE(errorSays("data of the buffer is NULL")) << dplGetLastError();
    EXPECT_EQ(dplWriteSplats(tube_, nullptr, nullptr, nullptr), DPL_ERROR_INVALID_ARGUMENT);
    StaticSplatData general;
    general.position = {{0, 0, 0}}, general.rotation = {Quatf(1, 0, 0, 0)}, general.scaleM = {Vec3f(0.1f)};
    general.opacity = {0.5f}, general.sh = {0, 0, 0};
    const auto ply = writePly(general);
    DplAvatar splats = nullptr;
    ASSERT_EQ(dplLoadAvatar(context_, ply->data(), ply->size(), &splats), DPL_OK) << dplGetLastError();
    EXPECT_EQ(dplWriteSplats(splats, nullptr, nullptr, &written), DPL_ERROR_INVALID_ARGUMENT);
    EXPECT_EQ(dplWriteMesh(splats, nullptr, &written), DPL_ERROR_INVALID_ARGUMENT);
    EXPECT_EQ(dplDestroyAvatar(splats), DPL_OK);
}

TEST_F(PosedTest, splatsOfAHiddenLayerHaveNoOpacity) {
    const DplAvatar person = load(dressed());
    const auto before = property(person, DPL_SPLAT_OPACITY);
    ASSERT_EQ(dplHideLayer(person, kCoat, DPL_TRUE), DPL_OK) << dplGetLastError();
    const auto after = property(person, DPL_SPLAT_OPACITY);
    ASSERT_EQ(before.size(), after.size());
    const size_t coat = 32 * 40;  // its splats, the last ones
    for (size_t i = 0; i < after.size(); ++i) ASSERT_EQ(after[i], i < after.size() - coat ? before[i] : 0) << i;
}

TEST_F(PosedTest, theWrapperWritesThem) {
    doppel::Avatar person(context_, load(makeTube({})));
    loaded_.pop_back();
    const auto count = person.splatCount();
    ASSERT_TRUE(count) << count.error().message;
    std::vector<std::byte> bytes(size_t(*count) * 16);
    const DplBufferElement places[] = {bufferElement(DPL_SPLAT_POSITION, 0, 16), bufferElement(DPL_SPLAT_OPACITY, 12, 16)};
    const auto written = person.writeSplats(places, bytes);
    ASSERT_TRUE(written) << written.error().message;
    EXPECT_EQ(written->count, *count);
    EXPECT_FALSE(person.writeSplats(places, std::span(bytes).first(100)));
    const DplBufferElement normals[] = {bufferElement(DPL_VERTEX_NORMAL, 0)};
    EXPECT_EQ(person.writeMesh(normals, bytes)->count, 21u * 16);
}

}  // namespace
}  // namespace dpl::test
