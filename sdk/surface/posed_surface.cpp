// SPDX-License-Identifier: Apache-2.0
#include "sdk/surface/posed_surface.h"

namespace dpl {

std::span<const Vec3f> PosedSurface::in(const PosedSubject& subject, const Pose& pose) {
    if (version_ == 0 || !samePose(pose_, pose)) {
        mesh_.control(subject, pose);
        mesh_.vertices(subject, jobs_);
        pose_ = pose, ++version_;
    }
    return mesh_.positions();
}

}  // namespace dpl
