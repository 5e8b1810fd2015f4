// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/judging/coach/joint_map.h"

#include "reconstruction/judging/coach/weighted_median.h"

namespace dpl {

CaptureMapData captureMapOf(const MeshData& surface, size_t jointCount, std::span<const SeenTriangle> map,
                            std::span<const uint8_t> viewable) {
    struct Side {
        std::vector<WeightedValue> pixel, detail, views;
        double seen = 0, all = 0;  // m²
    };
    std::vector<Side> sides(jointCount * kCaptureSides);
    const std::vector<uint32_t> joints = jointOfTriangles(surface);
    const std::vector<Vec3f> normals = restNormals(surface);
    const std::vector<double> areas = restAreas(surface);
    for (size_t t = 0; t < map.size(); ++t) {
        if (!viewable[t]) continue;
        Side& side = sides[joints[t] * kCaptureSides + size_t(sideOf(normals[t]))];
        side.all += areas[t];
        if (!map[t].seen()) continue;
        side.seen += areas[t];
        side.pixel.push_back({map[t].pixelM, areas[t]}), side.detail.push_back({map[t].detailM, areas[t]});
        side.views.push_back({double(map[t].views), areas[t]});
    }
    CaptureMapData out;
    for (Side& side : sides) {
        CaptureSide& to = out.sides.emplace_back();
        if (!(side.seen > 0) || 2 * side.seen < side.all) continue;
        to.pixelM = float(weightedMedian(std::move(side.pixel))), to.detailM = float(weightedMedian(std::move(side.detail)));
        to.views = uint32_t(weightedMedian(std::move(side.views)));
    }
    return out;
}

}  // namespace dpl
