// SPDX-License-Identifier: Apache-2.0
// How the fingers of the procedural subject bend: a pose of each hand by the seed, its small changes between still frames, and gestures
// while the subject moves.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "reconstruction/subject/sample/skeleton.h"
#include "reconstruction/subject/sample/skinning.h"

namespace dpl {

enum HandTurn : uint8_t { kBase, kSpread, kMiddleJoint, kEndJoint, kHandTurnCount };

/** Turns of the finger joints of one hand against the rest pose, radians. Of the thumb kBase brings it in across the palm and kSpread
 *  out of the palm's plane; of the other fingers kBase curls and kSpread turns towards the thumb. */
using HandPose = std::array<std::array<double, kHandTurnCount>, kFingerCount>;

/** The relaxed hand of a subject: curl 0 to 60° in each joint, fingers fanned by 0 to 20° from index to pinky, thumb in or out. */
HandPose seededHand(uint64_t seed, bool left);

/** That hand in static shot `index`, about a degree from it in each joint. */
HandPose stillHand(uint64_t seed, bool left, uint32_t index);

/** Gestures of both hands, one after the other: fist, point, spread and pinch, in an order by the seed. */
class HandMotion {
public:
    HandMotion(uint64_t seed, double durationS);
    /** The seeded hand before time 0. Twice continuously differentiable in time. */
    HandPose at(bool left, double timeS) const;

private:
    struct Hand {
        HandPose relaxed{};
        std::array<HandPose, 4> gestures{};
        double startS = 0;
    };
    std::array<Hand, 2> hands_;  // left, right
    double slotS_ = 0;
};

/** Sets the rotations of one hand's 15 finger joints. */
void setHand(bool left, const HandPose& hand, TruthPose& pose);

}  // namespace dpl
