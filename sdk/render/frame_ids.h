// The buffers and sizes that the passes of one frame share. A pass reads these ids and knows no other pass.
#pragma once

#include "sdk/backend/backend.h"
#include "sdk/core/result.h"
#include "shaders/shared/frame.h"

namespace dpl {

struct FrameIds {
    // sizes
    uint32_t vertexCount = 0, triangleCount = 0, splatCount = 0, shDegree = 0, viewCount = 1;
    uint32_t widthPx = 0, heightPx = 0;   // of one view
    uint32_t jointCount = 0;
    uint32_t groupCount = 0, filledGroups = 0;  // half-chunks; those with any splats
    gpu::CodesPush codes{};               // where its streams begin; views and groups are filled in per frame
    bool corrected = false;               // pose correctives: other vertex records, control nodes behind the joints in the palette
    bool general = false;                 // general splats: no vertices, no triangles; `splats` holds GeneralSplatRecord
    bool layered = true, depth = false, halfColour = false;
    bool cull = true;                     // triangles out of view or turned away
    bool floatKeys = false;               // depths are sorted as 32-bit floats
    bool shuffle = false;                 // subgroups hold whole tiles (DeviceInfo::shuffle)
    bool sceneDepth = false;              // splats behind the app's scene are hidden
    uint32_t samples = 1;                 // a pixel (sdk/math/coverage.h)

    // written by the CPU: at load, or (frame, palette, scene) before each frame
    BufferId scene;                                // view z of the app's scene, infinite where there is nothing; views, rows, columns
    BufferId frame, palette, vertices, triangles, splats, sh;
    // made by the GPU in each frame
    BufferId tileLists, tileEntries, tilePixels;   // none: quads alone
    BufferId meshDepth;                            // none: not wanted
    BufferId posed, triangleFrames, projected, visibility, counts, pairs, pairsSwap, histogram;
    TargetId target;
    // read by the CPU, made by the first read-back
    BufferId colourPixels, depthPixels, meshDepthPixels;

    uint32_t sortRounds() const { return floatKeys ? gpu::kFloatSortRounds : general ? gpu::kGeneralSortRounds : gpu::kSortRounds; }
    uint32_t maxDepthKey() const { return floatKeys ? gpu::kFloatDepthKeys : (1u << (sortRounds() * gpu::kSortDigitBits)) - 1; }
    uint32_t firstSum() const { return 7 * groupCount; }        // in the visibility buffer, as lib/visibility.glsl has it
    uint32_t firstDepth() const { return 8 * groupCount + 1; }
    BufferId unsorted() const { return sortRounds() % 2 ? pairsSwap : pairs; }  // from here the rounds end in `pairs`
    gpu::CodesPush codesPush() const {
        gpu::CodesPush push = codes;
        push.groupCount = groupCount;
        return push;
    }
    /** The kernel built for this many views; and for this SH degree. */
    std::string ofViews(std::string shader) const { return viewCount > 1 ? shader + ".stereo" : shader; }
    std::string ofColour(const char* shader) const { return ofViews(formatText("{}.sh{}", shader, shDegree)); }
    uint64_t histogramWords() const { return gpu::kSortTable + uint64_t(gpu::kSortDigits) * ((splatCount + gpu::kRun - 1) / gpu::kRun); }
};

}  // namespace dpl
