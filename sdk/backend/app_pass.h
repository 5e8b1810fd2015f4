// SPDX-License-Identifier: Apache-2.0
// What backends share that compose pictures into the passes of an app.
#pragma once

#include <span>

#include "sdk/backend/backend.h"
#include "shaders/shared/frame.h"

namespace dpl {

/** Depths of a picture. As flags, they are what prepare has to draw. */
enum class PictureDepth : uint8_t { None = 0, Splats = 1, Mesh = 2 };

using ComposerId = GpuId<struct ComposerTag>;

/** Where the picture layer of a view lies once its frame has run. */
struct LayerPlace {
    TargetId target;
    uint32_t view = 0;             // of the target
    BufferId tilePixels;           // of frames that tiles fill; none: quads
    BufferId counts;               // says whether the tile lists overflowed, so that quads filled the frame
    uint64_t tileDepthOffset = 0;  // of the depth sums in tilePixels, bytes
    BufferId meshDepth;            // none: the picture has no depth of the mesh
};

/** What a draw that composes `view` of a slot pushes, but for its place and what depends on the pass. shared: the target holds all views
 *  of its frame as layers of one image, so that one draw can compose them. */
inline gpu::ComposePush composePush(std::span<const LayerPlace> places, uint32_t view, const TargetDesc& target, bool shared,
                                    bool halfDepth) {
    const LayerPlace& place = places[view];
    gpu::ComposePush push{};
    push.widthPx = target.widthPx, push.heightPx = target.heightPx;
    for (uint32_t v = 0; v < places.size(); ++v)
        if (v == view || (shared && places[v].target == place.target)) push.views |= 1u << v;
    push.drawnFrom = view - (shared ? place.view : 0);
    push.bufferFrom = view - place.view;
    push.tiled = place.tilePixels ? 1 : 0;
    push.firstDepth = uint32_t(place.tileDepthOffset / 4);
    push.halfDepth = halfDepth ? 1 : 0;
    return push;
}

/** Whether a composer that writes such a depth can use a slot that was prepared with these. pass: of the API, with a member writesDepth. */
inline Status checkDepth(ComposerId composer, PictureDepth written, uint32_t slot, uint32_t prepared, const char* pass) {
    if (written == PictureDepth::None)
        return fail(Code::InvalidArgument, "composer {} writes no depth; set writesDepth of its {}", composer.value, pass);
    if (!(prepared & uint32_t(written)))
        return fail(Code::InvalidArgument, "slot {} was prepared before composer {} was made, so its picture lacks the depth", slot,
                    composer.value);
    return {};
}

}  // namespace dpl
