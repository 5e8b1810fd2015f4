// SPDX-License-Identifier: Apache-2.0
// The pictures by which packing is judged: one avatar from seeded random views and poses, drawn by the CPU engine.
#pragma once

#include <vector>

#include "sdk/avatar/rig.h"
#include "sdk/core/jobs.h"
#include "sdk/format/avatar_data.h"
#include "sdk/math/camera.h"

namespace dpl {

/** How far a packed avatar's pictures are from the unpacked one's: colour over mid grey, peak 1, all pictures together. */
struct PackError {
    double squares = 0, values = 0;  // of the pixels that either of the two covers
    double allValues = 0;            // background too
    double psnrDb() const;           // of the covered pixels; infinite for equal pictures
    double wholePsnrDb() const;
};

class PackPictures {
public:
    /** `count` views of `avatar`, which is drawn once and need not live on: azimuth all around, 20 degrees below to 40 above, every fourth
     *  close to head and shoulders. Half the poses from the avatar's clips, if it has any; else every joint turned by up to 30 degrees. */
    PackPictures(const AvatarData& avatar, uint32_t count, uint64_t seed, Jobs& jobs);

    /** Same joints and mesh, whatever splats and correctives. */
    PackError compare(const AvatarData& packed) const;

    /** Σ α·T over all pictures and pixels, one a splat: what the picture would miss of it. */
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
