// SPDX-License-Identifier: Apache-2.0
// What a renderer counts, as the public interface tells it.
#pragma once

#include <algorithm>

#include "sdk/draw/renderer.h"
#include "sdk/include/doppel/doppel.h"

namespace dpl::api {

/** All fields that follow from the frame. The others (frameMs, keptWanted, keptLimit, framesOver, budgetState) belong to the governor of an
 *  avatar. structSize is 0. */
inline DplFrameStats publicStats(const FrameStats& s) {
    DplFrameStats out{};
    out.viewCount = s.views;
    out.splatsDrawn = s.splatsDrawn;
    out.trianglesInView = s.trianglesInView, out.trianglesFacing = s.trianglesFacing;
    out.chunkCount = s.chunks, out.chunksProjected = s.chunksProjected;
    out.splatsInView = s.splatsInView, out.splatsFacing = s.splatsFacing;
    out.passCount = uint32_t(s.passes.size());
    out.residentBytes = s.residentBytes;
    out.waits = s.waits;
    out.avatarBytes = s.avatarBytes, out.splatBytes = s.splatBytes;
    out.bytesDecided = s.bytesDecided, out.bytesDecoded = s.bytesDecoded;
    for (const PassTime& pass : s.passes) out.gpuMs += pass.milliseconds;
    out.tileEntries = s.tileEntries;
    out.tilesOverflowed = s.tilesOverflowed ? 1 : 0;
    out.splatsAllowed = uint32_t(std::min<uint64_t>(s.splatsAllowed, UINT32_MAX));
    out.detailShare = s.detailShare;
    out.componentCount = s.components, out.componentsInView = s.componentsInView;
    return out;
}

}  // namespace dpl::api
