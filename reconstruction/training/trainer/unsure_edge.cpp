// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/training/trainer/unsure_edge.h"

#include <algorithm>
#include <cmath>

#include "reconstruction/training/trainer/priors.h"
#include "sdk/math/types.h"

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

/** Sets out.behind. Clears out.unsure where no background is within reach.
 *
 *  The Gaussian factors into x and y. Each row is blurred along x, and added to the sums of the unsure pixels above and below. Nothing is
 *  blurred where no unsure pixel of the column is within reach. */
void fillBehind(const FramePicture& picture, int radius, UnsureEdge& out) {
    const int width = int(picture.mask.widthPx), height = int(picture.mask.heightPx);
    const int reach = int(std::ceil(kReachRadii * radius));
    std::vector<double> weight;  // of a distance along one axis
    for (int d = 0; d <= reach; ++d) weight.push_back(std::exp(-0.5 * d * d / (kSigmaRadii * radius * kSigmaRadii * radius)));

    struct Column {
        std::vector<int> rows;      // of its unsure pixels, from the top
        std::vector<Vec4d> sums;    // of each: weighted colours, weights
        size_t first = 0, end = 0;  // those within reach of the current row
    };
    std::vector<Column> columns(size_t(width), Column{});
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x)
            if (out.unsure[size_t(y) * size_t(width) + size_t(x)]) columns[size_t(x)].rows.push_back(y);
    for (Column& column : columns) column.sums.assign(column.rows.size(), Vec4d(0));

    std::vector<Vec4d> row(size_t(width), Vec4d(0));  // colour and 1 where it is sure background, else 0
    for (int y = 0; y < height; ++y) {
        for (int x = 0; x < width; ++x) {
            const size_t at = size_t(y) * size_t(width) + size_t(x);
            const uint8_t* rgb = picture.image.pixels.data() + at * 3;
            row[size_t(x)] = out.unsure[at] || isPerson(picture.mask.pixels[at]) ? Vec4d(0) : Vec4d(rgb[0], rgb[1], rgb[2], 1);
        }
        for (int x = 0; x < width; ++x) {
            Column& column = columns[size_t(x)];
            while (column.end < column.rows.size() && column.rows[column.end] <= y + reach) ++column.end;
            while (column.first < column.end && column.rows[column.first] < y - reach) ++column.first;
            if (column.first == column.end) continue;
            Vec4d blurred(0);
            for (int i = std::max(0, x - reach); i <= std::min(width - 1, x + reach); ++i)
                blurred += weight[size_t(std::abs(i - x))] * row[size_t(i)];
            for (size_t k = column.first; k < column.end; ++k) column.sums[k] += weight[size_t(std::abs(column.rows[k] - y))] * blurred;
        }
    }
    for (int x = 0; x < width; ++x)
        for (size_t k = 0; k < columns[size_t(x)].rows.size(); ++k) {
            const size_t at = size_t(columns[size_t(x)].rows[k]) * size_t(width) + size_t(x);
            const Vec4d& sum = columns[size_t(x)].sums[k];
            if (!(sum.w > 0)) out.unsure[at] = 0;
            for (int c = 0; c < 3 && sum.w > 0; ++c) out.behind[at * 3 + size_t(c)] = float(sum[c] / sum.w);
        }
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
    fillBehind(picture, radius, out);
    return out;
}

}  // namespace dpl
