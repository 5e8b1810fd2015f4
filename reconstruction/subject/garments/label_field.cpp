// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/subject/garments/label_field.h"

#include <algorithm>
#include <array>
#include <map>

#include "reconstruction/input/capture/frame_picture.h"
#include "reconstruction/subject/shape/large_steps.h"
#include "reconstruction/subject/surface/mesh_raster.h"

namespace dpl {
namespace {

constexpr size_t kBatch = 8;         // views whose pictures are held at once
constexpr double kMinCosine = 0.15;  // a surface seen at a flatter angle does not vote: half a pixel of sway changes what is seen
constexpr uint8_t kNoColumn = 255;

}  // namespace

uint32_t LabelField::best(size_t vertex) const {
    const float* row = &score[vertex * columns()];
    return uint32_t(std::max_element(row, row + columns()) - row);
}

std::vector<ScanLabel> votingLabels(std::span<const ScanLabel> labels) {
    std::vector<ScanLabel> out;
    for (const ScanLabel& label : labels)
        if (label.name == "body") out.push_back(label);
    if (out.empty()) {
        uint8_t free = 1;
        while (free < 255 && std::any_of(labels.begin(), labels.end(), [&](const ScanLabel& l) { return l.value == free; })) ++free;
        out.push_back({"body", free});
    }
    out.resize(1);
    for (const ScanLabel& label : labels)
        if (label.name != "background" && label.name != "body" && label.value != 0) out.push_back(label);
    return out;
}

Result<LabelField> voteLabels(const SurfaceMesh& mesh, std::span<const GarmentView> views, std::span<const Camerad> cameras,
                              std::span<const ScanLabel> scanLabels, double smoothingM, Jobs& jobs) {
    LabelField field;
    field.labels = votingLabels(scanLabels);
    const size_t columns = field.columns(), count = mesh.positions.size();
    std::array<uint8_t, 256> columnOf;
    columnOf.fill(kNoColumn);
    for (size_t c = 0; c < columns; ++c) columnOf[field.labels[c].value] = uint8_t(c);

    std::vector<float> votes(count * columns, 0.0f);
    std::vector<MeshRaster> rasters(kBatch);
    for (size_t first = 0; first < views.size(); first += kBatch) {
        const size_t batch = std::min(kBatch, views.size() - first);
        jobs.forBlocks(batch, [&](size_t k, uint32_t) {
            if (!views[first + k].labels.pixels.empty()) rasters[k] = rasteriseMesh(mesh.positions, mesh.triangles, cameras[first + k]);
        });
        for (size_t k = 0; k < batch; ++k) {
            const GarmentView& view = views[first + k];
            if (view.labels.pixels.empty()) continue;
            const Vec3d eye = cameras[first + k].eye();
            for (size_t pixel = 0; pixel < rasters[k].triangle.size(); ++pixel) {
                const uint32_t id = rasters[k].triangle[pixel];
                if (id == kNoTriangle || !isPerson(view.mask.pixels[pixel])) continue;
                const uint8_t column = columnOf[view.labels.pixels[pixel]];
                if (column == kNoColumn) continue;
                const Triangle& t = mesh.triangles[id];
                const double cosine = frontCosine(mesh.positions, t, eye);
                if (cosine < kMinCosine) continue;
                const Vec2f uv = rasters[k].barycentric[pixel];
                const float share[3] = {1 - uv.x - uv.y, uv.x, uv.y};
                for (int i = 0; i < 3; ++i) votes[t[i] * columns + column] += share[i] * float(cosine);
            }
        }
    }

    DPL_TRY(const LargeSteps smooth, LargeSteps::create(mesh.positions, mesh.triangles, smoothingM));
    std::vector<Vec3f> in(count), out(count), u(smooth.size());
    std::vector<float> spread(count * columns);
    for (size_t c = 0; c < columns; c += 3) {
        for (size_t v = 0; v < count; ++v)
            for (size_t k = 0; k < 3; ++k) in[v][int(k)] = c + k < columns ? votes[v * columns + c + k] : 0;
        smooth.backward(in, u, 0);
        smooth.offsets(u, out, 0);
        for (size_t v = 0; v < count; ++v)
            for (size_t k = 0; k < 3 && c + k < columns; ++k) spread[v * columns + c + k] = std::max(0.0f, out[v][int(k)]);
    }
    std::vector<float> weights(count);
    for (size_t v = 0; v < count; ++v)
        for (size_t c = 0; c < columns; ++c) weights[v] += spread[v * columns + c];
    std::vector<float> sorted;  // of the vertices that pictures saw
    for (size_t v = 0; v < count; ++v) {
        const auto own = votes.begin() + long(v * columns);
        if (std::any_of(own, own + long(columns), [](float vote) { return vote > 0; })) sorted.push_back(weights[v]);
    }
    std::sort(sorted.begin(), sorted.end());
    const float median = sorted.empty() ? 0 : sorted[sorted.size() / 2];
    field.seen.assign(count, 0);
    field.score.assign(count * columns, 0);
    for (size_t v = 0; v < count; ++v) {
        if (median > 0) field.seen[v] = weights[v] / median;
        for (size_t c = 0; c < columns; ++c)
            field.score[v * columns + c] = weights[v] > 0 ? spread[v * columns + c] / weights[v] : float(c == 0);
    }
    return field;
}

std::vector<float> vertexAreas(const SurfaceMesh& mesh) {
    std::vector<float> area(mesh.positions.size(), 0);
    for (const Triangle& t : mesh.triangles) {
        const Vec3f n = glm::cross(mesh.positions[t.y] - mesh.positions[t.x], mesh.positions[t.z] - mesh.positions[t.x]);
        for (int k = 0; k < 3; ++k) area[t[k]] += glm::length(n) / 6;
    }
    return area;
}

void removeIslands(const SurfaceMesh& mesh, LabelField& field, std::span<const double> minAreaM2) {
    const auto neighbours = vertexNeighbours(mesh.positions.size(), mesh.triangles);
    const std::vector<float> areas = vertexAreas(mesh);
    const size_t columns = field.columns();
    for (int round = 0; round < 4; ++round) {  // an island within an island needs a second round
        std::vector<uint32_t> label(mesh.positions.size());
        for (uint32_t v = 0; v < label.size(); ++v) label[v] = field.best(v);
        std::vector<uint8_t> visited(label.size(), 0);
        bool changed = false;
        for (uint32_t seed = 0; seed < label.size(); ++seed) {
            if (visited[seed]) continue;
            std::vector<uint32_t> piece{seed};
            visited[seed] = 1;
            double area = 0;
            std::map<uint32_t, uint32_t> around;  // label → edges to it
            for (size_t i = 0; i < piece.size(); ++i) {
                area += areas[piece[i]];
                for (uint32_t n : neighbours[piece[i]]) {
                    if (label[n] != label[seed]) ++around[label[n]];
                    if (label[n] != label[seed] || visited[n]) continue;
                    visited[n] = 1;
                    piece.push_back(n);
                }
            }
            if (around.empty() || area >= minAreaM2[label[seed]]) continue;
            const auto winner = std::max_element(around.begin(), around.end(), [](auto& a, auto& b) { return a.second < b.second; });
            for (uint32_t v : piece) std::swap(field.score[v * columns + label[seed]], field.score[v * columns + winner->first]);
            changed = true;
        }
        if (!changed) break;
    }
}

}  // namespace dpl
