// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/body/swapped_sides.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "reconstruction/body/fit_limbs.h"

namespace dpl {
namespace {

constexpr double kUsualMotion = 0.03;  // of a keypoint between two frames, share of the diagonal
constexpr double kLargeMotion2 = 9;    // squared motion, in usual motions, that costs no more when it grows
constexpr double kSwapCost = 6;        // of one swapped frame: a few keypoints that clearly fit better the other way

/** Index of the keypoint on the other side; its own index for names without a side. */
std::vector<size_t> otherSides(std::span<const std::string> names) {
    std::vector<size_t> other(names.size());
    for (size_t k = 0; k < names.size(); ++k) {
        other[k] = k;
        std::string name = names[k];
        if (name.size() < 3 || name[name.size() - 2] != '_' || (name.back() != 'l' && name.back() != 'r')) continue;
        name.back() = name.back() == 'l' ? 'r' : 'l';
        const auto found = std::find(names.begin(), names.end(), name);
        if (found != names.end()) other[k] = size_t(found - names.begin());
    }
    return other;
}

double motion(const SidedFrame& a, const SidedFrame& b, const std::vector<size_t>& other, bool swapped) {
    double cost = 0;
    for (size_t k = 0; k < other.size() && k < a.keypoints.size(); ++k) {
        const size_t to = swapped ? other[k] : k;
        if (other[k] == k || to >= b.keypoints.size()) continue;
        if (!(a.keypoints[k].confidence > 0) || !(b.keypoints[to].confidence > 0)) continue;
        const Vec2d d = (a.keypoints[k].px - b.keypoints[to].px) / (kUsualMotion * b.diagonalPx);
        cost += std::min(kLargeMotion2, glm::dot(d, d));
    }
    return cost;
}

}  // namespace

std::vector<Keypoint> withSidesSwapped(std::span<const Keypoint> keypoints, std::span<const std::string> names) {
    const std::vector<size_t> other = otherSides(names);
    std::vector<Keypoint> out(keypoints.begin(), keypoints.end());
    for (size_t k = 0; k < out.size() && k < other.size(); ++k)
        if (other[k] < keypoints.size()) out[k] = keypoints[other[k]];
    return out;
}

std::vector<bool> swappedSides(std::span<const SidedFrame> frames, std::span<const std::string> names) {
    const std::vector<size_t> other = otherSides(names);
    std::vector<bool> swapped(frames.size(), false);
    for (size_t first = 0; first < frames.size();) {
        size_t end = first + 1;
        while (end < frames.size() && frames[end].timeS - frames[end - 1].timeS <= kMaxGapS) ++end;
        // Dynamic programming over the two states of each frame.
        std::vector<std::array<double, 2>> best(end - first);
        std::vector<std::array<int, 2>> from(end - first);
        const auto swapCost = [&](size_t i) { return frames[first + i].known ? std::numeric_limits<double>::infinity() : kSwapCost; };
        best[0] = {0, swapCost(0)};
        for (size_t i = 1; i < best.size(); ++i) {
            const double same = motion(frames[first + i - 1], frames[first + i], other, false),
                         crossed = motion(frames[first + i - 1], frames[first + i], other, true);
            for (int state = 0; state < 2; ++state) {
                const double stay = best[i - 1][size_t(state)] + same, change = best[i - 1][size_t(1 - state)] + crossed;
                from[i][size_t(state)] = change < stay ? 1 - state : state;
                best[i][size_t(state)] = std::min(stay, change) + (state == 1 ? swapCost(i) : 0.0);
            }
        }
        int state = best.back()[1] < best.back()[0] ? 1 : 0;
        for (size_t i = best.size(); i-- > 0;) {
            swapped[first + i] = state == 1;
            state = i > 0 ? from[i][size_t(state)] : state;
        }
        first = end;
    }
    return swapped;
}

std::vector<bool> swappedSides(const Scan& scan, std::span<const std::vector<Keypoint>> keypoints) {
    std::vector<bool> swapped(scan.frames.size(), false);
    for (const bool heldOut : {false, true}) {  // held-out frames are judged between training frames whose sides are known by then
        std::vector<size_t> order;
        for (size_t f = 0; f < scan.frames.size(); ++f)
            if (scan.frames[f].kind == FrameKind::Dynamic && (heldOut || scan.frames[f].split == Split::Train)) order.push_back(f);
        std::stable_sort(order.begin(), order.end(), [&](size_t a, size_t b) { return scan.frames[a].timeS < scan.frames[b].timeS; });
        std::vector<std::vector<Keypoint>> righted;
        for (const size_t f : order) righted.push_back(swapped[f] ? withSidesSwapped(keypoints[f], scan.keypointNames) : keypoints[f]);
        std::vector<SidedFrame> frames;
        for (size_t i = 0; i < order.size(); ++i) {
            const ScanFrame& frame = scan.frames[order[i]];
            frames.push_back({frame.timeS, std::hypot(double(frame.camera.widthPx), double(frame.camera.heightPx)), righted[i],
                              heldOut && frame.split == Split::Train});
        }
        const std::vector<bool> found = swappedSides(frames, scan.keypointNames);
        for (size_t i = 0; i < order.size(); ++i)
            if (!frames[i].known) swapped[order[i]] = found[i];
    }
    return swapped;
}

}  // namespace dpl
