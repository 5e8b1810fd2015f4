#include "apps/doppel/frame_model.h"

#include <algorithm>
#include <cstddef>
#include <cstdio>

#include "shaders/shared/frame.h"
#include "tests/baseline/shaders/shared/frame.h"

namespace dpl {
namespace {

constexpr uint64_t kHalfColourBytes = 4 * 2;   // a pixel of four halves
constexpr uint64_t kByteColourBytes = 4;

// Everything below: a record is fetched once a pass however many lanes ask for it, and written once.

template <class Vertex>
ModelledPass skinning(uint64_t vertices) {
    return {"pose.skin", vertices * sizeof(Vertex), vertices * sizeof(gpu::vec4)};
}

/** Rounds of count, prefix sum and scatter over `count` pairs; `table` entries of histogram are written, summed and walked again. */
template <class Pair>
ModelledPass sorting(uint64_t count, uint64_t table, uint64_t rounds) {
    return {"sort", rounds * (2 * count * sizeof(Pair) + 2 * table * sizeof(uint32_t)), rounds * (count * sizeof(Pair) + 3 * table * sizeof(uint32_t))};
}

/** Today's two rounds: pairs into words, and these into words. */
ModelledPass sortingToday(uint64_t count, uint64_t table) {
    static_assert(gpu::kSortRounds == 2);
    ModelledPass pass = sorting<uint32_t>(count, table, gpu::kSortRounds);
    pass.readBytes += 2 * count * (sizeof(gpu::uvec2) - sizeof(uint32_t));
    return pass;
}

uint64_t blocks(uint64_t count, uint64_t block) { return (count + block - 1) / block; }

void repeat(std::vector<ModelledPass>& passes, uint64_t times) {
    for (ModelledPass& pass : passes) pass.readBytes *= times, pass.writtenBytes *= times;
}

const ModelledPass* findPass(const std::vector<ModelledPass>& passes, const std::string& label) {
    const auto found = std::find_if(passes.begin(), passes.end(), [&](const ModelledPass& p) { return p.label == label; });
    return found == passes.end() ? nullptr : &*found;
}

std::string modelCell(const ModelledPass* pass, double gbps) {
    if (!pass) return " – | – |";
    char cell[80];
    std::snprintf(cell, sizeof cell, " %.2f + %.2f | %.3f |", double(pass->readBytes) / 1e6, double(pass->writtenBytes) / 1e6, pass->milliseconds(gbps));
    return cell;
}

ModelledPass sumOf(const std::vector<ModelledPass>& passes) {
    ModelledPass sum{"sum"};
    for (const ModelledPass& pass : passes) sum.readBytes += pass.readBytes, sum.writtenBytes += pass.writtenBytes;
    return sum;
}

}  // namespace

std::vector<ModelledPass> modelPlainFloat(const FrameWork& w) {
    using namespace plain;
    const uint64_t n = w.splats, drawn = w.splatsDrawn, pixels = w.pixels / w.views, sh = uint64_t(w.shDegree + 1) * (w.shDegree + 1) * 3 * sizeof(float);
    std::vector<ModelledPass> passes = {
        w.corrected ? skinning<CorrectedVertexRecord>(w.vertices) : skinning<VertexRecord>(w.vertices),
        {"pose.triangles", w.triangles * sizeof(TriangleRecord) + w.vertices * sizeof(vec4), w.triangles * sizeof(plain::TriangleFrame)},
        // Every splat: its record and the corners and columns of its triangle; a record a splat, seen or not, and its depth. Then the colour of
        // those that are seen: all are asked, the rest of the triangle's frame turns the direction.
        {"chunks, splat.project and splat.colour",
         n * sizeof(SplatRecord) + w.triangles * offsetof(plain::TriangleFrame, worldFromRest0) + n * sizeof(float) + drawn * (sizeof(SplatRecord) + sh) + w.triangles * sizeof(plain::TriangleFrame),
         n * (sizeof(ProjectedSplat) + sizeof(uint)) + drawn * 3 * sizeof(float)},
        {"compact", 2 * n * sizeof(uint), drawn * sizeof(uvec2)},
        sorting<uvec2>(drawn, kSortDigits * blocks(drawn, kSortBlock), kSortRounds),
        {"pixels", drawn * (sizeof(uvec2) + sizeof(ProjectedSplat)), pixels * kHalfColourBytes},
    };
    repeat(passes, w.views);
    return passes;
}

std::vector<ModelledPass> modelToday(const FrameWork& w) {
    using namespace gpu;
    const uint64_t drawn = w.splatsDrawn, records = drawn * w.views, lanes = uint64_t(w.liveGroups) * kSplatGroup;
    const uint64_t flags = uint64_t(w.groups) * sizeof(uint), masks = uint64_t(w.liveGroups) * kMaskWords * sizeof(uint);
    std::vector<ModelledPass> passes = {
        w.corrected ? skinning<CorrectedVertexRecord>(w.vertices) : skinning<VertexRecord>(w.vertices),
        {"pose.triangles", w.triangles * sizeof(TriangleRecord) + w.vertices * sizeof(vec4), w.triangles * sizeof(gpu::TriangleFrame)},
        // Codes as the renderer counts them; of each triangle who sees it, of those that face a view the frame. What no view shows gets an empty radius.
        {"chunks, splat.project and splat.colour", w.bytesDecided + w.bytesDecoded + w.triangles * sizeof(uvec4) + w.trianglesFacing * sizeof(gpu::TriangleFrame) + 2 * flags,
         2 * flags + records * sizeof(ProjectedSplat) + (lanes * w.views - std::min(records, lanes * w.views)) * sizeof(vec2) + drawn * sizeof(uint) + masks},
        {"compact", masks + 2 * flags + drawn * sizeof(uint), flags + drawn * sizeof(uvec2)},
        sortingToday(drawn, kSortDigits * blocks(drawn, kRun)),
    };
    if (w.tileEntries == 0) {
        passes.push_back({"pixels", drawn * sizeof(uint) + records * sizeof(ProjectedSplat), w.pixels * kHalfColourBytes});
        return passes;
    }
    // Two walks over the survivors make the lists. The fill reads place and look of a record once an entry; pixels are cleared and filled.
    passes.push_back({"tile lists", 2 * (drawn * sizeof(uint) + records * sizeof(ProjectedSplat)), w.tileEntries * sizeof(uint)});
    passes.push_back({"pixels", w.tileEntries * (sizeof(uint) + offsetof(ProjectedSplat, radiusPx)), 2 * w.pixels * kByteColourBytes});
    return passes;
}

std::string modelRows(const std::string& name, const std::vector<ModelledPass>& plain, const std::vector<ModelledPass>& today, double gbps) {
    std::string rows;
    const auto add = [&](const std::string& label, const ModelledPass* off, const ModelledPass* on) { rows += "| " + name + " | " + label + " |" + modelCell(off, gbps) + modelCell(on, gbps) + "\n"; };
    for (const ModelledPass& pass : plain) {
        if (pass.label == "pixels")
            for (const ModelledPass& other : today)   // what only today's frame has comes before the pixels
                if (!findPass(plain, other.label)) add(other.label, nullptr, &other);
        add(pass.label, &pass, findPass(today, pass.label));
    }
    const ModelledPass off = sumOf(plain), on = sumOf(today);
    add("sum", &off, &on);
    return rows;
}

}  // namespace dpl
