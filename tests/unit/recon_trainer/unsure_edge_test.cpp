// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/training/trainer/unsure_edge.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "reconstruction/training/trainer/priors.h"

namespace dpl::test {
namespace {

/** Random colours; a mask of random discs, with a hole that is too narrow to show background. */
FramePicture randomPicture(uint32_t width, uint32_t height, uint32_t seed) {
    std::mt19937 random(seed);
    FramePicture p;
    p.image = {width, height, std::vector<uint8_t>(size_t(width) * height * 3)};
    p.mask = {width, height, std::vector<uint8_t>(size_t(width) * height, 0)};
    for (uint8_t& v : p.image.pixels) v = uint8_t(random());
    for (int disc = 0; disc < 6; ++disc) {
        const int cx = int(random() % width), cy = int(random() % height), r = int(8 + random() % (width / 5));
        for (int y = 0; y < int(height); ++y)
            for (int x = 0; x < int(width); ++x)
                if ((x - cx) * (x - cx) + (y - cy) * (y - cy) < r * r) p.mask.pixels[size_t(y) * width + size_t(x)] = 255;
    }
    return p;
}

struct Direct {
    std::vector<uint8_t> unsure;
    std::vector<double> behind;
};

/** The definition of unsure_edge.h, pixel by pixel: a Gaussian of 0.75 radii, within a square of 3.5 radii. */
Direct directSum(const FramePicture& p) {
    const int width = int(p.mask.widthPx), height = int(p.mask.heightPx);
    const double share = p.maskFound ? priors::kFoundMaskEdge : 0;
    const int radius = int(std::max(1.0, std::round(share * std::hypot(width, height)))), reach = int(std::ceil(3.5 * radius));
    const auto index = [&](int x, int y) { return size_t(y) * size_t(width) + size_t(x); };
    const auto inside = [&](int x, int y) { return x >= 0 && y >= 0 && x < width && y < height; };
    const auto person = [&](int x, int y) { return isPerson(p.mask.pixels[index(x, y)]); };
    const auto atEdge = [&](int x, int y) {
        for (const auto& [i, j] : {std::pair(x - 1, y), std::pair(x + 1, y), std::pair(x, y - 1), std::pair(x, y + 1)})
            if (inside(i, j) && person(i, j) != person(x, y)) return true;
        return false;
    };
    std::vector<uint8_t> near(p.mask.pixels.size(), 0);
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x)
            for (int j = y - radius; j <= y + radius; ++j)
                for (int i = x - radius; i <= x + radius; ++i)
                    if (inside(i, j) && (i - x) * (i - x) + (j - y) * (j - y) <= radius * radius && person(i, j) != person(x, y) &&
                        atEdge(i, j))
                        near[index(x, y)] = 1;
    Direct out{near, std::vector<double>(near.size() * 3, 0.0)};
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) {
            if (!near[index(x, y)]) continue;
            double sum[3] = {}, total = 0;
            for (int j = y - reach; j <= y + reach; ++j)
                for (int i = x - reach; i <= x + reach; ++i) {
                    if (!inside(i, j) || near[index(i, j)] || person(i, j)) continue;
                    const double w = std::exp(-0.5 * ((i - x) * (i - x) + (j - y) * (j - y)) / (0.75 * radius * 0.75 * radius));
                    total += w;
                    for (size_t c = 0; c < 3; ++c) sum[c] += w * p.image.pixels[index(i, j) * 3 + c];
                }
            if (!(total > 0)) out.unsure[index(x, y)] = 0;
            for (size_t c = 0; c < 3 && total > 0; ++c) out.behind[index(x, y) * 3 + c] = sum[c] / total;
        }
    return out;
}

TEST(UnsureEdge, equalsTheDirectSumOfItsDefinition) {
    for (const bool found : {true, false})
        for (const uint32_t seed : {1u, 2u, 3u}) {
            SCOPED_TRACE(testing::Message() << "found " << found << ", seed " << seed);
            FramePicture p = randomPicture(143, 211, seed);                                                    // radius 2 if found, else 1
            for (size_t at = 0; at < p.mask.pixels.size(); at += 3) p.mask.pixels[at] |= seed == 3 ? 255 : 0;  // no sure background
            p.maskFound = found;
            const UnsureEdge edge = unsureEdge(p);
            const Direct direct = directSum(p);
            EXPECT_EQ(edge.unsure, direct.unsure);
            ASSERT_EQ(edge.behind.size(), direct.behind.size());
            size_t filled = 0;
            for (size_t i = 0; i < direct.behind.size(); ++i) {
                ASSERT_NEAR(double(edge.behind[i]), direct.behind[i], 1e-5) << i;  // of 255, as floats round
                filled += direct.behind[i] > 0;
            }
            EXPECT_EQ(filled > 1000, seed != 3);
        }
}

}  // namespace
}  // namespace dpl::test
