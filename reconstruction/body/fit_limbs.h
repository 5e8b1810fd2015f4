// SPDX-License-Identifier: Apache-2.0
// Which way an arm or a leg points in depth. One view leaves two places for the elbow (on its ray, an upper arm's length from the shoulder)
// and two for the wrist, so four arms a frame; the sequence of choices with the least acceleration and the most natural shoulder wins
// (dynamic programming over pairs of frames, exact). A least-squares fit alone stays in whichever arm it started.
// Words are those of the arm; for a leg read hip, knee, ankle.
#pragma once

#include <optional>
#include <vector>

#include "reconstruction/capture/scan.h"
#include "sdk/math/types.h"

namespace dpl {

struct LimbRig {
    Vec3d upperDirection{0}, hingeAxis{0};  // unit, rest frame; a positive turn about hingeAxis bends the elbow
    double restBendRad = 0;                 // signed, about hingeAxis
    double upperM = 0, lowerM = 0;          // bone lengths
    Mat3d shoulderAxes{1};                  // prior of the shoulder: axesᵀ·w has spread shoulderSigma
    double maxBackward = 1;                 // how far the upper bone reaches back: −z of its direction in the parent's frame
    // How natural a choice is: spread about the still pose, with tails as in JointPrior, and the shoulder's range.
    Vec3d shoulderMean{0}, shoulderSigma{1}, shoulderTail{0}, shoulderLow{-3.1}, shoulderHigh{3.1};  // along shoulderAxes
    double bendMean = 0, bendSigma = 1, bendTail = 0;                                                // about hingeAxis
};

/** One frame's evidence. Camera and places in metres. */
struct LimbView {
    double timeS = 0;
    Camerad camera;
    Keypoint elbow, wrist;  // confidence 0: the frame is left out
    Vec3d shoulder{0};
    Mat3d worldFromParent{1};  // world rotation of the upper arm's parent
};

struct LimbGuess {
    Vec3d shoulder{0};         // rotation vector of the upper arm, local
    double bendRad = 0;        // turn about hingeAxis from rest
    Vec3d elbow{0}, wrist{0};  // world
};

/** One guess a view, in order of time; nothing where a keypoint is missing. */
std::vector<std::optional<LimbGuess>> untangleLimb(const LimbRig& rig, const std::vector<LimbView>& views);

}  // namespace dpl
