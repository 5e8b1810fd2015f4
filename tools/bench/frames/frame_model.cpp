// SPDX-License-Identifier: Apache-2.0
#include "tools/bench/frames/frame_model.h"

#include <algorithm>
#include <cstddef>
#include <cstdio>

#include "shaders/shared/frame.h"
#include "tools/bench/baseline/shaders/shared/frame.h"

namespace dpl {
namespace {

constexpr uint64_t kHalfColourBytes = 4 * 2;  // a pixel of four halves
constexpr uint64_t kByteColourBytes = 4;

// Bytes: a pass fetches each record once, however many lanes read it, and writes it once.

// Operations, counted in the source of the kernels for the lanes that do work. An addition, multiplication, comparison, division, root,
// exponential or integer step counts as one.
constexpr uint64_t kSkinOps = 118, kCorrectOps = 37;  // a vertex: four joints, three rows each; four control nodes
constexpr uint64_t kTriangleOps = 190,
                   kTriangleViewOps = 125;                 // F, its polar rotation and stretch; corners into a view and against its sides
constexpr uint64_t kDecodeOps = 45, kPlaceOps = 70;        // a splat: its codes; centre, axes, normal and light
constexpr uint64_t kProjectOps = 150;                      // ... in a view: place, axes, footprint, fade, gate, box
constexpr uint64_t kColourOps = 52, kCoefficientOps = 15;  // ... its direction and packing; a coefficient of SH and its share of the basis
constexpr uint64_t kMaskOps = 4, kCompactOps = 4, kSortOps = 6;  // a splat of a live group; a pair; a pair in each round
constexpr uint64_t kListOps = 80,
                   kEntryOps = 8 * 40 + 64 * 12;  // a record, both walks; an entry: eight columns set up, 64 pixels stepped and blended
constexpr uint64_t kQuadOps = 6 * 30;             // a record: its corners; pixels of quads are not counted

template <class Vertex>
ModelledPass skinning(uint64_t vertices, bool corrected) {
    return {"pose.skin", vertices * sizeof(Vertex), vertices * sizeof(gpu::vec4), vertices * (kSkinOps + (corrected ? kCorrectOps : 0))};
}

uint64_t colourOps(uint32_t shDegree) {
    return kColourOps + kCoefficientOps * (shDegree + 1) * (shDegree + 1);
}

/** Rounds of count, prefix sum and scatter over `count` pairs; `table` entries of histogram are written, summed and walked again. */
template <class Pair>
ModelledPass sorting(uint64_t count, uint64_t table, uint64_t rounds) {
    return {"sort", rounds * (2 * count * sizeof(Pair) + 2 * table * sizeof(uint32_t)),
            rounds * (count * sizeof(Pair) + 3 * table * sizeof(uint32_t)), rounds * (count * kSortOps + 2 * table)};
}

/** Today's two rounds: pairs into words, and these into words. */
ModelledPass sortingToday(uint64_t count, uint64_t table) {
    static_assert(gpu::kSortRounds == 2);
    ModelledPass pass = sorting<uint32_t>(count, table, gpu::kSortRounds);
    pass.readBytes += 2 * count * (sizeof(gpu::uvec2) - sizeof(uint32_t));
    return pass;
}

uint64_t blocks(uint64_t count, uint64_t block) {
    return (count + block - 1) / block;
}

void repeat(std::vector<ModelledPass>& passes, uint64_t times) {
    for (ModelledPass& pass : passes) pass.readBytes *= times, pass.writtenBytes *= times, pass.operations *= times;
}

const ModelledPass* findPass(const std::vector<ModelledPass>& passes, const std::string& label) {
    const auto found = std::find_if(passes.begin(), passes.end(), [&](const ModelledPass& p) { return p.label == label; });
    return found == passes.end() ? nullptr : &*found;
}

std::string modelCell(const ModelledPass* pass, const ModelMachine& machine) {
    if (!pass) return " – | – | – |";
    char cell[100];
    std::snprintf(cell, sizeof cell, " %.2f + %.2f | %.1f | %.3f |", double(pass->readBytes) / 1e6, double(pass->writtenBytes) / 1e6,
                  double(pass->operations) / 1e6, pass->milliseconds(machine));
    return cell;
}

/** Passes run one after the other, so their times add up. */
std::string sumCell(const std::vector<ModelledPass>& passes, const ModelMachine& machine) {
    ModelledPass sum;
    double ms = 0;
    for (const ModelledPass& pass : passes)
        sum.readBytes += pass.readBytes, sum.writtenBytes += pass.writtenBytes, sum.operations += pass.operations,
            ms += pass.milliseconds(machine);
    char cell[100];
    std::snprintf(cell, sizeof cell, " %.2f + %.2f | %.1f | %.3f |", double(sum.readBytes) / 1e6, double(sum.writtenBytes) / 1e6,
                  double(sum.operations) / 1e6, ms);
    return cell;
}

}  // namespace

std::vector<ModelledPass> modelPlainFloat(const FrameWork& w) {
    using namespace plain;
    const uint64_t n = w.splats, drawn = w.splatsDrawn, pixels = w.pixels / w.views,
                   sh = uint64_t(w.shDegree + 1) * (w.shDegree + 1) * 3 * sizeof(float);
    std::vector<ModelledPass> passes = {
        w.corrected ? skinning<CorrectedVertexRecord>(w.vertices, true) : skinning<VertexRecord>(w.vertices, false),
        {"pose.triangles", w.triangles * sizeof(TriangleRecord) + w.vertices * sizeof(vec4), w.triangles * sizeof(plain::TriangleFrame),
         w.triangles * kTriangleOps},
        // Projection reads every splat's record and its triangle's corners and columns; it writes a record and a depth for every splat,
        // seen or not. Colour reads every depth; for splats that are seen it reads SH and the rest of the triangle's frame.
        {"chunks, splat.project and splat.colour",
         n * sizeof(SplatRecord) + w.triangles * offsetof(plain::TriangleFrame, worldFromRest0) + n * sizeof(float) +
             drawn * (sizeof(SplatRecord) + sh) + w.triangles * sizeof(plain::TriangleFrame),
         n * (sizeof(ProjectedSplat) + sizeof(uint)) + drawn * 3 * sizeof(float),
         n * (kPlaceOps + kProjectOps) + drawn * colourOps(w.shDegree)},
        {"compact", 2 * n * sizeof(uint), drawn * sizeof(uvec2), n * kCompactOps},
        sorting<uvec2>(drawn, kSortDigits * blocks(drawn, kSortBlock), kSortRounds),
        {"pixels", drawn * (sizeof(uvec2) + sizeof(ProjectedSplat)), pixels * kHalfColourBytes, drawn * kQuadOps},
    };
    repeat(passes, w.views);
    return passes;
}

std::vector<ModelledPass> modelToday(const FrameWork& w) {
    using namespace gpu;
    const uint64_t drawn = w.splatsDrawn, records = drawn * w.views, lanes = uint64_t(w.liveGroups) * kSplatGroup;
    const uint64_t flags = uint64_t(w.groups) * sizeof(uint), masks = flags * kMaskWords;
    std::vector<ModelledPass> passes = {
        w.corrected ? skinning<CorrectedVertexRecord>(w.vertices, true) : skinning<VertexRecord>(w.vertices, false),
        {"pose.triangles", w.triangles * sizeof(TriangleRecord) + w.vertices * sizeof(vec4), w.triangles * sizeof(gpu::TriangleFrame),
         w.triangles * (kTriangleOps + kTriangleViewOps * w.views)},
        // Codes as the renderer counts them; flags, ranges and the list of live groups; for each triangle the views that see it, and the
        // frames of those that face a view. A splat that no view shows gets an empty word.
        {"chunks, splat.project and splat.colour",
         w.bytesDecided + w.bytesDecoded + w.triangles * sizeof(uvec4) + w.trianglesFacing * sizeof(gpu::TriangleFrame) + 2 * flags,
         3 * flags + records * sizeof(ProjectedSplat) + (lanes * w.views - std::min(records, lanes * w.views)) * sizeof(uint) +
             lanes * sizeof(uint),
         w.splatsFacing * (kDecodeOps + kPlaceOps + kProjectOps * w.views) + records * colourOps(w.shDegree)},
        {"compact", lanes * sizeof(uint) + masks + 4 * flags + drawn * sizeof(uint), masks + 2 * flags + drawn * sizeof(uvec2),
         lanes * kMaskOps + drawn * kCompactOps},
        sortingToday(drawn, kSortDigits * blocks(drawn, kRun)),
    };
    if (w.tileEntries == 0) {
        passes.push_back(
            {"pixels", drawn * sizeof(uint) + records * sizeof(ProjectedSplat), w.pixels * kHalfColourBytes, records * kQuadOps});
        return passes;
    }
    // Two walks over the survivors make the lists. The fill reads a record once an entry; pixels are cleared and filled.
    passes.push_back(
        {"tile lists", 2 * (drawn * sizeof(uint) + records * sizeof(ProjectedSplat)), w.tileEntries * sizeof(uint), records * kListOps});
    passes.push_back(
        {"pixels", w.tileEntries * (sizeof(uint) + sizeof(ProjectedSplat)), 2 * w.pixels * kByteColourBytes, w.tileEntries * kEntryOps});
    return passes;
}

std::string modelRows(const std::string& name, const std::vector<ModelledPass>& plain, const std::vector<ModelledPass>& today,
                      const ModelMachine& machine) {
    std::string rows;
    const auto add = [&](const std::string& label, const ModelledPass* off, const ModelledPass* on) {
        rows += "| " + name + " | " + label + " |" + modelCell(off, machine) + modelCell(on, machine) + "\n";
    };
    for (const ModelledPass& pass : plain) {
        if (pass.label == "pixels")
            for (const ModelledPass& other : today)  // passes that only today's frame has come before the pixels
                if (!findPass(plain, other.label)) add(other.label, nullptr, &other);
        add(pass.label, &pass, findPass(today, pass.label));
    }
    return rows + "| " + name + " | sum |" + sumCell(plain, machine) + sumCell(today, machine) + "\n";
}

}  // namespace dpl
