// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/training/trainer/init.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "reconstruction/subject/shape/edge_uses.h"
#include "reconstruction/subject/shape/spread_place.h"
#include "reconstruction/subject/surface/mesh_raster.h"
#include "reconstruction/subject/surface/posed_positions.h"
#include "reconstruction/training/trainer/priors.h"
#include "reconstruction/training/trainer/random.h"
#include "sdk/math/merge_vertices.h"
#include "sdk/math/sh.h"

namespace dpl {
namespace {

bool contains(const std::vector<uint8_t>& list, uint8_t value) {
    return std::find(list.begin(), list.end(), value) != list.end();
}

/** Area at rest, m²; 0 for a triangle that no splat can lie on. */
double triangleArea(const MeshData& mesh, uint32_t triangle) {
    const Triangle& corner = mesh.triangles[triangle];
    const Vec3d a(mesh.restPositions[corner.x]), b(mesh.restPositions[corner.y]), c(mesh.restPositions[corner.z]);
    return restTriangle(a, b, c).valid ? 0.5 * glm::length(glm::cross(b - a, c - a)) : 0;
}

float medianAboveZero(std::vector<float> values, float ifNone) {
    std::erase_if(values, [](float value) { return !(value > 0); });
    if (values.empty()) return ifNone;
    const auto middle = values.begin() + long(values.size() / 2);
    std::nth_element(values.begin(), middle, values.end());
    return *middle;
}

/** 1 for triangles that get splats: all, except those of a clothed body that lie more than kRingsBelowClothes from a seen triangle. */
std::vector<uint8_t> drawnTriangles(const MeshData& mesh, const std::vector<uint8_t>& seen,
                                    const std::vector<std::vector<uint32_t>>& neighbours) {
    if (mesh.layers.size() < 2) return std::vector<uint8_t>(mesh.triangles.size(), 1);
    std::vector<uint8_t> drawn = seen;
    for (int ring = 0; ring < kRingsBelowClothes; ++ring) {
        std::vector<uint8_t> next = drawn;
        for (size_t t = 0; t < drawn.size(); ++t)
            if (drawn[t])
                for (const uint32_t other : neighbours[t]) next[other] = 1;
        drawn = std::move(next);
    }
    const uint32_t bodyEnd = mesh.layers.front().triangleCount;
    std::fill(drawn.begin() + bodyEnd, drawn.end(), uint8_t(1));
    return drawn;
}

/** Whether pictures can show a triangle, by its label. */
class LabelCheck {
public:
    explicit LabelCheck(std::span<const uint8_t> labels) : labels_(labels) {
        for (const uint8_t label : labels) worn_[label] = true;
    }
    /** False where the picture shows what another part of the mesh stands for. Labels without triangles of their own fit everywhere. */
    bool fits(uint32_t triangle, const FramePicture& picture, size_t pixel) const {
        const std::vector<uint8_t>& shown = picture.labels.pixels;
        return labels_.empty() || shown.empty() || shown[pixel] == labels_[triangle] || !worn_[shown[pixel]];
    }

private:
    std::span<const uint8_t> labels_;
    std::array<bool, 256> worn_{};
};

}  // namespace

std::vector<std::vector<uint32_t>> triangleNeighbours(const MeshData& mesh) {
    const auto [place, placeCount] = mergeVertices(mesh.restPositions);
    std::vector<std::vector<uint32_t>> at(placeCount), out(mesh.triangles.size());
    for (uint32_t t = 0; t < mesh.triangles.size(); ++t)
        for (int c = 0; c < 3; ++c) at[place[mesh.triangles[t][c]]].push_back(t);
    for (uint32_t t = 0; t < mesh.triangles.size(); ++t) {
        for (int c = 0; c < 3; ++c)
            for (const uint32_t other : at[place[mesh.triangles[t][c]]])
                if (other != t) out[t].push_back(other);
        std::sort(out[t].begin(), out[t].end());
        out[t].erase(std::unique(out[t].begin(), out[t].end()), out[t].end());
    }
    return out;
}

std::vector<Vec3f> spreadColours(const std::vector<Vec4f>& weighted, const std::vector<std::vector<uint32_t>>& neighbours) {
    std::vector<Vec3f> colour(weighted.size(), Vec3f(0));
    std::vector<uint8_t> known(weighted.size(), 0);
    std::vector<uint32_t> front;
    Vec4d all(0);
    for (uint32_t t = 0; t < weighted.size(); ++t) {
        all += Vec4d(weighted[t]);
        if (weighted[t].w > 0) colour[t] = Vec3f(weighted[t]) / weighted[t].w, known[t] = 1, front.push_back(t);
    }
    while (!front.empty()) {
        std::vector<uint32_t> next;
        for (const uint32_t t : front)
            for (const uint32_t other : neighbours[t])
                if (!known[other]) known[other] = 2, next.push_back(other);
        std::sort(next.begin(), next.end());
        for (const uint32_t t : next) {
            Vec3f sum(0);
            float count = 0;
            for (const uint32_t other : neighbours[t])
                if (known[other] == 1) sum += colour[other], ++count;
            colour[t] = sum / count;
        }
        for (const uint32_t t : next) known[t] = 1;
        front = std::move(next);
    }
    const Vec3f mean = all.w > 0 ? Vec3f(Vec3d(all) / all.w) : Vec3f(0.5f);
    for (size_t t = 0; t < colour.size(); ++t)
        if (!known[t]) colour[t] = mean;
    return colour;
}

std::vector<uint8_t> triangleFlags(std::span<const Vec3f> restPositions, std::span<const Triangle> triangles,
                                   std::span<const uint8_t> labels, std::span<const uint8_t> backs, const InitSettings& settings) {
    const auto [merged, placeCount] = mergeVertices(restPositions);
    std::vector<Triangle> joined;
    for (const Triangle& t : triangles) joined.push_back({merged[t.x], merged[t.y], merged[t.z]});
    std::vector<uint8_t> near(placeCount, 0);
    for (const auto& [edge, count] : edgeUses(joined))
        if (count == 1 && edge.first != edge.second) near[edge.first] = near[edge.second] = 1;
    for (size_t t = 0; t < backs.size(); ++t)
        for (int c = 0; c < 3 && backs[t]; ++c) near[merged[triangles[t][c]]] = 1;
    std::vector<uint8_t> open(triangles.size(), 0);
    for (int ring = 0; ring < 2; ++ring) {
        std::vector<uint8_t> next = near;
        for (size_t t = 0; t < triangles.size(); ++t) {
            const Triangle& corner = triangles[t];
            if (!near[merged[corner.x]] && !near[merged[corner.y]] && !near[merged[corner.z]]) continue;
            open[t] = 1;
            for (int c = 0; c < 3; ++c) next[merged[corner[c]]] = 1;
        }
        near = next;
    }
    std::vector<uint8_t> flags(triangles.size(), 0);
    for (size_t t = 0; t < triangles.size(); ++t) {
        const uint8_t label = t < labels.size() ? labels[t] : 1;
        if (!open[t] && !contains(settings.openLabels, label)) flags[t] |= kSplatSingleFace;
        if (contains(settings.clothLabels, label)) flags[t] |= kSplatCloth;
    }
    return flags;
}

Result<TriangleSight> triangleSight(const SeenMesh& seen, Jobs& jobs) {
    const MeshData& mesh = seen.mesh;
    const LabelCheck check(seen.labels);
    std::vector<float> density(mesh.triangles.size(), 0.0f), shownM2(mesh.triangles.size(), 0.0f);
    std::vector<Vec3f> posed;
    for (const TrainFrame& f : seen.frames) {
        DPL_TRY(const auto picture, checkedPicture(f));
        posedPositions(seen.joints, mesh, f.pose, jobs, posed);
        const MeshRaster raster = rasteriseMesh(posed, mesh.triangles, f.camera);
        for (size_t i = 0; i < raster.triangle.size(); ++i) {
            const uint32_t t = raster.triangle[i];
            if (t == kNoTriangle || !isPerson(picture->mask.pixels[i]) || !check.fits(t, *picture, i)) continue;
            const float pixelsAMetre = float(f.camera.fx) / raster.depthM[i];
            density[t] = std::max(density[t], pixelsAMetre);
            shownM2[t] += 1 / (pixelsAMetre * pixelsAMetre);
        }
    }
    const float median = medianAboveZero(density, 200);
    TriangleSight sight;
    for (const float d : density) sight.sizeFloorM.push_back(0.35f / (d > 0 ? d : median));
    // How often the frames together show each triangle and its neighbours.
    const std::vector<std::vector<uint32_t>> neighbours = triangleNeighbours(mesh);
    std::vector<float> times;
    for (uint32_t t = 0; t < mesh.triangles.size(); ++t) {
        double shown = shownM2[t], area = triangleArea(mesh, t);
        for (const uint32_t other : neighbours[t]) shown += shownM2[other], area += triangleArea(mesh, other);
        times.push_back(area > 0 ? float(shown / area) : 0.0f);
    }
    const float least = priors::kSeenShare * medianAboveZero(times, 0);
    for (const float shown : times) sight.seen.push_back(shown > least);
    return sight;
}

Result<TrainableSplats> initialSplats(const SeenMesh& seen, std::span<const uint8_t> flags, const TriangleSight& sight,
                                      const InitSettings& settings, uint64_t seed, Jobs& jobs) {
    const MeshData& mesh = seen.mesh;
    const size_t triangleCount = mesh.triangles.size();
    const std::vector<std::vector<uint32_t>> neighbours = triangleNeighbours(mesh);
    const std::vector<uint8_t> shown = drawnTriangles(mesh, sight.seen, neighbours);
    std::vector<double> area(triangleCount, 0.0);
    double total = 0;
    for (uint32_t t = 0; t < triangleCount; ++t)
        if (shown[t]) total += area[t] = triangleArea(mesh, t);
    std::vector<uint32_t> perTriangle(triangleCount, 0);
    double carried = 0;  // rounding error, passed on to the next triangle: at most one splat, so tiny triangles make the total larger
    for (size_t t = 0; t < triangleCount; ++t) {
        if (!(area[t] > 0)) continue;
        const double want = area[t] / total * settings.splatCount + carried;
        perTriangle[t] = uint32_t(std::max(1.0, std::floor(want + 0.5)));
        carried = std::clamp(want - perTriangle[t], -1.0, 1.0);
    }
    TrainableSplats s;
    uint32_t count = 0;
    for (uint32_t n : perTriangle) count += n;
    s.resize(count, settings.shDegree);
    s.sizeFloorM = sight.sizeFloorM;
    uint32_t at = 0;
    for (size_t t = 0; t < triangleCount; ++t)
        for (uint32_t k = 0; k < perTriangle[t]; ++k, ++at) {
            s.triangle[at] = uint32_t(t);
            s.flags[at] = flags[t];
            float* row = s.rows.data() + size_t(at) * s.stride;
            const bool single = perTriangle[t] == 1;
            const Vec2d uv = single ? Vec2d(1.0 / 3) : spreadPlace(0.5, k, {hashUniform(seed, 1, t), hashUniform(seed, 2, t)});
            row[kRowU] = float(uv.x), row[kRowV] = float(uv.y);
            row[kRowLogScale1] = row[kRowLogScale2] = float(std::log(std::max(2e-4, 0.8 * std::sqrt(area[t] / perTriangle[t]))));
            row[kRowOpacityLogit] = std::log(0.8f / 0.2f);
        }
    s.indexTriangles(triangleCount);

    const LabelCheck check(seen.labels);
    // Each frame adds the colour that it shows at each splat's position.
    std::vector<Vec3f> sum(count, Vec3f(0));
    std::vector<float> weight(count, 0.0f);
    std::vector<Vec3f> posed;
    for (const TrainFrame& f : seen.frames) {
        DPL_TRY(const auto picture, checkedPicture(f));
        posedPositions(seen.joints, mesh, f.pose, jobs, posed);
        const MeshRaster raster = rasteriseMesh(posed, mesh.triangles, f.camera);
        const Vec3d eye = f.camera.eye();
        const float trust = f.kind == FrameKind::Dynamic ? 0.2f : 1.0f;
        jobs.forRange(count, 4096, [&](size_t begin, size_t end, uint32_t) {
            for (size_t i = begin; i < end; ++i) {
                const Triangle& c = mesh.triangles[s.triangle[i]];
                const float* row = s.rows.data() + i * s.stride;
                const Vec3f p = (1 - row[kRowU] - row[kRowV]) * posed[c.x] + row[kRowU] * posed[c.y] + row[kRowV] * posed[c.z];
                const Vec3d view = f.camera.toView(Vec3d(p));
                if (!(view.z > 0.05)) continue;
                const Vec2d px = f.camera.pixelOf(view);
                if (!(px.x >= 1 && px.y >= 1 && px.x < f.camera.widthPx - 1.0 && px.y < f.camera.heightPx - 1.0)) continue;
                const size_t pixel = size_t(px.y) * f.camera.widthPx + size_t(px.x);
                if (!isPerson(picture->mask.pixels[pixel]) || !(std::abs(raster.depthM[pixel] - view.z) < 0.01)) continue;
                if (!check.fits(s.triangle[i], *picture, pixel)) continue;
                const Vec3f cross = glm::cross(posed[c.y] - posed[c.x], posed[c.z] - posed[c.x]);
                const float length = glm::length(cross);
                const Vec3f toEye = glm::normalize(Vec3f(eye) - p);
                const float cosine = length > 0 ? glm::dot(cross, toEye) / length : 0;
                if (cosine < 0.2f) continue;
                const float w = trust * cosine * cosine / float(view.z);
                const uint8_t* rgb = picture->image.pixels.data() + pixel * 3;
                sum[i] += w / 255.0f * Vec3f(rgb[0], rgb[1], rgb[2]);
                weight[i] += w;
            }
        });
    }
    std::vector<Vec4f> ofTriangle(triangleCount, Vec4f(0));  // weighted colour, weight
    for (size_t i = 0; i < count; ++i) ofTriangle[s.triangle[i]] += Vec4f(sum[i], weight[i]);
    const std::vector<Vec3f> filled = spreadColours(ofTriangle, neighbours);
    for (size_t i = 0; i < count; ++i) {
        const Vec3f colour = weight[i] > 0 ? sum[i] / weight[i] : filled[s.triangle[i]];
        for (int c = 0; c < 3; ++c) s.rows[i * s.stride + kRowSh + uint32_t(c)] = (colour[c] - 0.5f) / float(kShC0);
    }
    s.activateAll(jobs);
    return s;
}

}  // namespace dpl
