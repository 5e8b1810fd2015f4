// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/subject/body/limb_depths.h"

#include <algorithm>
#include <cmath>

#include "reconstruction/subject/body/body_tools.h"
#include "reconstruction/subject/body/priors.h"

namespace dpl {
namespace {

struct BendingLimb {
    const char *upper, *lower, *end, *middleKeypoint, *endKeypoint;
    double maxBackward;
};
constexpr BendingLimb kBendingLimbs[kLimbCount] = {{"leftUpperArm", "leftLowerArm", "leftHand", "elbow_l", "wrist_l", 0.25},
                                                   {"rightUpperArm", "rightLowerArm", "rightHand", "elbow_r", "wrist_r", 0.25},
                                                   {"leftUpperLeg", "leftLowerLeg", "leftFoot", "knee_l", "ankle_l", 0.7},
                                                   {"rightUpperLeg", "rightLowerLeg", "rightFoot", "knee_r", "ankle_r", 0.7}};

}  // namespace

std::optional<KnownLimb> knownLimb(const LimbModel& model, size_t index) {
    const BendingLimb& limb = kBendingLimbs[index];
    const auto keypoint = [&](const char* name) {
        return size_t(std::find(model.keypointNames.begin(), model.keypointNames.end(), name) - model.keypointNames.begin());
    };
    const auto slotOf = [&](int32_t joint) {
        const auto posed = model.chain.posedJoints();
        return size_t(std::find(posed.begin(), posed.end(), uint32_t(joint)) - posed.begin());
    };
    const int32_t upper = findHumanoid(model.body, limb.upper), lower = findHumanoid(model.body, limb.lower),
                  end = findHumanoid(model.body, limb.end);
    KnownLimb known;
    known.middleKeypoint = keypoint(limb.middleKeypoint), known.endKeypoint = keypoint(limb.endKeypoint);
    const size_t names = model.keypointNames.size();
    if (upper <= 0 || lower <= 0 || end <= 0 || known.middleKeypoint == names || known.endKeypoint == names) return std::nullopt;
    known.upper = size_t(upper), known.lower = size_t(lower), known.end = size_t(end);
    known.upperSlot = slotOf(upper), known.lowerSlot = slotOf(lower);
    if (known.upperSlot == model.priors.size() || known.lowerSlot == model.priors.size()) return std::nullopt;
    const JointPrior &upperPrior = model.priors[known.upperSlot], &lowerPrior = model.priors[known.lowerSlot];
    const auto rest = [&](size_t joint) { return model.chain.restPlace(joint, model.shape); };
    const auto usual = [&](size_t slot) {
        const auto w = model.usualPose;
        return w.empty() ? Vec3d(0) : Vec3d(w[3 * slot], w[3 * slot + 1], w[3 * slot + 2]);
    };
    LimbRig& rig = known.rig;
    rig.upperM = glm::length(rest(known.lower) - rest(known.upper));
    rig.lowerM = glm::length(rest(known.end) - rest(known.lower));
    if (!(rig.upperM > 1e-3) || !(rig.lowerM > 1e-3)) return std::nullopt;
    rig.upperDirection = (rest(known.lower) - rest(known.upper)) / rig.upperM;
    const Vec3d lowerDirection = (rest(known.end) - rest(known.lower)) / rig.lowerM;
    known.hinge = lowerPrior.axes[0];
    rig.hingeAxis = glm::normalize(known.hinge - glm::dot(known.hinge, rig.upperDirection) * rig.upperDirection);
    rig.restBendRad =
        std::atan2(glm::dot(glm::cross(rig.upperDirection, lowerDirection), rig.hingeAxis), glm::dot(rig.upperDirection, lowerDirection));
    rig.maxBackward = limb.maxBackward;
    rig.shoulderAxes = upperPrior.axes;
    rig.shoulderSigma = upperPrior.sigmaRad, rig.shoulderTail = upperPrior.tailSigmas;
    rig.shoulderLow = upperPrior.lowRad, rig.shoulderHigh = upperPrior.highRad;
    rig.shoulderMean = glm::transpose(rig.shoulderAxes) * usual(known.upperSlot);
    rig.bendSigma = lowerPrior.sigmaRad[0], rig.bendTail = lowerPrior.tailSigmas[0];
    rig.bendMean = glm::dot(known.hinge, usual(known.lowerSlot));
    return known;
}

bool showsLimb(const KnownLimb& limb, std::span<const Keypoint> keypoints) {
    return !keypoints.empty() && keypoints[limb.middleKeypoint].confidence > 0 && keypoints[limb.endKeypoint].confidence > 0;
}

std::array<LimbCandidate, 4> limbCandidates(const LimbModel& model, const KnownLimb& limb, const LimbFrame& frame) {
    KeypointChain::Output posed;
    model.chain.evaluate(*frame.reference, frame.root, frame.pose->data(), model.shape, false, posed);
    return limbCandidates(limb.rig,
                          {frame.timeS, frame.camera, frame.keypoints[limb.middleKeypoint].px, frame.keypoints[limb.endKeypoint].px,
                           posed.places[limb.upper], posed.rotations[size_t(model.chain.parent(limb.upper))]});
}

void setLimb(const KnownLimb& limb, const LimbCandidate& to, std::vector<double>& pose) {
    const Vec3d bend = to.bendRad * limb.hinge;
    for (int a = 0; a < 3; ++a) pose[3 * limb.upperSlot + size_t(a)] = to.shoulder[a], pose[3 * limb.lowerSlot + size_t(a)] = bend[a];
}

void untangleLimbs(const LimbModel& model, std::span<const LimbFrame> inTime) {
    for (size_t index = 0; index < kLimbCount; ++index) {
        const auto limb = knownLimb(model, index);
        if (!limb) continue;
        struct Used {
            const LimbFrame* frame;
            Vec3d middle, end;
        };
        std::vector<Used> used;
        std::vector<LimbChoices> choices;
        for (const LimbFrame& frame : inTime) {
            if (frame.free && !showsLimb(*limb, frame.keypoints)) continue;
            KeypointChain::Output now;
            model.chain.evaluate(*frame.reference, frame.root, frame.pose->data(), model.shape, false, now);
            used.push_back({&frame, now.places[limb->lower], now.places[limb->end]});
            choices.push_back({frame.timeS, {}});
            if (frame.free) {
                const auto four = limbCandidates(model, *limb, frame);
                choices.back().candidates.assign(four.begin(), four.end());
            } else {
                choices.back().candidates.push_back({Vec3d(0), 0, used.back().middle, used.back().end, 0});
            }
        }
        const std::vector<size_t> chosen = chooseLimbs(choices);
        for (size_t k = 0; k < used.size(); ++k) {
            const LimbCandidate& to = choices[k].candidates[chosen[k]];
            const double moved = std::max(glm::length(to.elbow - used[k].middle), glm::length(to.wrist - used[k].end));
            if (used[k].frame->free && moved >= priors::kSameLimbM) setLimb(*limb, to, *used[k].frame->pose);
        }
    }
}

}  // namespace dpl
