// SPDX-License-Identifier: Apache-2.0
// Arms and legs of moving frames, and the depths at which keypoints allow them (fit_limbs.h). Private to reconstruction/subject/body and
// reconstruction/subject/registration.
#pragma once

#include <array>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "reconstruction/input/capture/scan.h"
#include "reconstruction/subject/body/body_model.h"
#include "reconstruction/subject/body/fit_limbs.h"
#include "reconstruction/subject/body/keypoint_chain.h"
#include "reconstruction/subject/body/pose_prior.h"

namespace dpl {

struct LimbModel {
    const BodyModel& body;
    const KeypointChain& chain;
    const std::vector<JointPrior>& priors;
    std::span<const std::string> keypointNames;
    const double* shape;                // of the chain
    std::span<const double> usualPose;  // mean of the priors; empty: rest
};

/** A moving frame. References and pointers are the caller's. */
struct LimbFrame {
    double timeS = 0;
    Camerad camera;  // metric
    std::span<const Keypoint> keypoints;
    const Mat3d* reference = nullptr;  // of the root
    const double* root = nullptr;      // kRootSize values
    std::vector<double>* pose = nullptr;
    bool free = true;  // false: its limbs stay where they are
};

/** A limb of a body: its joints, their slots in the pose, its keypoints and its rig. */
struct KnownLimb {
    size_t upper = 0, lower = 0, end = 0, upperSlot = 0, lowerSlot = 0, middleKeypoint = 0, endKeypoint = 0;
    Vec3d hinge{0};
    LimbRig rig;
};

constexpr size_t kLimbCount = 4;  // arms, then legs; left before right

/** Empty where the body or the scan lacks a part of it. */
std::optional<KnownLimb> knownLimb(const LimbModel& model, size_t limb);
bool showsLimb(const KnownLimb& limb, std::span<const Keypoint> keypoints);
/** What the keypoints of a frame that shows the limb allow, with the rest of the body as it is. */
std::array<LimbCandidate, 4> limbCandidates(const LimbModel& model, const KnownLimb& limb, const LimbFrame& frame);
void setLimb(const KnownLimb& limb, const LimbCandidate& to, std::vector<double>& pose);

/** Sets limbs to the best sequence of candidates. `inTime`: ascending. Changes the poses of free frames whose candidate is another place
 *  than the current limb. */
void untangleLimbs(const LimbModel& model, std::span<const LimbFrame> inTime);

}  // namespace dpl
