// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/subject/registration/picture_cost.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "reconstruction/subject/body/priors.h"
#include "reconstruction/subject/registration/priors.h"
#include "sdk/math/projection.h"

namespace dpl {
namespace {

constexpr double kRelativeFloor = 1e-9;  // of the largest curvature: joints that no term sees would make H singular

double robust(double s, double c, double& slope) {
    const double c2 = c * c, w = c2 / (s + c2);
    slope = w * w;
    return w * s;
}

}  // namespace

PictureCost::PictureCost(const KeypointChain& chain, const Camerad& camera, const Mat3d& rootReference, const ContrastImage* contrast,
                         std::vector<ContrastTerm> points, std::vector<OutlineTerm> outline, std::span<const Mat3d> held)
    : chain_(chain),
      camera_(camera),
      rootReference_(rootReference),
      contrast_(contrast),
      points_(std::move(points)),
      outline_(std::move(outline)),
      held_(held) {
    set_num_residuals(int(chain.columns()) + 1);
    mutable_parameter_block_sizes()->push_back(kRootSize);
    addPoseBlockSizes(*mutable_parameter_block_sizes(), chain.posedCount());
}

bool PictureCost::Evaluate(double const* const* blocks, double* residuals, double** jacobians) const {
    using Matrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
    const Eigen::Index n = Eigen::Index(chain_.columns());
    const size_t joints = chain_.posedCount();
    const bool wantJacobian = jacobians && std::any_of(jacobians, jacobians + 1 + joints, [](const double* j) { return j != nullptr; });
    thread_local KeypointChain::Output posed;
    chain_.evaluate(rootReference_, blocks[0], poseOfBlocks(blocks + 1, joints).data(), nullptr, wantJacobian, posed, held_);
    const Mat3d viewToWorld = glm::transpose(camera_.viewFromWorldRotation);
    // Rows are collected in a block and added to H together, which is several times faster than one by one.
    constexpr Eigen::Index kBlock = 96;
    Matrix rows(kBlock, n);
    Eigen::VectorXd values(kBlock);
    Eigen::Index used = 0;
    Matrix h = Matrix::Zero(n, n);
    Eigen::VectorXd g = Eigen::VectorXd::Zero(n);
    double cost = 0;
    const auto flush = [&] {
        if (used == 0) return;
        h.selfadjointView<Eigen::Lower>().rankUpdate(rows.topRows(used).transpose());
        g.noalias() += rows.topRows(used).transpose() * values.head(used);
        used = 0;
    };
    const auto add = [&](const CarriedPoint& point, const Vec3d& view, const Vec2d& slopePx, double slopeZ, double scale, double residual) {
        if (used == kBlock) flush();
        const Vec3d inView(slopePx.x * camera_.fx / view.z, slopePx.y * camera_.fy / view.z,
                           slopeZ - (slopePx.x * camera_.fx * view.x + slopePx.y * camera_.fy * view.y) / (view.z * view.z));
        rows.row(used).setZero();
        point.pull(chain_, posed, viewToWorld * (scale * inView), &rows(used, 0));
        values[used++] = residual;
    };
    for (const ContrastTerm& term : points_) {
        const Vec3d view = camera_.toView(term.point.place(posed));
        Vec3d value, dx, dy;
        double slope;
        const double c = priors::kContrastOutlierSigmas;
        if (!(view.z > kNearM) || !contrast_->sample(camera_.pixelOf(view), value, dx, dy)) {
            cost += term.weight * c * c;  // what an outlier costs, so that leaving the mask is no gain
            continue;
        }
        const Vec3d r = (value - term.contrast) / term.sigma;
        cost += term.weight * robust(glm::dot(r, r), c, slope);
        const double scale = std::sqrt(term.weight * slope);
        for (int a = 0; wantJacobian && a < 3; ++a) add(term.point, view, Vec2d(dx[a], dy[a]), 0, scale / term.sigma, scale * r[a]);
    }
    for (const OutlineTerm& term : outline_) {
        const Vec3d view = camera_.toView(term.point.place(posed));
        const double c = priors::kOutlineOutlierSigmas;
        double slope;
        if (!(view.z > kNearM)) {
            cost += term.weight * c * c;
            continue;
        }
        Vec2d gradient;
        const double perPx = view.z / camera_.fx / term.sigmaM;
        const double r = term.outline->sample(camera_.pixelOf(view), gradient) * perPx;
        cost += term.weight * robust(r * r, c, slope);
        const double scale = std::sqrt(term.weight * slope);
        if (wantJacobian) add(term.point, view, gradient, r / perPx / view.z, scale * perPx, scale * r);
    }
    std::fill_n(residuals, n + 1, 0.0);
    residuals[n] = std::sqrt(cost);
    if (!wantJacobian) return true;
    flush();
    h.diagonal().array() += std::max(1e-12, kRelativeFloor * h.diagonal().maxCoeff());
    const Eigen::LLT<Eigen::MatrixXd> factor(Eigen::MatrixXd(h.selfadjointView<Eigen::Lower>()));
    if (factor.info() != Eigen::Success) return false;
    const Eigen::VectorXd z = factor.matrixL().solve(g);
    Eigen::Map<Eigen::VectorXd>(residuals, n) = z;
    residuals[n] = std::sqrt(std::max(0.0, cost - z.squaredNorm()));
    const Matrix r = factor.matrixU();
    if (jacobians[0]) {
        Eigen::Map<Matrix> out(jacobians[0], n + 1, kRootSize);
        out.setZero();
        out.topRows(n) = r.leftCols(kRootSize);
    }
    for (size_t j = 0; j < joints; ++j) {
        if (!jacobians[1 + j]) continue;
        Eigen::Map<Matrix> out(jacobians[1 + j], n + 1, 3);
        out.setZero();
        out.topRows(n) = r.middleCols(Eigen::Index(kRootSize + 3 * j), 3);
    }
    return true;
}

}  // namespace dpl
