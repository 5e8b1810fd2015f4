#include "sdk/avatar/detail.h"

#include <algorithm>
#include <cmath>

namespace dpl {

DetailSubject::DetailSubject(const AvatarData& avatar, const CodedSplats& splats) : splatCount_(splats.count()) {
    std::vector<std::pair<Vec3f, Vec3f>> boxes(avatar.joints.size(), {Vec3f(INFINITY), Vec3f(-INFINITY)});
    for (size_t v = 0; v < avatar.mesh.restPositions.size(); ++v)
        for (int k = 0; k < 4; ++k)
            if (avatar.mesh.jointWeights[v][k] > 0) {
                auto& [low, high] = boxes[avatar.mesh.jointIndices[v][k]];
                low = glm::min(low, avatar.mesh.restPositions[v]), high = glm::max(high, avatar.mesh.restPositions[v]);
            }
    for (size_t j = 0; j < boxes.size(); ++j)
        if (boxes[j].first.x <= boxes[j].second.x) balls_.push_back({uint32_t(j), 0.5f * (boxes[j].first + boxes[j].second), 0.5f * glm::length(boxes[j].second - boxes[j].first)});

    // Of each half-chunk: one splat, then its kept share and what fades (drawnRanks rounds up by at most a half), then all.
    double least = 0, most = 0, areaM2 = 0;
    for (size_t g = 0; g < splats.groups.size(); ++g) {
        const SplatGroup& group = splats.groups[g];
        const uint32_t inChunk = splats.chunks[g / 2].splatCount, before = g % 2 * kSplatGroupSize;
        if (inChunk <= before) continue;
        const double count = std::min(inChunk - before, kSplatGroupSize), slope = (1 + kDetailFade) * double(group.areaM2) * kSplatGroupSize;
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
    bends_.back().drawn = most, bends_.back().slope = 0;   // without the rounding of the sums
}

double DetailSubject::drawnAtMost(double perM2) const {
    if (bends_.empty()) return splatCount_;
    if (!(perM2 < bends_.back().perM2)) return bends_.back().drawn;
    const Bend& bend = *(std::upper_bound(bends_.begin(), bends_.end(), perM2, [](double x, const Bend& b) { return x < b.perM2; }) - 1);
    return bend.drawn + bend.slope * (perM2 - bend.perM2);
}

float DetailSubject::largestGrowth(float perM2) const {
    return !(smallestAreaM2_ < INFINITY) ? 1.0f : detailGrowth(keptShare(perM2, smallestAreaM2_), largestGain_, 1.0f);
}

double DetailSubject::finestPixelM(std::span<const Mat3x4f> worldFromRest, std::span<const Cameraf> views) const {
    double finest = INFINITY;
    for (const Cameraf& view : views) {
        double nearestM = INFINITY;
        for (const Ball& ball : balls_) nearestM = std::min(nearestM, double(view.toView(worldFromRest[ball.joint] * Vec4f(ball.centre, 1)).z) - double(ball.radiusM));
        finest = std::min(finest, std::max(nearestM, kDetailNearestM) / double(std::max(view.fx, view.fy)));
    }
    return finest;
}

uint64_t chooseDetails(const DetailOptions& options, std::span<const Cameraf> views, std::span<DetailMember> members) {
    for (DetailMember& m : members) {
        m.detail = {}, m.generalDetail = {}, m.share = 1;
        if (options.off()) continue;
        if (m.general) m.general->look(views);
        else m.pixelM = m.avatar->finestPixelM(m.worldFromRest, views);
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
    if (options.splatBudget > 0 && drawn(perPixel) > options.splatBudget) {
        double low = 1e-9, high = std::min(perPixel, 1e9);   // of splats a pixel; the sum rises with it
        for (int step = 0; step < 64; ++step) {
            const double middle = std::sqrt(low * high);
            (drawn(middle) > options.splatBudget ? high : low) = middle;
        }
        perPixel = low;
    }
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
    return uint64_t(std::ceil(drawn(perPixel)));
}

}  // namespace dpl
