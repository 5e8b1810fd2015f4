// SPDX-License-Identifier: Apache-2.0
// Cuts triangles off a layer, as shears would.
#pragma once

#include <functional>
#include <vector>

#include "reconstruction/output/dress/layer_part.h"

namespace dpl::test {

/** Keeps the triangles of the layer `name` whose first corner passes, with their splats. */
inline void cutLayer(const std::string& name, const std::function<bool(const Vec3f&)>& keep, AvatarData& avatar) {
    std::vector<LayerPart> parts;
    for (size_t i = 0; i < avatar.mesh.layers.size(); ++i) parts.push_back(takeLayer(avatar, i));
    for (LayerPart& part : parts) {
        if (part.name != name) continue;
        const LayerPart whole = part;
        const SplatData& all = whole.splats;
        const size_t floats = all.count() > 0 ? all.sh.size() / all.count() : 0;
        SurfaceMesh kept{whole.mesh.restPositions, {}};
        part.splats = SplatData{};
        part.splats.shDegree = all.shDegree, part.splats.triangleStart = {0};
        for (size_t t = 0; t < whole.mesh.triangles.size(); ++t) {
            const Triangle& c = whole.mesh.triangles[t];
            if (!keep(kept.positions[c.x])) continue;
            kept.triangles.push_back(c);
            for (uint32_t i = all.triangleStart[t]; i < all.triangleStart[t + 1]; ++i) {
                part.splats.uv.push_back(all.uv[i]), part.splats.phi.push_back(all.phi[i]), part.splats.scaleM.push_back(all.scaleM[i]);
                part.splats.opacity.push_back(all.opacity[i]), part.splats.flags.push_back(all.flags[i]);
                const auto sh = all.sh.begin() + long(i * floats);
                part.splats.sh.insert(part.splats.sh.end(), sh, sh + long(floats));
            }
            part.splats.triangleStart.push_back(part.splats.count());
        }
        std::vector<uint32_t> old;
        const SurfaceMesh used = withoutUnused(kept, &old);
        part.mesh.triangles = used.triangles, part.mesh.restPositions = used.positions;
        part.mesh.colours.clear(), part.mesh.jointIndices.clear(), part.mesh.jointWeights.clear();
        part.nodeIndices.clear(), part.nodeWeights.clear();
        for (const uint32_t v : old) {
            part.mesh.colours.push_back(whole.mesh.colours[v]);
            part.mesh.jointIndices.push_back(whole.mesh.jointIndices[v]), part.mesh.jointWeights.push_back(whole.mesh.jointWeights[v]);
            if (whole.nodeIndices.empty()) continue;
            part.nodeIndices.push_back(whole.nodeIndices[v]), part.nodeWeights.push_back(whole.nodeWeights[v]);
        }
    }
    joinLayers(parts, avatar);
}

}  // namespace dpl::test
