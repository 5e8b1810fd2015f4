// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/output/package/mesh_atlas.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <unordered_map>

#include "reconstruction/output/package/atlas_charts.h"
#include "reconstruction/output/package/atlas_packing.h"
#include "sdk/core/task.h"

namespace dpl {
namespace {

constexpr uint32_t kBlocks = 512, kLeastBlockPx = 4;  // packing works on blocks, at most this many along a side
constexpr float kBestFill = 0.85f;                    // share of the picture that charts never exceed: where the search for a scale begins
constexpr float kScaleStep = 0.96f;
constexpr int kScaleSteps = 60;  // down to a tenth

/** A chart in texels at some scale, its corners from (0, 0) on. */
struct FlatChart {
    std::vector<std::array<Vec2f, 3>> corners;
    Vec2f size{0};
};

FlatChart flatChart(const AtlasChart& chart, std::span<const Vec3f> positions, std::span<const Triangle> triangles, float perM) {
    FlatChart out;
    Vec2f low(std::numeric_limits<float>::max()), high(-std::numeric_limits<float>::max());
    for (const uint32_t t : chart.triangles) {
        auto& c = out.corners.emplace_back();
        for (int k = 0; k < 3; ++k) {
            const Vec2f p = chart.place(positions[triangles[t][k]]);
            c[k] = perM * Vec2f(p.x, -p.y);  // rows go down
            low = glm::min(low, c[k]), high = glm::max(high, c[k]);
        }
    }
    for (auto& c : out.corners)
        for (Vec2f& p : c) p -= low;
    out.size = high - low;
    return out;
}

/** Blocks that a chart and its gutter touch. The chart begins `gutter` texels within the first block. */
BlockShape blocksOf(const FlatChart& chart, uint32_t blockPx, uint32_t gutterPx) {
    const float gutter = float(gutterPx);
    BlockShape out;
    out.columns = uint32_t((chart.size.x + 2 * gutter) / float(blockPx)) + 1,
    out.rows = uint32_t((chart.size.y + 2 * gutter) / float(blockPx)) + 1;
    out.taken.assign(size_t(out.columns) * out.rows, 0);
    for (const auto& c : chart.corners) {
        // The rows of blocks that the triangle and its gutter cross, and of each row what they cross in it.
        const float first = std::min({c[0].y, c[1].y, c[2].y}), last = std::max({c[0].y, c[1].y, c[2].y}) + 2 * gutter;
        for (uint32_t y = uint32_t(first / float(blockPx)); y <= uint32_t(last / float(blockPx)); ++y) {
            const float from = float(y * blockPx) - 2 * gutter, to = float((y + 1) * blockPx);  // of the chart's own rows
            float left = std::numeric_limits<float>::max(), right = -left;
            for (int k = 0; k < 3; ++k) {
                const Vec2f a = c[k], b = c[(k + 1) % 3];
                const float low = std::min(a.y, b.y), high = std::max(a.y, b.y);
                if (high < from || low > to) continue;
                for (const float at : {std::max(low, from), std::min(high, to)}) {
                    const float share = high > low ? (at - a.y) / (b.y - a.y) : 0;
                    const float x = a.x + std::clamp(share, 0.0f, 1.0f) * (b.x - a.x);
                    left = std::min(left, x), right = std::max(right, x);
                }
                if (!(high > low)) left = std::min({left, a.x, b.x}), right = std::max({right, a.x, b.x});
            }
            if (left > right) continue;
            for (uint32_t x = uint32_t(left / float(blockPx)); x <= uint32_t((right + 2 * gutter) / float(blockPx)); ++x)
                if (x < out.columns && y < out.rows) out.taken[size_t(y) * out.columns + x] = 1;
        }
    }
    return out;
}

/** Where a texel of a chart lies in the picture. */
Vec2f placed(const Vec2f& own, const BlockShape& shape, const BlockPlace& place, uint32_t blockPx, uint32_t gutterPx) {
    Vec2f p = own + Vec2f(float(gutterPx)), size(float(shape.columns * blockPx), float(shape.rows * blockPx));
    for (uint32_t turn = 0; turn < place.quarterTurns; ++turn) p = Vec2f(size.y - p.y, p.x), size = Vec2f(size.y, size.x);
    return p + Vec2f(float(place.x * blockPx), float(place.y * blockPx));
}

Status checkSide(uint32_t sidePx) {
    if (!isTexturePx(sidePx))
        return fail(Code::InvalidArgument, "a texture of {} pixels a side; it must be a power of two from {} to {}", sidePx,
                    kLeastTexturePx, kMostTexturePx);
    return {};
}

}  // namespace

Result<MeshAtlas> layOutAtlas(std::span<const Vec3f> positions, std::span<const Triangle> triangles, std::span<const AtlasKind> kind,
                              uint32_t sidePx) {
    DPL_RETURN_IF_ERROR(checkSide(sidePx));
    if (triangles.empty()) return fail(Code::InvalidArgument, "the avatar has no mesh to write");
    std::map<AtlasKind, uint32_t> kinds;
    for (const AtlasKind& k : kind) kinds.emplace(k, uint32_t(kinds.size()));
    std::vector<uint32_t> group;
    for (const AtlasKind& k : kind) group.push_back(kinds[k]);
    const std::vector<AtlasChart> charts = chartsOf(positions, triangles, group);

    double area = 0;  // on the planes, by density
    for (const AtlasChart& chart : charts)
        for (const uint32_t t : chart.triangles) {
            const Vec2f a = chart.place(positions[triangles[t].x]), b = chart.place(positions[triangles[t].y]) - a,
                        c = chart.place(positions[triangles[t].z]) - a;
            area += 0.5 * std::abs(double(b.x) * c.y - double(b.y) * c.x) * kind[t].density * kind[t].density;
        }
    if (!(area > 0)) return fail(Code::InvalidArgument, "the avatar's mesh has no area to draw a texture on");

    MeshAtlas out;
    out.sidePx = sidePx, out.chartCount = uint32_t(charts.size());
    const uint32_t blockPx = std::max(kLeastBlockPx, sidePx / kBlocks);
    out.gutterPx = blockPx / 2 + 2;
    float perM = float(double(sidePx) * std::sqrt(kBestFill / area));
    std::vector<BlockShape> shapes;
    std::vector<FlatChart> flat;
    std::optional<std::vector<BlockPlace>> places;
    for (int step = 0; step < kScaleSteps && !places; ++step, perM *= kScaleStep) {
        DPL_RETURN_IF_ERROR(taskAt(double(step) / kScaleSteps, "laying out the texture"));
        shapes.clear(), flat.clear();
        size_t blocks = 0;
        for (const AtlasChart& chart : charts) {
            flat.push_back(flatChart(chart, positions, triangles, perM * kind[chart.triangles.front()].density));
            shapes.push_back(blocksOf(flat.back(), blockPx, out.gutterPx));
            blocks += size_t(std::count(shapes.back().taken.begin(), shapes.back().taken.end(), 1));
        }
        const uint32_t side = sidePx / blockPx;
        if (blocks <= size_t(side) * side) places = packShapes(shapes, side);
        out.texelM = 1 / perM;
    }
    if (!places)
        return fail(Code::Unsupported, "the {} parts of the mesh do not fit into a texture of {} × {} pixels; give a larger --texture-size",
                    charts.size(), sidePx, sidePx);
    out.chart.resize(triangles.size()), out.corners.resize(triangles.size());
    for (uint32_t c = 0; c < charts.size(); ++c)
        for (size_t i = 0; i < charts[c].triangles.size(); ++i) {
            const uint32_t t = charts[c].triangles[i];
            out.chart[t] = c;
            for (int k = 0; k < 3; ++k) out.corners[t][k] = placed(flat[c].corners[i][k], shapes[c], (*places)[c], blockPx, out.gutterPx);
        }
    return out;
}

SeamedMesh splitAtSeams(const MeshData& mesh, const MeshAtlas& atlas) {
    SeamedMesh out;
    for (LayerData layer : mesh.layers) {
        std::unordered_map<uint64_t, uint32_t> made;  // vertex and chart -> new vertex
        const uint32_t first = uint32_t(out.old.size());
        for (uint32_t t = layer.firstTriangle; t < layer.firstTriangle + layer.triangleCount; ++t) {
            Triangle corners(0);
            for (int k = 0; k < 3; ++k) {
                const uint32_t v = mesh.triangles[t][k];
                const auto [at, isNew] = made.emplace(uint64_t(atlas.chart[t]) << 32 | v, uint32_t(out.old.size()));
                corners[k] = at->second;
                if (!isNew) continue;
                out.old.push_back(v);
                out.uv.push_back(atlas.corners[t][k] / float(atlas.sidePx));
            }
            out.mesh.triangles.push_back(corners);
        }
        layer.firstVertex = first, layer.vertexCount = uint32_t(out.old.size()) - first;
        out.mesh.layers.push_back(std::move(layer));
    }
    for (const uint32_t v : out.old) {
        out.mesh.restPositions.push_back(mesh.restPositions[v]), out.mesh.colours.push_back(mesh.colours[v]);
        out.mesh.jointIndices.push_back(mesh.jointIndices[v]), out.mesh.jointWeights.push_back(mesh.jointWeights[v]);
    }
    return out;
}

}  // namespace dpl
