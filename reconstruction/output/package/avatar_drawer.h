// SPDX-License-Identifier: Apache-2.0
// Draws an avatar of decoded splats by the CPU engine, for tools that ask what each splat adds to a picture.
#pragma once

#include <vector>

#include "sdk/avatar/posed_mesh.h"
#include "sdk/avatar/rig.h"
#include "sdk/core/jobs.h"
#include "sdk/format/avatar_data.h"
#include "sdk/splat/splat_engine.h"

namespace dpl {

/** Poses and projects an avatar, reusing its buffers between pictures. The avatar must outlive it. */
class AvatarDrawer {
public:
    /** cloth: null, or of the same avatar. */
    AvatarDrawer(const AvatarData& avatar, Jobs& jobs, const ClothLimits* cloth = nullptr);
    SplatEngine& project(const Pose& pose, const Cameraf& camera);
    /** Vertices of the last pose. */
    std::span<const Vec3f> positions() const { return mesh_.positions(); }

private:
    const AvatarData& avatar_;
    Jobs& jobs_;
    const ClothLimits* cloth_;
    SplatEngine engine_;
    std::vector<RestTriangle<float>> rest_;
    std::vector<Vec3f> normals_;
    std::vector<uint32_t> triangle_;
    PosedMesh mesh_;
};

/** Adds to `sum`, one a splat, what each splat contributes to the projected picture: Σ α·T (alpha times transmittance) over its pixels. The
 *  order is fixed (tiles, pixels, depth), so sums are reproducible. only: one a pixel; those of 0 do not count; empty: all do. */
void addContributions(const SplatEngine& engine, const Cameraf& camera, std::vector<double>& sum, std::span<const uint8_t> only = {});

}  // namespace dpl
