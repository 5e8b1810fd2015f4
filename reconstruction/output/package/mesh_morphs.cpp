// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/output/package/mesh_morphs.h"

#include <cmath>

#include "reconstruction/subject/shape/implicit_mesh.h"
#include "sdk/avatar/posed_mesh.h"
#include "sdk/format/avatar_file.h"

namespace dpl {
namespace {

Vec3f snapped(const Vec3f& v, float step) {
    return {std::round(v.x / step) * step, std::round(v.y / step) * step, std::round(v.z / step) * step};
}

}  // namespace

DrawnAtRest drawnAtRest(const AvatarData& avatar) {
    const ClothLimits cloth(avatar.joints, avatar.mesh, avatar.correctives);
    const PosedSubject subject{avatar.joints, avatar.mesh, avatar.correctives, {}, nullptr, {}, &cloth, &avatar.expressions};
    Jobs alone(1);
    PosedMesh posed;
    const auto drawn = [&](const Pose& pose) {
        posed.control(subject, pose);
        posed.vertices(subject, alone);
        return std::vector<Vec3f>(posed.positions().begin(), posed.positions().end());
    };
    const Pose rest = Pose::rest(avatar.joints.size());
    DrawnAtRest out{drawn(rest), {}};
    for (const uint8_t expression : avatar.expressions.shapes) {
        Pose pose = rest;
        pose.expression[expression] = 1;
        out.expressed.push_back({expression, drawn(pose)});
    }
    return out;
}

std::vector<MeshMorph> morphsOf(std::span<const Vec3f> rest, std::span<const ExpressedMesh> expressed, std::span<const Triangle> triangles,
                                std::span<const uint32_t> old) {
    const std::vector<Vec3f> restNormals = expressed.empty() ? std::vector<Vec3f>() : vertexNormals(rest, triangles);
    std::vector<MeshMorph> out;
    for (const ExpressedMesh& shape : expressed) {
        const std::vector<Vec3f> normals = vertexNormals(shape.positions, triangles);
        MeshMorph morph{shape.expression, {}, {}, {}};
        bool moves = false;
        for (uint32_t v = 0; v < old.size(); ++v) {
            const uint32_t from = old[v];
            const Vec3f offset = snapped(shape.positions[from] - rest[from], kPositionStepM);
            const Vec3f turn = snapped(normals[from] - restNormals[from], kTurnStep);
            if (offset == Vec3f(0) && turn == Vec3f(0)) continue;
            morph.vertices.push_back(v), morph.offsetsM.push_back(offset), morph.turns.push_back(turn);
            moves = moves || offset != Vec3f(0);
        }
        if (moves) out.push_back(std::move(morph));
    }
    return out;
}

}  // namespace dpl
