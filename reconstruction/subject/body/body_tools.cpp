// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/subject/body/body_tools.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "sdk/format/check_mesh.h"
#include "sdk/format/expressions.h"

namespace dpl {
namespace {

bool finite(const Vec3f& v) {
    return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}

template <class Container>
bool allFinite(const Container& values) {
    return std::all_of(values.begin(), values.end(), [](const Vec3f& v) { return finite(v); });
}

}  // namespace

Status checkBody(const BodyModel& body) {
    const MeshData& mesh = body.mesh;
    const size_t vertices = mesh.restPositions.size(), joints = body.joints.size();
    const auto refuse = [&](const std::string& what) { return fail(Code::CorruptData, "body '{}': {}", body.name, what); };
    if (joints == 0) return refuse("it has no joints");
    if (vertices == 0 || mesh.triangles.empty()) return refuse("it has no mesh");
    if (mesh.jointIndices.size() != vertices || mesh.jointWeights.size() != vertices)
        return fail(Code::Unsupported, "body '{}' has no skin weights; rig the mesh (JOINTS_0 and WEIGHTS_0) and export it again",
                    body.name);
    for (size_t j = 0; j < joints; ++j) {
        const int32_t parent = body.joints[j].parent;
        if ((j == 0) != (parent == -1) || parent >= int32_t(j) || parent < -1)
            return refuse(
                formatText("joint '{}' has parent {}; joint 0 is the only root and parents come first", body.joints[j].name, parent));
        if (!finite(body.joints[j].restPosition)) return refuse(formatText("joint '{}' is not at a finite place", body.joints[j].name));
    }
    for (const Status& sound : {checkMesh(mesh, joints), checkFinite(mesh)})
        if (!sound) return refuse(sound.error().message);
    for (size_t v = 0; v < vertices; ++v) {
        int sum = 0;
        for (int i = 0; i < 4; ++i) {
            sum += mesh.jointWeights[v][i];
            if (mesh.jointIndices[v][i] >= joints)  // checked for weight 0 too: keypoints read these indices
                return refuse(formatText("vertex {} names joint {}; the rig has {}", v, mesh.jointIndices[v][i], joints));
        }
        if (sum != 255) return refuse(formatText("the weights of vertex {} sum to {}, not 255", v, sum));
    }
    for (const LayerData& layer : mesh.layers)
        if (uint64_t(layer.firstVertex) + layer.vertexCount > vertices ||
            uint64_t(layer.firstTriangle) + layer.triangleCount > mesh.triangles.size())
            return refuse(formatText("layer '{}' reaches beyond the mesh", layer.name));
    for (const ShapeMorph& m : body.morphs) {
        if (m.vertexOffsets.size() != vertices || m.jointOffsets.size() != joints)
            return refuse(formatText("morph '{}' is of another mesh", m.name));
        if (!allFinite(m.vertexOffsets) || !allFinite(m.jointOffsets) || !(m.minValue <= m.maxValue) || !std::isfinite(m.minValue) ||
            !std::isfinite(m.maxValue))
            return refuse(formatText("morph '{}' is not finite", m.name));
    }
    for (size_t e = 0; e < body.expressions.size(); ++e) {
        const ExpressionShape& shape = body.expressions[e];
        if (shape.expression >= kExpressionCount || (e > 0 && shape.expression <= body.expressions[e - 1].expression))
            return refuse(formatText("expression {} is number {} of {}; each is listed once, in rising order", e, int(shape.expression),
                                     kExpressionCount));
        const char* name = kExpressionNames[shape.expression];
        if (shape.offsetsM.size() != vertices) return refuse(formatText("expression '{}' is of another mesh", name));
        for (const Vec3f& o : shape.offsetsM)
            if (!(std::abs(o.x) <= kMostExpressionM && std::abs(o.y) <= kMostExpressionM && std::abs(o.z) <= kMostExpressionM))
                return refuse(
                    formatText("expression '{}' moves a vertex by more than {} m, or by what is not a number", name, kMostExpressionM));
    }
    for (const BodyKeypoint& k : body.keypoints) {
        double sum = 0;
        for (auto [v, w] : k.vertices) sum += v < vertices ? w : NAN;
        for (auto [j, w] : k.joints) sum += j < joints ? w : NAN;
        if (!(std::abs(sum - 1) < 1e-3)) return refuse(formatText("the weights of keypoint '{}' sum to {}, not 1", k.name, sum));
    }
    return {};
}

BodyModel shapedBody(const BodyModel& body, std::span<const double> shape) {
    BodyModel out = body;
    for (size_t m = 0; m < std::min(shape.size(), body.morphs.size()); ++m) {
        const float value = float(shape[m]);
        if (value == 0) continue;
        for (size_t v = 0; v < out.mesh.restPositions.size(); ++v) out.mesh.restPositions[v] += value * body.morphs[m].vertexOffsets[v];
        for (size_t j = 0; j < out.joints.size(); ++j) out.joints[j].restPosition += value * body.morphs[m].jointOffsets[j];
    }
    return out;
}

int32_t findHumanoid(const BodyModel& body, std::string_view humanoidBone) {
    for (size_t j = 0; j < body.joints.size(); ++j)
        if (body.joints[j].humanoidBone == humanoidBone) return int32_t(j);
    return -1;
}

int32_t findJoint(std::span<const JointData> joints, std::string_view name) {
    for (size_t j = 0; j < joints.size(); ++j)
        if (joints[j].name == name) return int32_t(j);
    return -1;
}

std::vector<std::pair<uint32_t, float>> anchorPoint(const MeshData& mesh, std::span<const uint32_t> candidates, const Vec3f& point) {
    // Minimum-norm weights with Σw = 1 and Σw·(v − point) = 0 on the nearest vertices: w = Aᵀ(A Aᵀ)⁻¹ e₀, rows of A are 1 and the offsets.
    constexpr size_t kAnchors = 16;
    std::vector<uint32_t> nearest(candidates.begin(), candidates.end());
    const auto distance2 = [&](uint32_t v) {
        const Vec3f d = mesh.restPositions[v] - point;
        return glm::dot(d, d);
    };
    std::sort(nearest.begin(), nearest.end(),
              [&](uint32_t a, uint32_t b) { return std::pair(distance2(a), a) < std::pair(distance2(b), b); });
    nearest.resize(std::min(nearest.size(), kAnchors));
    if (nearest.empty()) return {};
    const double spread = std::max(1e-6, std::sqrt(double(distance2(nearest.back()))));
    std::vector<Vec4d> rows;
    Mat4d gram(0.0);
    for (uint32_t v : nearest) {
        const Vec4d a(1.0, Vec3d(mesh.restPositions[v] - point) / spread);
        rows.push_back(a);
        gram += glm::outerProduct(a, a);
    }
    for (int i = 0; i < 4; ++i)
        gram[i][i] += 1e-6 * double(nearest.size());  // keeps the weights bounded on flat neighbourhoods, at the cost of exactness
    const Vec4d solution = glm::inverse(gram) * Vec4d(1, 0, 0, 0);
    std::vector<std::pair<uint32_t, float>> weights;
    double sum = 0;
    for (const Vec4d& a : rows) sum += glm::dot(a, solution);
    for (size_t i = 0; i < rows.size(); ++i) weights.emplace_back(nearest[i], float(glm::dot(rows[i], solution) / sum));
    return weights;
}

}  // namespace dpl
