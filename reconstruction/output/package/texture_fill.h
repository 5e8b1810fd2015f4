// SPDX-License-Identifier: Apache-2.0
// Continues the colours of a texture where nothing was seen: over the surface, and between the charts, so that neither bilinear filters nor
// mipmaps mix foreign colours into a chart.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "sdk/format/avatar_data.h"

namespace dpl {

/** Colours of vertices, 0 to 1. seen: V, colour times weight, weight; vertices of weight 0 take the mean of their neighbours, ring by ring,
 *  and pieces that nothing was seen of the mesh's own vertex colours. */
std::vector<Vec3f> spreadColours(std::span<const Vec4f> seen, const MeshData& mesh);

class TextureFill {
public:
    explicit TextureFill(uint32_t sidePx) : sidePx_(sidePx), colour_(size_t(sidePx) * sidePx, Vec4f(0)) {}
    /** colour: 0 to 1. */
    void set(uint32_t pixel, const Vec3f& colour) { colour_[pixel] = Vec4f(colour, 1); }
    /** The picture, 3 bytes a pixel. Pixels that were not set take the mean of their neighbours, ring by ring, `rings` times; beyond that
     *  of an ever coarser picture. */
    std::vector<uint8_t> finish(uint32_t rings);

private:
    uint32_t sidePx_;            // a power of two
    std::vector<Vec4f> colour_;  // and whether it is known: 1 or 0
};

}  // namespace dpl
