// SPDX-License-Identifier: Apache-2.0
// Pose correctives as data: what their arrays must be, and correctives encoding 1 (docs/formats/avatar.md).
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "sdk/core/result.h"
#include "sdk/format/avatar_data.h"

namespace dpl {

constexpr uint32_t kMaxCorrectiveModes = 64, kMaxCorrectiveNodes = 65535;

/** Refuses arrays that do not fit one another, the rig or the mesh, and numbers that are not finite or above 1e6, so that no pose can
 *  make an infinite vertex; says which (CorruptData). Every node index is in range, also of a slot of weight 0. */
Status checkCorrectives(const PoseCorrectiveData& correctives, size_t jointCount, size_t vertexCount);

/** The streams of a file: owned when written, borrowed when read. Little-endian, in a row. */
template <class Bytes>
struct CorrectiveStreams {
    Bytes mean;         // f32, 6 a heard joint
    Bytes modes;        // f32, 6 a heard joint, K rows
    Bytes ranges;       // f32 x 4 a mode: largest magnitude of x, y, z, light over its nodes
    Bytes nodes;        // i16 x 4 a node and mode, range·c/32767
    Bytes nodeIndices;  // u16 x 4 a vertex
    Bytes nodeWeights;  // unorm8 x 4 a vertex
};

/** The correctives must have passed checkCorrectives. Ranges are values that occur, so encoding what was decoded gives the same bytes. */
CorrectiveStreams<std::vector<uint8_t>> encodeCorrectives(const PoseCorrectiveData& correctives);

/** Fills all arrays but `joints`. `head` has joints, modeCount, nodeCount and reach. Every stream's length is checked before anything
 *  is allocated; the values are left to checkCorrectives. */
Result<PoseCorrectiveData> decodeCorrectives(const CorrectiveStreams<std::span<const uint8_t>>& streams, PoseCorrectiveData head,
                                             size_t vertexCount);

}  // namespace dpl
