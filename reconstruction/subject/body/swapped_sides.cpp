// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/subject/body/swapped_sides.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>

#include "reconstruction/input/cameras/rays.h"
#include "reconstruction/subject/body/fit_limbs.h"

namespace dpl {
namespace {

constexpr double kUsualMotion = 0.03;  // of a keypoint between two frames, share of the diagonal
constexpr double kUsualError = 0.015;  // of a keypoint of a still frame against the triangulated point, share of the diagonal
constexpr double kLargeMotion2 = 9;    // squared motion, in usual motions, that costs no more when it grows
constexpr double kSwapCost = 6;        // of one swapped frame: a few keypoints that clearly fit better the other way
constexpr double kHalfSwapCost = 9;    // of a frame in which only the upper or the lower body is swapped: that is rarer
constexpr int kStillRounds = 8;        // of triangulating and judging; three were enough in the tests
constexpr double kRobustShare = 0.03;  // rays that pass the point farther away than this share of the distance count little
constexpr std::array kStates{uint8_t(kNoneSwapped), uint8_t(kUpperSwapped), uint8_t(kLowerSwapped), uint8_t(kAllSwapped)};

double stateCost(uint8_t state) {
    return state == kNoneSwapped ? 0 : state == kAllSwapped ? kSwapCost : kHalfSwapCost;
}

/** The names of a scan's keypoints as pairs of sides. */
struct Sides {
    std::vector<size_t> other;   // index of the keypoint on the other side; its own index for names without a side
    std::vector<uint8_t> parts;  // the part that it belongs to

    explicit Sides(std::span<const std::string> names) : other(names.size()), parts(names.size(), kNoneSwapped) {
        for (size_t k = 0; k < names.size(); ++k) {
            other[k] = k;
            std::string name = names[k];
            if (name.size() < 3 || name[name.size() - 2] != '_' || (name.back() != 'l' && name.back() != 'r')) continue;
            name.back() = name.back() == 'l' ? 'r' : 'l';
            const auto found = std::find(names.begin(), names.end(), name);
            if (found == names.end()) continue;
            other[k] = size_t(found - names.begin());
            const bool lower = name.starts_with("hip") || name.starts_with("knee") || name.starts_with("ankle") ||
                               name.starts_with("toe") || name.starts_with("heel") || name.starts_with("foot");
            parts[k] = lower ? kLowerSwapped : kUpperSwapped;
        }
    }
    bool sided(size_t k) const { return other[k] != k; }
    /** Where keypoint k stands in a frame whose `state` is swapped. */
    size_t place(size_t k, uint8_t state) const { return state & parts[k] ? other[k] : k; }
};

/** Motion of the keypoints of `part` between two frames; `crossed`: one of them is swapped and the other not. */
double motion(const SidedFrame& a, const SidedFrame& b, const Sides& sides, uint8_t part, bool crossed) {
    double cost = 0;
    for (size_t k = 0; k < sides.other.size() && k < a.keypoints.size(); ++k) {
        if (sides.parts[k] != part) continue;
        const size_t to = crossed ? sides.other[k] : k;
        if (to >= b.keypoints.size() || !(a.keypoints[k].confidence > 0) || !(b.keypoints[to].confidence > 0)) continue;
        const Vec2d d = (a.keypoints[k].px - b.keypoints[to].px) / (kUsualMotion * b.diagonalPx);
        cost += std::min(kLargeMotion2, glm::dot(d, d));
    }
    return cost;
}

/** The points of the still subject, in the scan's unit; empty where too few frames show one. */
using StillPoints = std::vector<std::optional<Vec3d>>;

StillPoints triangulate(const Scan& scan, std::span<const std::vector<Keypoint>> keypoints, std::span<const uint8_t> swapped,
                        const Sides& sides) {
    StillPoints points(sides.other.size());
    for (size_t k = 0; k < points.size(); ++k) {
        std::vector<Ray> rays;
        std::vector<double> weights;
        for (size_t f = 0; f < scan.frames.size(); ++f) {
            const ScanFrame& frame = scan.frames[f];
            const size_t at = sides.place(k, swapped[f]);
            if (frame.kind == FrameKind::Dynamic || frame.split == Split::Test || at >= keypoints[f].size()) continue;
            const Keypoint& seen = keypoints[f][at];
            if (!(seen.confidence > 0.3)) continue;
            rays.push_back(pixelRay(frame.camera, seen.px)), weights.push_back(seen.confidence);
        }
        if (rays.size() < 4) continue;
        const auto rough = pointNearRays(rays, weights, 0);
        if (!rough) continue;
        double distance = 0;
        for (const Ray& ray : rays) distance += glm::length(*rough - ray.origin) / double(rays.size());
        points[k] = pointNearRays(rays, weights, kRobustShare * distance);
    }
    return points;
}

/** The state of a still frame that fits the points best. */
uint8_t stillState(const ScanFrame& frame, std::span<const Keypoint> keypoints, const StillPoints& points, const Sides& sides) {
    const double usual = kUsualError * std::hypot(double(frame.camera.widthPx), double(frame.camera.heightPx));
    uint8_t best = kNoneSwapped;
    double least = std::numeric_limits<double>::infinity();
    for (const uint8_t state : kStates) {
        double cost = stateCost(state);
        for (size_t k = 0; k < keypoints.size() && k < points.size(); ++k) {
            const size_t at = sides.place(k, state);
            if (!sides.sided(k) || !points[k] || at >= keypoints.size() || !(keypoints[at].confidence > 0)) continue;
            const Vec3d view = frame.camera.toView(*points[k]);
            if (!(view.z > 0)) continue;
            const Vec2d d = (keypoints[at].px - frame.camera.pixelOf(view)) / usual;
            cost += keypoints[at].confidence * std::min(kLargeMotion2, glm::dot(d, d));
        }
        if (cost < least) least = cost, best = state;
    }
    return best;
}

/** Whether these are the points of a body with its sides exchanged: toes and nose point away from where the front should be. */
bool facesBackwards(const StillPoints& points, std::span<const std::string> names) {
    const auto point = [&](const char* name) -> std::optional<Vec3d> {
        const auto found = std::find(names.begin(), names.end(), name);
        return found == names.end() ? std::nullopt : points[size_t(found - names.begin())];
    };
    const auto mean = [&](const char* left, const char* right) -> std::optional<Vec3d> {
        const auto l = point(left), r = point(right);
        return l && r ? std::optional(0.5 * (*l + *r)) : std::nullopt;
    };
    const auto hips = mean("hip_l", "hip_r"), shoulders = mean("shoulder_l", "shoulder_r");
    const auto hipL = point("hip_l"), hipR = point("hip_r"), shoulderL = point("shoulder_l"), shoulderR = point("shoulder_r");
    if (!hips || !shoulders) return false;
    const Vec3d up = *shoulders - *hips, left = (*hipL - *hipR) + (*shoulderL - *shoulderR);
    const Vec3d front = glm::cross(left, up);
    int forwards = 0, backwards = 0;
    const auto judge = [&](const std::optional<Vec3d>& behind, const std::optional<Vec3d>& before) {
        if (!behind || !before) return;
        const Vec3d d = *before - *behind - up * (glm::dot(*before - *behind, up) / glm::dot(up, up));
        if (glm::length(d) < 0.05 * glm::length(up)) return;  // too short to tell a direction
        (glm::dot(d, front) > 0 ? forwards : backwards) += 1;
    };
    judge(point("ankle_l"), point("toe_l"));
    judge(point("ankle_r"), point("toe_r"));
    judge(mean("ear_l", "ear_r"), point("nose"));
    return backwards >= 2 && forwards == 0;
}

/** Judges still frames, held-out ones by the points of the training frames. Returns whether the whole scan has its sides exchanged. */
bool judgeStills(const Scan& scan, std::span<const std::vector<Keypoint>> keypoints, const Sides& sides, std::vector<uint8_t>& swapped) {
    StillPoints points = triangulate(scan, keypoints, swapped, sides);
    for (int round = 0; round < kStillRounds; ++round) {
        bool changed = false;
        for (size_t f = 0; f < scan.frames.size(); ++f) {
            if (scan.frames[f].kind == FrameKind::Dynamic) continue;
            const uint8_t state = stillState(scan.frames[f], keypoints[f], points, sides);
            changed |= state != swapped[f] && scan.frames[f].split != Split::Test;
            swapped[f] = state;
        }
        if (!changed) break;
        points = triangulate(scan, keypoints, swapped, sides);
    }
    return facesBackwards(points, scan.keypointNames);
}

}  // namespace

std::vector<Keypoint> withSidesSwapped(std::span<const Keypoint> keypoints, std::span<const std::string> names, uint8_t parts) {
    const Sides sides(names);
    std::vector<Keypoint> out(keypoints.begin(), keypoints.end());
    for (size_t k = 0; k < out.size() && k < sides.other.size(); ++k)
        if (const size_t from = sides.place(k, parts); from < keypoints.size()) out[k] = keypoints[from];
    return out;
}

std::vector<uint8_t> swappedInMotion(std::span<const SidedFrame> frames, std::span<const std::string> names) {
    const Sides sides(names);
    std::vector<uint8_t> swapped(frames.size(), kNoneSwapped);
    for (size_t first = 0; first < frames.size();) {
        size_t end = first + 1;
        while (end < frames.size() && frames[end].timeS - frames[end - 1].timeS <= kMaxGapS) ++end;
        // Dynamic programming over the states of each frame.
        std::vector<std::array<double, kStates.size()>> best(end - first);
        std::vector<std::array<size_t, kStates.size()>> from(end - first);
        const auto cost = [&](size_t i, uint8_t state) {
            return state != kNoneSwapped && frames[first + i].known ? std::numeric_limits<double>::infinity() : stateCost(state);
        };
        for (size_t s = 0; s < kStates.size(); ++s) best[0][s] = cost(0, kStates[s]);
        for (size_t i = 1; i < best.size(); ++i) {
            const SidedFrame &a = frames[first + i - 1], &b = frames[first + i];
            std::array<std::array<double, 2>, 2> step{};  // of the upper and the lower body; straight and crossed
            for (const bool crossed : {false, true}) {
                step[0][crossed] = motion(a, b, sides, kUpperSwapped, crossed);
                step[1][crossed] = motion(a, b, sides, kLowerSwapped, crossed);
            }
            for (size_t s = 0; s < kStates.size(); ++s) {
                best[i][s] = std::numeric_limits<double>::infinity();
                for (size_t t = 0; t < kStates.size(); ++t) {
                    const uint8_t turned = kStates[s] ^ kStates[t];
                    const double total = best[i - 1][t] + step[0][(turned & kUpperSwapped) != 0] + step[1][(turned & kLowerSwapped) != 0];
                    if (total < best[i][s]) best[i][s] = total, from[i][s] = t;
                }
                best[i][s] += cost(i, kStates[s]);
            }
        }
        size_t state = size_t(std::min_element(best.back().begin(), best.back().end()) - best.back().begin());
        for (size_t i = best.size(); i-- > 0;) {
            swapped[first + i] = kStates[state];
            if (i > 0) state = from[i][state];
        }
        first = end;
    }
    return swapped;
}

std::vector<uint8_t> swappedSides(const Scan& scan, std::span<const std::vector<Keypoint>> keypoints) {
    std::vector<uint8_t> swapped(scan.frames.size(), kNoneSwapped);
    const bool everywhere = judgeStills(scan, keypoints, Sides(scan.keypointNames), swapped);
    for (const bool heldOut : {false, true}) {  // held-out frames are judged between training frames whose sides are known by then
        std::vector<size_t> order;
        for (size_t f = 0; f < scan.frames.size(); ++f)
            if (scan.frames[f].kind == FrameKind::Dynamic && (heldOut || scan.frames[f].split == Split::Train)) order.push_back(f);
        std::stable_sort(order.begin(), order.end(), [&](size_t a, size_t b) { return scan.frames[a].timeS < scan.frames[b].timeS; });
        std::vector<std::vector<Keypoint>> righted;
        for (const size_t f : order) righted.push_back(withSidesSwapped(keypoints[f], scan.keypointNames, swapped[f]));
        std::vector<SidedFrame> frames;
        for (size_t i = 0; i < order.size(); ++i) {
            const ScanFrame& frame = scan.frames[order[i]];
            frames.push_back({frame.timeS, std::hypot(double(frame.camera.widthPx), double(frame.camera.heightPx)), righted[i],
                              heldOut && frame.split == Split::Train});
        }
        const std::vector<uint8_t> found = swappedInMotion(frames, scan.keypointNames);
        for (size_t i = 0; i < order.size(); ++i)
            if (!frames[i].known) swapped[order[i]] = found[i];
    }
    if (everywhere)
        for (uint8_t& parts : swapped) parts ^= kAllSwapped;
    return swapped;
}

std::string describeSwaps(const Scan& scan, std::span<const uint8_t> swapped) {
    size_t still = 0, moving = 0, part = 0;
    for (size_t f = 0; f < swapped.size() && f < scan.frames.size(); ++f) {
        if (swapped[f] == kNoneSwapped) continue;
        (scan.frames[f].kind == FrameKind::Dynamic ? moving : still) += 1;
        part += swapped[f] != kAllSwapped;
    }
    if (still + moving == 0) return "";
    if (2 * (still + moving) > scan.frames.size())
        return formatText(
            "left and right are exchanged in the keypoints of {} of {} frames, almost the whole scan: feet and face pointed "
            "backwards. They were exchanged back; look at how the scan names its keypoints",
            still + moving, scan.frames.size());
    return formatText(
        "left and right were swapped in the keypoints of {} still and {} moving frames ({} of them only in the upper or the lower "
        "body); they were swapped back",
        still, moving, part);
}

}  // namespace dpl
