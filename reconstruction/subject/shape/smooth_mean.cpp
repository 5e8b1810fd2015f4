// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/subject/shape/smooth_mean.h"

#include <algorithm>

namespace dpl {

std::vector<Vec3f> smoothMean(const LargeSteps& smooth, const std::vector<Vec3f>& values, const std::vector<float>& weights,
                              float epsilon) {
    std::vector<Vec3f> u(smooth.size()), sum(values.size()), weight(values.size());
    smooth.backward(values, u, 0);
    smooth.offsets(u, sum, 0);
    for (size_t v = 0; v < weight.size(); ++v) weight[v] = Vec3f(weights[v]);
    smooth.backward(weight, u, 0);
    smooth.offsets(u, weight, 0);
    for (size_t v = 0; v < sum.size(); ++v) sum[v] /= std::max(0.0f, weight[v].x) + epsilon;
    return sum;
}

}  // namespace dpl
