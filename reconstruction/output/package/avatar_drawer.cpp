// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/output/package/avatar_drawer.h"

#include <algorithm>
#include <cmath>

#include "sdk/avatar/scene_light.h"

namespace dpl {

AvatarDrawer::AvatarDrawer(const AvatarData& avatar, Jobs& jobs, const ClothLimits* cloth)
    : avatar_(avatar),
      jobs_(jobs),
      cloth_(cloth),
      engine_(jobs),
      rest_(restTriangles(avatar.mesh)),
      normals_(restVertexNormals(avatar.mesh)),
      triangle_(avatar.splats.count()) {
    const auto& start = avatar.splats.triangleStart;
    for (uint32_t t = 0; t + 1 < start.size(); ++t) std::fill(triangle_.begin() + start[t], triangle_.begin() + start[t + 1], t);
}

SplatEngine& AvatarDrawer::project(const Pose& pose, const Cameraf& camera) {
    const SplatData& s = avatar_.splats;
    mesh_.pose({avatar_.joints, avatar_.mesh, avatar_.correctives, {rest_}, &avatar_.light, normals_, cloth_}, pose, jobs_);
    engine_.project(BoundSplatView{triangle_, s.uv, s.phi, s.scaleM, s.opacity, s.flags, s.shDegree, s.sh}, mesh_.frames(), camera,
                    avatar_.kappaPx2, avatar_.compensated);
    engine_.bin();
    return engine_;
}

void addContributions(const SplatEngine& engine, const Cameraf& camera, std::vector<double>& sum, std::span<const uint8_t> only) {
    const TileLists& tiles = engine.tiles();
    const auto projected = engine.projected();
    for (uint32_t tile = 0; tile < tiles.columns * tiles.rows; ++tile) {
        const uint32_t x0 = tile % tiles.columns * kTileSizePx, y0 = tile / tiles.columns * kTileSizePx;
        for (uint32_t y = y0; y < std::min(y0 + kTileSizePx, camera.heightPx); ++y)
            for (uint32_t x = x0; x < std::min(x0 + kTileSizePx, camera.widthPx); ++x) {
                if (!only.empty() && !only[size_t(y) * camera.widthPx + x]) continue;
                float left = 1;
                for (uint32_t e = tiles.offset[tile]; e < tiles.offset[tile + 1] && left > 1e-4f; ++e) {
                    const ProjectedSplat& s = projected[tiles.entries[e]];
                    const float dx = float(x) + 0.5f - s.x, dy = float(y) + 0.5f - s.y;
                    if (std::abs(dx) > s.radiusX || std::abs(dy) > s.radiusY) continue;
                    const float alpha = std::min(
                        float(kMaxAlpha), s.opacity * std::exp(-0.5f * (s.conicA * dx * dx + s.conicC * dy * dy) - s.conicB * dx * dy));
                    if (alpha < float(kMinAlpha)) continue;
                    sum[tiles.entries[e]] += alpha * left;
                    left *= 1 - alpha;
                }
            }
    }
}

}  // namespace dpl
