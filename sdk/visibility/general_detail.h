// SPDX-License-Identifier: Apache-2.0
// Level of detail of general splats in a frame (docs/adr/0010): every half-chunk has its own pixel, and how many splats that leaves.
#pragma once

#include <span>
#include <vector>

#include "sdk/format/splat_detail.h"
#include "sdk/math/camera.h"
#include "sdk/math/detail.h"

namespace dpl {

/** What general splats are to level of detail, made when they are loaded. One thread at a time. */
class GeneralDetailSubject {
public:
    GeneralDetailSubject() = default;
    /** groups: measureGroups. */
    GeneralDetailSubject(std::vector<GeneralGroup> groups, uint32_t splatCount);

    std::span<const GeneralGroup> groups() const { return groups_; }
    uint32_t splatCount() const { return splatCount_; }

    /** From these views; up to two. Allocates nothing; work: two dot products a half-chunk and view. */
    void look(std::span<const Cameraf> views);
    /** What `perPixel` splats a pixel are from there. */
    GeneralDetail detail(float perPixel) const;
    /** Splats that are drawn at most then; continuous and rising with it, and without steps while the views move. A number below infinity:
     * without those behind the cameras. */
    double drawnAtMost(double perPixel) const;
    /** Of the splats that are not behind the cameras. */
    float drawnShare(double perPixel) const;

private:
    struct Sums {
        double groups = 0, density = 0;  // of the bins before this one
    };
    std::vector<GeneralGroup> groups_;
    std::vector<Sums> sums_;  // by bins of areaM2 / pixelM²
    GeneralDetail seen_;      // of the last look
    uint32_t splatCount_ = 0;
};

}  // namespace dpl
