// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/subject/face/body_face.h"

#include <algorithm>
#include <cmath>

#include "reconstruction/subject/face/expression_nodes.h"
#include "sdk/core/log.h"
#include "sdk/format/expression_names.h"

namespace dpl {
namespace {

constexpr const char* kPart = "expressions from a film of the face";

/** Root mean square distance of vertices from their middle. */
double spread(std::span<const Vec3f> positions, std::span<const uint32_t> vertices) {
    Vec3d middle(0);
    for (const uint32_t v : vertices) middle += Vec3d(positions[v]) / double(vertices.size());
    double sum = 0;
    for (const uint32_t v : vertices) {
        const Vec3d from = Vec3d(positions[v]) - middle;
        sum += glm::dot(from, from);
    }
    return vertices.empty() ? 0 : std::sqrt(sum / double(vertices.size()));
}

}  // namespace

std::vector<ExpressionShape> shapesAtSize(const BodyModel& body, const MeshData& mesh) {
    std::vector<uint32_t> moved;
    for (uint32_t v = 0; v < body.mesh.restPositions.size(); ++v)
        if (std::any_of(body.expressions.begin(), body.expressions.end(),
                        [&](const ExpressionShape& shape) { return glm::length(shape.offsetsM[v]) >= kLeastExpressionM; }))
            moved.push_back(v);
    const double before = spread(body.mesh.restPositions, moved);
    const float size = before > 0 ? float(spread(mesh.restPositions, moved) / before) : 1.0f;
    std::vector<ExpressionShape> shapes = body.expressions;
    for (ExpressionShape& shape : shapes) {
        for (Vec3f& offset : shape.offsetsM) offset *= size;
        shape.offsetsM.resize(mesh.restPositions.size(), Vec3f(0));
    }
    return shapes;
}

Result<EvidenceData> addBodyFace(AvatarData& avatar, const BodyModel& body) {
    EvidenceData row{kPart, false, 0, 0, ""};
    if (body.expressions.empty()) {
        row.reason = "face not filmed, and the body brings no shapes: it follows the head and shows no expression";
        return row;
    }
    if (avatar.mesh.layers.empty() || avatar.mesh.layers.front().vertexCount != body.mesh.restPositions.size() ||
        avatar.mesh.layers.front().triangleCount != body.mesh.triangles.size())
        return fail(Code::InvalidArgument, "the body '{}' has {} vertices, the avatar's first layer {}", body.name,
                    body.mesh.restPositions.size(), avatar.mesh.layers.empty() ? 0 : avatar.mesh.layers.front().vertexCount);
    DPL_TRY(const ExpressionNodesReport report, addExpressions(avatar, shapesAtSize(body, avatar.mesh)));
    row.reason = formatText(
        "face not filmed: {} of {} expressions move it by the shape of the body alone, so its wrinkles and the inside of its mouth are not "
        "the person's",
        avatar.expressions.shapes.size(), kExpressionCount);
    log(LogLevel::Info, "{} expressions on {} control nodes; shapes are {} mm off, pose correctives {} mm",
        avatar.expressions.shapes.size(), report.nodes, 1e3 * double(report.shapesOffM), 1e3 * double(report.correctivesOffM));
    return row;
}

}  // namespace dpl
