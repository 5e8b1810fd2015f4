// SPDX-License-Identifier: Apache-2.0
// The vertices of an avatar in its current pose, posed again only when the pose has changed.
#pragma once

#include <span>

#include "sdk/avatar/posed_mesh.h"

namespace dpl {

/** Always of the same avatar. One thread at a time. */
class PosedSurface {
public:
    /** V vertices in the avatar's own space, valid until the next call. The pose must have passed checkPose. */
    std::span<const Vec3f> in(const PosedSubject& subject, const Pose& pose);
    /** Of the vertices: another number whenever they were posed again. */
    uint64_t version() const { return version_; }

private:
    Jobs jobs_{1};
    PosedMesh mesh_;
    Pose pose_;
    uint64_t version_ = 0;
};

}  // namespace dpl
