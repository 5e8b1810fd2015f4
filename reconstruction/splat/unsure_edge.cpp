// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/splat/unsure_edge.h"

#include <algorithm>
#include <cmath>

#include "reconstruction/priors.h"

namespace dpl {
namespace {

constexpr double kSigmaRadii = 0.75;  // of the Gaussian, in radii
constexpr double kReachRadii = 3.5;   // background farther away does not count

/** Calls visit(pixel, squared distance) for the pixels of the picture within `reach` of (x, y). */
template <class Visit>
void around(int x, int y, int width, int height, int reach, Visit&& visit) {
    for (int j = std::max(0, y - reach); j <= std::min(height - 1, y + reach); ++j)
        for (int i = std::max(0, x - reach); i <= std::min(width - 1, x + reach); ++i)
            visit(size_t(j) * size_t(width) + size_t(i), (i - x) * (i - x) + (j - y) * (j - y));
}

}  // namespace

UnsureEdge unsureEdge(const FramePicture& picture) {
    const int width = int(picture.mask.widthPx), height = int(picture.mask.heightPx);
    const double share = picture.maskFound ? priors::kFoundMaskEdge : 0;
    const int radius = int(std::max(1.0, std::round(share * std::hypot(width, height))));
    const std::vector<uint8_t>& mask = picture.mask.pixels;
    UnsureEdge out{std::vector<uint8_t>(mask.size(), 0), std::vector<float>(mask.size() * 3, 0.0f)};
    // Every pixel beside the edge marks the pixels of the other side that are near.
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) {
            const size_t at = size_t(y) * size_t(width) + size_t(x);
            const bool inside = isPerson(mask[at]);
            const auto differs = [&](bool exists, size_t other) { return exists && isPerson(mask[other]) != inside; };
            if (!differs(x > 0, at - 1) && !differs(x + 1 < width, at + 1) && !differs(y > 0, at - size_t(width)) &&
                !differs(y + 1 < height, at + size_t(width)))
                continue;
            around(x, y, width, height, radius, [&](size_t other, int squared) {
                if (squared <= radius * radius && isPerson(mask[other]) != inside) out.unsure[other] = 1;
            });
        }
    const int reach = int(std::ceil(kReachRadii * radius));
    const double falloff = -0.5 / (kSigmaRadii * radius * kSigmaRadii * radius);
    std::vector<size_t> alone;
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) {
            const size_t at = size_t(y) * size_t(width) + size_t(x);
            if (!out.unsure[at]) continue;
            double sum[3] = {}, total = 0;
            around(x, y, width, height, reach, [&](size_t other, int squared) {
                if (out.unsure[other] || isPerson(mask[other])) return;
                const double weight = std::exp(falloff * squared);
                total += weight;
                for (size_t c = 0; c < 3; ++c) sum[c] += weight * picture.image.pixels[other * 3 + c];
            });
            if (!(total > 0)) alone.push_back(at);
            for (size_t c = 0; c < 3 && total > 0; ++c) out.behind[at * 3 + c] = float(sum[c] / total);
        }
    for (const size_t at : alone) out.unsure[at] = 0;
    return out;
}

}  // namespace dpl
