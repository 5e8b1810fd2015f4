// SPDX-License-Identifier: Apache-2.0
// The cameras that a texture is taken from, and what of a person deserves more of them.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "sdk/format/avatar_data.h"
#include "sdk/math/camera.h"

namespace dpl {

enum class TexturePart : uint8_t { Other, Head, LeftHand, RightHand };
constexpr size_t kTextureParts = 4;

/** The part that moves each vertex most, clothes and hair included. All are Other on a rig without humanoid bones. */
std::vector<TexturePart> partOfVertices(const AvatarData& avatar);

struct TextureView {
    Cameraf camera;
    float pixelM;  // on the surface
    float weight;  // of its picture, among others that look at a place in the same way
};

/** Cameras all around a mesh, and nearer ones around head and hands. Each picture is as large as what it shows. Those at the height of
 *  people's eyes weigh most: where splats overlap, their order depends a little on the side that they are seen from, and with it the
 *  edges of a print. positions: V, metres; part: V; pixelM: of each part, metres, above 0. Pictures have sides of at most 4096 pixels. */
std::vector<TextureView> textureViews(std::span<const Vec3f> positions, std::span<const TexturePart> part,
                                      std::span<const float, kTextureParts> pixelM);

}  // namespace dpl
