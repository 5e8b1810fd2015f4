// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/subject/body/fit_limbs.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "reconstruction/subject/body/keypoint_chain.h"
#include "reconstruction/subject/body/priors.h"

namespace dpl {
namespace {

constexpr int kTwistSteps = 10;
constexpr double kTwistStepRad = 0.15;
constexpr double kSidewaysSigmaRad = 0.15, kHyperextensionSigmaRad = 0.15;  // loose: elbow depth is known to a few cm
constexpr double kBackwardSigma = 0.1;
constexpr double kShoulderSigmaRad = 0.1;  // σ of the part beyond the shoulder's range

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

LimbCandidate makeCandidate(const LimbRig& rig, const LimbView& view, const Vec3d& elbow, const Vec3d& wrist) {
    LimbCandidate c{Vec3d(0), 0, elbow, wrist, 0};
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
        c.shoulder = shoulder;
        c.bendRad = std::max(0.0, flexion) - rig.restBendRad;
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

std::array<LimbCandidate, 4> limbCandidates(const LimbRig& rig, const LimbView& view) {
    std::array<LimbCandidate, 4> four;
    const auto elbows = onRay(view.camera, view.elbowPx, view.shoulder, rig.upperM);
    for (size_t e = 0; e < 2; ++e) {
        const auto wrists = onRay(view.camera, view.wristPx, elbows[e], rig.lowerM);
        for (size_t w = 0; w < 2; ++w) four[2 * e + w] = makeCandidate(rig, view, elbows[e], wrists[w]);
    }
    return four;
}

std::vector<size_t> chooseLimbs(std::span<const LimbChoices> frames) {
    const size_t n = frames.size();
    if (n == 0) return {};
    // best[i](s, t): least cost up to frame i with candidate s at i−1 and t at i. link: the candidate at i−2 of that sequence.
    struct Table {
        size_t columns = 0;
        std::vector<double> best;
        std::vector<size_t> link;
    };
    std::vector<Table> tables(n);
    for (size_t i = 0; i < n; ++i) {
        const auto& now = frames[i].candidates;
        const size_t rows = i > 0 ? frames[i - 1].candidates.size() : 1, olds = i > 1 ? frames[i - 2].candidates.size() : 1;
        Table& table = tables[i];
        table.columns = now.size();
        table.best.assign(rows * now.size(), std::numeric_limits<double>::infinity());
        table.link.assign(rows * now.size(), 0);
        const double after = i > 0 ? frames[i].timeS - frames[i - 1].timeS : 0,
                     before = i > 1 ? frames[i - 1].timeS - frames[i - 2].timeS : 0;
        const bool moves = before > 1e-4 && after > 1e-4 && before < kMaxGapS && after < kMaxGapS;
        for (size_t s = 0; s < rows; ++s)
            for (size_t t = 0; t < now.size(); ++t)
                for (size_t r = 0; r < olds; ++r) {
                    double cost = now[t].cost + (i > 0 ? tables[i - 1].best[r * tables[i - 1].columns + s] : 0);
                    if (moves) {
                        const LimbCandidate &a = frames[i - 2].candidates[r], &b = frames[i - 1].candidates[s];
                        cost += acceleration2(a.elbow, b.elbow, now[t].elbow, before, after, priors::kElbowAccelerationMS2) +
                                acceleration2(a.wrist, b.wrist, now[t].wrist, before, after, priors::kWristAccelerationMS2);
                    }
                    double& best = table.best[s * now.size() + t];
                    if (cost < best) best = cost, table.link[s * now.size() + t] = r;
                }
    }
    const Table& last = tables[n - 1];
    const size_t end = size_t(std::min_element(last.best.begin(), last.best.end()) - last.best.begin());
    std::vector<size_t> chosen(n);
    size_t s = end / last.columns, t = end % last.columns;
    for (size_t i = n; i-- > 0;) {
        chosen[i] = t;
        const size_t r = tables[i].link[s * tables[i].columns + t];
        t = s;
        s = r;
    }
    return chosen;
}

}  // namespace dpl
