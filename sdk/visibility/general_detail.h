// SPDX-License-Identifier: Apache-2.0
// Level of detail of general splats in a frame (docs/reference/level-of-detail.md). Each group has its own pixel size.
#pragma once

#include <span>
#include <vector>

#include "sdk/format/splat_detail.h"
#include "sdk/math/camera.h"
#include "sdk/math/detail.h"

namespace dpl {

/** Constants of general splats for level of detail, made at load, and the views of the current frame. One thread at a time. */
class GeneralDetailSubject {
public:
    GeneralDetailSubject() = default;
    /** groups: measureGroups. */
    GeneralDetailSubject(std::vector<GeneralGroup> groups, uint32_t splatCount);

    std::span<const GeneralGroup> groups() const { return groups_; }
    uint32_t splatCount() const { return splatCount_; }

    /** Sets the views of the frame, one or two, in the splats' own space and metres; the functions below refer to them. scale: metres of
     * the world that one of these metres takes. Costs a few dot products for each group and view. Allocates nothing. */
    void look(std::span<const Cameraf> views, float scale = 1);
    /** The detail with which `perPixel` splats a pixel are drawn. */
    GeneralDetail detail(float perPixel) const;
    /** Upper bound of the splats drawn; continuous in perPixel and the views, and rises with perPixel. Splats behind the cameras count only
     * when perPixel is infinite. */
    double drawnAtMost(double perPixel) const;
    /** drawnAtMost as a share of the splats that are not behind the cameras. */
    float drawnShare(double perPixel) const;

private:
    struct Sums {
        double groups = 0, density = 0;  // over the bins before this one: number of groups, and Σ groups · pixels a splat stands for
    };
    std::vector<GeneralGroup> groups_;
    std::vector<Sums> sums_;  // by bins of areaM2 / pixelM²
    GeneralDetail seen_;      // of the last look
    uint32_t splatCount_ = 0;
};

}  // namespace dpl
