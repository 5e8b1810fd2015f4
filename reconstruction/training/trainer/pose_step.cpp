// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/training/trainer/pose_step.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <numeric>

#include "reconstruction/training/trainer/rotation_vector.h"

namespace dpl {
namespace {

using Matrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

Vec3d turnFrom(const Quatf& registered, const Quatd& now) {
    return logQuaternion(now * glm::conjugate(glm::normalize(Quatd(registered))));
}

Eigen::VectorXd deviation(const Pose& pose, const PosePull& pull) {
    const std::vector<uint32_t>& joints = pull.precision->joints;
    Eigen::VectorXd d(Eigen::Index(pull.precision->size()));
    for (size_t k = 0; k < joints.size(); ++k) {
        const Vec3d turn = turnFrom(pull.registered.localRotations[joints[k]], glm::normalize(Quatd(pose.localRotations[joints[k]])));
        for (int a = 0; a < 3; ++a) d[Eigen::Index(3 * k) + a] = turn[a];
    }
    for (int a = 0; a < 3; ++a)
        d[Eigen::Index(3 * joints.size()) + a] = double(pose.rootTranslation[a]) - double(pull.registered.rootTranslation[a]);
    return d;
}

}  // namespace

double lossPerNat(double loss, double personPx, double trust) {
    return loss / (trust * std::max(1.0, personPx));
}

PosePrecision heldAlong(PosePrecision precision, const Vec3d& direction, double times) {
    const Eigen::Index n = Eigen::Index(precision.size());
    Eigen::Map<Matrix> h(precision.matrix.data(), n, n);
    const Eigen::Vector3d v(direction.x, direction.y, direction.z);
    const Eigen::Matrix3d stretch = Eigen::Matrix3d::Identity() + (std::sqrt(times) - 1) * v * v.transpose();
    h.rightCols<3>() = (h.rightCols<3>() * stretch).eval();
    h.bottomRows<3>() = (stretch * h.bottomRows<3>()).eval();
    return precision;
}

void stepPose(Pose& pose, AdamVector& adam, const PoseGradient<double>& gradient, const PoseRates& rates, const PosePull& pull) {
    std::vector<uint32_t> joints;
    if (pull.precision) {
        joints = pull.precision->joints;
    } else {
        joints.resize(pose.localRotations.size());
        std::iota(joints.begin(), joints.end(), 0u);
    }
    const size_t turns = 3 * joints.size();
    std::vector<double> slope(turns + 3), rate(turns + 3, rates.rotation);
    for (size_t k = 0; k < joints.size(); ++k)
        for (int a = 0; a < 3; ++a) slope[3 * k + size_t(a)] = gradient.rotation[joints[k]][a];
    for (int a = 0; a < 3; ++a) slope[turns + size_t(a)] = gradient.rootTranslation[a], rate[turns + size_t(a)] = rates.translation;
    // Adam keeps squares, and a moment that is not finite would stay so.
    if (!std::all_of(slope.begin(), slope.end(), [](double g) { return std::isfinite(g * g); })) return;
    const std::vector<double> step = adam.step(slope, rate);
    Pose moved = pose;
    for (size_t k = 0; k < joints.size(); ++k) {
        Quatf& rotation = moved.localRotations[joints[k]];
        rotation = Quatf(glm::normalize(turnQuaternion({-step[3 * k], -step[3 * k + 1], -step[3 * k + 2]}) * Quatd(rotation)));
    }
    for (int a = 0; a < 3; ++a) moved.rootTranslation[a] -= float(step[turns + size_t(a)]);
    if (!pull.precision || !(pull.lossPerNat > 0)) {
        pose = std::move(moved);
        return;
    }

    // (M + sH) d = M d' with Adam's metric M = diag(√v̂/r).
    const Eigen::Index n = Eigen::Index(pull.precision->size());
    const std::vector<double> spread = adam.spread();
    Eigen::VectorXd metric(n);
    for (Eigen::Index i = 0; i < n; ++i) metric[i] = spread[size_t(i)] / std::max(1e-12, rate[size_t(i)]);
    Eigen::MatrixXd system = pull.lossPerNat * Eigen::Map<const Matrix>(pull.precision->matrix.data(), n, n);
    system.diagonal() += metric;
    system.diagonal().array() += std::max(1e-30, 1e-12 * system.diagonal().maxCoeff());  // what neither the picture nor registration saw
    const Eigen::VectorXd d = system.ldlt().solve(metric.cwiseProduct(deviation(moved, pull)));
    if (!system.allFinite() || !d.allFinite()) return;  // LDLT takes a pivot that is not a number for zero
    for (size_t k = 0; k < joints.size(); ++k) {
        const Eigen::Index i = Eigen::Index(3 * k);
        pose.localRotations[joints[k]] = Quatf(
            glm::normalize(turnQuaternion({d[i], d[i + 1], d[i + 2]}) * glm::normalize(Quatd(pull.registered.localRotations[joints[k]]))));
    }
    for (int a = 0; a < 3; ++a) pose.rootTranslation[a] = float(double(pull.registered.rootTranslation[a]) + d[Eigen::Index(turns) + a]);
}

double costOfDeviation(const Pose& pose, const PosePull& pull) {
    if (!pull.precision) return 0;
    const Eigen::Index n = Eigen::Index(pull.precision->size());
    const Eigen::VectorXd d = deviation(pose, pull);
    return 0.5 * d.dot(Eigen::Map<const Matrix>(pull.precision->matrix.data(), n, n) * d);
}

}  // namespace dpl
