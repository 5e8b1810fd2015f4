// SPDX-License-Identifier: Apache-2.0
// The body map as an avatar file carries it: a few numbers for each joint and side (docs/reference/body-map.md).
#pragma once

#include <span>
#include <vector>

#include "reconstruction/judging/coach/body_map.h"

namespace dpl {

/** Medians by area over the triangles that each joint moves most and that point to each side at rest. viewable: F, FilmAgain::viewable;
 *  triangles that no camera could see do not count. A side of which pictures show less than half is not seen. */
CaptureMapData captureMapOf(const MeshData& surface, size_t jointCount, std::span<const SeenTriangle> map,
                            std::span<const uint8_t> viewable);

}  // namespace dpl
