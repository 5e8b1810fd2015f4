// SPDX-License-Identifier: Apache-2.0
#include "tools/bench/frames/frame_model.h"

#include <algorithm>
#include <cstddef>
#include <cstdio>

#include "shaders/shared/frame.h"
#include "tools/bench/baseline/shaders/shared/frame.h"

namespace dpl {
namespace {

constexpr uint64_t kHalfColourBytes = 4 * 2;  // one pixel of four 16-bit floats
constexpr uint64_t kByteColourBytes = 4;

// Bytes: a pass is assumed to read each record once from memory, even if many lanes read it, and to write it once.

// Operations are counted in the source of the kernels, for active lanes only. An addition, multiplication, comparison, division, root,
// exponential or integer operation counts as one.
constexpr uint64_t kSkinOps = 118, kCorrectOps = 37, kLightOps = 166;  // per vertex: four joints of three rows; four nodes; turned normal
constexpr uint64_t kTriangleOps = 190,
                   kTriangleViewOps = 125;  // per triangle: F, its polar rotation and stretch; per view: project its corners and test them
constexpr uint64_t kDecodeOps = 45, kPlaceOps = 70;        // per splat: decode; centre, axes, normal and light
constexpr uint64_t kProjectOps = 150;                      // per splat and view: position, axes, footprint, fade, gate, box
constexpr uint64_t kColourOps = 52, kCoefficientOps = 15;  // per splat and view: direction and packing; per SH coefficient: basis and sum
constexpr uint64_t kMaskOps = 4, kCompactOps = 4, kSortOps = 6;  // per splat of a live group; per pair; per pair and round
constexpr uint64_t kListOps = 80,
                   kEntryOps = 8 * 40 + 64 * 12;     // per record, both passes; per entry: set up 8 columns, step and blend 64 pixels
constexpr uint64_t kCornerOps = 30;                  // per corner; the pixels of quads are not counted
constexpr uint64_t kPlainCorners = 4, kCorners = 3;  // per record: a strip of two triangles; one triangle around the ellipse

template <class Vertex>
ModelledPass skinning(uint64_t vertices, bool corrected, bool lit) {
    return {"pose.skin", vertices * sizeof(Vertex), vertices * sizeof(gpu::PosedVertex),
            vertices * (kSkinOps + (corrected ? kCorrectOps : 0) + (lit ? kLightOps : 0))};
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
    pass.readBytes += 2 * count * (sizeof(gpu::SortPair) - sizeof(uint32_t));
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
        w.corrected ? skinning<CorrectedVertexRecord>(w.vertices, true, false) : skinning<VertexRecord>(w.vertices, false, false),
        {"pose.triangles", w.triangles * sizeof(TriangleRecord) + w.vertices * sizeof(vec4), w.triangles * sizeof(plain::TriangleFrame),
         w.triangles * kTriangleOps},
        // Projection reads every splat's record and its triangle's corners and columns. It writes a record and a depth for every splat,
        // visible or not. Colour reads every depth; for visible splats it also reads SH and the rest of the triangle's frame.
        {"chunks, splat.project and splat.colour",
         n * sizeof(SplatRecord) + w.triangles * offsetof(plain::TriangleFrame, worldFromRest0) + n * sizeof(float) +
             drawn * (sizeof(SplatRecord) + sh) + w.triangles * sizeof(plain::TriangleFrame),
         n * (sizeof(ProjectedSplat) + sizeof(uint)) + drawn * 3 * sizeof(float),
         n * (kPlaceOps + kProjectOps) + drawn * colourOps(w.shDegree)},
        {"compact", 2 * n * sizeof(uint), drawn * sizeof(uvec2), n * kCompactOps},
        sorting<uvec2>(drawn, kSortDigits * blocks(drawn, kSortBlock), kSortRounds),
        {"pixels", drawn * (sizeof(uvec2) + sizeof(ProjectedSplat)), pixels * kHalfColourBytes, drawn * kPlainCorners * kCornerOps},
    };
    repeat(passes, w.views);
    return passes;
}

std::vector<ModelledPass> modelToday(const FrameWork& w) {
    using namespace gpu;
    const uint64_t drawn = w.splatsDrawn, records = drawn * w.views, lanes = uint64_t(w.liveGroups) * kSplatGroup;
    const uint64_t flags = uint64_t(w.groups) * sizeof(uint), masks = flags * kMaskWords;
    std::vector<ModelledPass> passes = {
        w.corrected ? skinning<CorrectedVertexRecord>(w.vertices, true, w.lit) : skinning<VertexRecord>(w.vertices, false, w.lit),
        {"pose.triangles", w.triangles * sizeof(TriangleRecord) + w.vertices * sizeof(PosedVertex),
         w.triangles * sizeof(gpu::TriangleFrame), w.triangles * (kTriangleOps + kTriangleViewOps * w.views)},
        // Reads: splat codes, as counted by the renderer; flags, ranges and the list of live groups; the view mask of every triangle, and
        // the frames of triangles that face a view. A splat that is visible in no view writes an empty word.
        {"chunks, splat.project and splat.colour",
         w.bytesDecided + w.bytesDecoded + w.triangles * sizeof(uvec4) + w.trianglesFacing * sizeof(gpu::TriangleFrame) + 2 * flags,
         3 * flags + records * sizeof(ProjectedSplat) + (lanes * w.views - std::min(records, lanes * w.views)) * sizeof(uint) +
             lanes * sizeof(uint),
         w.splatsFacing * (kDecodeOps + kPlaceOps + kProjectOps * w.views) + records * colourOps(w.shDegree)},
        {"compact", lanes * sizeof(uint) + masks + 4 * flags + drawn * sizeof(uint), masks + 2 * flags + drawn * sizeof(SortPair),
         lanes * kMaskOps + drawn * kCompactOps},
        sortingToday(drawn, kSortDigits * blocks(drawn, kRun)),
    };
    if (w.tileEntries == 0) {
        passes.push_back({"pixels", drawn * sizeof(uint) + records * sizeof(ProjectedSplat), w.pixels * kHalfColourBytes,
                          records * kCorners * kCornerOps});
        return passes;
    }
    // Two passes over the survivors build the lists. The fill reads one record per entry; pixels are written twice: cleared, then filled.
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
            for (const ModelledPass& other : today)  // passes that only the current frame has are listed before "pixels"
                if (!findPass(plain, other.label)) add(other.label, nullptr, &other);
        add(pass.label, &pass, findPass(today, pass.label));
    }
    return rows + "| " + name + " | sum |" + sumCell(plain, machine) + sumCell(today, machine) + "\n";
}

}  // namespace dpl
