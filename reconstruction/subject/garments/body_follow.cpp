// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/subject/garments/body_follow.h"

#include <Eigen/Sparse>
#include <Eigen/SparseCholesky>
#include <algorithm>

#include "reconstruction/subject/garments/priors.h"

namespace dpl {
namespace {

constexpr float kFacing = 0.3f;   // least cosine between the normals of cloth and of the body point that it follows
constexpr float kSearchM = 0.5f;  // no body point that faces the same way within this: any body point

}  // namespace

std::vector<SurfacePoint> bodyBelow(const SurfaceMesh& piece, const ClosestSurface& body) {
    const std::vector<Vec3f> normals = vertexNormals(piece.positions, piece.triangles);
    std::vector<SurfacePoint> below(piece.positions.size());
    for (size_t v = 0; v < below.size(); ++v) {
        below[v] = body.findFacing(piece.positions[v], normals[v], kFacing, kSearchM);
        if (!below[v].found()) below[v] = body.find(piece.positions[v]);
    }
    return below;
}

std::vector<double> followLengths(std::span<const SurfacePoint> below) {
    std::vector<double> lengths;
    for (const SurfacePoint& point : below)
        lengths.push_back(std::max(priors::kClothContactM, priors::kClothHang * double(point.distanceM)));
    return lengths;
}

Result<std::vector<double>> followBody(const SurfaceMesh& piece, std::span<const double> lengthsM, std::span<const double> values,
                                       size_t columns) {
    const size_t count = piece.positions.size();
    const auto neighbours = vertexNeighbours(count, piece.triangles);
    double edge = 0, edges = 0;
    for (size_t v = 0; v < count; ++v)
        for (uint32_t n : neighbours[v]) edge += glm::length(piece.positions[v] - piece.positions[n]), edges += 1;
    if (!(edge > 0)) return fail(Code::InvalidArgument, "a garment without edges cannot follow a body");
    edge /= edges;

    std::vector<Eigen::Triplet<double>> entries;
    Eigen::VectorXd data = Eigen::VectorXd::Zero(Eigen::Index(count));
    for (size_t v = 0; v < count; ++v) {
        data[Eigen::Index(v)] = edge * edge / (lengthsM[v] * lengthsM[v]);
        entries.emplace_back(int(v), int(v), data[Eigen::Index(v)] + double(neighbours[v].size()));
        for (uint32_t n : neighbours[v]) entries.emplace_back(int(v), int(n), -1.0);
    }
    Eigen::SparseMatrix<double> matrix{Eigen::Index(count), Eigen::Index(count)};
    matrix.setFromTriplets(entries.begin(), entries.end());
    const Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> factor(matrix);
    if (factor.info() != Eigen::Success) return fail(Code::Internal, "a garment could not be laid on the body; report this input");
    std::vector<double> out(values.size());
    for (size_t j = 0; j < columns; ++j) {
        Eigen::VectorXd right = Eigen::VectorXd::Zero(Eigen::Index(count));
        for (size_t v = 0; v < count; ++v) right[Eigen::Index(v)] = data[Eigen::Index(v)] * values[v * columns + j];
        const Eigen::VectorXd x = factor.solve(right);
        for (size_t v = 0; v < count; ++v) out[v * columns + j] = x[Eigen::Index(v)];
    }
    return out;
}

}  // namespace dpl
