// SPDX-License-Identifier: Apache-2.0
#include "sdk/api/app_frame.h"

#include <algorithm>
#include <cmath>

namespace dpl::api {

static_assert(DPL_DRAW_DEPTH == int(PictureDepth::Splats) && DPL_DRAW_MESH_DEPTH == int(PictureDepth::Mesh));

Status checkProjection(float scale, float offset) {
    if (std::isfinite(scale) && std::isfinite(offset) && offset != 0) return {};
    return fail(Code::InvalidArgument, "a depth with scale {} and offset {}; both must be finite, and offset not 0", scale, offset);
}

namespace {

/** Encodes the frame of a slot that was taken. */
Status encodePictures(Scene& scene, const AppSide& side, const FrameWants& wants, const AppFrame& frame) {
    Drawn what[DPL_MAX_TOGETHER];
    setDetailOfDraw(*scene.context, scene.first());
    DPL_TRY(const std::span<const EncodedView> encoded,
            side.renderer.encodeTogether(scene.drawn(what), scene.context->cameras, wants, frame));
    LayerPlace places[DPL_MAX_VIEWS];
    for (size_t v = 0; v < encoded.size(); ++v) {
        const EncodedView& e = encoded[v];
        places[v] = {e.widthPx, e.heightPx, e.target, e.view, e.tilePixels, e.tileDepthOffset, e.meshDepth};
    }
    return side.backend.setLayers(frame.slot, {places, encoded.size()});
}

}  // namespace

Status preparePictures(Scene& scene, const AppSide& side, uint32_t slot, const Recording& recording) {
    FrameWants wants;
    std::copy(std::begin(scene.sceneDepthM), std::end(scene.sceneDepthM), wants.sceneDepthM);
    wants.sceneEncoded = recording.withScene;
    const uint32_t written = side.backend.depthsWritten();
    wants.depth = written & DPL_DRAW_DEPTH;
    for (size_t i = 0; i < scene.count; ++i) wants.meshDepth |= (written & DPL_DRAW_MESH_DEPTH) && !scene.avatars[i]->data->joints.empty();
    const Cameraf& first = scene.context->cameras[0];
    AppCommands commands;
    const auto encodeScene = [&](BufferId to, uint32_t firstView, uint32_t count) -> Status {
        for (uint32_t v = 0; v < count; ++v) {
            DPL_RETURN_IF_ERROR(recording.readScene({slot, firstView + v, v, first.widthPx, first.heightPx, to, commands}));
        }
        return {};
    };
    DPL_RETURN_IF_ERROR(side.backend.takeSlot(slot));
    DPL_RETURN_IF_ERROR(checkUsable(*scene.context));  // the slot may have told that the device was lost
    const Status recorded = [&]() -> Status {
        DPL_TRY(commands, recording.begin());
        DPL_RETURN_IF_ERROR(side.backend.encodeCopies(slot, commands, /*endsSlot=*/false));
        DPL_RETURN_IF_ERROR(encodePictures(scene, side, wants, {slot, commands, encodeScene}));
        return recording.end();
    }();
    if (!recorded) {
        DPL_RETURN_IF_ERROR(side.backend.dropSlot(slot));  // what was recorded need not be submitted
    }
    return recorded;
}

Status encodeUploads(const Context& context, AppBackend& backend, uint32_t slot, AppCommands commands) {
    DPL_RETURN_IF_ERROR(backend.takeSlot(slot));
    DPL_RETURN_IF_ERROR(checkUsable(context));
    return backend.encodeCopies(slot, commands, /*endsSlot=*/true);
}

}  // namespace dpl::api
