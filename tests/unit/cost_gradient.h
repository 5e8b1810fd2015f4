// SPDX-License-Identifier: Apache-2.0
// Gradients of Ceres costs against finite differences.
#pragma once

#include <ceres/cost_function.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

namespace dpl::test {

/** Half the sum of the squared residuals at x, whose values are those of all blocks in order, and its gradient where it is asked for. */
inline double halfCost(const ceres::CostFunction& cost, const std::vector<double>& x, std::vector<double>* gradient = nullptr) {
    std::vector<double> residuals(size_t(cost.num_residuals()));
    std::vector<const double*> blocks;
    std::vector<std::vector<double>> jacobians;
    size_t at = 0;
    for (const int size : cost.parameter_block_sizes()) {
        blocks.push_back(x.data() + at);
        jacobians.emplace_back(residuals.size() * size_t(size), NAN);
        at += size_t(size);
    }
    EXPECT_EQ(at, x.size());
    std::vector<double*> pointers;
    for (auto& jacobian : jacobians) pointers.push_back(jacobian.data());
    EXPECT_TRUE(cost.Evaluate(blocks.data(), residuals.data(), gradient ? pointers.data() : nullptr));
    double sum = 0;
    for (const double r : residuals) sum += 0.5 * r * r;
    if (gradient) {
        gradient->clear();
        for (size_t b = 0; b < jacobians.size(); ++b) {
            const auto size = size_t(cost.parameter_block_sizes()[b]);
            for (size_t c = 0; c < size; ++c) {
                gradient->push_back(0);
                for (size_t r = 0; r < residuals.size(); ++r) gradient->back() += residuals[r] * jacobians[b][r * size + c];
            }
        }
    }
    return sum;
}

/** Returns the gradient at x. relative: of its largest entry. */
inline std::vector<double> expectGradient(const ceres::CostFunction& cost, const std::vector<double>& x, double relative = 1e-5) {
    std::vector<double> gradient;
    const double value = halfCost(cost, x, &gradient);
    EXPECT_NEAR(value, halfCost(cost, x), 1e-9 * value) << "with and without Jacobian";
    double largest = 0;
    for (const double g : gradient) largest = std::max(largest, std::abs(g));
    EXPECT_GT(largest, 0);
    for (size_t i = 0; i < x.size(); ++i) {
        const double h = 1e-6;
        std::vector<double> more = x, less = x;
        more[i] += h, less[i] -= h;
        EXPECT_NEAR(gradient[i], (halfCost(cost, more) - halfCost(cost, less)) / (2 * h), relative * largest) << i;
    }
    return gradient;
}

}  // namespace dpl::test
