// SPDX-License-Identifier: Apache-2.0
// Control nodes of the face's own, and their streams in a file: encoding 2 of expressions (docs/formats/avatar.md).
//
//   pose correctives, as they were ─► F nodes behind theirs, each with their values at the vertex where it stands
//   vertices that expressions move ─► bound to these nodes; where the pose alone had them is kept
//
// So a file holds nothing of the pose twice, and a reader that leaves the expressions out has the pose correctives as they were.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "sdk/core/result.h"
#include "sdk/format/avatar_data.h"

namespace dpl {

/** Four nodes of a vertex, counted from the first of the face's own. */
struct FaceVertex {
    uint32_t vertex;
    glm::u16vec4 nodes;
    glm::u8vec4 weights;  // sum 255
};

/** Gives the correctives `nodeCount` nodes more and binds these vertices, in rising order, to them alone. A node takes the values of the
 * pose at the first vertex that is on it alone, as it was. x must have no nodes of its own. CorruptData, and nothing changes: vertices that
 * are out of order or do not exist, a node that no vertex is on alone, or more nodes than a file holds. */
Status bindToFace(std::span<const FaceVertex> vertices, uint32_t nodeCount, size_t vertexCount, PoseCorrectiveData& c, ExpressionData& x);

/** The correctives as they were before bindToFace(). */
PoseCorrectiveData withoutFaceNodes(const PoseCorrectiveData& c, const ExpressionData& x);

/** The vertices that are on nodes of the face's own. */
std::vector<FaceVertex> faceVertices(const ExpressionData& x, const PoseCorrectiveData& c);

/** Takes the nodes for such as the expressions share with the pose: for a caller that binds further vertices to them, or puts nodes behind.
 */
void shareFaceNodes(ExpressionData& x);

/** Whether the nodes of the face's own are as bindToFace() leaves them (CorruptData). None: they are. */
Status checkFaceNodes(const ExpressionData& x, const PoseCorrectiveData& c);

/** The streams of a file, little-endian. Bytes: owned when written, borrowed when read. */
template <class Bytes>
struct FaceStreams {
    Bytes counts;       // u32 a shape: its entries
    Bytes ranges;       // f32 a shape: largest magnitude of a component of its offsets
    Bytes nodes;        // u16 an entry, counted from the first of the face's own
    Bytes offsets;      // i8 x 3 an entry of a shape whose range is at most kByteRangeM: range·code/127; else i16 x 3: range·code/32767
    Bytes alone;        // u32, rising: vertices on one node alone
    Bytes aloneNodes;   // u16 each
    Bytes vertices;     // u32, rising: those on several
    Bytes nodeIndices;  // u16 x 4 each
    Bytes nodeWeights;  // unorm8 x 4 each, sum 255
};
constexpr float kByteRangeM = 0.0127f;  // so that a step of a byte is at most 0.1 mm

/** Both must have passed their checks, and x has nodes of its own. Encoding what was decoded gives the same bytes. */
FaceStreams<std::vector<uint8_t>> encodeFace(const ExpressionData& x, const PoseCorrectiveData& c);

/** Fills the expressions of an avatar and gives its pose correctives, which are read, the nodes. CorruptData: streams that do not fit. */
Status decodeFace(const FaceStreams<std::span<const uint8_t>>& in, std::vector<uint8_t> shapes, uint32_t nodeCount, AvatarData& avatar);

}  // namespace dpl
