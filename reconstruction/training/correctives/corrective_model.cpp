// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/training/correctives/corrective_model.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <string_view>

#include "reconstruction/subject/shape/surface_graph.h"
#include "sdk/core/percentile.h"
#include "sdk/format/skin_weights.h"

namespace dpl {
namespace {

constexpr std::array<std::string_view, 17> kHeardBones{"spine",         "chest",         "upperChest",    "neck",          "head",
                                                       "leftShoulder",  "rightShoulder", "leftUpperArm",  "rightUpperArm", "leftLowerArm",
                                                       "rightLowerArm", "leftUpperLeg",  "rightUpperLeg", "leftLowerLeg",  "rightLowerLeg",
                                                       "leftFoot",      "rightFoot"};

/** Adds the farthest vertex as a node until every vertex is within `spacing` of a node. Leaves two of kMaxCorrectiveNodes free: one for
 *  holdBareVertices(), one for dressAvatar(). */
std::vector<uint32_t> chooseNodes(const SurfaceGraph& graph, float spacing) {
    std::vector<float> nearest(graph.neighbours.size(), 1e30f);
    std::vector<uint32_t> nodes;
    std::map<uint32_t, float> settled;
    while (nodes.size() + 2 < kMaxCorrectiveNodes) {
        const auto farthest = std::max_element(nearest.begin(), nearest.end());
        if (farthest == nearest.end() || *farthest <= spacing) break;
        nodes.push_back(uint32_t(farthest - nearest.begin()));
        graph.search(nodes.back(), settled, [&](uint32_t v, float distance) {
            if (distance >= nearest[v]) return false;
            nearest[v] = distance;
            return true;
        });
    }
    return nodes;
}

void bindVertices(const SurfaceGraph& graph, const std::vector<uint32_t>& nodes, float spacing, PoseCorrectiveData& out) {
    std::vector<std::vector<std::pair<float, uint32_t>>> near(graph.neighbours.size());
    std::map<uint32_t, float> settled;
    for (uint32_t n = 0; n < nodes.size(); ++n)
        graph.search(nodes[n], settled, [&](uint32_t v, float distance) {
            if (distance > 3 * spacing) return false;
            near[v].emplace_back(distance, n);
            return true;
        });
    std::vector<PackedWeights> packed(near.size());
    for (size_t v = 0; v < near.size(); ++v) {
        std::sort(near[v].begin(), near[v].end());
        const size_t count = std::min<size_t>(4, near[v].size());
        const float reach = near[v].size() > 4 ? near[v][4].first : 1.5f * near[v][count - 1].first + 1e-6f;
        std::vector<std::pair<uint32_t, float>> weights;
        for (size_t i = 0; i < count; ++i) {
            const float w = std::max(0.0f, 1 - near[v][i].first / std::max(reach, 1e-6f));
            weights.emplace_back(near[v][i].second, w * w + 1e-6f);
        }
        packed[v] = packWeights(weights);
    }
    for (const uint32_t merged : graph.mergedOf)
        out.nodeIndices.push_back(packed[merged].joints), out.nodeWeights.push_back(packed[merged].weights);
}

}  // namespace

Result<PoseCorrectiveData> correctiveModel(std::span<const JointData> joints, const MeshData& mesh, std::span<const Pose> poses,
                                           const CorrectiveModelSettings& settings) {
    PoseCorrectiveData out;
    for (uint32_t j = 0; j < joints.size(); ++j)
        if (std::find(kHeardBones.begin(), kHeardBones.end(), joints[j].humanoidBone) != kHeardBones.end()) out.joints.push_back(j);
    if (out.joints.empty() || poses.size() < settings.minPoses || mesh.triangles.empty()) return PoseCorrectiveData{};
    const auto features = Eigen::Index(out.joints.size() * 6), rows = Eigen::Index(poses.size());
    Eigen::MatrixXd samples(rows, features);
    for (Eigen::Index r = 0; r < rows; ++r) {
        DPL_RETURN_IF_ERROR(checkPose(joints, poses[size_t(r)]));
        for (size_t j = 0; j < out.joints.size(); ++j) {
            double feature[6];
            correctiveFeature(Quatd(poses[size_t(r)].localRotations[out.joints[j]]), feature);
            for (int f = 0; f < 6; ++f) samples(r, Eigen::Index(j) * 6 + f) = feature[f];
        }
    }
    const Eigen::RowVectorXd mean = samples.colwise().mean();
    samples.rowwise() -= mean;
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(samples.transpose() * samples / double(rows));
    if (solver.info() != Eigen::Success) return fail(Code::Internal, "the modes of {} poses could not be found", poses.size());
    const Eigen::VectorXd& variance = solver.eigenvalues();  // ascending
    if (!(variance(features - 1) > settings.minSpread * settings.minSpread)) return PoseCorrectiveData{};
    const double total = variance.sum();
    for (Eigen::Index f = 0; f < features; ++f) out.mean.push_back(float(mean(f)));
    for (Eigen::Index i = features - 1; i >= 0 && out.modeCount < settings.maxModes && variance(i) >= settings.minVariance * total;
         --i, ++out.modeCount) {
        Eigen::VectorXd mode = solver.eigenvectors().col(i);
        Eigen::Index largest = 0;
        mode.cwiseAbs().maxCoeff(&largest);
        if (mode(largest) < 0) mode = -mode;  // an eigenvector's sign is arbitrary
        for (Eigen::Index f = 0; f < features; ++f) out.modes.push_back(float(mode(f) / std::sqrt(variance(i))));
    }
    const SurfaceGraph graph(mesh.restPositions, mesh.triangles);
    const std::vector<uint32_t> nodes = chooseNodes(graph, float(settings.nodeSpacingM));
    out.nodeCount = uint32_t(nodes.size());
    bindVertices(graph, nodes, float(settings.nodeSpacingM), out);
    out.nodes.assign(size_t(out.nodeCount) * out.modeCount, Vec4f(0));
    out.reach = out.reachOffModes = 1e30f;
    std::vector<float> coefficients;
    std::vector<float> lengths, offs;
    for (const Pose& pose : poses) {
        const CorrectiveDistance distance = correctiveCoefficients(out, pose, coefficients);
        lengths.push_back(distance.length), offs.push_back(distance.offModes);
    }
    out.reach = percentile(std::move(lengths), settings.reachQuantile);
    out.reachOffModes = std::max(float(settings.minReachOffModes), percentile(std::move(offs), settings.offModesQuantile));
    return out;
}

}  // namespace dpl
