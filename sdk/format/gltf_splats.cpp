// SPDX-License-Identifier: Apache-2.0
#include "sdk/format/gltf_splats.h"

#include <cmath>

#include "sdk/format/glb_builder.h"
#include "sdk/format/vertex_colour.h"
#include "sdk/math/sh.h"

namespace dpl {
namespace {

constexpr const char* kExtension = "KHR_gaussian_splatting";

Status checkSplats(const StaticSplatData& s) {
    const size_t n = s.position.size();
    if (n == 0) return fail(Code::InvalidArgument, "there are no splats to write; a glTF accessor cannot be empty");
    if (s.shDegree > kMaxShDegree || s.rotation.size() != n || s.scaleM.size() != n || s.opacity.size() != n ||
        s.sh.size() != n * shCoefficientCount(s.shDegree) * 3)
        return fail(Code::InvalidArgument, "the arrays of {} splats differ in length", n);
    for (size_t i = 0; i < n; ++i) {
        const Vec3f &p = s.position[i], &scale = s.scaleM[i];
        const float all = p.x + p.y + p.z + scale.x + scale.y + scale.z + s.opacity[i], length = glm::length(s.rotation[i]);
        if (!std::isfinite(all) || !(length > 1e-6f) || !std::isfinite(length) || scale.x < 0 || scale.y < 0 || scale.z < 0)
            return fail(Code::InvalidArgument, "splat {} has a number that is not finite, a zero rotation or a negative scale", i);
    }
    for (float v : s.sh)
        if (!std::isfinite(v)) return fail(Code::InvalidArgument, "an SH value is not finite");
    return {};
}

}  // namespace

Result<std::vector<uint8_t>> writeGltfSplats(const StaticSplatData& s) try {
    DPL_RETURN_IF_ERROR(checkSplats(s));
    const size_t n = s.position.size();
    const uint32_t coefficients = shCoefficientCount(s.shDegree);
    GlbBuilder glb;
    Json attributes = Json::object();
    auto add = [&](const std::string& semantic, const auto& values, int component, const char* type, bool normalized = false) -> Json& {
        Json& accessor = glb.addAccessor(glb.addView(values, kGltfVertices), component, type, n, normalized);
        attributes[semantic] = glb.lastAccessor();
        return accessor;
    };
    Vec3f low = s.position[0], high = low;
    for (const Vec3f& p : s.position) low = glm::min(low, p), high = glm::max(high, p);
    Json& positions = add("POSITION", s.position, kGltfF32, "VEC3");
    positions["min"] = {low.x, low.y, low.z}, positions["max"] = {high.x, high.y, high.z};

    std::vector<glm::u16vec4> colours(n);
    std::vector<Vec4f> rotations(n);
    std::vector<float> opacities(n);
    for (size_t i = 0; i < n; ++i) {
        const float* dc = s.sh.data() + i * coefficients * 3;
        for (int c = 0; c < 3; ++c) colours[i][c] = linearFromSrgb8(uint8_t(std::lround(255 * std::clamp(0.5 + kShC0 * dc[c], 0.0, 1.0))));
        opacities[i] = std::clamp(s.opacity[i], 0.0f, 1.0f);
        colours[i].a = uint16_t(std::lround(opacities[i] * 65535));
        const Quatf q = glm::normalize(s.rotation[i]);
        rotations[i] = {q.x, q.y, q.z, q.w};
    }
    add("COLOR_0", colours, kGltfU16, "VEC4", true);
    const std::string prefix = std::string(kExtension) + ":";
    add(prefix + "ROTATION", rotations, kGltfF32, "VEC4");
    add(prefix + "SCALE", s.scaleM, kGltfF32, "VEC3");
    add(prefix + "OPACITY", opacities, kGltfF32, "SCALAR");
    for (uint32_t degree = 0; degree <= s.shDegree; ++degree)
        for (uint32_t m = 0; m < 2 * degree + 1; ++m) {
            std::vector<Vec3f> values(n);
            const uint32_t k = degree * degree + m;
            for (size_t i = 0; i < n; ++i)
                values[i] = {s.sh[(i * coefficients + k) * 3], s.sh[(i * coefficients + k) * 3 + 1], s.sh[(i * coefficients + k) * 3 + 2]};
            add(prefix + "SH_DEGREE_" + std::to_string(degree) + "_COEF_" + std::to_string(m), values, kGltfF32, "VEC3");
        }
    Json primitive = {{"mode", 0}, {"attributes", std::move(attributes)}};
    primitive["extensions"][kExtension] = {
        {"kernel", "ellipse"}, {"colorSpace", "srgb_rec709_display"}, {"projection", "perspective"}, {"sortingMethod", "cameraDistance"}};
    glb.root["asset"] = {{"version", "2.0"}, {"generator", "Doppel"}};
    glb.root["extensionsUsed"] = Json::array({kExtension});
    glb.root["meshes"] = Json::array({{{"name", "splats"}, {"primitives", Json::array({std::move(primitive)})}}});
    glb.root["nodes"] = Json::array({{{"name", "splats"}, {"mesh", 0}}});
    glb.root["scenes"] = Json::array({{{"nodes", Json::array({0})}}});
    glb.root["scene"] = 0;
    if (glb.bin().size() > (1ull << 31)) return fail(Code::Unsupported, "{} splats make a .glb above 2 GiB; export a PLY", n);
    return glb.finish([](std::string&, std::span<const uint8_t>) {});
} catch (const std::bad_alloc&) {
    return outOfMemory("write splats");
} catch (const std::exception& e) {
    return fail(Code::Internal, "the splats could not be written: {}", e.what());
}

}  // namespace dpl
