// SPDX-License-Identifier: Apache-2.0
// Shared by tests of general splat files: pinned files by other programs and their content, refusals, damaged files.
#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>

#include "sdk/core/files.h"
#include "sdk/format/splat_file.h"
#include "sdk/math/sh.h"
#include "tests/unit/shared_data.h"

namespace dpl::test {

using Bytes = std::vector<uint8_t>;

inline Bytes fileBytes(const std::filesystem::path& path) {
    auto bytes = readFile(path);
    EXPECT_TRUE(bytes) << path;
    return bytes ? *bytes : Bytes{};
}
inline Bytes pinned(const char* name) {
    return fileBytes(sourceFolder() / "tests/unit/format/pinned" / name);
}

/** Content of the pinned files. splats_v*.spz are by the reference library (@adobe/spz, 8 bits of SH); splats.compressed.ply and
 *  splats_khr.glb are by PlayCanvas' splat-transform 2.7.1, which reorders the splats and rotates the .glb by half a turn about z. */
inline StaticSplatData pinnedSplats() {
    StaticSplatData s;
    s.shDegree = 3;
    const Quatf turns[] = {
        {1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}, {0, 0, 0, 1}, {0.5f, 0.5f, -0.5f, 0.5f}, {0.8f, 0, 0, -0.6f}, {-0.1f, 0.7f, 0.1f, -0.7f}};
    for (int i = 0; i < 7; ++i) {
        s.position.emplace_back(0.25f * i - 1, 0.5f - 0.125f * i, 0.0625f * i);
        s.rotation.push_back(glm::normalize(turns[i]));
        s.scaleM.emplace_back(0.01f * (i + 1), 0.02f, 0.04f / (i + 1));
        s.opacity.push_back((i + 1) / 8.0f);
        for (const float dc : {0.2f * i - 0.6f, 0.5f, -0.1f * i}) s.sh.push_back(dc);
        for (int k = 0; k < 15; ++k)
            for (int c = 0; c < 3; ++c) s.sh.push_back(0.9f * std::sin(0.7f * k + 1.3f * c + 0.5f * i));
    }
    return s;
}

/** Largest differences that expectSplats accepts. */
struct Tolerance {
    float place, turn, scaleShare, opacity, dc, rest;
};

/** Expects the splats of `want` in `read`, in any order; matches them by position. */
inline void expectSplats(const StaticSplatData& read, const StaticSplatData& want, const Tolerance& t) {
    ASSERT_EQ(read.count(), want.count());
    ASSERT_EQ(read.shDegree, want.shDegree);
    const uint32_t floats = shCoefficientCount(want.shDegree) * 3;
    ASSERT_EQ(read.sh.size(), want.sh.size());
    for (size_t i = 0; i < want.count(); ++i) {
        size_t j = 0;
        for (size_t k = 1; k < read.count(); ++k)
            if (glm::length(read.position[k] - want.position[i]) < glm::length(read.position[j] - want.position[i])) j = k;
        EXPECT_LE(glm::length(read.position[j] - want.position[i]), t.place) << i;
        EXPECT_GE(std::abs(glm::dot(read.rotation[j], want.rotation[i])), 1 - t.turn) << i;
        EXPECT_NEAR(glm::length(read.rotation[j]), 1, 1e-5) << i;
        for (int a = 0; a < 3; ++a) EXPECT_NEAR(read.scaleM[j][a] / want.scaleM[i][a], 1, t.scaleShare) << i << " axis " << a;
        EXPECT_NEAR(read.opacity[j], want.opacity[i], t.opacity) << i;
        for (size_t k = 0; k < floats; ++k)
            EXPECT_NEAR(read.sh[j * floats + k], want.sh[i * floats + k], k < 3 ? t.dc : t.rest) << i << " SH " << k;
    }
}

inline void expectRefused(const Result<SplatFile>& result, const char* what, Code code, const char* says) {
    ASSERT_FALSE(result) << what << " was accepted";
    EXPECT_EQ(int(result.error().code), int(code)) << what << ": " << result.error().message;
    EXPECT_NE(result.error().message.find(says), std::string::npos) << what << ": " << result.error().message;
}

/** Expects that every truncation is refused, and that a flipped bit is refused or read without harm. */
inline void expectSturdy(const Bytes& good) {
    ASSERT_TRUE(readSplats(good));
    for (size_t size = 0; size < good.size(); ++size) {
        auto cut = readSplats(std::span(good).first(size));
        ASSERT_FALSE(cut) << "cut to " << size << " of " << good.size();
        EXPECT_FALSE(cut.error().message.empty());
    }
    for (size_t at = 0; at < good.size(); ++at)
        for (int bit = 0; bit < 8; bit += 3) {
            Bytes bad = good;
            bad[at] ^= uint8_t(1 << bit);
            auto read = readSplats(bad);
            if (!read) continue;
            for (const Vec3f& p : read->splats.position) ASSERT_TRUE(std::isfinite(p.x + p.y + p.z)) << at;
            for (const float v : read->splats.sh) ASSERT_TRUE(std::isfinite(v)) << at;
        }
}

/** The pinned splats cut to this SH degree. */
inline StaticSplatData ofDegree(uint32_t degree) {
    StaticSplatData s = pinnedSplats(), out = s;
    out.shDegree = degree, out.sh.clear();
    for (size_t i = 0; i < s.count(); ++i)
        out.sh.insert(out.sh.end(), s.sh.begin() + ptrdiff_t(i * 48), s.sh.begin() + ptrdiff_t(i * 48 + shCoefficientCount(degree) * 3));
    return out;
}

template <class T>
void append(Bytes& out, T value) {
    const auto* raw = reinterpret_cast<const uint8_t*>(&value);
    out.insert(out.end(), raw, raw + sizeof(T));
}

/** A hand-made file: 300 splats in two chunks, SH degree 1. */
struct CompressedPlyByHand {
    uint32_t count = 300, chunks = 2, shRows = 300;
    bool chunkColours = true;
    std::vector<std::array<uint32_t, 4>> words = std::vector<std::array<uint32_t, 4>>(300, {0, 0, 0, 0});
    std::vector<std::array<uint8_t, 9>> sh = std::vector<std::array<uint8_t, 9>>(300);
    float ranges[2][18] = {{0, 0, 0, 1, 2, 4, -5, -5, -5, -3, -3, -3, 0, 0, 0, 1, 1, 1},
                           {10, 20, 30, 10, 20, 30, -4, -4, -4, -4, -4, -4, -1, -1, -1, 2, 2, 2}};
    Bytes bytes() const {
        std::string header = "ply\nformat binary_little_endian 1.0\ncomment by hand\nelement chunk " + std::to_string(chunks) + "\n";
        for (const char* name : {"min_x", "min_y", "min_z", "max_x", "max_y", "max_z", "min_scale_x", "min_scale_y", "min_scale_z",
                                 "max_scale_x", "max_scale_y", "max_scale_z"})
            header += std::string("property float ") + name + "\n";
        if (chunkColours)
            for (const char* name : {"min_r", "min_g", "min_b", "max_r", "max_g", "max_b"})
                header += std::string("property float ") + name + "\n";
        header += "element vertex " + std::to_string(count) + "\n";
        for (const char* name : {"packed_position", "packed_rotation", "packed_scale", "packed_color"})
            header += std::string("property uint ") + name + "\n";
        header += "element sh " + std::to_string(shRows) + "\n";
        for (int k = 0; k < 9; ++k) header += "property uchar f_rest_" + std::to_string(k) + "\n";
        header += "end_header\n";
        Bytes out(header.begin(), header.end());
        for (const auto& range : ranges)
            for (int k = 0; k < (chunkColours ? 18 : 12); ++k) append(out, range[k]);
        for (const auto& row : words) append(out, row);
        for (const auto& row : sh) append(out, row);
        return out;
    }
};

}  // namespace dpl::test
