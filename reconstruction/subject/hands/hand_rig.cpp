// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/subject/hands/hand_rig.h"

#include <algorithm>
#include <cmath>

#include "reconstruction/subject/body/body_tools.h"

namespace dpl {
namespace {

constexpr double kDegree = 0.017453292519943295;

struct Range {
    double lowDeg, highDeg;  // from the straight finger; of the base's side turn and of all turns of the thumb's base from rest
};
// American Academy of Orthopaedic Surgeons, Joint Motion: Method of Measuring and Recording, 1965, widened by 10° for bodies whose joints
// lie elsewhere. Fingers: base −45 to 90 (here −30, which people reach by themselves), middle 0 to 100, last −10 to 90. Thumb: base 20 out
// and 15 in, out of the palm's plane 0 to 70; middle 0 to 50, last −15 to 80. They give no range for the spread; 25 is a round figure. The
// thumb's base turns about more axes than two, so its range inwards is wider here.
constexpr Range kFingerRanges[kFingerTurns] = {{-30, 100}, {-25, 25}, {-10, 110}, {-20, 100}};
constexpr Range kThumbRanges[kFingerTurns] = {{-30, 45}, {-20, 70}, {-10, 60}, {-25, 90}};
constexpr double kThumbInwards = 0.7;  // share of "across the palm" in the direction in which a thumb bends; the rest is "out of the palm"

Vec3d unit(const Vec3d& v) {
    const double length = glm::length(v);
    return length > 1e-9 ? v / length : Vec3d(0, 0, 1);
}

/** How far `next` is bent against `bone` about `axis`, radians. */
double bendOf(const Vec3d& bone, const Vec3d& next, const Vec3d& axis) {
    return std::atan2(glm::dot(glm::cross(bone, next), axis), glm::dot(bone, next));
}

}  // namespace

std::optional<HandRig> handRig(const BodyModel& shaped, bool left) {
    HandRig hand;
    const int32_t wrist = findHumanoid(shaped, left ? "leftHand" : "rightHand");
    if (wrist < 0) return std::nullopt;
    hand.wrist = uint32_t(wrist);
    const Vec3d origin(shaped.joints[hand.wrist].restPosition);
    for (size_t f = 0; f < kHandFingers; ++f) {
        const size_t finger = f + (left ? 0 : kHandFingers);
        const auto joints = fingerJoints(shaped, finger);
        const auto tip = std::find_if(shaped.keypoints.begin(), shaped.keypoints.end(), [&](const BodyKeypoint& k) {
            return k.name == handKeypointNames()[finger * kFingerPoints + kFingerPoints - 1];
        });
        if (!joints || tip == shaped.keypoints.end() || tip->vertices.empty()) return std::nullopt;
        if (shaped.joints[(*joints)[0]].parent != wrist) return std::nullopt;
        FingerRig& rig = hand.fingers[f];
        rig.joints = *joints;
        for (size_t i = 0; i < 3; ++i) rig.places[i] = Vec3d(shaped.joints[(*joints)[i]].restPosition) - origin;
        rig.places[3] = -origin;
        for (const auto& [vertex, weight] : tip->vertices) rig.places[3] += double(weight) * Vec3d(shaped.mesh.restPositions[vertex]);
    }
    hand.lengthM = glm::length(hand.fingers[2].places[3]);

    // The palm's plane holds the wrist and the bases of index and pinky. Seen from the back of a left hand, fingers up, the thumb is right.
    const Vec3d index = hand.fingers[1].places[0], pinky = hand.fingers[4].places[0];
    const Vec3d along = unit(index + pinky), thumbward = unit(index - pinky - glm::dot(index - pinky, along) * along);
    const Vec3d palm = (left ? 1.0 : -1.0) * glm::cross(along, thumbward);
    for (size_t f = 0; f < kHandFingers; ++f) {
        FingerRig& rig = hand.fingers[f];
        const bool thumb = f == 0;
        const Vec3d inwards = thumb ? unit((1 - kThumbInwards) * palm - kThumbInwards * thumbward) : palm;
        Vec3d bones[3];
        for (size_t b = 0; b < 3; ++b) bones[b] = unit(rig.places[b + 1] - rig.places[b]);
        for (size_t b = 0; b < 3; ++b) rig.bendAxes[b] = unit(glm::cross(bones[b], inwards));
        rig.sideAxis = thumb ? unit(glm::cross(bones[0], palm)) : unit(glm::cross(along, thumbward));
        const double bentDeg[kFingerTurns] = {thumb ? 0 : bendOf(along, bones[0], rig.bendAxes[0]) / kDegree, 0,
                                              bendOf(bones[0], bones[1], rig.bendAxes[1]) / kDegree,
                                              bendOf(bones[1], bones[2], rig.bendAxes[2]) / kDegree};
        for (size_t t = 0; t < kFingerTurns; ++t) {
            const Range& range = (thumb ? kThumbRanges : kFingerRanges)[t];
            hand.low[f * kFingerTurns + t] = std::min(0.0, (range.lowDeg - bentDeg[t]) * kDegree);
            hand.high[f * kFingerTurns + t] = std::max(0.0, (range.highDeg - bentDeg[t]) * kDegree);
        }
    }
    return hand;
}

void setFingers(const HandRig& hand, const HandTurns& turns, Pose& pose) {
    for (size_t f = 0; f < kHandFingers; ++f) {
        const FingerRig& finger = hand.fingers[f];
        const double* t = &turns[f * kFingerTurns];
        const double bends[3] = {t[kBaseBend], t[kMiddleBend], t[kEndBend]};
        for (size_t b = 0; b < 3; ++b) {
            Quatd turn = glm::angleAxis(bends[b], finger.bendAxes[b]);
            if (b == 0) turn = glm::angleAxis(t[kBaseSide], finger.sideAxis) * turn;
            pose.localRotations[finger.joints[b]] = Quatf(glm::normalize(turn));
        }
    }
}

}  // namespace dpl
