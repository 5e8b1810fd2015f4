// SPDX-License-Identifier: Apache-2.0
// Writes the splats of an avatar as the glTF extension DPL_skinned_gaussian_splatting (docs/formats/skinned-splats.md), for engines that
// draw splats and skin meshes themselves. Internal. Only .cpp files include it, because the JSON header is slow to compile.
#pragma once

#include "sdk/format/avatar_data.h"
#include "sdk/format/glb_builder.h"

namespace dpl {

/** Adds the extension to the primitive of each layer that has splats. The avatar has passed checkAvatar(). After addLayers(). */
void addSkinnedSplats(GlbBuilder& glb, const AvatarData& avatar);

}  // namespace dpl
