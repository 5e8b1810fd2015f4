// SPDX-License-Identifier: Apache-2.0
// What all splat encodings share: how splats are cut into chunks and hang on triangles, and what a chunk's ranges may be.
#pragma once

#include <vector>

#include "sdk/core/result.h"
#include "sdk/format/avatar_data.h"
#include "sdk/format/coded_splats.h"

namespace dpl {

/** Splats [first, end) of each layer, in order; of a mesh whose layers do not tile its triangles (avatars made in memory may), all at once.
 */
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

/** visit(first, count) for each chunk: kSplatChunkSize splats, the last of a layer fewer. */
template <class Visit>
void forChunks(const MeshData& mesh, const std::vector<uint32_t>& start, Visit&& visit) {
    forLayers(mesh, start, [&](uint32_t layerFirst, uint32_t layerEnd) {
        for (uint32_t first = layerFirst; first < layerEnd; first += kSplatChunkSize)
            visit(first, layerEnd - first < kSplatChunkSize ? layerEnd - first : kSplatChunkSize);
    });
}

/** parents, parent and the chunks' triangles, from the chunks' splats and the triangles' (start: a prefix sum). */
void setParents(CodedSplats& out, const std::vector<uint32_t>& start);

/** Splats of each triangle, as a prefix sum. */
std::vector<uint32_t> triangleStarts(const CodedSplats& coded, size_t triangleCount);

/** Refuses ranges that are not finite, empty or too large (CorruptData). */
Status checkRanges(const SplatChunk& chunk, size_t index);

}  // namespace dpl
