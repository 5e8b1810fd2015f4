// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/body/fit_limbs.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "reconstruction/body/keypoint_chain.h"
#include "reconstruction/priors.h"

namespace dpl {
namespace {

constexpr int kStates = 4;  // elbow near or far × wrist near or far
constexpr int kTwistSteps = 10;
constexpr double kTwistStepRad = 0.15;
constexpr double kSidewaysSigmaRad = 0.15, kHyperextensionSigmaRad = 0.15;  // loose: elbow depth is known to a few cm
constexpr double kBackwardSigma = 0.1;
constexpr double kShoulderSigmaRad = 0.1;  // σ of the part beyond the shoulder's range

struct Candidate {
    LimbGuess guess;
    double cost = 0;  // shoulder and elbow priors, σ²
};

/** The two points of the pixel's ray at distance `length` from `from`. A ray that passes farther away gives its nearest point, moved to
 *  that distance. */
std::array<Vec3d, 2> onRay(const Camerad& camera, const Vec2d& px, const Vec3d& from, double length) {
    const Vec3d eye = camera.eye();
    const Vec3d direction = glm::normalize(glm::transpose(camera.viewFromWorldRotation) *
                                           Vec3d((px.x - camera.cx) / camera.fx, (px.y - camera.cy) / camera.fy, 1));
    const Vec3d toEye = eye - from;
    const double b = glm::dot(toEye, direction), c = glm::dot(toEye, toEye) - length * length, discriminant = b * b - c;
    if (discriminant <= 0) {
        const Vec3d offset = eye - b * direction - from;
        const Vec3d p = from + offset * (length / std::max(glm::length(offset), 1e-9));
        return {p, p};
    }
    const double root = std::sqrt(discriminant);
    return {eye + (-b - root) * direction, eye + (-b + root) * direction};
}

/** Cost of a deviation in σ: its square, or the Geman–McClure loss when `tail` is set. */
double spread(double sigmas, double tail) {
    return tail > 0 ? sigmas * sigmas / (1 + sigmas * sigmas / (tail * tail)) : sigmas * sigmas;
}

Candidate makeCandidate(const LimbRig& rig, const LimbView& view, const Vec3d& elbow, const Vec3d& wrist) {
    Candidate c{{Vec3d(0), 0, elbow, wrist}, 0};
    const Mat3d toParent = glm::transpose(view.worldFromParent);
    const Vec3d upper = glm::normalize(toParent * (elbow - view.shoulder)), lower = glm::normalize(toParent * (wrist - elbow));
    const Vec3d cross = glm::cross(upper, lower);
    const double bend = std::atan2(glm::length(cross), glm::dot(upper, lower));
    // Rotate the rest direction onto the upper arm, then try several twists about it. The twist splits the elbow's bend into flexion
    // (cosine; negative is hyperextension) and sideways bend (sine). The twist of least cost is kept.
    const Vec3d swingAxis = glm::cross(rig.upperDirection, upper);
    const double sine = glm::length(swingAxis);
    const Mat3d swing = sine > 1e-9 ? rotationOf(swingAxis * (std::atan2(sine, glm::dot(rig.upperDirection, upper)) / sine)) : Mat3d(1.0);
    const Vec3d is = swing * rig.hingeAxis, flat = glm::normalize(is - glm::dot(is, upper) * upper);
    const double hinge = bend > 1e-6 ? std::atan2(glm::dot(glm::cross(flat, cross), upper), glm::dot(flat, cross)) : 0;
    c.cost = std::numeric_limits<double>::infinity();
    for (int step = -kTwistSteps; step <= kTwistSteps; ++step) {
        const double twist = kTwistStepRad * step, flexion = bend * std::cos(hinge - twist), sideways = bend * std::sin(hinge - twist);
        const Vec3d shoulder = rotationVector(rotationOf(upper * twist) * swing), angles = glm::transpose(rig.shoulderAxes) * shoulder;
        const double over = std::max(0.0, -flexion) / kHyperextensionSigmaRad, side = sideways / kSidewaysSigmaRad;
        double cost = over * over + side * side + spread((flexion - rig.restBendRad - rig.bendMean) / rig.bendSigma, rig.bendTail);
        for (int a = 0; a < 3; ++a) {
            const double beyond = std::max({0.0, rig.shoulderLow[a] - angles[a], angles[a] - rig.shoulderHigh[a]}) / kShoulderSigmaRad;
            cost += spread((angles[a] - rig.shoulderMean[a]) / rig.shoulderSigma[a], rig.shoulderTail[a]) + beyond * beyond;
        }
        if (cost >= c.cost) continue;
        c.cost = cost;
        c.guess.shoulder = shoulder;
        c.guess.bendRad = std::max(0.0, flexion) - rig.restBendRad;
    }
    const double behind = std::max(0.0, -upper.z - rig.maxBackward) / kBackwardSigma;
    c.cost += behind * behind;
    return c;
}

double acceleration2(const Vec3d& a, const Vec3d& b, const Vec3d& c, double before, double after, double sigma) {
    const double mean = 0.5 * (before + after);
    const Vec3d v = ((c - b) / after - (b - a) / before) / mean;
    const double noise = 2.4 * priors::kDepthNoiseM / (before * after);
    return glm::dot(v, v) / (sigma * sigma + noise * noise);
}

}  // namespace

std::vector<std::optional<LimbGuess>> untangleLimb(const LimbRig& rig, const std::vector<LimbView>& views) {
    std::vector<std::optional<LimbGuess>> guesses(views.size());
    std::vector<size_t> used;
    std::vector<std::array<Candidate, kStates>> candidates;
    for (size_t i = 0; i < views.size(); ++i) {
        const LimbView& v = views[i];
        if (!(v.elbow.confidence > 0) || !(v.wrist.confidence > 0)) continue;
        used.push_back(i);
        std::array<Candidate, kStates> four;
        const auto elbows = onRay(v.camera, v.elbow.px, v.shoulder, rig.upperM);
        for (int e = 0; e < 2; ++e) {
            const auto wrists = onRay(v.camera, v.wrist.px, elbows[size_t(e)], rig.lowerM);
            for (int w = 0; w < 2; ++w) four[size_t(2 * e + w)] = makeCandidate(rig, v, elbows[size_t(e)], wrists[size_t(w)]);
        }
        candidates.push_back(four);
    }
    if (used.empty()) return guesses;

    // best[i][s][t]: least cost up to frame i with state s at i−1 and state t at i.
    const size_t n = used.size();
    using Table = std::array<std::array<double, kStates>, kStates>;
    using Links = std::array<std::array<int, kStates>, kStates>;
    std::vector<Table> best(n);
    std::vector<Links> link(n);
    for (int s = 0; s < kStates; ++s)
        for (int t = 0; t < kStates; ++t)
            best[0][size_t(s)][size_t(t)] = s == 0 ? candidates[0][size_t(t)].cost : std::numeric_limits<double>::infinity();
    for (size_t i = 1; i < n; ++i)
        for (size_t s = 0; s < kStates; ++s)
            for (size_t t = 0; t < kStates; ++t) {
                const double after = views[used[i]].timeS - views[used[i - 1]].timeS;
                double winner = std::numeric_limits<double>::infinity();
                for (size_t r = 0; r < kStates; ++r) {
                    double cost = best[i - 1][r][s];
                    const double before = i >= 2 ? views[used[i - 1]].timeS - views[used[i - 2]].timeS : 0;
                    if (i >= 2 && before > 1e-4 && after > 1e-4 && before < kMaxGapS && after < kMaxGapS)
                        cost += acceleration2(candidates[i - 2][r].guess.elbow, candidates[i - 1][s].guess.elbow,
                                              candidates[i][t].guess.elbow, before, after, priors::kElbowAccelerationMS2) +
                                acceleration2(candidates[i - 2][r].guess.wrist, candidates[i - 1][s].guess.wrist,
                                              candidates[i][t].guess.wrist, before, after, priors::kWristAccelerationMS2);
                    if (cost < winner) winner = cost, link[i][s][t] = int(r);
                }
                best[i][s][t] = winner + candidates[i][t].cost;
            }
    size_t s = 0, t = 0;
    for (size_t a = 0; a < kStates; ++a)
        for (size_t b = 0; b < kStates; ++b)
            if (best[n - 1][a][b] < best[n - 1][s][t]) s = a, t = b;
    for (size_t i = n; i-- > 0;) {
        guesses[used[i]] = candidates[i][t].guess;
        const size_t r = i > 0 ? size_t(link[i][s][t]) : 0;
        t = s;
        s = r;
    }
    return guesses;
}

}  // namespace dpl
