// SPDX-License-Identifier: Apache-2.0
// Pose correctives as data: checks of their arrays, and correctives encoding 1 (docs/formats/avatar.md).
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "sdk/core/result.h"
#include "sdk/format/avatar_data.h"

namespace dpl {

constexpr uint32_t kMaxCorrectiveModes = 64, kMaxCorrectiveNodes = 65535;  // modes: motion modes included

/** Refuses arrays that do not fit one another, the rig or the mesh, and numbers that are not finite or above 1e6, so that no pose makes a
 *  vertex infinite (CorruptData, naming the array). Node indices must be in range, also in slots of weight 0. Without modes, only nodes
 *  and vertices are allowed. */
Status checkCorrectives(const PoseCorrectiveData& correctives, size_t jointCount, size_t vertexCount);

/** The streams of a file, little-endian. Bytes: owned when written, borrowed when read. */
template <class Bytes>
struct CorrectiveStreams {
    Bytes mean;         // f32, 6 per joint of the feature
    Bytes modes;        // f32, K rows of 6 per joint of the feature
    Bytes ranges;       // f32 x 4 per mode, motion modes last: largest magnitude of x, y, z, brightness over its nodes
    Bytes nodes;        // i16 x 4 per node and mode; value = range·code/32767
    Bytes nodeIndices;  // u16 x 4 per vertex
    Bytes nodeWeights;  // unorm8 x 4 per vertex
};

/** The correctives must have passed checkCorrectives. Encoding decoded correctives gives the same bytes, because ranges are values that
 *  occur. */
CorrectiveStreams<std::vector<uint8_t>> encodeCorrectives(const PoseCorrectiveData& correctives);

/** Fills all arrays but `joints`. head: joints, modeCount, nodeCount, the reaches and the motion modes. Checks the length of each stream
 * before it allocates; the caller checks the values by checkCorrectives. */
Result<PoseCorrectiveData> decodeCorrectives(const CorrectiveStreams<std::span<const uint8_t>>& streams, PoseCorrectiveData head,
                                             size_t vertexCount);

}  // namespace dpl
