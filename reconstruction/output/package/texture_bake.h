// SPDX-License-Identifier: Apache-2.0
// Takes the texture of an avatar's mesh from its splats, as they look from outside.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "reconstruction/input/capture/train_frame.h"
#include "reconstruction/output/package/mesh_atlas.h"
#include "reconstruction/output/package/texture_views.h"
#include "sdk/core/jobs.h"
#include "sdk/core/result.h"
#include "sdk/format/avatar_data.h"
#include "sdk/math/camera.h"

namespace dpl {

/** Draws the avatar at rest from every camera, and gives each texel of the atlas the mean colour of the pictures that see it. Those that
 *  look straight at it weigh most. A picture sees a texel that faces it and is not hidden; texels beside the outline of something well
 *  before them, where its splats reach over them, take that picture only if there is no other. Texels that no picture sees continue the
 *  surface around them, and what no chart covers the nearest chart. photographs: their detail is added (texture_photographs.h); empty: of
 *  the splats alone.
 *  positions: V, metres, of the avatar at rest as it is drawn; the atlas is of its triangles. Returns sidePx² · 3 bytes, sRGB, top row
 *  first, which do not depend on the number of threads. taskAt hears each camera. Memory: about 50 bytes a texel, with
 *  photographs 60. OutOfMemory: there is
 *  less. */
Result<std::vector<uint8_t>> bakeTexture(const AvatarData& avatar, std::span<const Vec3f> positions, const MeshAtlas& atlas,
                                         std::span<const TextureView> views, std::span<const TrainFrame> photographs, Jobs& jobs);

/** Which triangles a camera sees, or whose neighbours one sees: the rest lies under clothes. */
std::vector<bool> seenTriangles(std::span<const Vec3f> positions, std::span<const Triangle> triangles, std::span<const TextureView> views);

}  // namespace dpl
