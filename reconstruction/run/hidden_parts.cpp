// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/run/hidden_parts.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <span>

#include "reconstruction/subject/shape/spread_place.h"
#include "reconstruction/subject/surface/mesh_raster.h"
#include "reconstruction/subject/surface/orbit_camera.h"
#include "sdk/format/avatar_file.h"
#include "sdk/math/sh.h"

namespace dpl {
namespace {

constexpr float kSpacingM = 0.002f, kSigmaOfSpacing = 0.8f, kOpacity = 0.99f;
constexpr uint32_t kMostInTriangle = 16, kPicturePx = 512;
constexpr float kMovedM = 1e-3f;
constexpr int kYaws = 12;
constexpr double kPitchStepRad = 0.35, kPi = 3.14159265358979;

/** Triangles of another colour than the skin, which is the colour of most vertices. */
std::vector<uint32_t> colouredTriangles(const MeshData& mesh) {
    const auto asKey = [](const glm::u8vec4& c) { return uint32_t(c.x) << 16 | uint32_t(c.y) << 8 | uint32_t(c.z); };
    std::map<uint32_t, size_t> count;
    for (const glm::u8vec4& c : mesh.colours) ++count[asKey(c)];
    const auto skin = std::max_element(count.begin(), count.end(), [](const auto& a, const auto& b) { return a.second < b.second; });
    std::vector<uint32_t> out;
    for (uint32_t t = 0; t < mesh.triangles.size() && skin != count.end(); ++t) {
        const Triangle& corner = mesh.triangles[t];
        bool coloured = true;
        for (int c = 0; c < 3; ++c) coloured &= asKey(mesh.colours[corner[c]]) != skin->first;
        if (coloured) out.push_back(t);
    }
    return out;
}

struct Box {
    Vec3f low{1e9f}, high{-1e9f};
    void add(const Vec3f& p) { low = glm::min(low, p), high = glm::max(high, p); }
    bool holds(const Vec3f& p) const { return glm::all(glm::greaterThanEqual(p, low)) && glm::all(glm::lessThanEqual(p, high)); }
};

/** Around all that expressions move. */
Box faceBox(const BodyModel& body, std::span<const Vec3f> positions) {
    Box box;
    for (const ExpressionShape& shape : body.expressions)
        for (size_t v = 0; v < shape.offsetsM.size(); ++v)
            if (glm::length(shape.offsetsM[v]) >= kMovedM) box.add(positions[v]);
    return box;
}

/** F: whether a camera around the box sees the triangle. */
std::vector<uint8_t> seenFromOutside(std::span<const Vec3f> positions, std::span<const Triangle> triangles, const Box& box) {
    std::vector<uint8_t> seen(triangles.size(), 0);
    for (int yaw = 0; yaw < kYaws; ++yaw)
        for (int pitch = -1; pitch <= 1; ++pitch) {
            const Camerad camera = orbitBox(box.low, box.high, 2 * kPi * yaw / kYaws, kPitchStepRad * pitch, kPicturePx);
            for (const uint32_t t : rasteriseMesh(positions, triangles, camera).triangle)
                if (t != kNoTriangle) seen[t] = 1;
        }
    return seen;
}

}  // namespace

Result<size_t> paintHiddenParts(AvatarData& avatar, const BodyModel& body) {
    if (body.mesh.colours.size() != body.mesh.restPositions.size()) return size_t(0);
    const std::vector<uint32_t> coloured = colouredTriangles(body.mesh);
    if (coloured.empty() || body.expressions.empty()) return size_t(0);
    const auto triangles = std::span(avatar.mesh.triangles).first(body.mesh.triangles.size());
    const std::vector<Vec3f>& positions = avatar.mesh.restPositions;
    const Box box = faceBox(body, positions);
    const std::vector<uint8_t> seen = seenFromOutside(positions, triangles, box);
    std::vector<uint8_t> painted(avatar.mesh.triangles.size(), 0);
    for (const uint32_t t : coloured) {
        const Triangle& c = triangles[t];
        painted[t] = uint8_t(!seen[t] && box.holds(positions[c.x]) && box.holds(positions[c.y]) && box.holds(positions[c.z]));
    }

    const SplatData& old = avatar.splats;
    const size_t stride = shCoefficientCount(old.shDegree) * 3;
    SplatData out;
    out.shDegree = old.shDegree;
    std::vector<uint32_t> triangleOf;
    for (uint32_t t = 0; t < painted.size(); ++t) {
        for (uint32_t i = old.triangleStart[t]; i < old.triangleStart[t + 1] && !painted[t]; ++i) {
            out.uv.push_back(old.uv[i]), out.phi.push_back(old.phi[i]), out.scaleM.push_back(old.scaleM[i]);
            out.opacity.push_back(old.opacity[i]), out.flags.push_back(old.flags[i]), triangleOf.push_back(t);
            out.sh.insert(out.sh.end(), old.sh.begin() + ptrdiff_t(i * stride), old.sh.begin() + ptrdiff_t((i + 1) * stride));
        }
        if (!painted[t]) continue;
        const Triangle& corner = avatar.mesh.triangles[t];
        const auto at = [&](int c) { return avatar.mesh.restPositions[corner[c]]; };
        const auto colour = [&](int c) { return Vec3f(body.mesh.colours[corner[c]]) / 255.0f; };
        const float area = 0.5f * glm::length(glm::cross(at(1) - at(0), at(2) - at(0)));
        if (!(area > 1e-10f)) continue;
        const uint32_t count = std::clamp(uint32_t(std::lround(area / (kSpacingM * kSpacingM))), 1u, kMostInTriangle);
        for (uint32_t k = 0; k < count; ++k) {
            const Vec2f uv = count == 1 ? Vec2f(1.0f / 3) : Vec2f(spreadPlace(0.5, k));
            const Vec3f c = (1 - uv.x - uv.y) * colour(0) + uv.x * colour(1) + uv.y * colour(2);
            out.uv.push_back(uv), out.phi.push_back(0), out.scaleM.push_back(Vec2f(kSigmaOfSpacing * std::sqrt(area / float(count))));
            out.opacity.push_back(kOpacity), out.flags.push_back(kSplatSingleFace), triangleOf.push_back(t);
            out.sh.resize(out.sh.size() + stride, 0.0f);
            for (int i = 0; i < 3; ++i) out.sh[out.sh.size() - stride + size_t(i)] = (c[i] - 0.5f) / float(kShC0);
        }
    }
    avatar.splats = std::move(out);
    DPL_TRY([[maybe_unused]] const auto order, sortSplats(avatar, triangleOf));
    return size_t(std::count(painted.begin(), painted.end(), uint8_t(1)));
}

}  // namespace dpl
