// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/output/package/atlas_texels.h"

#include <algorithm>

namespace dpl {

AtlasTexels::AtlasTexels(const MeshAtlas& atlas) {
    std::vector<bool> taken(size_t(atlas.sidePx) * atlas.sidePx, false);
    for (const auto& c : atlas.corners) {
        const Vec2f first = glm::min(c[0], glm::min(c[1], c[2])), last = glm::max(c[0], glm::max(c[1], c[2]));
        const Vec2f a = c[1] - c[0], b = c[2] - c[0];
        const float doubled = a.x * b.y - a.y * b.x;
        if (doubled != 0)
            for (uint32_t y = uint32_t(std::max(0.0f, first.y - 0.5f)); y <= std::min(uint32_t(last.y), atlas.sidePx - 1); ++y)
                for (uint32_t x = uint32_t(std::max(0.0f, first.x - 0.5f)); x <= std::min(uint32_t(last.x), atlas.sidePx - 1); ++x) {
                    const Vec2f p = Vec2f(float(x) + 0.5f, float(y) + 0.5f) - c[0];
                    const Vec2f at((p.x * b.y - p.y * b.x) / doubled, (a.x * p.y - a.y * p.x) / doubled);
                    const size_t pixel = size_t(y) * atlas.sidePx + x;
                    if (at.x < 0 || at.y < 0 || at.x + at.y > 1 || taken[pixel]) continue;
                    taken[pixel] = true;
                    all.push_back({uint32_t(pixel), at});
                }
        start.push_back(uint32_t(all.size()));
    }
}

}  // namespace dpl
