// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/input/cameras/rays.h"

#include <cmath>

namespace dpl {

std::optional<Vec3d> pointNearRays(std::span<const Ray> rays, std::span<const double> weights, double robustM) {
    std::optional<Vec3d> point;
    if (rays.size() < 2 || weights.size() != rays.size()) return point;
    for (int round = 0; round < (robustM > 0 ? 10 : 1); ++round) {
        Mat3d a(0.0);
        Vec3d b(0);
        double total = 0;
        for (size_t i = 0; i < rays.size(); ++i) {
            const Mat3d across = Mat3d(1.0) - glm::outerProduct(rays[i].direction, rays[i].direction);
            double w = weights[i];
            if (point && robustM > 0) {
                const Vec3d off = across * (*point - rays[i].origin);
                const double q = 1 + glm::dot(off, off) / (robustM * robustM);
                w /= q * q;
            }
            a += w * across;
            b += w * (across * rays[i].origin);
            total += w;
        }
        if (!(total > 0) || !(glm::determinant(a / total) > 1e-6)) return std::nullopt;  // parallel rays: the determinant is 0
        point = glm::inverse(a) * b;
    }
    return point;
}

}  // namespace dpl
