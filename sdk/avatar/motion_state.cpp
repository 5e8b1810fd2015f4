// SPDX-License-Identifier: Apache-2.0
#include "sdk/avatar/motion_state.h"

#include <algorithm>
#include <cmath>

#include "sdk/avatar/rotation_feature.h"
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
using Features = std::array<double, std::tuple_size_v<HeldInputs> + std::tuple_size_v<LaggedTurns>>;

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

/** modes · features, before any limit. k: K' entries. */
void columnsOf(const MotionModeData& motion, const MotionState& state, std::span<double> k) {
    Features features;
    const size_t count = motion.featureCount();
    motionFeatures(motion, state, std::span(features).first(count));
    for (size_t c = 0; c < k.size(); ++c) {
        k[c] = 0;
        for (size_t i = 0; i < count; ++i) k[c] += double(motion.modes[c * count + i]) * features[i];
    }
}

double lengthOf(std::span<const double> v) {
    double squares = 0;
    for (const double x : v) squares += x * x;
    return std::sqrt(squares);
}

}  // namespace

MotionState stateOf(const MotionModeData& motion, const Pose& pose) {
    Inputs inputs{};
    inputsOf(motion, pose, inputs);
    MotionState state;
    const size_t width = motion.inputCount(), turns = motion.turnCount();
    for (size_t i = 0; i < motion.heldCount(); ++i) state.held[i] = std::max(pose.before.held[i], inputs[i % width]);
    if (motion.lagsS.empty()) return state;
    for (size_t j = 0; j < motion.joints.size(); ++j)
        correctiveFeature(Quatd(pose.localRotations[motion.joints[j]]), state.turns.data() + 6 * j);
    for (size_t i = 0; i < motion.lagCount(); ++i)
        state.lagged[i] = pose.before.lagged[i] + (1 - pose.before.earlier[i / turns]) * state.turns[i % turns];
    return state;
}

MotionMemory forgetMotion(const MotionModeData& motion, const MotionState& state, double seconds) {
    MotionMemory left;
    if (!std::isfinite(seconds) || seconds < 0) return left;
    const size_t width = motion.inputCount(), turns = motion.turnCount();
    for (size_t h = 0; h < motion.holdsS.size(); ++h) {
        const double hold = double(motion.holdsS[h]), kept = hold > 0 ? std::exp(-seconds / hold) : 0.0;
        for (size_t i = h * width; i < (h + 1) * width; ++i) left.held[i] = kept * state.held[i];
    }
    // ẏ = (u − y)/τ with u linear over the step: y₁ = e⁻ˣ y₀ + (r − e⁻ˣ) u₀ + (1 − r) u₁, x = seconds/τ, r = (1 − e⁻ˣ)/x. The three weights
    // are positive and sum to 1, so y never leaves the range of u.
    for (size_t l = 0; l < motion.lagsS.size(); ++l) {
        const double x = seconds / double(motion.lagsS[l]), kept = std::exp(-x), r = x > 0 ? -std::expm1(-x) / x : 1.0;
        for (size_t i = 0; i < turns; ++i) left.lagged[l * turns + i] = kept * state.lagged[l * turns + i] + (r - kept) * state.turns[i];
        left.earlier[l] = r;
    }
    return left;
}

MotionMemory carryMotion(const MotionModeData& motion, const MotionState& state) {
    MotionMemory left;
    for (size_t h = 0; h < motion.holdsS.size(); ++h)
        for (size_t i = h * motion.inputCount(); i < (h + 1) * motion.inputCount(); ++i)
            left.held[i] = motion.holdsS[h] > 0 ? state.held[i] : 0.0;
    for (size_t i = 0; i < motion.lagCount(); ++i) left.lagged[i] = state.lagged[i] - state.turns[i % motion.turnCount()];
    return left;
}

void motionFeatures(const MotionModeData& motion, const MotionState& state, std::span<double> features) {
    const size_t held = motion.heldCount();
    std::copy_n(state.held.begin(), held, features.begin());
    for (size_t i = 0; i < motion.lagCount(); ++i) features[held + i] = state.lagged[i] - state.turns[i % motion.turnCount()];
}

void motionCoefficients(const MotionModeData& motion, const MotionState& state, std::span<float> coefficients, float stiffness) {
    Columns all{};
    columnsOf(motion, state, std::span(all).first(motion.columnCount()));
    const double share = 2 / (1 + double(stiffness)), over = std::clamp(share, 1.0, kMostMotionOverReach);  // both exactly 1 at 1
    for (double& k : all) k *= share;
    size_t column = 0;
    for (const MotionGroupData& group : motion.groups) {
        const double length = lengthOf(std::span(all).subspan(column, group.columnCount));
        const double reach = over * double(group.reach), shorter = length > reach ? reach / length : 1.0;
        for (size_t c = 0; c < group.columnCount; ++c, ++column) coefficients[column] = float(shorter * all[column]);
    }
}

void addMotionGradient(const MotionModeData& motion, const Pose& pose, std::span<const double> gCoefficients, std::span<Vec3d> rotation) {
    Inputs inputs{}, gInputs{};
    inputsOf(motion, pose, inputs);
    Columns all{};
    const MotionState state = stateOf(motion, pose);
    columnsOf(motion, state, std::span(all).first(motion.columnCount()));
    const size_t width = motion.inputCount(), turns = motion.turnCount(), held = motion.heldCount(), count = motion.featureCount();
    Turns gTurns{};
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
            const float* mode = motion.modes.data() + column * count;
            for (size_t i = 0; i < held; ++i)
                if (inputs[i % width] > pose.before.held[i]) gInputs[i % width] += g * double(mode[i]);
            for (size_t i = 0; i < motion.lagCount(); ++i)  // ∂(lagged − turns)/∂turns = −earlier
                gTurns[i % turns] -= g * double(mode[held + i]) * pose.before.earlier[i / turns];
        }
    }
    std::array<Vec3d, kMaxMotionJoints> fromStill;
    double squares = 0;
    for (size_t j = 0; j < motion.joints.size(); ++j) {
        fromStill[j] = turnFromStill(motion, pose, j);
        squares += glm::dot(fromStill[j], fromStill[j]);
    }
    const double distance = std::sqrt(squares), from = double(motion.movedFromRad), to = double(motion.movedToRad);
    const double t = std::clamp((distance - from) / (to - from), 0.0, 1.0), slope = 6 * t * (1 - t) / (to - from);
    for (size_t j = 0; j < motion.joints.size(); ++j) {
        Vec3d& g = rotation[motion.joints[j]];
        if (!motion.lagsS.empty()) addFeatureGradient(Quatd(pose.localRotations[motion.joints[j]]), gTurns.data() + 6 * j, g);
        const double angle = glm::length(fromStill[j]), over = angle - double(motion.rangeRad[j].x);
        if (!(angle > 0)) continue;
        g += gInputs[0] * slope / distance * fromStill[j];
        if (over > 0 && over < double(motion.rangeRad[j].y)) g += gInputs[1 + j] / angle * fromStill[j];
    }
}

}  // namespace dpl
