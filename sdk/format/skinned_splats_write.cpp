// SPDX-License-Identifier: Apache-2.0
#include "sdk/format/skinned_splats_write.h"

#include <string>

#include "sdk/math/sh.h"

namespace dpl {
namespace {

constexpr const char* kExtension = "DPL_skinned_gaussian_splatting";

/** Values of the splats [first, end), one accessor for each property. */
Json attributesOf(GlbBuilder& glb, const AvatarData& avatar, const LayerData& layer, uint32_t first, uint32_t end) {
    const SplatData& splats = avatar.splats;
    Json attributes = Json::object();
    auto add = [&](const std::string& name, const auto& values, int component, const char* type) {
        glb.addAccessor(glb.addView(values), component, type, values.size());
        attributes[name] = glb.lastAccessor();
    };
    auto cut = [&](const auto& values) { return std::vector(values.begin() + first, values.begin() + end); };
    std::vector<uint32_t> triangles;
    for (uint32_t t = 0; t < layer.triangleCount; ++t) {
        const uint32_t parent = layer.firstTriangle + t;
        triangles.insert(triangles.end(), splats.triangleStart[parent + 1] - splats.triangleStart[parent], t);
    }
    std::vector<uint8_t> outside;
    for (uint32_t i = first; i < end; ++i) outside.push_back((splats.flags[i] & kSplatSingleFace) != 0);
    add("TRIANGLE", triangles, kGltfU32, "SCALAR");
    add("BARYCENTRIC", cut(splats.uv), kGltfF32, "VEC2");
    add("ANGLE", cut(splats.phi), kGltfF32, "SCALAR");
    add("SCALE", cut(splats.scaleM), kGltfF32, "VEC2");
    add("OPACITY", cut(splats.opacity), kGltfF32, "SCALAR");
    add("OUTSIDE", outside, kGltfU8, "SCALAR");
    const uint32_t coefficients = shCoefficientCount(splats.shDegree);
    for (uint32_t degree = 0; degree <= splats.shDegree; ++degree)
        for (uint32_t m = 0; m < 2 * degree + 1; ++m) {
            std::vector<Vec3f> values;
            for (uint32_t i = first; i < end; ++i) {
                const float* rgb = splats.sh.data() + (size_t(i) * coefficients + degree * degree + m) * 3;
                values.emplace_back(rgb[0], rgb[1], rgb[2]);
            }
            add("SH_DEGREE_" + std::to_string(degree) + "_COEF_" + std::to_string(m), values, kGltfF32, "VEC3");
        }
    return attributes;
}

}  // namespace

void addSkinnedSplats(GlbBuilder& glb, const AvatarData& avatar) {
    const std::vector<LayerData>& layers = avatar.mesh.layers;
    const std::vector<uint32_t>& start = avatar.splats.triangleStart;
    for (size_t l = 0; l < layers.size(); ++l) {
        const uint32_t first = start[layers[l].firstTriangle], end = start[layers[l].firstTriangle + layers[l].triangleCount];
        if (first == end) continue;  // an accessor cannot be empty
        glb.root["meshes"][l]["primitives"][0]["extensions"][kExtension] = {
            {"colorSpace", "srgb_rec709_display"},
            {"lowPassVariance", avatar.kappaPx2},
            {"energyPreserving", avatar.compensated},
            {"attributes", attributesOf(glb, avatar, layers[l], first, end)}};
    }
    glb.root["extensionsUsed"].push_back(kExtension);
}

}  // namespace dpl
