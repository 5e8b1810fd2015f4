// SPDX-License-Identifier: Apache-2.0
// What the calls about the posed surface of an avatar keep. context->mutex guards it.
#pragma once

#include "sdk/api/api_state.h"
#include "sdk/surface/contact_shadow.h"
#include "sdk/surface/posed_surface.h"
#include "sdk/surface/ray_caster.h"

namespace dpl::api {

struct PosedOutput;

struct Surface {
    ClothLimits cloth;
    PosedSurface posed;
    ContactShadowCaster caster;
    ContactShadow shadow;
    std::optional<RayCaster> rays;  // made by the first pick
    uint64_t raysVersion = 0;       // of `posed`, that the rays follow
    std::vector<uint8_t> leftOut;   // one a triangle: whether its layer is hidden; empty: none is
    // Of doppel_posed.h; null before its first call. Shared, so that a program without these calls links no code of it, not even a
    // destructor.
    std::shared_ptr<PosedOutput> output;
};

/** Made by the first call. */
Surface& surfaceOf(Avatar& avatar);

/** The vertices in the current pose, in avatar space. */
std::span<const Vec3f> verticesOf(Avatar& avatar);

}  // namespace dpl::api
