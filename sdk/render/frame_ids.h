// SPDX-License-Identifier: Apache-2.0
// The buffers and sizes that the passes of one frame share. A pass reads these ids and knows no other pass.
#pragma once

#include "sdk/backend/backend.h"
#include "sdk/core/result.h"
#include "shaders/shared/frame.h"

namespace dpl {

/** One avatar, or one set of general splats, of a frame. */
struct SubjectIds {
    uint32_t vertexCount = 0, triangleCount = 0, splatCount = 0, shDegree = 0;
    uint32_t jointCount = 0;
    uint32_t groupCount = 0, filledGroups = 0;           // half-chunks; those with any splats
    uint32_t componentCount = 0;                         // that may be left out (sdk/visibility/components.h)
    uint32_t drawn = 0, firstGroup = 0, firstSplat = 0;  // its number, and what lies before its own in the lists of the frame
    gpu::CodesPush codes{};                              // where its streams begin; what belongs to the frame is filled in there
    bool corrected = false;                    // pose correctives: other vertex records, control nodes behind the joints in the palette
    bool general = false;                      // general splats: no vertices, no triangles; `splats` holds GeneralSplatRecord
    bool wide = false;                         // they reach so far that 16 bits of depth are too few
    BufferId frame, palette;                   // written by the CPU before each frame
    BufferId vertices, triangles, splats, sh;  // ... at load
    BufferId posed, triangleFrames;            // made by the GPU in each frame
};

/** Cells that are counted, and prefix sums over them (passes/scan.h). */
struct TableIds {
    BufferId cells, sums, places;
};

/** A frame. As a subject: the one whose passes are added; for the passes over all, the number of their splats and half-chunks, and whether
 * any reaches far. */
struct FrameIds : SubjectIds {
    uint32_t viewCount = 1;
    uint32_t widthPx = 0, heightPx = 0;  // of one view
    uint32_t allGroups = 0;              // half-chunks of all subjects
    std::vector<uint32_t> endGroups;     // where those of each end
    bool multiview = true, depth = false;
    ColourFormat colour = ColourFormat::Codes8;
    bool floatKeys = false;   // depths are sorted as 32-bit floats
    bool shuffle = false;     // subgroups hold whole tiles (DeviceInfo::shuffle)
    bool sceneDepth = false;  // splats behind the app's scene are hidden
    uint32_t samples = 1;     // a pixel (sdk/math/coverage.h)
    float guard = 1;          // of the draw: clip space over target

    BufferId
        scene;  // view z of the app's scene, infinite where there is nothing; views, rows, columns; written by the CPU before each frame
    // made by the GPU in each frame
    TableIds tiles;
    BufferId tileSpans, tileEntries, tilePixels;  // none: quads alone
    BufferId meshDepth;                           // none: not wanted
    BufferId projected, visibility, survivors, counts;
    BufferId pairs, pairsSwap;  // (depth key, splat); sorted: the splats alone, in `pairs`
    TableIds digits;            // of the sort: [digit][run]
    TargetId target;
    // read by the CPU, made by the first read-back
    BufferId colourPixels, depthPixels, meshDepthPixels;

    /** The same frame, for the passes of one subject. */
    FrameIds of(const SubjectIds& subject) const {
        FrameIds ids = *this;
        static_cast<SubjectIds&>(ids) = subject;
        return ids;
    }
    uint32_t sortRounds() const { return floatKeys ? gpu::kFloatSortRounds : wide ? gpu::kWideSortRounds : gpu::kSortRounds; }
    uint32_t maxDepthKey() const { return floatKeys ? gpu::kFloatDepthKeys : (1u << (sortRounds() * gpu::kSortDigitBits)) - 1; }
    // As lib/visibility.glsl has them.
    uint64_t visibilityWords() const { return 3ull * allGroups + splatCount; }
    uint32_t firstSum() const { return gpu::kMaskWords * allGroups; }
    uint64_t survivorWords() const { return firstSum() + allGroups + 1ull; }
    BufferId unsorted() const { return sortRounds() % 2 ? pairsSwap : pairs; }  // from here the rounds end in `pairs`
    gpu::CodesPush codesPush() const {
        gpu::CodesPush push = codes;
        push.groupCount = groupCount, push.allGroups = allGroups, push.firstGroup = firstGroup, push.firstSplat = firstSplat;
        return push;
    }
    /** The kernel built for this many views; and for this SH degree. */
    std::string ofViews(std::string shader) const {
        if (viewCount > 1) shader += ".stereo";
        return shader;
    }
    std::string ofColour(const char* shader) const { return ofViews(formatText("{}.sh{}", shader, shDegree)); }
    uint64_t digitWords() const { return uint64_t(gpu::kSortDigits) * ((splatCount + gpu::kRun - 1) / gpu::kRun); }
};

}  // namespace dpl
