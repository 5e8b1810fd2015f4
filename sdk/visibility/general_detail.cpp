// SPDX-License-Identifier: Apache-2.0
#include "sdk/visibility/general_detail.h"

#include <algorithm>
#include <cmath>

#include "sdk/math/projection.h"
#include "sdk/visibility/detail.h"

namespace dpl {
namespace {

// Groups are sorted into bins by the pixels that one of their splats stands for: from 2^-40 to 2^40, in steps of 2^(1/64), which is 1.1 %.
constexpr int kBinsAnOctave = 64, kFirstOctave = -40, kBins = 80 * kBinsAnOctave;

constexpr double kBehindM = 1;  // world: a group that lies wholly behind the cameras counts less, and from this distance on not at all

double binOf(double pixels) {
    return (std::log2(pixels) - kFirstOctave) * kBinsAnOctave;
}

}  // namespace

GeneralDetailSubject::GeneralDetailSubject(std::vector<GeneralGroup> groups, uint32_t splatCount)
    : groups_(std::move(groups)), sums_(kBins + 1), splatCount_(splatCount) {}

void GeneralDetailSubject::look(std::span<const Cameraf> views, float scale) {
    if (views.empty()) return;
    float longest = 0;
    for (size_t v = 0; v < 2; ++v) {
        const Cameraf& view = views[std::min(v, views.size() - 1)];
        seen_.planes[v] = pixelPlane(view);
        longest = std::max({longest, view.fx, view.fy});
    }
    seen_.finestM = float(kDetailNearestM) / scale / longest;
    std::fill(sums_.begin(), sums_.end(), Sums{});
    // A group at position `at` is shared between the two bins above ⌊at⌋. So the sums are never too low, and they move without steps.
    for (const GeneralGroup& group : groups_) {
        double aheadM = -INFINITY;
        for (const PixelPlane& p : seen_.planes)
            aheadM = std::max(aheadM, double(glm::dot(p.axis, group.middle) + p.offsetM + glm::dot(glm::abs(p.axis), group.reach)) /
                                          double(glm::length(p.axis)));
        const double counts = std::clamp(1 + (double(scale) * aheadM - kNearM) / kBehindM, 0.0, 1.0);
        if (counts == 0) continue;
        const double pixelM = double(seen_.pixelM(group.middle, group.reach));
        const double at = std::clamp(binOf(double(group.detail.areaM2) / (pixelM * pixelM)), 0.0, double(kBins - 3));
        const int bin = int(at);
        const double farther = at - bin;
        sums_[size_t(bin) + 2].groups += counts * (1 - farther),
            sums_[size_t(bin) + 3].groups += counts * farther;  // bin b is stored at b + 1: sums_[b] gets the sum of the bins before b
    }
    double pixels = std::exp2(kFirstOctave);
    static const double step = std::exp2(1.0 / kBinsAnOctave);
    for (int bin = 0; bin < kBins; ++bin, pixels *= step) {
        Sums& sum = sums_[size_t(bin) + 1];
        sum.density = sum.groups * pixels + sums_[size_t(bin)].density;
        sum.groups += sums_[size_t(bin)].groups;
    }
}

GeneralDetail GeneralDetailSubject::detail(float perPixel) const {
    GeneralDetail detail = seen_;
    detail.perPixel = perPixel;
    return detail;
}

double GeneralDetailSubject::drawnAtMost(double perPixel) const {
    // With x = slope · pixels a splat stands for, a group draws 1 splat up to x = ½, then at most x + ½ (drawnRanks rounds up by at most
    // ½), then all.
    const double slope = (1 + kDetailFade) * kSplatGroupSize * perPixel;
    if (!(slope < INFINITY)) return splatCount_;
    const auto binFrom = [&](double splats) { return size_t(std::clamp(std::ceil(binOf(splats / slope)), 0.0, double(kBins))); };
    const Sums &one = sums_[binFrom(0.5)], &all = sums_[binFrom(kSplatGroupSize - 0.5)], &end = sums_.back();
    const double drawn =
        one.groups + slope * (all.density - one.density) + 0.5 * (all.groups - one.groups) + kSplatGroupSize * (end.groups - all.groups);
    return std::min(drawn, double(splatCount_));
}

float GeneralDetailSubject::drawnShare(double perPixel) const {
    const double ahead = std::min(kSplatGroupSize * sums_.back().groups, double(splatCount_));
    return ahead > 0 && perPixel < INFINITY ? float(std::min(1.0, drawnAtMost(perPixel) / ahead)) : 1.0f;
}

}  // namespace dpl
