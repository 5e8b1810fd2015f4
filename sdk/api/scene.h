// SPDX-License-Identifier: Apache-2.0
// What the drawing calls of the API have in common: they take a context, avatars and views, and check them.
#pragma once

#include <mutex>
#include <span>

#include "sdk/api/api_state.h"

namespace dpl::api {

/** Context, avatars and scene depths of a drawing call. Locks the context for its lifetime. */
struct Scene {
    std::shared_ptr<Context> context;
    std::shared_ptr<Avatar> avatars[DPL_MAX_TOGETHER];
    size_t count = 0;
    Avatar& first() const { return *avatars[0]; }
    std::unique_lock<std::mutex> lock;
    std::span<const float> sceneDepthM[DPL_MAX_VIEWS];

    /** The avatars in their current poses and places. The poses are shown by this: clothes remember them. */
    std::span<const Drawn> drawn(Drawn (&what)[DPL_MAX_TOGETHER]) const {
        for (size_t i = 0; i < count; ++i) {
            avatars[i]->clock.show(avatars[i]->data->correctives.motion, avatars[i]->pose);
            what[i] = {avatars[i]->renderId, &avatars[i]->drawnPose(), avatars[i]->placement, avatars[i]->hiddenLayers};
        }
        return {what, count};
    }
};

/** The avatars 1 to DPL_MAX_TOGETHER of a call. */
Result<std::span<const DplAvatar>> together(const DplAvatar* avatars, uint32_t count);

Result<Scene> sceneOf(DplContext context, std::span<const DplAvatar> handles, uint32_t viewCount);

/** Fills context->cameras and s.sceneDepthM, and checks the cameras. */
Status takeViews(Scene& s, const DplCamera* views, uint32_t viewCount);

}  // namespace dpl::api
