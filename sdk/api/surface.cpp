// SPDX-License-Identifier: Apache-2.0
// What programs ask of the posed surface of an avatar.
#include "sdk/api/surface.h"

#include <algorithm>
#include <cmath>

#include "sdk/api/scene.h"
#include "sdk/draw/check_draw.h"
#include "sdk/surface/layer_cover.h"
#include "sdk/visibility/components.h"

using namespace dpl;
using namespace dpl::api;

Surface& dpl::api::surfaceOf(Avatar& avatar) {
    if (avatar.surface) return *avatar.surface;
    avatar.surface = std::make_unique<Surface>();
    avatar.surface->cloth = ClothLimits(avatar.data->joints, avatar.data->mesh, avatar.data->correctives);
    return *avatar.surface;
}

std::span<const Vec3f> dpl::api::verticesOf(Avatar& avatar) {
    const AvatarData& data = *avatar.data;
    Surface& surface = surfaceOf(avatar);
    return surface.posed.in({data.joints, data.mesh, data.correctives, {}, nullptr, {}, &surface.cloth, &data.expressions},
                            avatar.drawnPose());
}

namespace {

void write(float (&to)[3], const Vec3d& from) {
    for (int axis = 0; axis < 3; ++axis) to[axis] = float(from[axis]);
}

/** The floor in avatar space: the avatar's own, or the level plane at a height of the world. */
ShadowFloor floorOf(const Placement& placed, const float* floorM) {
    if (floorM == nullptr) return {};
    return {placed.directionToOwn({0, 1, 0}), (double(*floorM) - placed.translation.y) / placed.scale};
}

}  // namespace

extern "C" DplResult dplGetContactShadow(DplAvatar avatar, const float* floorM, uint8_t* alpha, size_t alphaBytes,
                                         DplContactShadow* shadow) {
    return guarded("dplGetContactShadow", [&]() -> Status {
        static_assert(DPL_CONTACT_SHADOW_PX == kShadowSidePx);
        if (alpha == nullptr) return fail(Code::InvalidArgument, "alpha is NULL");
        if (floorM != nullptr && !(std::abs(*floorM) <= kMaxDistanceM))
            return fail(Code::InvalidArgument, "the floor is at {} m; up to {} m above or below the origin is possible", *floorM,
                        kMaxDistanceM);
        DPL_TRY(const auto found, avatarOf(avatar));
        DPL_RETURN_IF_ERROR(checkPosable(*found));
        std::lock_guard lock(found->context->mutex);
        const std::span<const Vec3f> vertices = verticesOf(*found);
        Surface& s = *found->surface;
        if (alphaBytes < s.shadow.alpha.size())
            return fail(Code::InvalidArgument, "alpha has room for {} bytes; {} are needed", alphaBytes, s.shadow.alpha.size());
        const Placement& placed = found->placement;
        s.caster.cast(vertices, found->data->mesh.triangles, floorOf(placed, floorM), Vec3d(rootPosition(found->data->joints, found->pose)),
                      s.shadow, s.leftOut);
        DplContactShadow out{};
        out.darkest = s.shadow.darkest;
        write(out.corner, placed.toWorld(s.shadow.corner));
        write(out.across, placed.rotation * (placed.scale * s.shadow.across));
        write(out.along, placed.rotation * (placed.scale * s.shadow.along));
        DPL_RETURN_IF_ERROR(writeStruct(shadow, out, "shadow"));
        std::copy(s.shadow.alpha.begin(), s.shadow.alpha.end(), alpha);
        return {};
    });
}

namespace {

Result<const LayerData*> layerOf(const Avatar& avatar, uint32_t layer) {
    const std::vector<LayerData>& layers = avatar.data->mesh.layers;
    if (layer < layers.size()) return &layers[layer];
    return fail(Code::NotFound, "there is no layer {}; the avatar has {}", layer, layers.size());
}

/** Whether pictures may leave out a layer, whose context is locked. */
Status checkHidable(const Avatar& avatar, uint32_t layer, std::span<const uint8_t> leftOut) {
    const MeshData& mesh = avatar.data->mesh;
    const LayerData& asked = mesh.layers[layer];
    if (asked.role == "body")
        return fail(Code::Unsupported, "'{}' is the body; what lies over it may be hidden, where splats lie below", asked.name);
    const ComponentMap map = componentsOf(*avatar.data);
    for (size_t l = 0; l < mesh.layers.size(); ++l)
        if (l != layer && (layer >= 64 || (map.ofLayer[l] & map.ofLayer[layer]) != 0))
            return fail(Code::Unsupported, "'{}' is one of so many layers ({}) that it cannot be hidden alone", asked.name,
                        mesh.layers.size());
    const LayerCover cover = coverBelow(mesh, layer, avatar.carriesSplats, leftOut);
    if (cover.shownM2 == 0) return fail(Code::Unsupported, "nothing lies below '{}', so it cannot be hidden", asked.name);
    if (cover.bareM2 > kMostBare * cover.shownM2)
        return fail(Code::Unsupported,
                    "'{}' cannot be hidden: {} % of what lies below it carries no splats, because no picture of the scan shows it",
                    asked.name, int(std::lround(100 * cover.bareM2 / cover.shownM2)));
    return {};
}

/** One a triangle: whether its layer is hidden; empty: none is. */
std::vector<uint8_t> trianglesOf(const MeshData& mesh, uint64_t hiddenLayers) {
    std::vector<uint8_t> leftOut(hiddenLayers == 0 ? 0 : mesh.triangles.size(), 0);
    for (size_t l = 0; l < std::min<size_t>(mesh.layers.size(), 64); ++l)
        if (hiddenLayers >> l & 1)
            std::fill_n(leftOut.begin() + std::ptrdiff_t(mesh.layers[l].firstTriangle), mesh.layers[l].triangleCount, uint8_t(1));
    return leftOut;
}

uint32_t heaviestJoint(const MeshData& mesh, const RayHit& hit) {
    uint32_t joints[12], most = 0;
    double weights[12];
    size_t count = 0;
    for (int corner = 0; corner < 3; ++corner)
        for (int k = 0; k < 4; ++k) {
            const uint32_t v = mesh.triangles[hit.triangle][corner], joint = mesh.jointIndices[v][k];
            const double weight = hit.shares[corner] * mesh.jointWeights[v][k];
            const size_t at = size_t(std::find(joints, joints + count, joint) - joints);
            if (at == count) joints[count] = joint, weights[count++] = 0;
            weights[at] += weight;
        }
    for (size_t i = 1; i < count; ++i)
        if (weights[i] > weights[most]) most = uint32_t(i);
    return joints[most];
}

/** What a ray of the world meets of one avatar, whose context is locked; distances of the world. */
std::optional<RayHit> castAt(Avatar& avatar, const SurfaceRay& world) {
    const std::span<const Vec3f> vertices = verticesOf(avatar);
    Surface& s = *avatar.surface;
    if (!s.rays) s.rays.emplace(avatar.data->mesh);
    if (s.raysVersion != s.posed.version()) s.rays->follow(vertices), s.raysVersion = s.posed.version();
    const Placement& placed = avatar.placement;
    auto hit = s.rays->cast(vertices, {placed.toOwn(world.origin), placed.directionToOwn(world.direction)}, s.leftOut);
    if (hit) hit->distanceM *= placed.scale;
    return hit;
}

/** The fields of a pick that follow from its avatar, whose context is locked. */
void describe(const Avatar& avatar, const RayHit& hit, const SurfaceRay& world, std::span<const Vec3f> vertices, DplPick& pick) {
    const MeshData& mesh = avatar.data->mesh;
    const Triangle& t = mesh.triangles[hit.triangle];
    pick.hit = DPL_TRUE;
    for (size_t l = 0; l < mesh.layers.size(); ++l)
        if (hit.triangle - mesh.layers[l].firstTriangle < mesh.layers[l].triangleCount) pick.layer = uint32_t(l);
    pick.joint = heaviestJoint(mesh, hit);
    pick.distanceM = float(hit.distanceM);
    write(pick.point, world.origin + hit.distanceM * world.direction);
    const Vec3d a(vertices[t.x]), b(vertices[t.y]), c(vertices[t.z]);
    const Vec3d normal = avatar.placement.rotation * glm::normalize(glm::cross(b - a, c - a));
    write(pick.normal, glm::dot(normal, world.direction) > 0 ? -normal : normal);
}

Result<SurfaceRay> rayOf(const float* origin, const float* direction) {
    if (origin == nullptr || direction == nullptr)
        return fail(Code::InvalidArgument, "{} is NULL", origin == nullptr ? "origin" : "direction");
    for (int axis = 0; axis < 3; ++axis) {
        if (!(std::abs(origin[axis]) <= kMaxDistanceM))
            return fail(Code::InvalidArgument, "the ray's origin is not finite, or beyond {} m", kMaxDistanceM);
        if (!std::isfinite(direction[axis])) return fail(Code::InvalidArgument, "the ray's direction is not finite");
    }
    const Vec3d along(direction[0], direction[1], direction[2]);
    const double length = glm::length(along);
    if (!(length > 0)) return fail(Code::InvalidArgument, "the ray's direction is 0");
    return SurfaceRay{{origin[0], origin[1], origin[2]}, along / length};
}

/** Whether there is room for all `count` of something, or nothing is wanted. */
Status checkCount(const char* what, const void* out, size_t given, size_t count) {
    if (out != nullptr ? given == count : given == 0) return {};
    return fail(Code::InvalidArgument, "{}room for {} {}; the avatar has {}", out == nullptr ? "NULL with " : "", given, what, count);
}

}  // namespace

extern "C" {

DplResult dplGetLayerInfo(DplAvatar avatar, uint32_t layer, DplLayerInfo* info) {
    return guarded("dplGetLayerInfo", [&]() -> Status {
        DPL_TRY(const auto found, avatarOf(avatar));
        std::lock_guard lock(found->context->mutex);
        DPL_TRY(const LayerData* data, layerOf(*found, layer));
        DplLayerInfo out{};
        out.name = data->name.c_str(), out.role = data->role.c_str();
        out.triangleCount = data->triangleCount;
        out.hidden = layer < 64 && (found->hiddenLayers >> layer & 1) != 0 ? DPL_TRUE : DPL_FALSE;
        return writeStruct(info, out, "info");
    });
}

DplResult dplHideLayer(DplAvatar avatar, uint32_t layer, int hidden) {
    return guarded("dplHideLayer", [&]() -> Status {
        DPL_TRY(const auto found, avatarOf(avatar));
        DPL_RETURN_IF_ERROR(checkPosable(*found));
        std::lock_guard lock(found->context->mutex);
        if (const auto known = layerOf(*found, layer); !known) return known.error();
        const MeshData& mesh = found->data->mesh;
        uint64_t layers = found->hiddenLayers;
        if (hidden != DPL_FALSE) {
            DPL_RETURN_IF_ERROR(checkHidable(*found, layer, surfaceOf(*found).leftOut));
            layers |= uint64_t(1) << layer;
        } else if (layer < 64) {
            layers &= ~(uint64_t(1) << layer);
        }
        surfaceOf(*found).leftOut = trianglesOf(mesh, layers);
        found->hiddenLayers = layers;
        return {};
    });
}

DplResult dplGetPosedMesh(DplAvatar avatar, float* positions, uint32_t vertexCount, uint32_t* triangles, uint32_t triangleCount) {
    return guarded("dplGetPosedMesh", [&]() -> Status {
        DPL_TRY(const auto found, avatarOf(avatar));
        DPL_RETURN_IF_ERROR(checkPosable(*found));
        const MeshData& mesh = found->data->mesh;
        DPL_RETURN_IF_ERROR(checkCount("vertices", positions, vertexCount, mesh.restPositions.size()));
        DPL_RETURN_IF_ERROR(checkCount("triangles", triangles, triangleCount, mesh.triangles.size()));
        std::lock_guard lock(found->context->mutex);
        if (positions != nullptr)
            for (const Vec3f& p : verticesOf(*found))
                for (int axis = 0; axis < 3; ++axis) *positions++ = p[axis];
        const std::vector<uint8_t>& leftOut = surfaceOf(*found).leftOut;
        for (size_t t = 0; t < triangleCount; ++t)
            for (int corner = 0; corner < 3; ++corner) *triangles++ = !leftOut.empty() && leftOut[t] != 0 ? 0 : mesh.triangles[t][corner];
        return {};
    });
}

DplResult dplPick(const DplAvatar* avatars, uint32_t avatarCount, const float* origin, const float* direction, DplPick* pick) {
    return guarded("dplPick", [&]() -> Status {
        DPL_TRY(const auto handles, together(avatars, avatarCount));
        DPL_TRY(const SurfaceRay ray, rayOf(origin, direction));
        DplPick out{};
        double nearest = INFINITY;
        for (uint32_t i = 0; i < avatarCount; ++i) {
            DPL_TRY(const auto found, avatarOf(handles[i]));
            if (const Status posable = checkPosable(*found); !posable)
                return fail(posable.error().code, "avatar {}: {}", i, posable.error().message);
            std::lock_guard lock(found->context->mutex);
            const auto hit = castAt(*found, ray);
            if (!hit || !(hit->distanceM < nearest)) continue;
            nearest = hit->distanceM;
            out.avatar = i;
            describe(*found, *hit, ray, verticesOf(*found), out);
        }
        return writeStruct(pick, out, "pick");
    });
}

}  // extern "C"
