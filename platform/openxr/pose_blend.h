// SPDX-License-Identifier: Apache-2.0
// A pose without jumps where a joint's driver changes: a clip, or the user (puppet.h).
#pragma once

#include <span>
#include <vector>

#include "platform/openxr/openxr.h"

namespace dpl::xr {

/** When a joint's driver changes, the joint goes on from the rotation that it showed last and reaches its new driver's after
 *  kPoseBlendS, smoothly. In between it follows the new driver, turned by what is left of the difference. */
constexpr float kPoseBlendS = 0.25f;

class PoseBlend {
public:
    explicit PoseBlend(size_t jointCount) : joints_(jointCount) {}

    /** Once a frame. rotations: local, unit; what shall be shown, replaced by what is shown. driven: by joint, who drives it. stepS: since
     *  the frame before, seconds. Allocates nothing. */
    void step(std::span<XrQuaternionf> rotations, std::span<const uint8_t> driven, float stepS);

private:
    struct Joint {
        XrQuaternionf shown{0, 0, 0, 1}, offset{0, 0, 0, 1};
        float leftS = 0;  // of the blend
        uint8_t driver = 0;
    };
    std::vector<Joint> joints_;
    bool first_ = true;
};

}  // namespace dpl::xr
