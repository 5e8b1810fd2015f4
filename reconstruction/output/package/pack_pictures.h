// SPDX-License-Identifier: Apache-2.0
// The pictures that packing compares: one avatar in seeded random views and poses, drawn by the CPU engine.
#pragma once

#include <vector>

#include "sdk/avatar/rig.h"
#include "sdk/core/jobs.h"
#include "sdk/format/avatar_data.h"
#include "sdk/math/camera.h"

namespace dpl {

/** Error of a packed avatar's pictures against the unpacked avatar's, summed over all pictures. Colour is composited over mid grey; peak 1.
 */
struct PackError {
    double squares = 0, values = 0;  // sum of squares and number of channel values, over pixels that either avatar covers
    double allValues = 0;            // number of channel values with background
    double psnrDb() const;           // over covered pixels; infinite for equal pictures
    double wholePsnrDb() const;      // over all pixels
};

class PackPictures {
public:
    /** Draws `count` views of `avatar`, which need not outlive the call. Any azimuth, elevation from −20 to 40 degrees; every fourth view
     * shows only the top third. If the avatar has clips, half the poses come from them; in all others every joint but the root turns by up
     * to 30 degrees. `jobs` must outlive the object. */
    PackPictures(const AvatarData& avatar, uint32_t count, uint64_t seed, Jobs& jobs);

    /** Draws `packed` in the same views. It must have the same joints and mesh; splats and correctives may differ. */
    PackError compare(const AvatarData& packed) const;

    /** Per splat: its contribution Σ α·T (alpha times transmittance) over all pictures and pixels. */
    std::vector<float> importance(const AvatarData& avatar) const;

private:
    struct Shot {
        Pose pose;
        Cameraf camera;
        std::vector<float> rgb, alpha;  // premultiplied
    };
    std::vector<Shot> shots_;
    Jobs& jobs_;
};

}  // namespace dpl
