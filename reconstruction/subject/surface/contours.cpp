// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/subject/surface/contours.h"

#include <cmath>
#include <nanoflann.hpp>

namespace dpl {
namespace {

/** nanoflann adaptor: points with scaled normals, 4 dimensions. */
struct Cloud {
    std::span<const ContourPoint> points;
    double turnPx;
    size_t kdtree_get_point_count() const { return points.size(); }
    double kdtree_get_pt(size_t i, size_t axis) const {
        return axis < 2 ? points[i].px[int(axis)] : turnPx * points[i].normal[int(axis) - 2];
    }
    template <class Box>
    bool kdtree_get_bbox(Box&) const {
        return false;
    }
};
using Tree = nanoflann::KDTreeSingleIndexAdaptor<nanoflann::L2_Simple_Adaptor<double, Cloud>, Cloud, 4, uint32_t>;

}  // namespace

std::vector<ContourPoint> contourPoints(std::span<const uint8_t> inside, uint32_t width, uint32_t height) {
    std::vector<ContourPoint> points;
    const auto at = [&](int x, int y) {
        return x >= 0 && y >= 0 && x < int(width) && y < int(height) && inside[size_t(y) * width + size_t(x)];
    };
    // Normal: minus the gradient of the picture in a 7 × 7 window around the edge.
    const auto normalAt = [&](int x, int y, Vec2d crack) {
        Vec2d sum = 1e-3 * crack;
        for (int dy = -3; dy <= 3; ++dy)
            for (int dx = -3; dx <= 3; ++dx)
                if (!at(x + dx, y + dy) && dx * dx + dy * dy <= 10) sum += Vec2d(dx, dy);
        return glm::normalize(sum);
    };
    for (int y = 0; y < int(height); ++y)
        for (int x = 0; x < int(width); ++x) {
            if (!at(x, y)) continue;
            const auto add = [&](int dx, int dy) {
                if (x + dx < 0 || y + dy < 0 || x + dx >= int(width) || y + dy >= int(height) || at(x + dx, y + dy)) return;
                points.push_back({{x + 0.5 + 0.5 * dx, y + 0.5 + 0.5 * dy}, normalAt(x, y, {dx, dy}), uint32_t(y) * width + uint32_t(x)});
            };
            add(-1, 0), add(1, 0), add(0, -1), add(0, 1);
        }
    return points;
}

std::vector<uint32_t> matchContours(std::span<const ContourPoint> from, std::span<const ContourPoint> to, double reachPx, double turnPx) {
    std::vector<uint32_t> matches(from.size(), UINT32_MAX);
    if (to.empty()) return matches;
    const Cloud cloud{to, turnPx};
    const Tree tree(4, cloud, nanoflann::KDTreeSingleIndexAdaptorParams(16));
    for (size_t i = 0; i < from.size(); ++i) {
        const double query[4] = {from[i].px.x, from[i].px.y, turnPx * from[i].normal.x, turnPx * from[i].normal.y};
        uint32_t found = UINT32_MAX;
        double distance2 = 0;
        nanoflann::KNNResultSet<double, uint32_t> best(1);
        best.init(&found, &distance2);
        tree.findNeighbors(best, query, {});  // default parameters: the type changed its name in nanoflann 1.5
        if (found == UINT32_MAX || distance2 > reachPx * reachPx + turnPx * turnPx) continue;
        if (glm::dot(from[i].normal, to[found].normal) > 0) matches[i] = found;
    }
    return matches;
}

}  // namespace dpl
