// SPDX-License-Identifier: Apache-2.0
// A pose without jumps where a joint's driver changes: the pose beneath, or a tracker.
#pragma once

#include <span>
#include <vector>

#include "sdk/avatar/rig.h"

namespace dpl {

/** When a joint's driver changes, the joint goes on from what it showed last and reaches its new driver smoothly: within kFadeInS if that
 * is a tracker, within kFadeOutS if it is the pose beneath (driver 0). In between it follows the new driver, turned by what is left of the
 *  difference. */
constexpr float kFadeInS = 0.25f, kFadeOutS = 0.5f;

class PoseFade {
public:
    explicit PoseFade(size_t jointCount) : joints_(jointCount) {}

    /** Once a picture. pose: what shall be shown, replaced by what is shown. drivers: by joint, then one for the root translation; 0: the
     *  pose beneath. stepS: since the picture before, seconds, 0 or more. Allocates nothing. */
    void step(Pose& pose, std::span<const uint32_t> drivers, float stepS);

private:
    struct Fade {
        float leftS = 0, wholeS = 1;
        uint32_t driver = 0;

        bool begins(uint32_t next, float stepS);
        float left() const;
    };
    struct Joint {
        Fade fade;
        Quatf shown{1, 0, 0, 0}, offset{1, 0, 0, 0};
    };
    std::vector<Joint> joints_;
    Fade root_;
    Vec3f rootShown_{0}, rootOffset_{0};
    bool first_ = true;
};

}  // namespace dpl
