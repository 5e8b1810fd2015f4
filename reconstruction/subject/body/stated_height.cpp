// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/subject/body/stated_height.h"

#include <ceres/normal_prior.h>

#include <algorithm>

#include "reconstruction/subject/body/priors.h"

namespace dpl {

ceres::CostFunction* makeStatedHeight(const BodyModel& body, double heightM) {
    const std::vector<Vec3f>& p = body.mesh.restPositions;
    const auto [low, high] = std::minmax_element(p.begin(), p.end(), [](const Vec3f& a, const Vec3f& b) { return a.y < b.y; });
    if (low == p.end()) return nullptr;
    const size_t bottom = size_t(low - p.begin()), top = size_t(high - p.begin());
    ceres::Vector rise(Eigen::Index(body.morphs.size()));  // of a morph at value 1, metres
    for (size_t m = 0; m < body.morphs.size(); ++m)
        rise[Eigen::Index(m)] = double(body.morphs[m].vertexOffsets[top].y - body.morphs[m].vertexOffsets[bottom].y);
    if (!(rise.squaredNorm() > 1e-8)) return nullptr;
    const double missing = heightM - double(high->y - low->y);
    return new ceres::NormalPrior(rise.transpose() / priors::kStatedHeightM, rise * (missing / rise.squaredNorm()));
}

}  // namespace dpl
