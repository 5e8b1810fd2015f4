// SPDX-License-Identifier: Apache-2.0
// Draws an avatar in scan cameras through the public SDK, with the renderer that anyone can run: the CPU.
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "sdk/avatar/rig.h"
#include "sdk/core/result.h"
#include "sdk/math/camera.h"

namespace dpl {

class AvatarView {
public:
    /** Loads the shipped bytes. threadCount 0: one a core; pictures do not depend on it. */
    static Result<AvatarView> open(std::span<const uint8_t> bytes, uint32_t threadCount);
    AvatarView(AvatarView&&) noexcept;
    AvatarView& operator=(AvatarView&&) noexcept;
    ~AvatarView();

    /** RGBA, straight alpha, of the camera's size. */
    Result<std::vector<uint8_t>> draw(const Pose& pose, const Camerad& camera);

private:
    struct State;
    explicit AvatarView(std::unique_ptr<State> state);
    std::unique_ptr<State> state_;
};

}  // namespace dpl
