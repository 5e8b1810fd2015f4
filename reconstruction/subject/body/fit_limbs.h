// SPDX-License-Identifier: Apache-2.0
// Decides whether an arm or a leg bends towards or away from the camera. In one view two points on the elbow's ray lie an upper arm's
// length from the shoulder, and likewise two for the wrist: four candidates per frame. Dynamic programming over pairs of frames finds the
// exact sequence with the least acceleration and the least cost of its candidates. Least squares alone cannot move from one candidate to
// another. The names are those of the arm; for a leg read hip, knee, ankle.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "reconstruction/input/capture/scan.h"
#include "sdk/math/types.h"

namespace dpl {

constexpr double kMaxGapS = 1.0;  // moving frames farther apart in time say nothing about each other

struct LimbRig {
    Vec3d upperDirection{0}, hingeAxis{0};  // unit, rest frame; a positive angle about hingeAxis bends the elbow
    double restBendRad = 0;                 // signed angle about hingeAxis
    double upperM = 0, lowerM = 0;          // bone lengths
    Mat3d shoulderAxes{1};                  // columns: anatomical axes; axesᵀ·w has the standard deviations shoulderSigma
    double maxBackward = 1;                 // limit of −z of the upper bone's unit direction, parent's frame
    // Priors as in JointPrior: mean at the still pose, standard deviation, tail, and range. Radians (tails: σ).
    Vec3d shoulderMean{0}, shoulderSigma{1}, shoulderTail{0}, shoulderLow{-3.1}, shoulderHigh{3.1};  // along shoulderAxes
    double bendMean = 0, bendSigma = 1, bendTail = 0;                                                // about hingeAxis
};

/** What one frame shows of the limb. Camera and positions in metres, world frame. */
struct LimbView {
    double timeS = 0;
    Camerad camera;
    Vec2d elbowPx{0}, wristPx{0};
    Vec3d shoulder{0};
    Mat3d worldFromParent{1};  // world rotation of the upper arm's parent
};

struct LimbCandidate {
    Vec3d shoulder{0};         // rotation vector of the upper arm, local
    double bendRad = 0;        // angle about hingeAxis from rest
    Vec3d elbow{0}, wrist{0};  // world
    double cost = 0;           // of how natural shoulder and elbow are, σ²
};

/** Elbow near or far, for each of them wrist near or far. A ray that passes too far away gives the same point twice. */
std::array<LimbCandidate, 4> limbCandidates(const LimbRig& rig, const LimbView& view);

/** One frame of a sequence. It has at least one candidate. */
struct LimbChoices {
    double timeS = 0;
    std::vector<LimbCandidate> candidates;
};
/** The index of the chosen candidate of each frame. `frames` must be in order of time. */
std::vector<size_t> chooseLimbs(std::span<const LimbChoices> frames);

}  // namespace dpl
