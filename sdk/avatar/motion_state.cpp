// SPDX-License-Identifier: Apache-2.0
#include "sdk/avatar/motion_state.h"

#include <algorithm>
#include <cmath>

#include "sdk/format/correctives.h"

namespace dpl {
namespace {

/** How far a joint is turned from the still pose: axis in the parent's frame times angle in [0, π]. */
Vec3d turnFromStill(const MotionModeData& motion, const Pose& pose, size_t joint) {
    const Vec4f& s = motion.still[joint];
    const Quatd still(double(s.w), double(s.x), double(s.y), double(s.z));
    Quatd turn = glm::normalize(Quatd(pose.localRotations[motion.joints[joint]])) * glm::conjugate(glm::normalize(still));
    if (turn.w < 0) turn = -turn;
    const Vec3d v(turn.x, turn.y, turn.z);
    const double sine = glm::length(v);
    return sine > 0 ? 2 * std::atan2(sine, turn.w) / sine * v : Vec3d(0);
}

/** The share of [from, to] that x has covered, smooth at both ends. */
double shareOf(double from, double to, double x) {
    const double t = std::clamp((x - from) / (to - from), 0.0, 1.0);
    return t * t * (3 - 2 * t);
}

using Inputs = std::array<double, 1 + kMaxMotionJoints>;
using Columns = std::array<double, kMaxCorrectiveModes>;

void inputsOf(const MotionModeData& motion, const Pose& pose, Inputs& inputs) {
    double squares = 0;
    for (size_t j = 0; j < motion.joints.size(); ++j) {
        const double angle = glm::length(turnFromStill(motion, pose, j));
        const double rest = double(motion.rangeRad[j].x), most = double(motion.rangeRad[j].y);
        squares += angle * angle;
        inputs[1 + j] = std::clamp(angle - rest, 0.0, most);
    }
    inputs[0] = shareOf(double(motion.movedFromRad), double(motion.movedToRad), std::sqrt(squares));
}

/** modes · held, before any limit. k: K' entries. */
void columnsOf(const MotionModeData& motion, const MotionState& state, std::span<double> k) {
    const size_t count = motion.holdsS.size() * motion.inputCount();
    for (size_t c = 0; c < k.size(); ++c) {
        k[c] = 0;
        for (size_t i = 0; i < count; ++i) k[c] += double(motion.modes[c * count + i]) * state.held[i];
    }
}

double lengthOf(std::span<const double> v) {
    double squares = 0;
    for (const double x : v) squares += x * x;
    return std::sqrt(squares);
}

}  // namespace

void settleMotion(const MotionModeData& motion, const Pose& pose, MotionState& state) {
    Inputs inputs{};
    inputsOf(motion, pose, inputs);
    for (size_t h = 0; h < motion.holdsS.size(); ++h)
        std::copy_n(inputs.begin(), motion.inputCount(), state.held.begin() + ptrdiff_t(h * motion.inputCount()));
}

void advanceMotion(const MotionModeData& motion, const Pose& pose, double seconds, MotionState& state) {
    if (!std::isfinite(seconds) || seconds < 0) return settleMotion(motion, pose, state);
    Inputs inputs{};
    inputsOf(motion, pose, inputs);
    for (size_t h = 0; h < motion.holdsS.size(); ++h) {
        const double hold = double(motion.holdsS[h]), kept = hold > 0 ? std::exp(-seconds / hold) : 0.0;
        for (size_t i = 0; i < motion.inputCount(); ++i) {
            double& held = state.held[h * motion.inputCount() + i];
            held = std::max(held * kept, inputs[i]);
        }
    }
}

void motionCoefficients(const MotionModeData& motion, const MotionState& state, std::span<float> coefficients) {
    Columns all{};
    columnsOf(motion, state, std::span(all).first(motion.columnCount()));
    size_t column = 0;
    for (const MotionGroupData& group : motion.groups) {
        const double length = lengthOf(std::span(all).subspan(column, group.columnCount));
        const double shorter = length > double(group.reach) ? double(group.reach) / length : 1.0;
        for (size_t c = 0; c < group.columnCount; ++c, ++column) coefficients[column] = float(shorter * all[column]);
    }
}

void addSettledMotionGradient(const MotionModeData& motion, const Pose& pose, std::span<const double> gCoefficients,
                              std::span<Vec3d> rotation) {
    Inputs gInputs{};
    Columns all{};
    MotionState state;
    settleMotion(motion, pose, state);
    columnsOf(motion, state, std::span(all).first(motion.columnCount()));
    const size_t inputs = motion.inputCount(), count = motion.holdsS.size() * inputs;
    size_t column = 0;
    for (const MotionGroupData& group : motion.groups) {
        const auto k = std::span(all).subspan(column, group.columnCount);
        const auto gk = gCoefficients.subspan(column, group.columnCount);
        const double length = lengthOf(k), shorter = double(group.reach) / length;
        double along = 0;
        for (size_t c = 0; c < k.size(); ++c) along += k[c] * gk[c];
        for (size_t c = 0; c < k.size(); ++c, ++column) {
            const double g = length > double(group.reach)  // then only what is orthogonal to k passes
                                 ? shorter * (gk[c] - along / (length * length) * k[c])
                                 : gk[c];
            for (size_t i = 0; i < count; ++i) gInputs[i % inputs] += g * double(motion.modes[column * count + i]);
        }
    }
    std::array<Vec3d, kMaxMotionJoints> turns;
    double squares = 0;
    for (size_t j = 0; j < motion.joints.size(); ++j) turns[j] = turnFromStill(motion, pose, j), squares += glm::dot(turns[j], turns[j]);
    const double distance = std::sqrt(squares), from = double(motion.movedFromRad), to = double(motion.movedToRad);
    const double t = std::clamp((distance - from) / (to - from), 0.0, 1.0), slope = 6 * t * (1 - t) / (to - from);
    for (size_t j = 0; j < motion.joints.size(); ++j) {
        const double angle = glm::length(turns[j]), over = angle - double(motion.rangeRad[j].x);
        if (!(angle > 0)) continue;
        Vec3d& g = rotation[motion.joints[j]];
        g += gInputs[0] * slope / distance * turns[j];
        if (over > 0 && over < double(motion.rangeRad[j].y)) g += gInputs[1 + j] / angle * turns[j];
    }
}

}  // namespace dpl
