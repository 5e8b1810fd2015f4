// SPDX-License-Identifier: Apache-2.0
// Central differences in double precision, and the comparison that all gradient tests use.
#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <string>
#include <vector>

namespace dpl::test {

/** (f(x+h) − f(x−h)) / 2h for every entry of x. */
inline std::vector<double> differences(std::vector<double> x, const std::function<double(const std::vector<double>&)>& f, double h) {
    std::vector<double> g(x.size());
    for (size_t i = 0; i < x.size(); ++i) {
        const double keep = x[i];
        x[i] = keep + h;
        const double up = f(x);
        x[i] = keep - h;
        const double down = f(x);
        x[i] = keep;
        g[i] = (up - down) / (2 * h);
    }
    return g;
}

/** Every entry may differ by `relative` times the largest numeric entry, which must be above 1e-9. With expectZero all analytic entries
 * must be exactly 0. */
inline void expectGradients(const std::vector<double>& analytic, const std::vector<double>& numeric, double relative,
                            const std::string& what, bool expectZero = false) {
    ASSERT_EQ(analytic.size(), numeric.size()) << what;
    double largest = 0;
    for (double g : numeric) largest = std::max(largest, std::abs(g));
    if (expectZero) {
        for (size_t i = 0; i < analytic.size(); ++i) EXPECT_EQ(analytic[i], 0) << what << " entry " << i;
        EXPECT_LT(largest, 1e-12) << what;
        return;
    }
    EXPECT_GT(largest, 1e-9) << what << ": the case must not be flat";
    for (size_t i = 0; i < analytic.size(); ++i) EXPECT_NEAR(analytic[i], numeric[i], relative * largest) << what << " entry " << i;
}

}  // namespace dpl::test
