// The buffers and sizes that the passes of one frame share. A pass reads these ids and knows no other pass.
#pragma once

#include "sdk/backend/backend.h"
#include "shaders/shared/frame.h"

namespace dpl {

struct FrameIds {
    // sizes
    uint32_t vertexCount = 0, triangleCount = 0, splatCount = 0, shDegree = 0, viewCount = 1;
    uint32_t widthPx = 0, heightPx = 0;   // of one view
    uint32_t jointCount = 0;
    uint32_t groupCount = 0, filledGroups = 0;  // half-chunks of an avatar's splats; those with any
    gpu::CodesPush codes{};               // where its streams begin; views and groups are filled in per frame
    bool corrected = false;               // pose correctives: other vertex records, control nodes behind the joints in the palette
    bool general = false;                 // general splats: no vertices, no triangles; `splats` holds GeneralSplatRecord
    bool layered = true, depth = false, halfColour = false;
    bool cull = true;                     // triangles out of view or turned away
    bool floatKeys = false;               // depths are sorted as 32-bit floats
    uint32_t samples = 1;                 // a pixel (sdk/math/coverage.h)

    // written by the CPU: at load, or (frame, palette) before each frame
    BufferId frame, palette, vertices, triangles, splats, sh;
    // made by the GPU in each frame
    BufferId tileLists, tileEntries, tilePixels;   // none: quads alone
    BufferId posed, triangleFrames, projected, visibility, blockSums, counts, pairs, pairsSwap, histogram;
    TargetId target;
    // read by the CPU, made by the first read-back
    BufferId colourPixels, depthPixels;

    uint32_t sortRounds() const { return floatKeys ? gpu::kFloatSortRounds : general ? gpu::kGeneralSortRounds : gpu::kSortRounds; }
    uint32_t maxDepthKey() const { return floatKeys ? gpu::kFloatDepthKeys : (1u << (sortRounds() * gpu::kSortDigitBits)) - 1; }
    uint32_t firstDepth() const { return 2 * groupCount; }  // in the visibility buffer
    gpu::CodesPush codesPush() const {
        gpu::CodesPush push = codes;
        push.viewCount = viewCount, push.groupCount = groupCount;
        return push;
    }
    uint32_t compactBlocks() const { return (splatCount + gpu::kCompactBlock - 1) / gpu::kCompactBlock; }
    uint32_t maxSortBlocks() const { return (splatCount + gpu::kSortBlock - 1) / gpu::kSortBlock; }
};

}  // namespace dpl
