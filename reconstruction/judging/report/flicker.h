// SPDX-License-Identifier: Apache-2.0
// How much a moving avatar changes its look from one picture to the next (docs/reference/metrics.md, "Flicker").
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "sdk/math/camera.h"
#include "sdk/math/types.h"

namespace dpl {

/** A drawn picture and the surface that it shows. */
struct DrawnSurface {
    std::span<const uint8_t> rgba;     // straight alpha, 4 bytes a pixel, in the camera's size
    std::span<const Vec3f> positions;  // V, world, metres
};

/** Change of the drawn picture that the surface's motion does not explain: root mean square, over the pixels of `first` that show the
 *  surface and whose point of it `second` shows too, of the difference between the colour there and the bilinear colour where the point
 *  has moved to. 8-bit levels; alpha counts through mid grey. Pixels within 2 px of the surface's outline in either picture are left out.
 *  nullopt when fewer than 64 pixels are left. */
std::optional<double> flickerLevels(const DrawnSurface& first, const DrawnSurface& second, std::span<const Triangle> triangles,
                                    const Camerad& camera);

}  // namespace dpl
