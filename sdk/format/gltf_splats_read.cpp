// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>

#include "sdk/core/task.h"
#include "sdk/format/gltf_model.h"
#include "sdk/format/gltf_splats.h"
#include "sdk/math/sh_rotation.h"

namespace dpl {
namespace {

constexpr double kSameBound = 0.01;  // relative; programs that quantise or round state bounds a little off
constexpr float kSameScale = 1e-4f;  // relative; the scales of a node's axes may differ by rounding

/** World placement of a node. The extension allows translation, rotation and positive scale; Doppel needs one scale for all axes. */
struct Placement {
    Quatf rotation{1, 0, 0, 0};
    Vec3f translation{0};
    float scale = 1;

    Vec3f apply(const Vec3f& p) const { return rotation * (scale * p) + translation; }
};

Result<Placement> placementOf(const GltfModel& model, uint32_t node) {
    Placement world;
    for (int32_t at = int32_t(node); at >= 0; at = model.nodes[size_t(at)].parent) {
        const GltfNode& n = model.nodes[size_t(at)];
        const float scale = n.scale.x;
        if (!(scale > 0) || std::abs(n.scale.y - scale) > kSameScale * scale || std::abs(n.scale.z - scale) > kSameScale * scale)
            return fail(Code::Unsupported,
                        "node {} ('{}') mirrors its splats or scales their axes differently; apply its transform before the export", at,
                        n.name);
        world.translation = n.rotation * (scale * world.translation) + n.translation;
        world.rotation = n.rotation * world.rotation;
        world.scale *= scale;
    }
    world.rotation = glm::normalize(world.rotation);
    if (!std::isfinite(world.scale + world.translation.x + world.translation.y + world.translation.z))
        return fail(Code::CorruptData, "the transform of node {} is not finite", node);
    return world;
}

Status checkKind(const GltfSplatting& s) {
    const auto only = [](const char* what, const std::string& found, const char* wanted) -> Status {
        if (found == wanted) return {};
        return fail(Code::Unsupported, "KHR_gaussian_splatting: '{}' is '{}', only '{}' is drawn; export the file with that", what, found,
                    wanted);
    };
    if (!s.extension.empty())
        return fail(Code::Unsupported, "KHR_gaussian_splatting: extended by {}, which is not read; export the file without it, or as .spz",
                    s.extension);
    DPL_RETURN_IF_ERROR(only("kernel", s.kernel, "ellipse"));
    DPL_RETURN_IF_ERROR(only("projection", s.projection, "perspective"));
    DPL_RETURN_IF_ERROR(only("colorSpace", s.colorSpace, "srgb_rec709_display"));
    return only("sortingMethod", s.sortingMethod, "cameraDistance");
}

struct SplatReader {
    const GltfModel& model;
    const ReadLimits& limits;
    uint64_t budget = 0;  // bytes that may still be decoded: each byte of the file about once
    SplatRemarks& remarks;
    std::vector<uint32_t> broken{};  // indices of splats that are not finite
    StaticSplatData out{};
    ShRotator rotator{};

    /** count × components floats of an attribute that must be there. */
    Result<std::vector<float>> floats(const GltfPrimitive& p, const std::string& semantic, uint32_t components, uint32_t count) {
        const auto found = p.attributes.find(semantic);
        if (found == p.attributes.end()) return fail(Code::CorruptData, "a splat primitive has no {}", semantic);
        const GltfAccessor& a = model.accessors[found->second];
        if (a.count != count) return fail(Code::CorruptData, "{} has {} entries for {} splats", semantic, a.count, count);
        const uint64_t componentBytes = a.component == GltfComponent::I8 || a.component == GltfComponent::U8     ? 1
                                        : a.component == GltfComponent::I16 || a.component == GltfComponent::U16 ? 2
                                                                                                                 : 4;
        const uint64_t bytes = componentBytes * components * count;
        if (bytes > budget)
            return fail(Code::CorruptData, "the splats of this file are used more than once (mesh instances?); write each of them out");
        budget -= bytes;
        DPL_TRY(auto values, readAnyFloats(model, found->second, components));
        noteBounds(a, semantic, values);
        return values;
    }

    /** An accessor may state the least and the largest of its values; that of POSITION must. */
    void noteBounds(const GltfAccessor& a, const std::string& semantic, const std::vector<float>& values) {
        for (uint32_t k = 0; k < a.components && !a.normalized; ++k) {
            float low = INFINITY, high = -INFINITY;
            for (size_t i = k; i < values.size(); i += a.components)
                if (std::isfinite(values[i])) low = std::min(low, values[i]), high = std::max(high, values[i]);
            if (low > high) continue;
            const double slack = kSameBound * std::max({1e-3, std::abs(double(low)), std::abs(double(high))});
            const auto off = [&](const std::vector<double>& stated, float found) {
                return k < stated.size() && !(std::abs(stated[k] - double(found)) <= slack);
            };
            if (!off(a.least, low) && !off(a.largest, high)) continue;
            remarks.notes.push_back(
                formatText("{} states values from {} to {}, its values go from {} to {}: the file is damaged or was edited", semantic,
                           k < a.least.size() ? a.least[k] : low, k < a.largest.size() ? a.largest[k] : high, low, high));
            return;
        }
    }

    static std::string coefficient(uint32_t degree, uint32_t m) {
        return "KHR_gaussian_splatting:SH_DEGREE_" + std::to_string(degree) + "_COEF_" + std::to_string(m);
    }

    static uint32_t shDegreeOf(const GltfPrimitive& p) {
        uint32_t degree = 0;
        while (degree < kMaxShDegree && p.attributes.contains(coefficient(degree + 1, 0))) ++degree;
        return degree;
    }

    Status add(const GltfPrimitive& p, const Placement& world) {
        DPL_RETURN_IF_ERROR(checkKind(*p.splatting));
        if (p.mode != 0) return fail(Code::CorruptData, "splats on a primitive of mode {}; the extension asks for points (0)", p.mode);
        if (p.dracoView >= 0) return fail(Code::Unsupported, "splats compressed by KHR_draco_mesh_compression; export them without");
        const auto place = p.attributes.find("POSITION");
        if (place == p.attributes.end()) return fail(Code::CorruptData, "a splat primitive has no POSITION");
        const uint32_t n = model.accessors[place->second].count;
        const size_t first = out.position.size();
        if (n > limits.maxSplats - first) return fail(Code::CorruptData, "more than {} splats", limits.maxSplats);
        DPL_TRY(const auto positions, floats(p, "POSITION", 3, n));
        DPL_TRY(const auto rotations, floats(p, "KHR_gaussian_splatting:ROTATION", 4, n));
        DPL_TRY(const auto scales, floats(p, "KHR_gaussian_splatting:SCALE", 3, n));
        DPL_TRY(const auto opacities, floats(p, "KHR_gaussian_splatting:OPACITY", 1, n));
        const uint32_t degree = shDegreeOf(p), shFloats = shCoefficientCount(out.shDegree) * 3;
        out.sh.resize((first + n) * shFloats, 0.0f);
        for (uint32_t k = 0, band = 0; band <= degree; ++band)
            for (uint32_t m = 0; m < 2 * band + 1; ++m, ++k) {
                DPL_RETURN_IF_ERROR(taskAt(0.5 * k / shCoefficientCount(degree)));
                DPL_TRY(const auto values, floats(p, coefficient(band, m), 3, n));
                for (uint32_t i = 0; i < n; ++i)
                    for (uint32_t c = 0; c < 3; ++c) out.sh[(first + i) * shFloats + k * 3 + c] = values[i * 3 + c];
            }
        const Mat3d turn = glm::mat3_cast(glm::dquat(world.rotation));
        const bool turned = std::abs(world.rotation.w) < 1 - 1e-7f;
        const ShTurn<double> shTurn = rotator.turn(turn, degree);
        for (uint32_t i = 0; i < n; ++i) {
            if (i % kLook == 0) {
                DPL_RETURN_IF_ERROR(taskAt(0.5 + 0.5 * i / n));
            }
            const Quatf q(rotations[i * 4 + 3], rotations[i * 4], rotations[i * 4 + 1], rotations[i * 4 + 2]);
            const Vec3f scale = world.scale * Vec3f(scales[i * 3], scales[i * 3 + 1], scales[i * 3 + 2]),
                        centre = world.apply({positions[i * 3], positions[i * 3 + 1], positions[i * 3 + 2]});
            const float length = glm::length(q), all = glm::dot(scale, Vec3f(1)) + glm::dot(centre, Vec3f(1)) + opacities[i];
            float* sh = out.sh.data() + (first + i) * shFloats;
            bool finite = std::isfinite(all) && std::isfinite(length);
            for (uint32_t k = 0; k < shCoefficientCount(degree) * 3; ++k) finite = finite && std::isfinite(sh[k]);
            if (!finite) {
                broken.push_back(uint32_t(first + i));
                out.position.emplace_back(0), out.scaleM.emplace_back(0), out.opacity.push_back(0), out.rotation.emplace_back(1, 0, 0, 0);
                continue;
            }
            if (!(length > 1e-6f)) return fail(Code::CorruptData, "splat {} has no rotation", first + i);
            if (!(glm::min(scale.x, glm::min(scale.y, scale.z)) >= 0))
                return fail(Code::CorruptData, "splat {} has a negative scale", first + i);
            if (!(opacities[i] >= 0 && opacities[i] <= 1))
                return fail(Code::CorruptData, "splat {} has an opacity of {}", first + i, opacities[i]);
            out.position.push_back(centre), out.scaleM.push_back(scale), out.opacity.push_back(opacities[i]);
            out.rotation.push_back(world.rotation * (q / length));
            if (turned) shTurn.apply(sh);
        }
        return {};
    }

    Status read() {
        std::vector<std::pair<const GltfPrimitive*, uint32_t>> found;  // primitive, node
        for (uint32_t n = 0; n < model.nodes.size(); ++n)
            if (model.nodes[n].mesh >= 0)
                for (const GltfPrimitive& p : model.meshes[size_t(model.nodes[n].mesh)].primitives)
                    if (p.splatting) found.emplace_back(&p, n);
        if (found.empty()) return fail(Code::Unsupported, "no node of this glTF shows splats (KHR_gaussian_splatting)");
        for (const auto& [primitive, node] : found) out.shDegree = std::max(out.shDegree, shDegreeOf(*primitive));
        for (const auto& [primitive, node] : found) {
            DPL_TRY(const Placement world, placementOf(model, node));
            DPL_RETURN_IF_ERROR(add(*primitive, world));
        }
        return dropBroken(out, broken, remarks);
    }
};

}  // namespace

Result<StaticSplatData> readGltfSplats(std::span<const uint8_t> bytes, const ReadLimits& limits, SplatRemarks* wanted) try {
    SplatRemarks unwanted;
    SplatRemarks& remarks = wanted ? *wanted : unwanted;
    DPL_TRY(const GltfModel model, parseGlb(bytes, limits));
    SplatReader reader{model, limits, model.bin.size(), remarks};
    DPL_RETURN_IF_ERROR(reader.read());
    remarks.axes = *axesOfLetters("RUB");
    remarks.shDegree = reader.out.shDegree;
    return std::move(reader.out);
} catch (const std::bad_alloc&) {
    return outOfMemory("read splats");
} catch (const std::exception& e) {
    return fail(Code::CorruptData, "the splats cannot be read: {}", e.what());
}

}  // namespace dpl
