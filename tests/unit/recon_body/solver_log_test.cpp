// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/subject/body/solver_log.h"

#include <ceres/ceres.h>
#include <gtest/gtest.h>

namespace dpl {
namespace {

/** One residual whose squared slope is beyond double, so that the linear solver fails. */
struct TooSteep : ceres::SizedCostFunction<1, 1> {
    bool Evaluate(double const* const*, double* residuals, double** jacobians) const override {
        residuals[0] = 1;
        if (jacobians && jacobians[0]) jacobians[0][0] = 1e200;
        return true;
    }
};

std::string saidWhileSolving() {
    double x = 0;
    ceres::Problem problem;
    problem.AddResidualBlock(new TooSteep, nullptr, &x);
    ceres::Solver::Options options;
    options.logging_type = ceres::SILENT;
    options.linear_solver_type = ceres::DENSE_NORMAL_CHOLESKY;
    options.jacobi_scaling = false;
    ceres::Solver::Summary summary;
    testing::internal::CaptureStderr();
    ceres::Solve(options, &problem, &summary);
    return testing::internal::GetCapturedStderr();
}

TEST(SolverLog, isSilencedForAFailedStep) {
    if (saidWhileSolving().empty()) GTEST_SKIP() << "this Ceres says nothing by itself: it was built without glog";
    silenceSolverLog();
    EXPECT_EQ(saidWhileSolving(), "");
}

}  // namespace
}  // namespace dpl
