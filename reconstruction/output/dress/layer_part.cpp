// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/output/dress/layer_part.h"

#include <algorithm>

#include "sdk/format/avatar_file.h"
#include "sdk/math/binding.h"
#include "sdk/math/sh.h"
#include "sdk/math/sh_rotation.h"

namespace dpl {
namespace {

template <class T>
std::vector<T> cut(const std::vector<T>& from, size_t first, size_t count) {
    return {from.begin() + long(first), from.begin() + long(first + count)};
}

template <class T>
void append(std::vector<T>& to, const std::vector<T>& more) {
    to.insert(to.end(), more.begin(), more.end());
}

}  // namespace

LayerPart takeLayer(const AvatarData& avatar, size_t layer) {
    const LayerData& range = avatar.mesh.layers[layer];
    const MeshData& mesh = avatar.mesh;
    LayerPart part{range.name, range.role, {}, {}, {}, {}};
    part.mesh.restPositions = cut(mesh.restPositions, range.firstVertex, range.vertexCount);
    part.mesh.colours = cut(mesh.colours, range.firstVertex, range.vertexCount);
    part.mesh.jointIndices = cut(mesh.jointIndices, range.firstVertex, range.vertexCount);
    part.mesh.jointWeights = cut(mesh.jointWeights, range.firstVertex, range.vertexCount);
    part.mesh.triangles = cut(mesh.triangles, range.firstTriangle, range.triangleCount);
    for (Triangle& t : part.mesh.triangles) t -= range.firstVertex;

    const SplatData& all = avatar.splats;
    SplatData& own = part.splats;
    own.triangleStart = cut(all.triangleStart, range.firstTriangle, range.triangleCount + 1);
    const uint32_t first = own.triangleStart.front(), count = own.triangleStart.back() - first;
    for (uint32_t& start : own.triangleStart) start -= first;
    own.uv = cut(all.uv, first, count);
    own.phi = cut(all.phi, first, count);
    own.scaleM = cut(all.scaleM, first, count);
    own.opacity = cut(all.opacity, first, count);
    own.flags = cut(all.flags, first, count);
    own.shDegree = all.shDegree;
    own.sh = cut(all.sh, first * 3 * size_t(shCoefficientCount(all.shDegree)), count * 3 * size_t(shCoefficientCount(all.shDegree)));
    if (!avatar.correctives.empty()) {
        part.nodeIndices = cut(avatar.correctives.nodeIndices, range.firstVertex, range.vertexCount);
        part.nodeWeights = cut(avatar.correctives.nodeWeights, range.firstVertex, range.vertexCount);
    }
    return part;
}

void joinLayers(std::span<const LayerPart> parts, AvatarData& avatar) {
    MeshData mesh;
    SplatData splats;
    std::vector<glm::u16vec4> nodeIndices;
    std::vector<glm::u8vec4> nodeWeights;
    splats.triangleStart = {0};
    for (const LayerPart& part : parts) splats.shDegree = std::max(splats.shDegree, part.splats.shDegree);
    for (const LayerPart& part : parts) {
        const auto firstVertex = uint32_t(mesh.restPositions.size()), vertexCount = uint32_t(part.mesh.restPositions.size());
        mesh.layers.push_back(
            {part.name, part.role, firstVertex, vertexCount, uint32_t(mesh.triangles.size()), uint32_t(part.mesh.triangles.size())});
        append(mesh.restPositions, part.mesh.restPositions);
        append(mesh.colours, part.mesh.colours);
        append(mesh.jointIndices, part.mesh.jointIndices);
        append(mesh.jointWeights, part.mesh.jointWeights);
        for (const Triangle& t : part.mesh.triangles) mesh.triangles.push_back(t + firstVertex);

        const uint32_t firstSplat = splats.count();
        for (size_t t = 1; t < part.splats.triangleStart.size(); ++t)
            splats.triangleStart.push_back(firstSplat + part.splats.triangleStart[t]);
        append(splats.uv, part.splats.uv);
        append(splats.phi, part.splats.phi);
        append(splats.scaleM, part.splats.scaleM);
        append(splats.opacity, part.splats.opacity);
        append(splats.flags, part.splats.flags);
        const size_t from = 3 * size_t(shCoefficientCount(part.splats.shDegree)), to = 3 * size_t(shCoefficientCount(splats.shDegree));
        splats.sh.resize(splats.count() * to, 0.0f);
        for (size_t i = 0; i < part.splats.count(); ++i)
            std::copy_n(part.splats.sh.begin() + long(i * from), from, splats.sh.begin() + long((firstSplat + i) * to));

        append(nodeIndices, part.nodeIndices);
        append(nodeWeights, part.nodeWeights);
    }
    avatar.mesh = std::move(mesh);
    avatar.splats = std::move(splats);
    if (avatar.correctives.empty()) return;
    avatar.correctives.nodeIndices = std::move(nodeIndices);
    avatar.correctives.nodeWeights = std::move(nodeWeights);
}

void movePart(std::vector<Vec3f> restPositions, LayerPart& part) {
    const std::vector<Vec3f> old = std::exchange(part.mesh.restPositions, std::move(restPositions));
    AvatarData moved;
    moved.mesh = part.mesh;
    moved.splats = std::move(part.splats);
    [[maybe_unused]] const auto degenerate = rebaseSplats(old, moved);  // the sizes fit, so it cannot fail
    part.splats = std::move(moved.splats);
    SplatData& splats = part.splats;
    if (splats.shDegree == 0) return;
    const ShRotator rotator;
    for (size_t t = 0; t < part.mesh.triangles.size(); ++t) {
        const Triangle& c = part.mesh.triangles[t];
        const auto at = [&](const std::vector<Vec3f>& positions, int k) { return Vec3d(positions[c[k]]); };
        const TriangleFrame<double> frame = poseTriangle(restTriangle(at(old, 0), at(old, 1), at(old, 2)), at(part.mesh.restPositions, 0),
                                                         at(part.mesh.restPositions, 1), at(part.mesh.restPositions, 2));
        if (!frame.valid) continue;
        if (splats.triangleStart[t] == splats.triangleStart[t + 1]) continue;
        const ShTurn<double> turn = rotator.turn(frame.worldFromRest, splats.shDegree);
        for (uint32_t i = splats.triangleStart[t]; i < splats.triangleStart[t + 1]; ++i)
            turn.apply(&splats.sh[i * 3 * size_t(shCoefficientCount(splats.shDegree))]);
    }
}

}  // namespace dpl
