// SPDX-License-Identifier: Apache-2.0
// How frames are recorded: the lists of a row, and one frame a shape with its three slots.
#include "sdk/render/gpu_renderer.h"

#include <algorithm>
#include <array>

#include "sdk/core/log.h"
#include "sdk/math/coverage.h"
#include "sdk/render/passes/chunks.h"
#include "sdk/render/passes/compact.h"
#include "sdk/render/passes/draw.h"
#include "sdk/render/passes/mesh_depth.h"
#include "sdk/render/passes/project.h"
#include "sdk/render/passes/scan.h"
#include "sdk/render/passes/skin.h"
#include "sdk/render/passes/sort.h"
#include "sdk/render/passes/triangles.h"

namespace dpl {
namespace {

constexpr std::array<std::byte, 4> kZero{};
constexpr uint32_t kGuard = 3;  // targets across: splats no larger than a target reach no farther from it
constexpr size_t kFramesKept =
    4;  // recorded frame shapes a row keeps; an app uses one or two at two sample counts, a resize leaves others behind

}  // namespace

Result<TableIds> GpuRenderer::makeTable(std::vector<BufferId>& owned, const std::string& label, uint64_t cells, uint64_t sums) {
    TableIds table;
    DPL_TRY(table.cells, makeBuffer(owned, label + " cells", cells * 4));
    DPL_TRY(table.sums, makeBuffer(owned, label + " sums", sums * 4));
    DPL_TRY(table.places, makeBuffer(owned, label + " places", cells * 4));
    return table;
}

/** Where each member's splats lie in the lists of a frame, and these lists, whatever its size. */
Status GpuRenderer::makeWorkBuffers(Row& row) {
    FrameIds& ids = row.ids;
    ids.multiview = backend_->info().multiview;
    uint64_t splats = 0;
    for (SubjectIds& subject : row.subjects) {
        subject.drawn = uint32_t(ids.endGroups.size()), subject.firstGroup = ids.allGroups, subject.firstSplat = uint32_t(splats);
        splats += subject.splatCount;
        if (splats * sizeof(gpu::ProjectedSplat) * gpu::kMaxViews > backend_->info().maxBindingBytes || splats > 1u << gpu::kSortIndexBits)
            return fail(Code::Unsupported, "{} avatars together have more splats than {} draws at once ({}); draw fewer together",
                        row.subjects.size(), backend_->info().name,
                        std::min<uint64_t>(backend_->info().maxBindingBytes / (sizeof(gpu::ProjectedSplat) * gpu::kMaxViews),
                                           1u << gpu::kSortIndexBits));
        ids.allGroups += subject.groupCount;
        ids.endGroups.push_back(ids.allGroups);
        ids.filledGroups += subject.filledGroups, ids.componentCount += subject.componentCount;
        ids.wide |= subject.wide;
    }
    ids.splatCount = uint32_t(splats);
    DPL_TRY(ids.visibility, makeBuffer(row.owned, "visibility", ids.visibilityWords() * 4));
    DPL_TRY(ids.survivors, makeBuffer(row.owned, "survivors", ids.survivorWords() * 4));
    DPL_TRY(ids.counts, makeBuffer(row.owned, "counts", sizeof(gpu::FrameCounts)));
    DPL_TRY(ids.pairs, makeBuffer(row.owned, "pairs", splats * 8));
    ids.floatKeys = !options_.quantiseDepth;
    DPL_TRY(ids.pairsSwap, makeBuffer(row.owned, "pairs swap",
                                      splats * (ids.sortRounds() == 2 ? 4 : 8)));  // two rounds: one digit is left when it is first written
    DPL_TRY(ids.digits, makeTable(row.owned, "digits", ids.digitWords(), scanSumWords(gpu::kSortDigits)));
    return {};
}

Status GpuRenderer::build(const Row& row, ShapedFrame& f) {
    f.ids = row.ids;
    FrameIds& ids = f.ids;
    ids.viewCount = f.shape.views;
    ids.widthPx = f.shape.widthPx;
    ids.heightPx = f.shape.heightPx;
    ids.depth = f.shape.depth;
    ids.sceneDepth = f.shape.sceneDepth;
    ids.colour = !options_.preciseBlending ? ColourFormat::Codes8 : backend_->info().codes16 ? ColourFormat::Codes16 : ColourFormat::Halves;
    ids.shuffle = backend_->info().shuffle;
    ids.guard = float(std::clamp(backend_->info().maxViewportPx / std::max({ids.widthPx, ids.heightPx, 1u}), 1u, kGuard));
    ids.samples = f.shape.samples;
    DPL_TRY(ids.target,
            backend_->createTarget({ids.widthPx, ids.heightPx, ids.viewCount, ids.depth, ids.multiview, ids.colour, ids.samples}));
    // Whoever walks away from this avatar should not wait for a shader compiler: its other pipelines are made now, its other target and
    // lists when they are needed.
    const bool trained = std::any_of(row.members.begin(), row.members.end(), [&](RenderAvatarId id) {
        const LoadedAvatar& a = avatars_.at(id);
        return a.data && a.data->trainedPixelM > 0;
    });
    if (trained && backend_->info().fourSamples) {
        const uint32_t other = ids.samples == 1 ? kCoverageSamples : 1;
        DPL_CHECK_OK(backend_->drawPipeline(drawPipelineOf(ids, other)));
        if (f.shape.fill == Fill::Tiles) {
            DPL_CHECK_OK(backend_->computePipeline(tileFillOf(ids, other)));
        }
    }
    DPL_TRY(ids.projected, makeBuffer(f.owned, "projected", uint64_t(ids.splatCount) * ids.viewCount * sizeof(gpu::ProjectedSplat)));
    if (f.shape.meshDepth) {
        DPL_TRY(ids.meshDepth, makeBuffer(f.owned, "mesh depth", uint64_t(ids.widthPx) * ids.heightPx * ids.viewCount * 4));
        DPL_CHECK_OK(backend_->write(ids.meshDepth, 0, kZero));  // every frame fills it; this is for the check of the read-back
    }
    std::optional<TilePlan> tiles;
    if (f.shape.fill == Fill::Tiles && ids.splatCount > 0) {
        tiles = planTiles(ids, backend_->info());
        if (!tiles)
            log(LogLevel::Info, "{} x {} px, {} splats: the lists of compute tiles do not fit the device, quads fill this size",
                ids.widthPx, ids.heightPx, ids.splatCount);
    }
    if (tiles) {
        f.firstTileDepth = tiles->push.firstDepth * 4ull;
        DPL_TRY(ids.tiles, makeTable(f.owned, "tile table", tiles->tableWords, tiles->sumWords));
        DPL_TRY(ids.tileSpans, makeBuffer(f.owned, "tile spans", tiles->spanBytes));
        DPL_TRY(ids.tileEntries, makeBuffer(f.owned, "tile entries", tiles->entryBytes));
        DPL_TRY(ids.tilePixels, makeBuffer(f.owned, "tile pixels", tiles->pixelBytes));
        DPL_CHECK_OK(backend_->write(ids.tilePixels, 0, kZero));  // the same
    }
    for (Slot& slot : f.slots) {
        DPL_CHECK_OK(buildSlot(row, f, slot, tiles));
    }
    return {};
}

Status GpuRenderer::buildSlot(const Row& row, ShapedFrame& f, Slot& slot, const std::optional<TilePlan>& tiles) {
    std::vector<FrameIds> subjects;
    for (size_t k = 0; k < row.members.size(); ++k) {
        const LoadedAvatar& a = avatars_.at(row.members[k]);
        slot.frame.emplace_back(), slot.palette.emplace_back();
        DPL_TRY(slot.frame[k], makeBuffer(f.owned, "frame", sizeof(gpu::FrameData), BufferMemory::Upload));
        if (a.data) {
            DPL_TRY(slot.palette[k], makeBuffer(f.owned, "palette", paletteRows(*a.data) * sizeof(gpu::vec4), BufferMemory::Upload));
        }
        subjects.push_back(f.ids.of(row.subjects[k]));
        subjects[k].frame = slot.frame[k], subjects[k].palette = slot.palette[k];
    }
    if (f.shape.sceneDepth) {
        DPL_TRY(slot.scene,
                makeBuffer(f.owned, "scene depth", uint64_t(f.shape.widthPx) * f.shape.heightPx * f.shape.views * 4, BufferMemory::Upload));
    }
    DPL_TRY(slot.finalCounts, makeBuffer(f.owned, "final counts", sizeof(gpu::FrameCounts), BufferMemory::Readback));
    FrameIds ids = f.ids;
    ids.scene = slot.scene;

    FramePlan plan(*backend_);
    plan.fill("begin", ids.counts, 0);
    for (const FrameIds& subject : subjects) {
        if (!subject.general && subject.vertexCount > 0 && (subject.splatCount > 0 || ids.meshDepth)) addSkin(plan, subject);
        if (ids.meshDepth) addMeshDepth(plan, subject);
    }
    for (const FrameIds& subject : subjects) {
        if (subject.splatCount == 0) continue;
        if (!subject.general) {
            addTriangles(plan, subject);
            addChunks(plan, subject);
        }
        addProject(plan, subject);
    }
    if (ids.splatCount > 0) {
        addCompact(plan, ids);
        addSort(plan, ids);
        if (tiles) addTiles(plan, ids, *tiles);
    } else {  // no work, but the draw still clears the target: its arguments are zero
        plan.fill("no pairs", ids.pairs, 0);
        plan.fill("no splats", ids.projected, 0);
    }
    addDraw(plan, ids, tiles && backend_->info().clearDraw);
    plan.copy("counts", ids.counts, slot.finalCounts);
    DPL_TRY(slot.draw, plan.finish());
    return {};
}

Status GpuRenderer::buildReadback(ShapedFrame& f, bool tiles) {
    FrameIds& ids = f.ids;
    const uint64_t pixels = uint64_t(ids.widthPx) * ids.heightPx * ids.viewCount;
    if (!ids.colourPixels) {
        DPL_TRY(ids.colourPixels, makeBuffer(f.owned, "colour pixels", pixels * 4, BufferMemory::Readback));
    }
    if (ids.depth && !ids.depthPixels) {
        DPL_TRY(ids.depthPixels,
                makeBuffer(f.owned, "depth pixels", pixels * (backend_->info().halfDepth ? 4 : 8), BufferMemory::Readback));
    }
    FramePlan plan(*backend_);
    if (tiles) {
        plan.copy("readback", ids.tilePixels, ids.colourPixels);
        if (ids.depth) plan.copy("readback", ids.tilePixels, ids.depthPixels, f.firstTileDepth);
    } else {
        plan.readback("readback", ids.target, ids.colourPixels, ids.depthPixels);
    }
    if (ids.meshDepth) {
        if (!ids.meshDepthPixels) {
            DPL_TRY(ids.meshDepthPixels, makeBuffer(f.owned, "mesh depth pixels", pixels * 4, BufferMemory::Readback));
        }
        plan.copy("mesh readback", ids.meshDepth, ids.meshDepthPixels);
    }
    DPL_TRY(f.readback[tiles], plan.finish());
    return {};
}

Result<GpuRenderer::ShapedFrame*> GpuRenderer::frameOf(Row& row, const Shape& shape) {
    for (ShapedFrame& f : row.frames)
        if (f.shape == shape) return &f;
    if (row.frames.size() >= kFramesKept) {
        const auto oldest =
            std::min_element(row.frames.begin(), row.frames.end(), [](const auto& x, const auto& y) { return x.lastUse < y.lastUse; });
        freeFrame(*oldest);
        row.frames.erase(oldest);
    }
    ShapedFrame f;
    f.shape = shape;
    if (auto status = build(row, f); !status) {
        freeFrame(f);
        return status.error();
    }
    row.frames.push_back(std::move(f));
    return &row.frames.back();
}

void GpuRenderer::freeFrame(ShapedFrame& f) {
    for (const Slot& slot : f.slots) backend_->destroyFrame(slot.draw);
    for (const FrameId readback : f.readback) backend_->destroyFrame(readback);
    backend_->destroyTarget(f.ids.target);
    for (BufferId id : f.owned) backend_->destroyBuffer(id);
}

}  // namespace dpl
