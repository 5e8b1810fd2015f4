// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/output/package/texture_fill.h"

#include <algorithm>
#include <cmath>

#include "reconstruction/subject/shape/implicit_mesh.h"

namespace dpl {

std::vector<Vec3f> spreadColours(std::span<const Vec4f> seen, const MeshData& mesh) {
    std::vector<Vec3f> out(seen.size());
    std::vector<bool> known(seen.size());
    std::vector<uint32_t> ring;
    for (uint32_t v = 0; v < seen.size(); ++v) {
        known[v] = seen[v].w > 0;
        const glm::u8vec4& own = mesh.colours[v];
        out[v] = known[v] ? Vec3f(seen[v]) / seen[v].w : Vec3f(own.r, own.g, own.b) / 255.0f;
        if (known[v]) ring.push_back(v);
    }
    const auto neighbours = vertexNeighbours(seen.size(), mesh.triangles);
    while (!ring.empty()) {
        std::vector<uint32_t> next;
        for (const uint32_t v : ring)
            for (const uint32_t n : neighbours[v])
                if (!known[n]) next.push_back(n);
        std::sort(next.begin(), next.end());
        next.erase(std::unique(next.begin(), next.end()), next.end());
        for (const uint32_t v : next) {
            Vec3f sum(0);
            float count = 0;
            for (const uint32_t n : neighbours[v])
                if (known[n]) sum += out[n], ++count;
            out[v] = sum / count;
        }
        for (const uint32_t v : next) known[v] = true;
        ring = std::move(next);
    }
    return out;
}

std::vector<uint8_t> TextureFill::finish(uint32_t rings) {
    const int side = int(sidePx_);
    std::vector<uint32_t> next;
    for (uint32_t ring = 0; ring < rings; ++ring) {
        next.clear();
        std::vector<Vec4f> found;
        for (int y = 0; y < side; ++y)
            for (int x = 0; x < side; ++x) {
                if (colour_[size_t(y) * side + x].w > 0) continue;
                Vec4f sum(0);
                for (int dy = std::max(0, y - 1); dy <= std::min(side - 1, y + 1); ++dy)
                    for (int dx = std::max(0, x - 1); dx <= std::min(side - 1, x + 1); ++dx) sum += colour_[size_t(dy) * side + dx];
                if (sum.w > 0) next.push_back(uint32_t(y * side + x)), found.push_back(Vec4f(Vec3f(sum) / sum.w, 1));
            }
        for (size_t i = 0; i < next.size(); ++i) colour_[next[i]] = found[i];
    }
    // Pull: each level is the mean of what is known in the level below. Push: unknown pixels take the colour of the level above.
    std::vector<std::vector<Vec4f>> levels;
    const std::vector<Vec4f>* below = &colour_;
    for (uint32_t size = sidePx_ / 2; size > 0; size /= 2) {
        std::vector<Vec4f> level(size_t(size) * size, Vec4f(0));
        for (uint32_t y = 0; y < size; ++y)
            for (uint32_t x = 0; x < size; ++x) {
                Vec4f sum(0);
                for (uint32_t k = 0; k < 4; ++k) sum += (*below)[size_t(2 * y + k / 2) * 2 * size + 2 * x + k % 2];
                if (sum.w > 0) level[size_t(y) * size + x] = Vec4f(Vec3f(sum) / sum.w, 1);
            }
        levels.push_back(std::move(level));
        below = &levels.back();
    }
    for (size_t l = levels.size(); l-- > 0;) {
        std::vector<Vec4f>& fine = l > 0 ? levels[l - 1] : colour_;
        const uint32_t size = sidePx_ >> l;
        for (uint32_t y = 0; y < size; ++y)
            for (uint32_t x = 0; x < size; ++x)
                if (Vec4f& c = fine[size_t(y) * size + x]; !(c.w > 0)) c = levels[l][size_t(y / 2) * (size / 2) + x / 2];
    }
    std::vector<uint8_t> rgb;
    rgb.reserve(colour_.size() * 3);
    for (const Vec4f& c : colour_)
        for (int k = 0; k < 3; ++k) rgb.push_back(uint8_t(std::lround(255 * std::clamp(c[k], 0.0f, 1.0f))));
    return rgb;
}

}  // namespace dpl
