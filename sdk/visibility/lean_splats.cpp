// SPDX-License-Identifier: Apache-2.0
#include "sdk/visibility/lean_splats.h"

#include <algorithm>
#include <cmath>

#include "sdk/format/spatial_order.h"
#include "sdk/format/splat_detail.h"
#include "sdk/math/sh.h"
#include "sdk/visibility/detail.h"

namespace dpl {
namespace {

/** Ranks of a group that stay, at least one. */
uint32_t ranksOf(double share) {
    return uint32_t(std::clamp(std::lround(share * kSplatGroupSize), 1l, long(kSplatGroupSize)));
}

bool stays(uint32_t place, uint32_t ranks) {
    return placeOfRank(place) < ranks;  // reversing the bits twice gives the rank
}

double growth(double share, const SplatGroup& group) {
    return Formulas<double>::detailGrowth(share, double(group.gain), double(group.enough));
}

void lowerDegree(CodedSplats& s, uint32_t shDegree) {
    if (shDegree >= s.shDegree) return;
    const size_t from = shEntryBytes(s.shDegree), to = shEntryBytes(shDegree), coefficients = ((shDegree + 1) * (shDegree + 1) - 1) * 3;
    std::vector<int8_t> sh(to == 0 ? 0 : s.sh.size() / from * to, 0);
    for (size_t entry = 0; to > 0 && entry < s.sh.size() / from; ++entry)
        std::copy_n(s.sh.begin() + ptrdiff_t(entry * from), coefficients, sh.begin() + ptrdiff_t(entry * to));
    s.sh = std::move(sh);
    if (to == 0) s.shIndex.clear();
    s.shDegree = shDegree;
}

/** Wanted splats per m² at which the groups keep this share of the splats. */
double densityOf(const CodedSplats& s, double share) {
    const auto keptAt = [&](double perM2) {
        double kept = 0;
        for (size_t g = 0; g < s.groups.size(); ++g) kept += groupRange(s, g).count() * keptShare(perM2, double(s.groups[g].areaM2));
        return kept;
    };
    double low = -40, high = 60;  // logarithms
    for (int step = 0; step < 60; ++step) {
        const double middle = (low + high) / 2;
        (keptAt(std::exp(middle)) < share * s.count() ? low : high) = middle;
    }
    return std::exp(low);
}

/** Appends the splats of a chunk that stay to `out`. */
void appendChunk(const CodedSplats& from, size_t chunk, const std::vector<uint8_t>& keep, double grown, CodedSplats& out) {
    SplatChunk c = from.chunks[chunk];
    const uint32_t begin = c.firstSplat, end = begin + c.splatCount, parents = c.firstParent;
    const size_t entry = shEntryBytes(from.shDegree);
    c.firstSplat = out.count(), c.firstParent = uint32_t(out.parents.size());
    c.scaleMinM *= float(grown), c.scaleMaxM *= float(grown);
    for (uint32_t i = begin; i < end; ++i) {
        if (!keep[i]) continue;
        const uint32_t triangle = from.parents[parents + from.parent[i]];
        if (out.parents.size() == c.firstParent || out.parents.back() != triangle) out.parents.push_back(triangle);  // they rise
        out.parent.push_back(uint8_t(out.parents.size() - 1 - c.firstParent));
        out.place.push_back(from.place[i]), out.size.push_back(from.size[i]), out.colour.push_back(from.colour[i]);
        if (!from.shIndex.empty())
            out.shIndex.push_back(from.shIndex[i]);
        else
            out.sh.insert(out.sh.end(), from.sh.begin() + ptrdiff_t(i * entry), from.sh.begin() + ptrdiff_t((i + 1) * entry));
    }
    c.splatCount = out.count() - c.firstSplat;
    c.firstTriangle = out.parents[c.firstParent], c.endTriangle = out.parents.back() + 1;
    out.chunks.push_back(c);
}

}  // namespace

bool LeanSearch::lower(uint64_t needs, std::optional<uint64_t> room) {
    if (lean_.shDegree > 0) {
        --lean_.shDegree;
        return true;
    }
    if (lean_.share <= kLeastShare) return false;
    double share = lean_.share / 2;
    if (room) {
        // The bytes are a line over the share, of which the first attempt knows one point: then it is taken to begin at 0.
        const double slope = shareBefore_ > 0 ? (needsBefore_ - double(needs)) / (shareBefore_ - lean_.share) : double(needs) / lean_.share;
        share = slope > 0 ? lean_.share - (double(needs) - 0.99 * double(*room)) / slope : 0;
    }
    shareBefore_ = lean_.share, needsBefore_ = double(needs);
    lean_.share = std::clamp(share, kLeastShare, std::max(kLeastShare, 0.95 * lean_.share));
    return true;
}

CodedSplats leanSplats(const AvatarData& avatar, const CodedSplats& splats, const Leanness& lean) {
    CodedSplats s = splats;
    lowerDegree(s, lean.shDegree);
    if (lean.share >= 1 || s.count() == 0) return s;
    measureDetail(avatar, s);
    const double perM2 = densityOf(s, lean.share);
    std::vector<uint8_t> keep(s.count());
    CodedSplats out;
    out.shDegree = s.shDegree;
    if (!s.shIndex.empty()) out.sh = s.sh;  // a palette
    for (size_t chunk = 0; chunk < s.chunks.size(); ++chunk) {
        double grown = 0, kept = 0;
        for (const size_t g : {2 * chunk, 2 * chunk + 1}) {
            const double share = keptShare(perM2, double(s.groups[g].areaM2));
            const GroupRange range = groupRange(s, g);
            for (uint32_t i = range.first; i < range.end; ++i) {
                keep[i] = stays(i - range.first, ranksOf(share));
                if (keep[i]) grown += growth(share, s.groups[g]), kept += 1;
            }
        }
        if (kept > 0) appendChunk(s, chunk, keep, grown / kept, out);
    }
    return out;
}

StaticSplatData leanSplats(const StaticSplatData& s, const Leanness& lean) {
    StaticSplatData out;
    out.shDegree = std::min(s.shDegree, lean.shDegree);
    out.kappaPx2 = s.kappaPx2, out.compensated = s.compensated;
    const size_t from = shCoefficientCount(s.shDegree) * 3, to = shCoefficientCount(out.shDegree) * 3;
    const std::vector<uint32_t> order = spatialOrder(s.position);
    const std::vector<GeneralGroup> groups = lean.share < 1 ? measureGroups(s, order) : std::vector<GeneralGroup>();
    for (size_t k = 0; k < order.size(); ++k) {
        float grown = 1;
        if (lean.share < 1) {
            if (!stays(uint32_t(k % kSplatGroupSize), ranksOf(lean.share))) continue;
            grown = float(growth(lean.share, groups[k / kSplatGroupSize].detail));
        }
        const uint32_t i = order[k];
        out.position.push_back(s.position[i]), out.rotation.push_back(s.rotation[i]);
        out.scaleM.push_back(s.scaleM[i] * grown), out.opacity.push_back(s.opacity[i]);
        out.sh.insert(out.sh.end(), s.sh.begin() + ptrdiff_t(i * from), s.sh.begin() + ptrdiff_t(i * from + to));
    }
    return out;
}

}  // namespace dpl
