// SPDX-License-Identifier: Apache-2.0
#include "apps/reference/reference_mesh.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <sstream>

namespace dpl {
namespace {

constexpr double kNone = std::numeric_limits<double>::infinity();

/** A triangle in view space, and its box in the image, px; unbounded when the triangle reaches the near plane. */
struct ViewTriangle {
    glm::dvec3 a, e1, e2;
    glm::dvec2 low{-kNone}, high{kNone};
};

std::vector<ViewTriangle> inView(std::span<const glm::dvec3> positions, std::span<const glm::uvec3> triangles,
                                 const ReferenceCamera& camera) {
    std::vector<ViewTriangle> list;
    for (const glm::uvec3& t : triangles) {
        glm::dvec3 c[3];
        for (int k = 0; k < 3; ++k) c[k] = camera.rotation * positions[t[k]] + camera.translation;
        ViewTriangle v{c[0], c[1] - c[0], c[2] - c[0]};
        if (std::min({c[0].z, c[1].z, c[2].z}) > 0.05) {
            v.low = glm::dvec2(kNone), v.high = glm::dvec2(-kNone);
            for (const glm::dvec3& p : c) {
                const glm::dvec2 px(camera.fx * p.x / p.z + camera.cx, camera.fy * p.y / p.z + camera.cy);
                v.low = glm::min(v.low, px), v.high = glm::max(v.high, px);
            }
        }
        list.push_back(v);
    }
    return list;
}

double depthAt(const std::vector<ViewTriangle>& triangles, const ReferenceCamera& camera, const glm::dvec2& pointPx) {
    const glm::dvec3 ray((pointPx.x - camera.cx) / camera.fx, (pointPx.y - camera.cy) / camera.fy, 1);
    double nearest = kNone;
    for (const ViewTriangle& t : triangles) {
        if (pointPx.x < t.low.x || pointPx.y < t.low.y || pointPx.x > t.high.x || pointPx.y > t.high.y) continue;
        const glm::dvec3 p = glm::cross(ray, t.e2);
        const double det = glm::dot(t.e1, p);
        if (!(std::abs(det) > 0)) continue;
        const double u = -glm::dot(t.a, p) / det;
        const glm::dvec3 q = glm::cross(-t.a, t.e1);
        const double v = glm::dot(ray, q) / det, z = glm::dot(t.e2, q) / det;
        if (u >= 0 && v >= 0 && u + v <= 1 && z > 0.05) nearest = std::min(nearest, z);
    }
    return nearest;
}

}  // namespace

double referenceMeshDepth(std::span<const glm::dvec3> positions, std::span<const glm::uvec3> triangles, const ReferenceCamera& camera,
                          const glm::dvec2& pointPx) {
    return depthAt(inView(positions, triangles, camera), camera, pointPx);
}

MeshDepthReport compareMeshDepth(std::span<const float> depthM, std::span<const glm::dvec3> positions,
                                 std::span<const glm::uvec3> triangles, const ReferenceCamera& camera, double slackPx, double slack) {
    MeshDepthReport report{depthM.size(), 0, 0, 0, {}};
    const std::vector<ViewTriangle> list = inView(positions, triangles, camera);
    for (size_t i = 0; i < depthM.size(); ++i) {
        const glm::dvec2 centre(double(i % camera.widthPx) + 0.5, double(i / camera.widthPx) + 0.5);
        double low = kNone, high = 0;
        for (int dy = -1; dy <= 1; ++dy)
            for (int dx = -1; dx <= 1; ++dx) {
                const double z = depthAt(list, camera, centre + slackPx * glm::dvec2(dx, dy));
                low = std::min(low, z), high = std::max(high, z);
            }
        const double got = depthM[i] == 0 ? kNone : double(depthM[i]);
        report.covered += got < kNone;
        report.sharp += low == kNone || high - low < 0.01 * low;
        if (got >= low * (1 - slack) && got <= high * (1 + slack)) continue;
        if (report.wrong++ > 0) continue;
        std::ostringstream text;
        text << "pixel " << i % camera.widthPx << ", " << i / camera.widthPx << ": " << got << " m, the referee sees " << low << " to "
             << high << " m";
        report.firstWrong = text.str();
    }
    return report;
}

}  // namespace dpl
