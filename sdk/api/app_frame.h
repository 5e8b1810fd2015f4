// SPDX-License-Identifier: Apache-2.0
// The frame of a context on an app's device that becomes part of the app's frame: what Vulkan and Metal have in common.
#pragma once

#include "sdk/api/scene.h"
#include "sdk/backend/slotted_backend.h"
#include "sdk/core/function_ref.h"
#include "sdk/include/doppel/doppel.h"
#include "sdk/render/gpu_renderer.h"

namespace dpl::api {

/** What only a context on the program's device has. The context owns the renderer, which owns the backend. */
struct AppSide {
    GpuRenderer& renderer;
    AppBackend& backend;
};

/** What a program asks prepare or submit to draw. */
struct PictureCall {
    DplContext context;
    uint32_t slot;
    std::span<const DplAvatar> avatars;
    const DplCamera* views;
    uint32_t viewCount;
};

/** What prepare does with a slot once it has taken it: begin() gives the commands to record into, end() follows the recording. readScene
 *  encodes the conversion of the program's depth image behind a view; called if withScene. */
struct Recording {
    FunctionRef<Result<AppCommands>()> begin;
    FunctionRef<Status()> end;
    bool withScene;
    FunctionRef<Status(const SceneRead&)> readScene;
};

/** Whether stored depth = scale + offset / z says anything. */
Status checkProjection(float scale, float offset);

/** Draws a scene, whose views were taken, into the pictures of a slot. */
Status preparePictures(Scene& scene, const AppSide& side, uint32_t slot, const Recording& recording);

/** Encodes uploads that wait, without a picture. The context is locked. */
Status encodeUploads(const Context& context, AppBackend& backend, uint32_t slot, AppCommands commands);

}  // namespace dpl::api
