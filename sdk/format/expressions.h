// SPDX-License-Identifier: Apache-2.0
// Expressions as data: checks of their arrays, and their streams in a file, encoding 1 (docs/formats/avatar.md): of shapes that move the
// nodes of the pose correctives. Those with nodes of their own: face_nodes.h.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "sdk/core/result.h"
#include "sdk/format/avatar_data.h"
#include "sdk/format/expression_names.h"

namespace dpl {

constexpr float kMostExpressionM = 0.1f;  // of an offset at weight 1, along each axis; a jaw opens by half of it

/** Refuses shapes that are unknown or not in rising order, entries that do not fit them or the control nodes, and offsets that are not
 *  finite or too large, so that no weights make a vertex infinite (CorruptData, naming the shape). Node 0 of correctives that follow no
 *  pose holds all that never moves. */
Status checkExpressions(const ExpressionData& expressions, const PoseCorrectiveData& correctives);

/** Takes the modes of the pose away, as pack does where they do not pay. The control nodes stay for the expressions, or go with the modes
 *  where there are none. */
void dropPoseModes(PoseCorrectiveData& correctives, ExpressionData& expressions);

/** The streams of a file, little-endian. Bytes: owned when written, borrowed when read. */
template <class Bytes>
struct ExpressionStreams {
    Bytes counts;   // u32 a shape: its entries
    Bytes ranges;   // f32 a shape: largest magnitude of a component of its offsets
    Bytes nodes;    // u16 an entry
    Bytes offsets;  // i16 x 3 an entry; value = range·code/32767
    // Where no pose correctives hold the control nodes: the vertices that are not on node 0 alone.
    Bytes vertices;     // u32, rising
    Bytes nodeIndices;  // u16 x 4 each
    Bytes nodeWeights;  // unorm8 x 4 each, sum 255
};

/** Both must have passed their checks. Encoding decoded expressions gives the same bytes, because ranges are values that occur. */
ExpressionStreams<std::vector<uint8_t>> encodeExpressions(const ExpressionData& expressions, const PoseCorrectiveData& correctives);

/** Fills all arrays but `shapes`. Checks the length of each stream before it allocates; the caller checks the values by
 *  checkExpressions(). */
Result<ExpressionData> decodeExpressions(const ExpressionStreams<std::span<const uint8_t>>& streams, std::vector<uint8_t> shapes);

/** The control nodes of a file without pose correctives: nodeCount of them, node 0 included. The caller checks them by
 *  checkCorrectives(). CorruptData: streams that do not fit one another, or vertices that are out of range or not in rising order. */
Result<PoseCorrectiveData> decodeExpressionNodes(const ExpressionStreams<std::span<const uint8_t>>& streams, uint32_t nodeCount,
                                                 size_t vertexCount);

}  // namespace dpl
