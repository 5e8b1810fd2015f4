// SPDX-License-Identifier: Apache-2.0
// The basis of motion modes: how a still pose differs from the poses of a motion. Training fills in the nodes later.
// docs/reference/correctives.md, "Motion modes"
//
//   still poses  ─► mean still pose, and how far the still frames stray from it
//   a film       ─► states ─► [has moved], and principal components of the legs' and of the arms' angles, then of held ones, then of
//                             lags, of unit variance and 0 in the still pose
#pragma once

#include <span>
#include <vector>

#include "sdk/avatar/rig.h"
#include "sdk/core/result.h"

namespace dpl {

struct MotionModelSettings {
    uint32_t maxComponents = 3;                    // columns of a group
    double minVariance = 0.03;                     // share of the variance of a group's inputs; smaller components are left out
    double leastRestRad = 0.05;                    // 3°: smallest angle of a joint that counts as moved
    double leastMovedRad = 0.1;                    // 6°: smallest distance from the still pose that counts as moved
    double movedBandRad = 0.2;                     // over which "has moved" rises from 0 to 1
    double strayFactor = 1.5;                      // times the largest angle or distance of the still frames, if that is more
    std::vector<float> holdsS{0.0f, 6.0f, 60.0f};  // of MotionModeData, rising
    std::vector<float> lagsS{0.15f, 0.4f, 1.0f};   // the same, where the film is dense enough
    double lagPosesPerS = 12;                      // median rate; sparser films cannot tell lags
    uint32_t minPoses = 12;                        // with fewer moving poses, or no still one, the result is empty
    double minMovedShare = 0.25;                   // of the moving poses that must count as moved; with less the result is empty
};

/** Returns motion modes, or empty ones where the poses say too little. The first group is one column: "has moved" itself, by the longest
 *  hold. Then come the angles of the legs and of the arms, each with the spine, and what is held of them, centred on the moving poses that
 * have moved; and, of a dense film, their lags. timesS: of the moving poses, seconds, as rememberFilm() takes them. Deterministic.
 * InvalidArgument when the poses do not match the rig, or the times the poses. */
Result<MotionModeData> motionModel(std::span<const JointData> joints, std::span<const Pose> stillPoses, std::span<const Pose> movingPoses,
                                   std::span<const double> timesS, const MotionModelSettings& settings = {});

/** Sets Pose::before of a film's poses from those at earlier times. timesS: one a pose, seconds, in any order. Where all times are the
 * same, none is known, and nothing is held. */
void rememberFilm(const MotionModeData& motion, std::span<const double> timesS, std::span<Pose> poses);

/** Whether a group of motionModel() is of held peaks. */
bool isOfPeaks(const MotionModeData& motion, size_t group);

/** The place in MotionState::held of "has moved" that motionModel() takes: that of the longest hold. */
size_t hasMoved(const MotionModeData& motion);

/** The groups of motionModel() that reach each control node of clothes that hang, as bits: "has moved", and those whose limbs the skin
 *  weights of its layer follow. None for skin, hair and shoes, which do not slide. The correctives must have passed checkCorrectives for
 * this mesh. */
std::vector<uint32_t> motionReachingNodes(std::span<const JointData> joints, const MeshData& mesh, const PoseCorrectiveData& correctives);

}  // namespace dpl
