// SPDX-License-Identifier: Apache-2.0
#include "sdk/visibility/detail.h"

#include <algorithm>
#include <cmath>

#include "sdk/avatar/humanoid.h"
#include "sdk/format/splat_detail.h"

namespace dpl {

namespace {

constexpr float kFace = 3, kHand = 2;  // factors by which they keep more splats than other surface, because people look at them

float favourOf(std::string_view bone) {
    if (bone == "head" || bone == "jaw" || bone.ends_with("Eye")) return kFace;
    for (const char* part : {"Hand", "Thumb", "Index", "Middle", "Ring", "Little"})
        if (bone.find(part) != bone.npos) return kHand;
    return 1;
}

/** One a group: the mean favour of its splats. A triangle's favour is the mean of its joints' favours by skin weight. */
std::vector<float> favours(const AvatarData& avatar, const CodedSplats& splats) {
    const MeshData& mesh = avatar.mesh;
    std::vector<float> ofJoint, ofTriangle;
    for (const std::string& bone : humanoidBones(avatar.joints)) ofJoint.push_back(favourOf(bone));
    for (const Triangle& t : mesh.triangles) {
        float more = 0;
        for (int corner = 0; corner < 3; ++corner)
            for (int k = 0; k < 4; ++k)
                if (const uint32_t weight = mesh.jointWeights[t[corner]][k]; weight > 0)
                    more += float(weight) * (ofJoint[mesh.jointIndices[t[corner]][k]] - 1);
        ofTriangle.push_back(1 + more / (3 * 255));
    }
    std::vector<float> out(splats.groups.size(), 1);
    for (size_t g = 0; g < out.size(); ++g) {
        const SplatChunk& c = splats.chunks[g / 2];
        const GroupRange range = groupRange(splats, g);
        float sum = 0;
        for (uint32_t i = range.first; i < range.end; ++i) sum += ofTriangle[splats.parents[c.firstParent + splats.parent[i]]];
        if (range.count() > 0) out[g] = sum / float(range.count());
    }
    return out;
}

}  // namespace

void measureDetail(const AvatarData& avatar, CodedSplats& splats) {
    measureGroups(avatar.mesh, splats);
    const std::vector<float> favour = favours(avatar, splats);
    double area = 0, favoured = 0;
    for (size_t g = 0; g < favour.size(); ++g) {
        const double own = double(splats.groups[g].areaM2) * groupRange(splats, g).count();
        area += own, favoured += own * double(favour[g]);
    }
    for (size_t g = 0; g < favour.size() && favoured > 0; ++g) splats.groups[g].areaM2 *= float(double(favour[g]) * area / favoured);
}

DetailSubject::DetailSubject(const AvatarData& avatar, const CodedSplats& splats) : splatCount_(splats.count()) {
    std::vector<std::pair<Vec3f, Vec3f>> boxes(avatar.joints.size(), {Vec3f(INFINITY), Vec3f(-INFINITY)});
    for (size_t v = 0; v < avatar.mesh.restPositions.size(); ++v)
        for (int k = 0; k < 4; ++k)
            if (avatar.mesh.jointWeights[v][k] > 0) {
                auto& [low, high] = boxes[avatar.mesh.jointIndices[v][k]];
                low = glm::min(low, avatar.mesh.restPositions[v]), high = glm::max(high, avatar.mesh.restPositions[v]);
            }
    for (size_t j = 0; j < boxes.size(); ++j)
        if (boxes[j].first.x <= boxes[j].second.x)
            balls_.push_back(
                {uint32_t(j), 0.5f * (boxes[j].first + boxes[j].second), 0.5f * glm::length(boxes[j].second - boxes[j].first)});

    // Each group draws 1 splat up to the density 0.5 / slope, then at most slope · density + ½ (kept and fading ranks; drawnRanks rounds up
    // by at most ½), then all. `least` and `most` are the sums of the ends.
    double least = 0, most = 0, areaM2 = 0;
    for (size_t g = 0; g < splats.groups.size(); ++g) {
        const SplatGroup& group = splats.groups[g];
        const double count = groupRange(splats, g).count();
        if (count == 0) continue;
        const double slope = (1 + kDetailFade) * double(group.areaM2) * kSplatGroupSize;
        least += 1, most += slope > 0 ? count : 1, areaM2 += double(group.areaM2) * count;
        smallestAreaM2_ = std::min(smallestAreaM2_, group.areaM2), largestGain_ = std::max(largestGain_, group.gain);
        if (count > 1 && slope > 0) bends_.push_back({0.5 / slope, 0, slope}), bends_.push_back({(count - 0.5) / slope, 0, -slope});
    }
    if (splats.groups.empty()) least = most = splatCount_;
    if (splatCount_ > 0) meanAreaM2_ = float(areaM2 / splatCount_);
    std::sort(bends_.begin(), bends_.end(), [](const Bend& a, const Bend& b) { return a.perM2 < b.perM2; });
    bends_.insert(bends_.begin(), Bend{0, least, 0});
    for (size_t i = 1; i < bends_.size(); ++i) {
        bends_[i].drawn = bends_[i - 1].drawn + bends_[i - 1].slope * (bends_[i].perM2 - bends_[i - 1].perM2);
        bends_[i].slope += bends_[i - 1].slope;
    }
    bends_.back().drawn = most, bends_.back().slope = 0;  // without the rounding of the sums
}

double DetailSubject::drawnAtMost(double perM2) const {
    if (bends_.empty()) return splatCount_;
    if (!(perM2 < bends_.back().perM2)) return bends_.back().drawn;
    const Bend& bend = *(std::upper_bound(bends_.begin(), bends_.end(), perM2, [](double x, const Bend& b) { return x < b.perM2; }) - 1);
    return bend.drawn + bend.slope * (perM2 - bend.perM2);
}

double DetailSubject::densityWithin(uint32_t splats) const {
    if (bends_.empty() || splats >= bends_.back().drawn) return INFINITY;
    const auto after = std::upper_bound(bends_.begin(), bends_.end(), double(splats), [](double n, const Bend& b) { return n < b.drawn; });
    if (after == bends_.begin()) return 0;
    const Bend& bend = *(after - 1);
    return bend.slope > 0 ? bend.perM2 + (splats - bend.drawn) / bend.slope : bend.perM2;
}

SplatDetail DetailSubject::detailWithin(uint32_t splats) const {
    SplatDetail detail;
    if (splats == 0 || splats >= splatCount_) return detail;
    detail.perM2 = std::nextafter(float(densityWithin(splats)), 0.0f);
    detail.shShare = shShare(detail.perM2);
    return detail;
}

float DetailSubject::largestGrowth(float perM2) const {
    return !(smallestAreaM2_ < INFINITY) ? 1.0f : detailGrowth(keptShare(perM2, smallestAreaM2_), largestGain_, 1.0f);
}

double DetailSubject::finestPixelM(std::span<const Mat3x4f> worldFromRest, std::span<const Cameraf> views, float scale) const {
    const double floorM = kDetailNearestM / double(scale);
    double finest = INFINITY;
    for (const Cameraf& view : views) {
        double nearestM = INFINITY;
        for (const Ball& ball : balls_)
            nearestM = std::min(nearestM, double(view.toView(worldFromRest[ball.joint] * Vec4f(ball.centre, 1)).z) - double(ball.radiusM));
        finest = std::min(finest, std::max(nearestM, floorM) / double(std::max(view.fx, view.fy)));
    }
    return finest;
}

DetailTotals chooseDetails(const DetailOptions& options, std::span<DetailMember> members) {
    for (DetailMember& m : members) {
        m.detail = {}, m.generalDetail = {}, m.share = 1;
        if (options.off()) continue;
        if (m.general)
            m.general->look(m.views, m.scale);
        else
            m.pixelM = m.avatar->finestPixelM(m.worldFromRest, m.views, m.scale);
    }
    const auto drawnOf = [](const DetailMember& m, double perPixel) {
        return m.general ? m.general->drawnAtMost(perPixel) : m.avatar->drawnAtMost(perPixel / (m.pixelM * m.pixelM));
    };
    const auto drawn = [&](double perPixel) {
        double sum = 0;
        for (const DetailMember& m : members) sum += drawnOf(m, perPixel);
        return sum;
    };
    double perPixel = options.splatsPerPixel > 0 ? double(options.splatsPerPixel) : INFINITY;
    const auto kept = [&](double perPixel) { return drawn(perPixel / (1 + kDetailFade)); };
    const auto lowerTo = [&perPixel](const auto& count, double most) {
        double low = 1e-9, high = std::min(perPixel, 1e9);  // splats a pixel; `count` rises with it
        for (int step = 0; step < 64; ++step) {
            const double middle = std::sqrt(low * high);
            (count(middle) > most ? high : low) = middle;
        }
        perPixel = low;
    };
    if (options.splatBudget > 0 && drawn(perPixel) > options.splatBudget) lowerTo(drawn, options.splatBudget);
    DetailTotals totals;
    totals.drawn = totals.wantedDrawn = uint64_t(std::ceil(drawn(perPixel)));
    totals.kept = totals.wantedKept = uint64_t(std::ceil(kept(perPixel)));
    if (options.limits.drawn > 0 && totals.drawn > options.limits.drawn) lowerTo(drawn, options.limits.drawn);
    if (options.limits.kept > 0 && totals.kept > options.limits.kept) lowerTo(kept, options.limits.kept);
    totals.drawn = uint64_t(std::ceil(drawn(perPixel)));
    totals.kept = uint64_t(std::ceil(kept(perPixel)));
    for (DetailMember& m : members) {
        if (!(perPixel < INFINITY)) continue;
        if (m.general) {
            m.generalDetail = m.general->detail(float(perPixel));
            m.share = m.general->drawnShare(perPixel);
        } else {
            m.detail.perM2 = float(perPixel / (m.pixelM * m.pixelM));
            m.detail.shShare = m.avatar->shShare(m.detail.perM2);
            m.share = m.avatar->drawnShare(m.detail);
        }
    }
    return totals;
}

}  // namespace dpl
