// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/subject/hands/finger_precision.h"

#include <Eigen/Dense>
#include <algorithm>

#include "reconstruction/subject/body/priors.h"

namespace dpl {
namespace {

constexpr double kNoHingeRad = 0.01;    // standard deviation of a turn about an axis that a joint lacks
constexpr double kLeastRoomRad = 0.02;  // to a limit that the fit met

using Matrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
constexpr Eigen::Index kTurns = Eigen::Index(kHandTurns);

Eigen::Vector3d eigen(const Vec3d& v) {
    return {v.x, v.y, v.z};
}

}  // namespace

std::array<double, kHandTurns * kHandTurns> turnPrecision(const HandRig& hand, const HandView& view, const HandTurns& turns,
                                                          const std::array<double, kWristSize>& wrist, const HandTurns& prior) {
    const double outlierSigmas = priors::kKeypointOutlierSigmas;
    auto* points = new HandCost(hand, view, outlierSigmas);
    const int count = points->residuals();
    const ceres::AutoDiffCostFunction<HandCost, ceres::DYNAMIC, int(kHandTurns), kWristSize> cost(points, count);
    Matrix perTurn = Matrix::Zero(count, kTurns), perWrist = Matrix::Zero(count, kWristSize);
    std::vector<double> residuals(size_t(count), 0.0);
    const double* blocks[] = {turns.data(), wrist.data()};
    double* jacobians[] = {perTurn.data(), perWrist.data()};
    if (!cost.Evaluate(blocks, residuals.data(), jacobians)) perTurn.setZero(), perWrist.setZero();

    Matrix ofWrist = perWrist.transpose() * perWrist;
    for (int i = 0; i < kWristSize; ++i)
        ofWrist(i, i) += 1 / std::pow(i < 3 ? priors::kWristTurnRad : priors::kWristShiftM, 2);  // above 0, so it can be inverted
    const Matrix both = perWrist.transpose() * perTurn;
    Matrix own = perTurn.transpose() * perTurn - both.transpose() * ofWrist.ldlt().solve(both);
    for (size_t t = 0; t < kHandTurns; ++t) {
        const double room = std::max(kLeastRoomRad, std::min(turns[t] - hand.low[t], hand.high[t] - turns[t]));
        own(Eigen::Index(t), Eigen::Index(t)) += 1 / (prior[t] * prior[t]) + 1 / (room * room);
    }
    std::array<double, kHandTurns * kHandTurns> out{};
    Eigen::Map<Matrix>(out.data(), kTurns, kTurns) = 0.5 * (own + own.transpose());
    return out;
}

PosePrecision jointPrecision(const HandRig& hand, const HandTurns& turns, const std::array<double, kHandTurns * kHandTurns>& precision) {
    PosePrecision out;
    out.joints.push_back(0);
    for (const FingerRig& finger : hand.fingers) out.joints.insert(out.joints.end(), finger.joints.begin(), finger.joints.end());
    std::sort(out.joints.begin(), out.joints.end());
    const Eigen::Index n = Eigen::Index(out.size());
    const auto rowOf = [&](uint32_t joint) {
        return 3 * Eigen::Index(std::lower_bound(out.joints.begin(), out.joints.end(), joint) - out.joints.begin());
    };
    // Which turns of the hinges a turn of the joints is, and what of it is none.
    Matrix hinges = Matrix::Zero(kTurns, n), held = Matrix::Zero(n, n);
    for (size_t f = 0; f < kHandFingers; ++f) {
        const FingerRig& finger = hand.fingers[f];
        const double* t = &turns[f * kFingerTurns];
        for (size_t b = 0; b < 3; ++b) {
            Eigen::Matrix<double, 3, Eigen::Dynamic> axes(3, b == 0 ? 2 : 1);
            axes.col(0) = eigen(b == 0 ? glm::angleAxis(t[kBaseSide], finger.sideAxis) * finger.bendAxes[0] : finger.bendAxes[b]);
            if (b == 0) axes.col(1) = eigen(finger.sideAxis);
            const Eigen::MatrixXd inverse = axes.completeOrthogonalDecomposition().pseudoInverse();
            const Eigen::Index column = rowOf(finger.joints[b]), first = Eigen::Index(f * kFingerTurns);
            for (Eigen::Index k = 0; k < axes.cols(); ++k)
                hinges.row(b == 0 ? first + (k == 0 ? kBaseBend : kBaseSide) : first + (b == 1 ? kMiddleBend : kEndBend))
                    .segment(column, 3) = inverse.row(k);
            held.block(column, column, 3, 3) = (Eigen::Matrix3d::Identity() - axes * inverse) / (kNoHingeRad * kNoHingeRad);
        }
    }
    out.matrix.resize(size_t(n * n));
    Eigen::Map<Matrix>(out.matrix.data(), n, n) =
        hinges.transpose() * Eigen::Map<const Matrix>(precision.data(), kTurns, kTurns) * hinges + held;
    return out;
}

}  // namespace dpl
