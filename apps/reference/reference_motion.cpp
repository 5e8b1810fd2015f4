// SPDX-License-Identifier: Apache-2.0
// Motion modes in double precision: what clothes remember, and the coefficients that follow from it.
#include <algorithm>
#include <cmath>

#include "apps/reference/reference_maths.h"
#include "apps/reference/reference_renderer.h"

namespace dpl {
namespace {

/** u of a pose: has moved, then how far each joint is turned beyond what still frames stray. The angle between two rotations is that of
 *  R·Sᵀ, by its trace and its antisymmetric part. */
std::vector<double> inputsOf(const MotionModeData& m, const Pose& pose) {
    std::vector<double> inputs(1 + m.joints.size(), 0.0);
    double distance = 0;
    for (size_t j = 0; j < m.joints.size(); ++j) {
        const Quatf still(m.still[j].w, m.still[j].x, m.still[j].y, m.still[j].z);
        const glm::dmat3 turn = referenceRotation(pose.localRotations[m.joints[j]]) * glm::transpose(referenceRotation(still));
        const glm::dvec3 twice(turn[1][2] - turn[2][1], turn[2][0] - turn[0][2], turn[0][1] - turn[1][0]);  // 2 sin(angle) times the axis
        const double angle = std::atan2(glm::length(twice), turn[0][0] + turn[1][1] + turn[2][2] - 1);
        distance += angle * angle;
        inputs[1 + j] = std::min(std::max(angle - double(m.rangeRad[j].x), 0.0), double(m.rangeRad[j].y));
    }
    inputs[0] = referenceSmoothstep(double(m.movedFromRad), double(m.movedToRad), std::sqrt(distance));
    return inputs;
}

/** t of a pose: the first two columns of R − I of each joint. */
std::vector<double> turnsOf(const MotionModeData& m, const Pose& pose) {
    std::vector<double> turns;
    for (const uint32_t joint : m.joints) {
        const glm::dmat3 turned = referenceRotation(pose.localRotations[joint]) - glm::dmat3(1);
        for (int column = 0; column < 2; ++column)
            for (int row = 0; row < 3; ++row) turns.push_back(turned[column][row]);
    }
    return turns;
}

/** ∫₀¹ x e^(−x(1 − s)) f(s) ds by Simpson's rule: what a lag, x of its time constants long, takes from an input f. */
template <class Input>
double heardBy(double x, const Input& f) {
    constexpr int kParts = 2000;
    double sum = 0;
    for (int i = 0; i <= kParts; ++i) {
        const double s = double(i) / kParts, weight = i == 0 || i == kParts ? 1 : i % 2 == 1 ? 4 : 2;
        sum += weight * x * std::exp(-x * (1 - s)) * f(s);
    }
    return sum / (3 * kParts);
}

}  // namespace

MotionMemory referenceMemory(const MotionModeData& m, std::span<const ReferenceEarlierPose> earlier) {
    MotionMemory left;
    for (const ReferenceEarlierPose& e : earlier) {
        const bool first = &e == earlier.data();
        const std::vector<double> inputs = inputsOf(m, e.pose), turns = turnsOf(m, e.pose);
        for (size_t h = 0, i = 0; h < m.holdsS.size(); ++h)
            for (const double input : inputs) {
                const double hold = double(m.holdsS[h]);
                left.held[i] = hold > 0 ? std::exp(-e.secondsToNext / hold) * std::max(left.held[i], input) : 0.0;
                ++i;
            }
        for (size_t l = 0, i = 0; l < m.lagsS.size(); ++l) {  // ẏ = (t − y)/lag, t linear from this pose's turns to the next one's
            const double x = e.secondsToNext / double(m.lagsS[l]);
            const double ofThis = heardBy(x, [](double s) { return 1 - s; }), ofNext = heardBy(x, [](double s) { return s; });
            for (const double turn : turns) {
                const double y = first ? turn : left.lagged[i] + (1 - left.earlier[l]) * turn;
                left.lagged[i++] = std::exp(-x) * y + ofThis * turn;
            }
            left.earlier[l] = 1 - ofNext;
        }
    }
    return left;
}

std::vector<double> referenceMotion(const MotionModeData& m, const Pose& pose) {
    const std::vector<double> inputs = inputsOf(m, pose), turns = turnsOf(m, pose);
    std::vector<double> features, k;
    for (size_t h = 0; h < m.holdsS.size(); ++h)
        for (const double input : inputs) features.push_back(std::max(pose.before.held[features.size()], input));
    for (size_t l = 0, i = 0; l < m.lagsS.size(); ++l)  // y − t with y = lagged + (1 − earlier)·t
        for (const double turn : turns) features.push_back(pose.before.lagged[i++] - pose.before.earlier[l] * turn);
    for (const MotionGroupData& group : m.groups) {
        double squares = 0;
        for (uint32_t c = 0; c < group.columnCount; ++c) {
            const size_t row = k.size() * features.size();
            double sum = 0;
            for (size_t i = 0; i < features.size(); ++i) sum += double(m.modes[row + i]) * features[i];
            squares += sum * sum;
            k.push_back(sum);
        }
        if (squares > 0)
            for (size_t c = k.size() - group.columnCount; c < k.size(); ++c)
                k[c] *= std::min(1.0, double(group.reach) / std::sqrt(squares));
    }
    return k;
}

}  // namespace dpl
