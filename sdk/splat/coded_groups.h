// SPDX-License-Identifier: Apache-2.0
// Coded splats to packed groups, a few at a time: the renderer keeps codes and decodes what a view needs. Private to sdk/splat.
#pragma once

#include <span>

#include "sdk/format/coded_splats.h"
#include "sdk/splat/packed_layout.h"

namespace dpl {

/** A splat of which level of detail leaves so much, and makes it so large. */
struct ChosenSplat {
    uint32_t splat;
    float weight, growth;
};

/** Decodes groups of sixteen splats in rising order. Cheap to make; one a worker. The codes must have passed readSplatStreams or come
 *  from codeSplats. Values are those of decodeSplats but for float rounding: scales within 1e-6 of themselves. */
class CodedGroups {
public:
    /** shShare: of SH beyond coefficient 0; 0: these are not decoded, and the groups are of degree 0. */
    CodedGroups(const CodedSplats& splats, uint32_t firstSplat, float shShare = 1);

    uint32_t shDegree() const { return shDegree_; }
    /** Fills the group of splats [first, first + 16); those past the last become invisible. */
    void decode(uint32_t first, float* out);
    /** A group of chosen ones, rising. */
    void decode(std::span<const ChosenSplat> chosen, float* out);

private:
    void enter(size_t chunk);
    void decodeOne(uint32_t splat, uint32_t lane, float* out);

    const CodedSplats& splats_;
    uint32_t shDegree_;
    float shShare_;
    size_t chunk_ = 0;
    uint32_t chunkEnd_ = 0;  // its last splat plus one
    uint32_t firstParent_ = 0;
    // s = coarse[c / 64] · fine[c % 64]: two short tables instead of an exponential a splat and axis.
    float coarse_[32], fine_[64];
    float dcMin_[3], dcStep_[3], shStep_[3];
};

}  // namespace dpl
