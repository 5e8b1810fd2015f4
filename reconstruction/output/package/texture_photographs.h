// SPDX-License-Identifier: Apache-2.0
// Detail of photographs for a texture that was taken from splats.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "reconstruction/input/capture/train_frame.h"
#include "reconstruction/output/package/atlas_texels.h"
#include "sdk/core/jobs.h"
#include "sdk/core/result.h"
#include "sdk/format/avatar_data.h"

namespace dpl {

/** Adds to the colours of texels what photographs show of them and the texture does not.
 *
 *  The textured mesh is drawn in the pose and from the camera of each photograph. Of the difference only what is finer than a few pixels
 *  counts: light, exposure and the shade of a pose are coarser, so they leave no seams. A texel takes a robust mean over the photographs
 *  that see it best: near, straight, sharp, inside the mask by a margin, and nothing before it. Where none sees it, it stays.
 *
 *  texels: of the atlas, which is of the avatar's triangles. texture: sidePx² · 3 bytes, of these colours. photographs: cameras in metres.
 *  colours: one a texel, 0 to 1, changed in place; the result does not depend on the number of threads. taskAt hears each photograph.
 *  Memory: 40 bytes a texel. Errors are those of reading a picture. Throws std::bad_alloc. */
Status addPhotographs(const AvatarData& avatar, const MeshAtlas& atlas, const AtlasTexels& texels, std::span<const uint8_t> texture,
                      std::span<const TrainFrame> photographs, std::span<Vec3f> colours, Jobs& jobs);

}  // namespace dpl
