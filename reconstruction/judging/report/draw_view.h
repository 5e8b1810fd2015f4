// SPDX-License-Identifier: Apache-2.0
// Draws an avatar in scan cameras through the public SDK, with the software renderer because it runs everywhere.
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "sdk/avatar/rig.h"
#include "sdk/core/result.h"
#include "sdk/math/camera.h"

namespace dpl {

/** What clothes remember in a pose, as bytes for dplSetMotionState. motion: of the avatar. */
std::vector<uint8_t> motionStateBytes(const MotionModeData& motion, Pose pose);

class AvatarView {
public:
    /** Loads the bytes of an avatar file. threadCount 0: one thread per core. Pictures do not depend on the number of threads. */
    static Result<AvatarView> open(std::span<const uint8_t> bytes, uint32_t threadCount);
    AvatarView(AvatarView&&) noexcept;
    AvatarView& operator=(AvatarView&&) noexcept;
    ~AvatarView();

    /** RGBA with straight alpha, 4 bytes per pixel, in the camera's size. Clothes remember what the pose remembers (Pose::before). */
    Result<std::vector<uint8_t>> draw(const Pose& pose, const Camerad& camera);

private:
    struct State;
    explicit AvatarView(std::unique_ptr<State> state);
    std::unique_ptr<State> state_;
};

}  // namespace dpl
