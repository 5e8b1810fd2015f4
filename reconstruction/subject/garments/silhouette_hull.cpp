// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/subject/garments/silhouette_hull.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "reconstruction/input/capture/frame_picture.h"
#include "reconstruction/subject/garments/priors.h"
#include "sdk/math/projection.h"

namespace dpl {
namespace {

constexpr int kSmoothingRounds = 12;
constexpr float kFarOutsideM = 1.0f;  // where too few views look
constexpr size_t kMaxViews = 512;     // that one evaluation holds on its stack; of more views an even share is used

/** Distance to the outline at pixel centres, smoothed by a pixel because the outline of a binary mask is a staircase. */
std::vector<float> signedDistance(const ImageGrey8& mask) {
    const int width = int(mask.widthPx), height = int(mask.heightPx);
    cv::Mat inside(height, width, CV_8U), outside(height, width, CV_8U);
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) {
            const bool person = isPerson(mask.pixels[size_t(y) * mask.widthPx + size_t(x)]);
            inside.at<uint8_t>(y, x) = person ? 255 : 0;
            outside.at<uint8_t>(y, x) = person ? 0 : 255;
        }
    cv::Mat toOutside, toInside;
    cv::distanceTransform(inside, toOutside, cv::DIST_L2, cv::DIST_MASK_PRECISE);
    cv::distanceTransform(outside, toInside, cv::DIST_L2, cv::DIST_MASK_PRECISE);
    cv::Mat distance = toInside - toOutside;
    // Both transforms measure to pixel centres; the outline is half a pixel before them.
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) {
            float& d = distance.at<float>(y, x);
            d += d > 0 ? -0.5f : 0.5f;
            d = std::clamp(d, -1e4f, 1e4f);  // a picture without an outside has no distance
        }
    cv::GaussianBlur(distance, distance, cv::Size(0, 0), 1.0, 1.0, cv::BORDER_REPLICATE);
    return {distance.begin<float>(), distance.end<float>()};
}

/** Removes the ridges between facets of the hull and the noise of outlines without shrinking it (Taubin 1995, λ|μ). */
void smooth(SurfaceMesh& mesh) {
    const auto neighbours = vertexNeighbours(mesh.positions.size(), mesh.triangles);
    for (int round = 0; round < kSmoothingRounds; ++round)
        for (const float step : {0.5f, -0.52f}) {
            std::vector<Vec3f> next = mesh.positions;
            for (size_t v = 0; v < next.size(); ++v) {
                Vec3f mean(0);
                for (uint32_t n : neighbours[v]) mean += mesh.positions[n] / float(neighbours[v].size());
                if (!neighbours[v].empty()) next[v] += step * (mean - mesh.positions[v]);
            }
            mesh.positions = std::move(next);
        }
}

}  // namespace

SilhouetteField::SilhouetteField(std::span<const GarmentView> views, std::span<const Camerad> cameras, Jobs& jobs) {
    std::vector<size_t> used;
    for (size_t i = 0; i < views.size(); ++i)
        if (std::any_of(views[i].mask.pixels.begin(), views[i].mask.pixels.end(), isPerson)) used.push_back(i);
    const size_t count = std::min(used.size(), kMaxViews);
    maps_.resize(count);
    jobs.forBlocks(count, [&](size_t k, uint32_t) {
        const size_t i = used[k * used.size() / count];
        maps_[k] = {cameras[i].cast<float>(), signedDistance(views[i].mask)};
    });
}

float SilhouetteField::operator()(const Vec3f& point) const {
    float distances[kMaxViews];
    size_t seen = 0;
    for (const Map& map : maps_) {
        const Cameraf& c = map.camera;
        const Vec3f view = c.toView(point);
        if (!(view.z > float(kNearM))) continue;
        const Vec2f px = c.pixelOf(view) - 0.5f;
        if (!(px.x > -0.5f && px.y > -0.5f && px.x < float(c.widthPx) - 0.5f && px.y < float(c.heightPx) - 0.5f)) continue;
        const float x = std::clamp(px.x, 0.0f, float(c.widthPx - 1)), y = std::clamp(px.y, 0.0f, float(c.heightPx - 1));
        const auto x0 = uint32_t(x), y0 = uint32_t(y), x1 = std::min(x0 + 1, c.widthPx - 1), y1 = std::min(y0 + 1, c.heightPx - 1);
        const float fx = x - float(x0), fy = y - float(y0);
        const auto at = [&](uint32_t column, uint32_t row) { return map.distancePx[size_t(row) * c.widthPx + column]; };
        const float distancePx = (1 - fy) * ((1 - fx) * at(x0, y0) + fx * at(x1, y0)) + fy * ((1 - fx) * at(x0, y1) + fx * at(x1, y1));
        distances[seen++] = distancePx * view.z / c.fx;
    }
    if (seen == 0 || seen * 3 < maps_.size()) return kFarOutsideM;
    const auto outvoted = size_t(priors::kHullOutvotedShare * double(seen));
    std::nth_element(distances, distances + outvoted, distances + seen, std::greater<>());
    return distances[outvoted];
}

SurfaceMesh meshHull(const ScalarField& field, const Vec3f& low, const Vec3f& high, const HullOptions& options, Jobs& jobs) {
    SampleGrid grid;
    appendSamples(grid.xs, low.x, high.x, options.cellM);
    appendSamples(grid.ys, low.y, high.y, options.cellM);
    appendSamples(grid.zs, low.z, high.z, options.cellM);
    const SurfaceMesh raw = marchField(field, grid, jobs);
    if (raw.triangles.empty()) return {};
    SurfaceMesh hull = remesh(largestPiece(raw), field, {[&](const Vec3f&) { return options.edgeM; }, 6}, jobs);
    smooth(hull);
    return hull;
}

}  // namespace dpl
