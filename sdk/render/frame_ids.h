// SPDX-License-Identifier: Apache-2.0
// The buffers and sizes that passes take. Passes over all subjects take the frame, passes of one subject take the frame and the subject. A
// pass knows no other pass.
#pragma once

#include "sdk/backend/backend.h"
#include "sdk/core/result.h"
#include "shaders/shared/frame.h"

namespace dpl {

/** One subject of a frame: an avatar, or one set of general splats. */
struct SubjectIds {
    // Set when it is loaded.
    uint32_t vertexCount = 0, triangleCount = 0, splatCount = 0, shDegree = 0;
    uint32_t jointCount = 0;
    uint32_t firstLight = 0;  // in the palette; 0: no light of the scene
    uint32_t groupCount = 0;  // of splats
    gpu::CodesPush codes{};   // where its streams begin; codesPush() adds its place in the frame
    bool corrected = false;   // has pose correctives: other vertex records, control nodes after the joints in the palette
    bool general = false;     // general splats: no vertices, no triangles; `splats` holds GeneralSplatRecord
    BufferId vertices, triangles, splats, sh;
    BufferId posed, triangleFrames;  // written by the GPU in each frame
    // Set by its scene set: its number there, and the number of groups and splats before its own in the lists of the frame.
    uint32_t drawn = 0, firstGroup = 0, firstSplat = 0;
    // Of the slot; the CPU writes them before each frame.
    BufferId uniforms, palette;
};

/** Cells that are counted, and prefix sums over them (passes/scan.h). */
struct TableIds {
    BufferId cells, sums, places;
};

/** A frame of all subjects of a scene set. */
struct FrameIds {
    uint32_t allSplats = 0, allGroups = 0;  // of all subjects together
    std::vector<uint32_t> endGroups;        // for each subject, the end of its groups
    uint32_t viewCount = 1;
    uint32_t widthPx = 0, heightPx = 0;  // of one view
    bool multiview = true, depth = false;
    uint32_t drawInstances = 1;  // of the draw of all views (DeviceInfo::viewsAreInstances)
    bool wide = false;           // a subject reaches so far that 16 bits of depth are too few
    bool shuffle = false;        // subgroups hold whole tiles (DeviceInfo::shuffle)
    bool sceneDepth = false;     // splats behind the app's scene are hidden
    uint32_t samples = 1;        // a pixel (sdk/math/coverage.h)

    BufferId scene;  // of the slot: view z of the app's scene in metres by view, row and column; infinite where it is empty

    // Written by the GPU in each frame.
    TableIds tiles;
    BufferId tileSpans, tileEntries, tilePixels;  // none: only quads fill
    BufferId meshDepth;                           // none: not wanted
    BufferId projected, visibility, survivors, counts;
    BufferId pairs, pairsSwap;  // (depth key, splat); after sorting, `pairs` holds the splats alone
    TableIds digits;            // of the sort: [digit][run]
    TargetId target;            // none: tiles fill

    uint32_t sortRounds() const { return wide ? gpu::kWideSortRounds : gpu::kSortRounds; }
    uint32_t maxDepthKey() const { return (1u << (sortRounds() * gpu::kSortDigitBits)) - 1; }
    // Layout of shaders/lib/visibility.glsl.
    uint64_t visibilityWords() const { return 3ull * allGroups + allSplats; }
    uint32_t firstSum() const { return gpu::kMaskWords * allGroups; }
    uint64_t survivorWords() const { return firstSum() + allGroups + 1ull; }
    /** The buffer of the pairs before the sort, chosen so that the last round writes into `pairs`. */
    BufferId unsorted() const { return sortRounds() % 2 ? pairsSwap : pairs; }
    gpu::CodesPush codesPush(const SubjectIds& subject) const {
        gpu::CodesPush push = subject.codes;
        push.groupCount = subject.groupCount, push.allGroups = allGroups;
        push.firstGroup = subject.firstGroup, push.firstSplat = subject.firstSplat;
        return push;
    }
    /** The kernel built for this many views. */
    std::string ofViews(std::string shader) const {
        if (viewCount > 1) shader += ".stereo";
        return shader;
    }
    /** Bytes of the lists of a scene set. */
    uint64_t listBytes() const {
        const uint64_t pairBytes = sizeof(gpu::SortPair), swapBytes = sortRounds() == 2 ? sizeof(uint32_t) : pairBytes;
        return (visibilityWords() + survivorWords() + 2 * digitWords()) * sizeof(uint32_t) + allSplats * (pairBytes + swapBytes);
    }
    uint64_t digitWords() const { return uint64_t(gpu::kSortDigits) * ((allSplats + gpu::kRun - 1) / gpu::kRun); }
};

}  // namespace dpl
