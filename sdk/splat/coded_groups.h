// SPDX-License-Identifier: Apache-2.0
// Decodes coded splats into packed groups (packed_layout.h), a few at a time: the renderer keeps the codes and decodes what a view needs.
// Private to sdk/splat.
#pragma once

#include <span>

#include "sdk/format/coded_splats.h"
#include "sdk/splat/packed_layout.h"

namespace dpl {

/** A splat that level of detail keeps. */
struct ChosenSplat {
    uint32_t splat;
    float weight, growth;  // factors of the opacity and of the standard deviations
};

/** Decodes packed groups in rising order of splats. Cheap to make; use one per worker. The codes must have passed readSplatStreams or come
 *  from codeSplats. Values equal those of decodeSplats up to float rounding (scales: 1e-6 relative). */
class CodedGroups {
public:
    /** shShare: factor of SH coefficients above band 0. At 0 they are not decoded and the packed groups have degree 0. `splats` must
     * outlive this. firstSplat: no smaller splat is decoded. */
    CodedGroups(const CodedSplats& splats, uint32_t firstSplat, float shShare = 1);

    uint32_t shDegree() const { return shDegree_; }
    /** Decodes splats [first, first + 16); lanes past the last splat become invisible. */
    void decode(uint32_t first, float* out);
    /** Decodes up to 16 chosen splats, in rising order. */
    void decode(std::span<const ChosenSplat> chosen, float* out);

private:
    void enter(size_t chunk);
    void decodeOne(uint32_t splat, uint32_t lane, float* out);

    const CodedSplats& splats_;
    uint32_t shDegree_;
    float shShare_;
    size_t chunk_ = 0;
    uint32_t chunkEnd_ = 0;  // last splat of the chunk plus one
    uint32_t firstParent_ = 0;
    // Standard deviation of code c = coarse[c / 64] · fine[c % 64]: two short tables replace an exponential per splat and axis.
    float coarse_[32], fine_[64];
    float dcMin_[3], dcStep_[3], shStep_[3];
};

}  // namespace dpl
