// SPDX-License-Identifier: Apache-2.0
// Shared by all splat encodings: cuts splats into chunks, finds their parent triangles, checks the ranges of chunks.
#pragma once

#include <vector>

#include "sdk/core/result.h"
#include "sdk/format/avatar_data.h"
#include "sdk/format/coded_splats.h"

namespace dpl {

/** Calls visit(first, end) with the splats of each layer, in order. If the layers do not tile the triangles, as in some avatars made in
 *  memory, it calls once with all splats. */
template <class Visit>
void forLayers(const MeshData& mesh, const std::vector<uint32_t>& start, Visit&& visit) {
    uint32_t triangle = 0;
    for (const LayerData& layer : mesh.layers) {
        if (layer.firstTriangle != triangle || layer.triangleCount > mesh.triangles.size() - triangle) break;
        triangle += layer.triangleCount;
    }
    if (triangle != mesh.triangles.size()) return visit(start.front(), start.back());
    for (const LayerData& layer : mesh.layers) visit(start[layer.firstTriangle], start[layer.firstTriangle + layer.triangleCount]);
}

/** Calls visit(first, count) for each chunk: kSplatChunkSize splats, fewer in the last chunk of a layer. */
template <class Visit>
void forChunks(const MeshData& mesh, const std::vector<uint32_t>& start, Visit&& visit) {
    forLayers(mesh, start, [&](uint32_t layerFirst, uint32_t layerEnd) {
        for (uint32_t first = layerFirst; first < layerEnd; first += kSplatChunkSize)
            visit(first, layerEnd - first < kSplatChunkSize ? layerEnd - first : kSplatChunkSize);
    });
}

/** Fills parents, parent and the triangle ranges of the chunks. start: prefix sum of the splats of each triangle. */
void setParents(CodedSplats& out, const std::vector<uint32_t>& start);

/** Prefix sum of the splats of each triangle; triangleCount + 1 entries. */
std::vector<uint32_t> triangleStarts(const CodedSplats& coded, size_t triangleCount);

/** Refuses ranges that are not finite, empty or too large (CorruptData). index: of the chunk, for the text. */
Status checkRanges(const SplatChunk& chunk, size_t index);

}  // namespace dpl
