// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/subject/shape/large_steps.h"

#include <Eigen/SparseCholesky>
#include <algorithm>
#include <cmath>

#include "sdk/math/merge_vertices.h"

namespace dpl {

/** M as lists of neighbours, and its factor P·M·Pᵀ = L·D·Lᵀ with L unit lower triangular, stored by columns. */
struct LargeSteps::Factor {
    double lambda = 0;
    std::vector<uint32_t> mergedOf;  // per vertex: its merged vertex
    std::vector<uint32_t> neighbourStart, neighbours;
    std::vector<uint32_t> component;      // per merged vertex
    std::vector<uint32_t> componentSize;  // in merged vertices
    std::vector<int> columnStart, rowIndex;
    std::vector<double> lower, inverseDiagonal;
    std::vector<uint32_t> permuted;  // per unknown: its position in the factor

    void removeMeans(std::span<Vec3d> x, uint32_t heldVertices) const {
        std::vector<uint8_t> held(componentSize.size(), 0);
        for (size_t v = 0; v < std::min<size_t>(heldVertices, mergedOf.size()); ++v) held[component[mergedOf[v]]] = 1;
        std::vector<Vec3d> mean(componentSize.size(), Vec3d(0));
        for (size_t i = 0; i < x.size(); ++i) mean[component[i]] += x[i];
        for (size_t c = 0; c < mean.size(); ++c) mean[c] *= held[c] / double(componentSize[c]);
        for (size_t i = 0; i < x.size(); ++i) x[i] -= mean[component[i]];
    }
};

LargeSteps::LargeSteps(std::unique_ptr<Factor> factor) : factor_(std::move(factor)) {}
LargeSteps::LargeSteps(LargeSteps&&) noexcept = default;
LargeSteps& LargeSteps::operator=(LargeSteps&&) noexcept = default;
LargeSteps::~LargeSteps() = default;

uint32_t LargeSteps::size() const {
    return uint32_t(factor_->permuted.size());
}
double LargeSteps::lambda() const {
    return factor_->lambda;
}
uint32_t LargeSteps::componentCount() const {
    return uint32_t(factor_->componentSize.size());
}

Result<LargeSteps> LargeSteps::create(std::span<const Vec3f> positions, std::span<const Triangle> triangles, double smoothingLengthM) {
    double sum = 0, count = 0;
    for (const Triangle& t : triangles)
        for (int c = 0; c < 3; ++c) {
            if (t[c] >= positions.size() || t[(c + 1) % 3] >= positions.size()) continue;  // createWithLambda reports it
            sum += glm::length(Vec3d(positions[t[c]]) - Vec3d(positions[t[(c + 1) % 3]])), count += 1;
        }
    const double edge = count > 0 ? sum / count : 0;
    if (!(edge > 0) || !std::isfinite(edge))
        return fail(Code::InvalidArgument, "the mesh has no edges of finite length; LargeSteps needs triangles");
    return createWithLambda(positions, triangles, smoothingLengthM * smoothingLengthM / (edge * edge));
}

Result<LargeSteps> LargeSteps::createWithLambda(std::span<const Vec3f> positions, std::span<const Triangle> triangles, double lambda) {
    if (!(lambda >= 0) || !std::isfinite(lambda))
        return fail(Code::InvalidArgument, "LargeSteps: lambda {} is not a number at or above 0", lambda);
    auto f = std::make_unique<Factor>();
    f->lambda = lambda;
    for (size_t v = 0; v < positions.size(); ++v) {
        const Vec3f p = positions[v];
        if (!std::isfinite(p.x) || !std::isfinite(p.y) || !std::isfinite(p.z))
            return fail(Code::InvalidArgument, "LargeSteps: vertex {} is not finite", v);
    }
    MergedVertices merged = mergeVertices(positions);
    f->mergedOf = std::move(merged.placeOf);
    const size_t n = merged.count;
    std::vector<std::vector<uint32_t>> adjacent(n);
    for (size_t t = 0; t < triangles.size(); ++t)
        for (int c = 0; c < 3; ++c) {
            if (triangles[t][c] >= positions.size())
                return fail(Code::InvalidArgument, "LargeSteps: triangle {} names vertex {} of {}", t, triangles[t][c], positions.size());
            if (triangles[t][(c + 1) % 3] >= positions.size()) continue;
            const uint32_t a = f->mergedOf[triangles[t][c]], b = f->mergedOf[triangles[t][(c + 1) % 3]];
            if (a != b) adjacent[a].push_back(b), adjacent[b].push_back(a);
        }
    f->neighbourStart.assign(n + 1, 0);
    std::vector<Eigen::Triplet<double>> entries;
    for (size_t i = 0; i < n; ++i) {
        auto& list = adjacent[i];
        std::sort(list.begin(), list.end());
        list.erase(std::unique(list.begin(), list.end()), list.end());
        entries.emplace_back(int(i), int(i), 1 + lambda * double(list.size()));
        for (uint32_t j : list) entries.emplace_back(int(i), int(j), -lambda);
        f->neighbours.insert(f->neighbours.end(), list.begin(), list.end());
        f->neighbourStart[i + 1] = uint32_t(f->neighbours.size());
    }
    f->component.assign(n, ~0u);
    for (size_t i = 0; i < n; ++i) {
        if (f->component[i] != ~0u) continue;
        const uint32_t id = uint32_t(f->componentSize.size());
        std::vector<uint32_t> stack{uint32_t(i)};
        f->component[i] = id;
        f->componentSize.push_back(0);
        while (!stack.empty()) {
            const uint32_t v = stack.back();
            stack.pop_back();
            ++f->componentSize[id];
            for (uint32_t k = f->neighbourStart[v]; k < f->neighbourStart[v + 1]; ++k)
                if (f->component[f->neighbours[k]] == ~0u) f->component[f->neighbours[k]] = id, stack.push_back(f->neighbours[k]);
        }
    }
    Eigen::SparseMatrix<double> matrix{Eigen::Index(n), Eigen::Index(n)};
    matrix.setFromTriplets(entries.begin(), entries.end());
    Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> ldlt(matrix);
    if (ldlt.info() != Eigen::Success) return fail(Code::Internal, "LargeSteps: the factorisation of {} unknowns failed", n);
    const Eigen::SparseMatrix<double> lower = ldlt.matrixL();
    f->columnStart.assign(n + 1, 0);
    f->inverseDiagonal.resize(n);
    f->permuted.resize(n);
    for (size_t i = 0; i < n; ++i) {
        for (Eigen::SparseMatrix<double>::InnerIterator it(lower, Eigen::Index(i)); it; ++it)
            if (it.row() > it.col()) f->rowIndex.push_back(int(it.row())), f->lower.push_back(it.value());
        f->columnStart[i + 1] = int(f->rowIndex.size());
        const double d = ldlt.vectorD()[Eigen::Index(i)];
        if (!(d > 0) || !std::isfinite(d)) return fail(Code::Internal, "LargeSteps: pivot {} is {}", i, d);
        f->inverseDiagonal[i] = 1 / d;
        f->permuted[i] = uint32_t(ldlt.permutationP().indices()[Eigen::Index(i)]);
    }
    return LargeSteps(std::move(f));
}

void LargeSteps::solve(std::span<Vec3d> x) const {
    const Factor& f = *factor_;
    const size_t n = f.permuted.size();
    std::vector<Vec3d> y(n);
    for (size_t i = 0; i < n; ++i) y[f.permuted[i]] = x[i];
    for (size_t c = 0; c < n; ++c) {
        const Vec3d yc = y[c];
        for (int k = f.columnStart[c]; k < f.columnStart[c + 1]; ++k) y[size_t(f.rowIndex[size_t(k)])] -= f.lower[size_t(k)] * yc;
    }
    for (size_t c = n; c-- > 0;) {
        Vec3d yc = y[c] * f.inverseDiagonal[c];
        for (int k = f.columnStart[c]; k < f.columnStart[c + 1]; ++k) yc -= f.lower[size_t(k)] * y[size_t(f.rowIndex[size_t(k)])];
        y[c] = yc;
    }
    for (size_t i = 0; i < n; ++i) x[i] = y[f.permuted[i]];
}

void LargeSteps::apply(std::span<const Vec3d> x, std::span<Vec3d> y) const {
    const Factor& f = *factor_;
    for (size_t i = 0; i < x.size(); ++i) {
        Vec3d sum(0);
        for (uint32_t k = f.neighbourStart[i]; k < f.neighbourStart[i + 1]; ++k) sum += x[i] - x[f.neighbours[k]];
        y[i] = x[i] + f.lambda * sum;
    }
}

void LargeSteps::offsets(std::span<const Vec3f> u, std::span<Vec3f> vertexOffsets, uint32_t heldVertices) const {
    std::vector<Vec3d> x(u.begin(), u.end());
    solve(x);
    factor_->removeMeans(x, heldVertices);
    for (size_t v = 0; v < vertexOffsets.size(); ++v) vertexOffsets[v] = Vec3f(x[factor_->mergedOf[v]]);
}

void LargeSteps::backward(std::span<const Vec3f> vertexGradient, std::span<Vec3f> uGradient, uint32_t heldVertices) const {
    std::vector<Vec3d> x(factor_->permuted.size(), Vec3d(0));
    for (size_t v = 0; v < vertexGradient.size(); ++v) x[factor_->mergedOf[v]] += Vec3d(vertexGradient[v]);
    factor_->removeMeans(x, heldVertices);
    solve(x);
    for (size_t i = 0; i < x.size(); ++i) uGradient[i] = Vec3f(x[i]);
}

}  // namespace dpl
