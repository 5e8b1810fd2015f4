// SPDX-License-Identifier: Apache-2.0
#include "sdk/motion/pose_fade.h"

#include <algorithm>

namespace dpl {

bool PoseFade::Fade::begins(uint32_t next, float stepS) {
    leftS = std::max(0.0f, leftS - stepS);
    if (driver == next) return false;
    driver = next;
    leftS = wholeS = next == 0 ? kFadeOutS : kFadeInS;
    return true;
}

float PoseFade::Fade::left() const {
    const float t = leftS / wholeS;
    return t * t * (3 - 2 * t);
}

void PoseFade::step(Pose& pose, std::span<const uint32_t> drivers, float stepS) {
    for (size_t j = 0; j < joints_.size(); ++j) {
        Joint& joint = joints_[j];
        Quatf& rotation = pose.localRotations[j];
        if (joint.fade.begins(drivers[j], stepS)) {
            joint.offset = glm::normalize(joint.shown * glm::conjugate(rotation));
            if (joint.offset.w < 0) joint.offset = -joint.offset;
            if (first_) joint.fade.leftS = 0;
        }
        if (const float left = joint.fade.left(); left > 0)
            rotation = glm::normalize(glm::slerp(Quatf(1, 0, 0, 0), joint.offset, left) * rotation);
        joint.shown = rotation;
    }
    if (root_.begins(drivers[joints_.size()], stepS)) {
        rootOffset_ = rootShown_ - pose.rootTranslation;
        if (first_) root_.leftS = 0;
    }
    pose.rootTranslation += root_.left() * rootOffset_;
    rootShown_ = pose.rootTranslation;
    first_ = false;
}

}  // namespace dpl
