// SPDX-License-Identifier: Apache-2.0
// Splats that a GPU has written into a program's buffer, against those that dplWriteSplats writes on the CPU: what the tests of Vulkan and
// of Metal have in common.
#pragma once

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdio>
#include <random>

#include "apps/reference/reference_renderer.h"
#include "sdk/format/avatar_file.h"
#include "sdk/include/doppel/doppel.hpp"
#include "sdk/math/half.h"
#include "tests/reference/compare_renderers.h"
#include "tests/unit/format/sample_correctives.h"
#include "tests/unit/render/tube_avatar.h"
#include "tests/unit/surface/dressed.h"

namespace dpl::test {

inline std::vector<uint8_t> fileOf(AvatarData avatar) {
    sortSplats(avatar);
    const auto bytes = writeAvatar(avatar);
    EXPECT_TRUE(bytes) << (bytes ? "" : bytes.error().message);
    return bytes ? *bytes : std::vector<uint8_t>();
}

/** With all that a posed splat depends on: correctives that move and light vertices, light of the scene, gated and free splats. */
inline AvatarData writtenTube(uint32_t shDegree) {
    AvatarData avatar = withCorrectives(makeTube({.splatsPerTriangle = 5, .rings = 12, .shDegree = shDegree}), 3);
    avatar.light.irradiance = {-0.6f, 0.6f, -1.0f, 0.1f, -0.15f, -0.2f, 0.1f, 0.05f};
    return avatar;
}

inline DplBufferElement at(DplSplatProperty what, uint64_t offset, uint64_t stride = 0, DplNumber number = DPL_NUMBER_FLOAT) {
    return doppel::bufferElement(what, offset, stride, number);
}
inline uint32_t numbersOf(uint32_t property, uint32_t shDegree) {
    constexpr uint32_t kCounts[] = {3, 4, 3, 6, 1, 3, 0, 4};
    return property == DPL_SPLAT_SH ? 3 * (shDegree + 1) * (shDegree + 1) : kCounts[property];
}

/** A layout of a buffer for `count` splats. */
struct Layout {
    std::vector<DplBufferElement> elements;
    uint64_t bytes = 0;
};

/** All of a general splat as floats, one after the other, with a gap of a word. */
inline Layout interleaved(uint64_t count, uint32_t shDegree) {
    const uint64_t sh = 4 * numbersOf(DPL_SPLAT_SH, shDegree), stride = 48 + sh;
    return {{at(DPL_SPLAT_POSITION, 0, stride), at(DPL_SPLAT_ROTATION, 12, stride), at(DPL_SPLAT_SCALE, 28, stride),
             at(DPL_SPLAT_OPACITY, 40, stride), at(DPL_SPLAT_SH, 48, stride)},
            count * stride};
}

/** Two blocks of interleaved rows at different strides, with halves, odd numbers of them too, and between them an array of its own. */
inline Layout mixed(uint64_t count, uint32_t shDegree) {
    constexpr DplNumber kHalf = DPL_NUMBER_HALF;
    const uint64_t sh = (2 * numbersOf(DPL_SPLAT_SH, shDegree) + 3) / 4 * 4, stride = 52 + sh, array = 300 + count * stride,
                   second = array + 4 * count + 20;
    return {
        {at(DPL_SPLAT_SCALE, 300, stride, kHalf), at(DPL_SPLAT_ROTATION_WXYZ, 308, stride, kHalf), at(DPL_SPLAT_COLOUR, 316, stride, kHalf),
         at(DPL_SPLAT_COVARIANCE, 324, stride), at(DPL_SPLAT_SH, 352, stride, kHalf), at(DPL_SPLAT_OPACITY, array),
         at(DPL_SPLAT_POSITION, second, 24, kHalf), at(DPL_SPLAT_POSITION, second + 8, 24), at(DPL_SPLAT_OPACITY, second + 20, 24, kHalf)},
        second + 24 * count + 7};
}

/** One pose of the avatar, and what is asked for. */
struct WriteCase {
    std::string name;
    float bend = 0, turn = 0;
    std::optional<std::array<float, 12>> transform;
    std::optional<Vec3f> eye;
    uint32_t budget = 0, shDegree = 0;

    void pose(DplAvatar avatar) const {
        const Pose pose = tubePose(bend, turn);
        std::vector<float> rotations;
        for (const Quatf& q : pose.localRotations) rotations.insert(rotations.end(), {q.x, q.y, q.z, q.w});
        const float root[3] = {0.05f, 0.1f, -0.02f};
        EXPECT_EQ(dplSetPose(avatar, rotations.data(), 2, root), DPL_OK) << dplGetLastError();
        const float stands[12] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};
        EXPECT_EQ(dplSetTransform(avatar, transform ? transform->data() : stands), DPL_OK) << dplGetLastError();
    }
    DplSplatOptions options() const { return {sizeof(DplSplatOptions), budget, eye ? &eye->x : nullptr, shDegree}; }
};

inline std::array<float, 12> placedAt(float yaw, float scale, const Vec3f& to) {
    const float c = scale * std::cos(yaw), s = scale * std::sin(yaw);
    return {c, 0, s, to.x, 0, scale, 0, to.y, -s, 0, c, to.z};
}

/** Hard poses, then random ones. */
inline std::vector<WriteCase> writeCases() {
    std::vector<WriteCase> cases = {
        {"at rest, for no eye", 0, 0, {}, {}, 0, 3},
        {"joint at 180 degrees", 3.14159265f, 0, {}, Vec3f(0.3f, 0.7f, 1.6f), 0, 2},
        {"stretched until it fades", 2.6f, 0.4f, {}, Vec3f(-1, 0.5f, 1), 0, 1},
        {"eye within a splat's reach", 0.4f, 0, {}, Vec3f(0.22f, 0.6f, 0.05f), 0, 0},
        {"one splat a group", 0.7f, 0.2f, {}, Vec3f(1, 1, 1), 1, 3},
        {"a third of the splats", 0.7f, 0.2f, placedAt(2, 1.3f, {3, 0.5f, -2}), Vec3f(4, 1, -1), 700, 3},
        {"far away", 0.5f, 1, placedAt(0.5f, 1, {20, 10, -30}), Vec3f(21, 11, -31), 0, 2},
        {"more SH than there is", -0.9f, 0.3f, {}, Vec3f(0, 0.4f, -1.5f), 0, 3},
    };
    std::mt19937 random(20261129);
    std::uniform_real_distribution<float> any(-1, 1);
    for (int i = 0; i < 6; ++i) {
        WriteCase c;
        c.name = "random pose " + std::to_string(i);
        c.bend = 1.6f * any(random), c.turn = 3 * any(random);
        c.transform = placedAt(3 * any(random), std::exp(any(random)), 3.0f * Vec3f(any(random), any(random), any(random)));
        const auto& m = *c.transform;
        if (i % 3 != 2) c.eye = Vec3f(m[3], m[7], m[11]) + 2.0f * Vec3f(any(random), any(random), any(random));
        c.shDegree = uint32_t(i % 4), c.budget = i == 4 ? 1500 : 0;
        cases.push_back(c);
    }
    return cases;
}

/** An avatar on the CPU, which says what is right. */
class OnCpu {
public:
    explicit OnCpu(const std::vector<uint8_t>& file) {
        const DplContextInfo info{sizeof info, DPL_RENDERER_SOFTWARE, 1};
        EXPECT_EQ(dplCreateContext(&info, &context_), DPL_OK) << dplGetLastError();
        EXPECT_EQ(dplLoadAvatar(context_, file.data(), file.size(), &avatar), DPL_OK) << dplGetLastError();
    }
    ~OnCpu() { dplDestroyAvatar(avatar), dplDestroyContext(context_); }
    OnCpu(const OnCpu&) = delete;
    OnCpu& operator=(const OnCpu&) = delete;

    uint32_t count(const WriteCase& c) const {
        const DplSplatOptions options = c.options();
        DplWritten written{sizeof written};
        EXPECT_EQ(dplWriteSplats(avatar, &options, nullptr, &written), DPL_OK) << dplGetLastError();
        return written.count;
    }
    /** Into a buffer full of `fill`. Returns how many numbers saturated. */
    uint64_t write(const WriteCase& c, const Layout& layout, std::vector<uint8_t>& bytes, uint8_t fill = 0xAB) const {
        bytes.assign(layout.bytes, fill);
        const DplSplatOptions options = c.options();
        const DplBuffer buffer{sizeof buffer, uint32_t(layout.elements.size()), layout.elements.data(), bytes.data(), bytes.size()};
        DplWritten written{sizeof written};
        EXPECT_EQ(dplWriteSplats(avatar, &options, &buffer, &written), DPL_OK) << dplGetLastError();
        return written.saturated;
    }
    std::vector<float> property(const WriteCase& c, DplSplatProperty what) const {
        const uint32_t splats = count(c);
        std::vector<uint8_t> bytes;
        write(c, {{at(what, 0)}, uint64_t(splats) * 4 * numbersOf(what, c.shDegree)}, bytes);
        std::vector<float> out(bytes.size() / 4);
        std::memcpy(out.data(), bytes.data(), bytes.size());
        return out;
    }

    DplAvatar avatar = nullptr;

private:
    DplContext context_ = nullptr;
};

/** The largest differences, by property, of splats that show; in the units of Bars. */
using Differences = std::array<double, 8>;

/**
 * What the GPU's splats may differ by. A triangle's frame holds its rotation in 16 bits a component and its brightness and fade in halves,
 * which say what colours and SH (absolute) and opacities may differ by. Positions are relative to the distance from the origin, sizes and
 * covariances to the splat's largest, rotations are angles (radians) times how far the ellipse is from a circle, whose axes are any.
 * Twice what was measured over all cases on lavapipe; halves add their own rounding.
 */
constexpr Differences kBars = {5e-7, 7e-5, 6e-6, 6e-5, 3e-4, 2e-4, 7e-3, 7e-5};

/** Expects two buffers of one layout to hold nearly the same splats, and all other bytes to be `fill`. */
inline void expectSameSplats(const OnCpu& cpu, const WriteCase& c, const Layout& layout, const std::vector<uint8_t>& want,
                             const std::vector<uint8_t>& got, Differences& worst, uint8_t fill = 0xAB) {
    SCOPED_TRACE(c.name);
    ASSERT_EQ(want.size(), got.size());
    const std::vector<float> opacity = cpu.property(c, DPL_SPLAT_OPACITY), scale = cpu.property(c, DPL_SPLAT_SCALE);
    std::vector<bool> covered(want.size(), false);
    for (const DplBufferElement& e : layout.elements) {
        const uint32_t n = numbersOf(e.property, c.shDegree), size = e.number == DPL_NUMBER_HALF ? 2 : 4;
        const uint64_t stride = e.strideBytes ? e.strideBytes : n * size;
        const auto number = [&](const std::vector<uint8_t>& bytes, uint64_t row, uint32_t k) {
            const uint8_t* p = &bytes[e.offsetBytes + row * stride + k * size];
            float f = 0;
            uint16_t h = 0;
            if (size == 4) return std::memcpy(&f, p, 4), double(f);
            return std::memcpy(&h, p, 2), double(floatFromHalf(h));
        };
        size_t shown = 0;
        for (uint64_t row = 0; row < opacity.size(); ++row) {
            for (uint32_t b = 0; b < n * size; ++b) covered[e.offsetBytes + row * stride + b] = true;
            double differs = 0, largest = 0, squares = 0, dot = 0;
            for (uint32_t k = 0; k < n; ++k) dot += number(want, row, k) * number(got, row, k);
            const bool turns = e.property == DPL_SPLAT_ROTATION || e.property == DPL_SPLAT_ROTATION_WXYZ;
            const double sign = turns && dot < 0 ? -1 : 1;  // q and -q are one rotation
            for (uint32_t k = 0; k < n; ++k) {
                const double a = number(want, row, k), b = sign * number(got, row, k);
                ASSERT_TRUE(std::isfinite(b)) << "property " << e.property << " of splat " << row;
                const double halfStep = size == 2 ? std::ldexp(std::max(std::abs(a), 6.2e-5), -10) : 0;  // neighbours among halves
                const double difference = std::max(0.0, std::abs(a - b) - halfStep);
                differs = std::max(differs, difference), squares += difference * difference, largest = std::max(largest, std::abs(a));
            }
            const double major = scale[3 * row], minor = scale[3 * row + 1];
            if (e.property == DPL_SPLAT_POSITION) differs /= std::max(1.0, largest);
            if (e.property == DPL_SPLAT_SCALE) differs /= major;
            if (e.property == DPL_SPLAT_COVARIANCE) differs /= major * major;
            if (turns) differs = 2 * std::sqrt(squares) * (1 - minor * minor / (major * major));
            if (e.property == DPL_SPLAT_OPACITY) {
                ASSERT_EQ(number(got, row, 0) == 0, number(want, row, 0) == 0) << row << ": " << opacity[row];
            } else if (opacity[row] == 0) {
                continue;
            }
            ++shown;
            worst[e.property] = std::max(worst[e.property], differs);
            ASSERT_LE(differs, kBars[e.property]) << "property " << e.property << " of splat " << row;
        }
        EXPECT_GT(shown, opacity.size() / 8);
    }
    for (size_t b = 0; b < got.size(); ++b) ASSERT_TRUE(covered[b] || got[b] == fill) << "byte " << b << " belongs to no property";
}

inline void print(const char* device, const Differences& worst) {
    std::printf(
        "[  WRITTEN ] %s differs by at most: position %.2g, rotation %.2g, scale %.2g, covariance %.2g, opacity %.2g, colour %.2g, "
        "SH %.2g\n",
        device, worst[0], std::max(worst[1], worst[7]), worst[2], worst[3], worst[4], worst[5], worst[6]);
}

/** dB between the pictures that the referee draws of two interleaved() buffers. */
inline double picturesDb(const WriteCase& c, const std::vector<uint8_t>& a, const std::vector<uint8_t>& b, const Cameraf& camera) {
    std::vector<double> pictures[2];
    for (int i = 0; i < 2; ++i) {
        const std::vector<uint8_t>& bytes = i == 0 ? a : b;
        const uint32_t sh = numbersOf(DPL_SPLAT_SH, c.shDegree), words = 12 + sh;
        StaticSplatData splats;
        splats.shDegree = c.shDegree;
        std::vector<float> row(words);
        for (size_t at = 0; at < bytes.size(); at += 4 * words) {
            std::memcpy(row.data(), &bytes[at], 4 * words);
            splats.position.push_back({row[0], row[1], row[2]});
            splats.rotation.push_back(Quatf(row[6], row[3], row[4], row[5]));
            splats.scaleM.push_back({row[7], row[8], row[9]});
            splats.opacity.push_back(row[10]);
            splats.sh.insert(splats.sh.end(), row.begin() + 12, row.end());
        }
        const ReferenceImage drawn = renderReference(splats, referenceCamera(camera), {.kappaPx2 = 1.0f / 12, .compensated = true});
        EXPECT_GT(coverage(drawn.alpha), 0.05);
        for (size_t p = 0; p < drawn.alpha.size(); ++p) {
            for (size_t k = 0; k < 3; ++k) pictures[i].push_back(drawn.rgb[3 * p + k]);
            pictures[i].push_back(drawn.alpha[p]);
        }
    }
    return compareImages(pictures[0], pictures[1]).psnrDb;
}

}  // namespace dpl::test
