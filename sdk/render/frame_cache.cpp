// SPDX-License-Identifier: Apache-2.0
#include "sdk/render/frame_cache.h"

#include <optional>

#include "sdk/core/log.h"
#include "sdk/math/coverage.h"
#include "sdk/render/frame_steps.h"
#include "sdk/render/passes/draw.h"
#include "sdk/render/passes/scan.h"

namespace dpl {
namespace {

static_assert(kMaxDrawnTogether == gpu::kMaxDrawn && kFramesInFlight == kAppSlots);

constexpr size_t kLargeSetsKept = 4;  // scene sets of several avatars; an app draws one set until an avatar is added or removed
constexpr size_t kShapesKept = 4;     // of one set; an app draws one or two sizes, each with one or four samples, until it resizes

Result<TableIds> makeTable(DeviceBuffers& buffers, const std::string& label, uint64_t cells, uint64_t sums) {
    TableIds table;
    DPL_TRY(table.cells, buffers.create(label + " cells", cells * 4));
    DPL_TRY(table.sums, buffers.create(label + " sums", sums * 4));
    DPL_TRY(table.places, buffers.create(label + " places", cells * 4));
    return table;
}

/** The lists of tiles that fill such a frame; none where quads do. */
std::optional<TilePlan> tilesOf(const FrameIds& ids, Fill fill, const DeviceInfo& device) {
    if (fill != Fill::Tiles || ids.allSplats == 0) return std::nullopt;
    std::optional<TilePlan> tiles = planTiles(ids, device);
    if (!tiles)
        log(LogLevel::Info, "{} x {} px, {} splats: the lists of compute tiles do not fit the device, quads fill this size", ids.widthPx,
            ids.heightPx, ids.allSplats);
    return tiles;
}

uint64_t pixelsOf(const FrameShape& shape) {
    return uint64_t(shape.widthPx) * shape.heightPx * shape.views;
}

/** Numbers the subjects and places them one after the other in the lists of a frame. Unsupported: too many splats together. */
Status placeSubjects(SceneSet& set, const AvatarStore& store, const DeviceInfo& device) {
    FrameIds& ids = set.ids;
    const uint64_t most =
        std::min<uint64_t>(device.maxBindingBytes / (sizeof(gpu::ProjectedSplat) * gpu::kMaxViews), 1u << gpu::kSortIndexBits);
    uint64_t splats = 0;
    for (const RenderAvatarId member : set.members) {
        const LoadedSubject& loaded = store.at(member);
        SubjectIds& subject = set.subjects.emplace_back(loaded.ids);
        subject.drawn = uint32_t(ids.endGroups.size());
        subject.firstGroup = ids.allGroups;
        subject.firstSplat = uint32_t(splats);
        splats += subject.splatCount;
        if (splats > most)
            return fail(Code::Unsupported, "{} avatars together have more splats than {} draws at once ({}); draw fewer together",
                        set.members.size(), device.name, most);
        ids.allGroups += subject.groupCount;
        ids.endGroups.push_back(ids.allGroups);
        ids.wide |= loaded.wide;
        set.filledGroups += loaded.filledGroups;
        set.componentCount += loaded.components.count();
        set.mayTakeFourSamples |= loaded.mayTakeFourSamples();
    }
    ids.allSplats = uint32_t(splats);
    return {};
}

}  // namespace

SubmittedFrame SceneSet::submitted(uint64_t frameNumber) const {
    for (const RecordedFrame& frame : frames)
        for (const FrameSlot& slot : frame.slots)
            if (frame.lastUse == frameNumber && slot.last.number == frameNumber) return {&frame, &slot};
    return {};
}

FrameCache::FrameCache(Backend& backend, const AvatarStore& store, std::function<void(const RecordedFrame&)> onFree)
    : backend_(backend), store_(store), onFree_(std::move(onFree)) {}

FrameCache::~FrameCache() {
    for (auto& [number, set] : sets_) free(set);
}

Result<SceneSet*> FrameCache::sceneSet(std::span<const RenderAvatarId> members) {
    size_t largeSets = 0;
    auto oldest = sets_.end();
    for (auto it = sets_.begin(); it != sets_.end(); ++it) {
        SceneSet& set = it->second;
        if (std::equal(members.begin(), members.end(), set.members.begin(), set.members.end())) return &set;
        if (set.members.size() == 1) continue;
        ++largeSets;
        if (oldest == sets_.end() || set.lastUse < oldest->second.lastUse) oldest = it;
    }
    if (members.size() > 1 && largeSets >= kLargeSetsKept) {
        free(oldest->second);
        sets_.erase(oldest);
    }
    SceneSet set(backend_);
    set.members.assign(members.begin(), members.end());
    DPL_RETURN_IF_ERROR(makeLists(set));
    set.number = ++lastNumber_;
    return &sets_.emplace(set.number, std::move(set)).first->second;
}

const SceneSet* FrameCache::find(uint32_t number) const {
    const auto found = sets_.find(number);
    return found == sets_.end() ? nullptr : &found->second;
}

void FrameCache::remove(RenderAvatarId avatar) {
    for (auto it = sets_.begin(); it != sets_.end();) {
        if (!it->second.holds(avatar)) {
            ++it;
            continue;
        }
        free(it->second);
        it = sets_.erase(it);
    }
}

Status FrameCache::makeLists(SceneSet& set) {
    FrameIds& ids = set.ids;
    ids.multiview = backend_.info().multiview;
    DPL_RETURN_IF_ERROR(placeSubjects(set, store_, backend_.info()));
    DPL_TRY(ids.visibility, set.buffers.create("visibility", ids.visibilityWords() * 4));
    DPL_TRY(ids.survivors, set.buffers.create("survivors", ids.survivorWords() * 4));
    DPL_TRY(ids.counts, set.buffers.create("counts", sizeof(gpu::FrameCounts)));
    DPL_TRY(ids.pairs, set.buffers.create("pairs", ids.allSplats * uint64_t(sizeof(gpu::SortPair))));
    // With two rounds of sorting, pairs have shrunk to one word when they are first written here.
    DPL_TRY(ids.pairsSwap,
            set.buffers.create("pairs swap", ids.allSplats * uint64_t(ids.sortRounds() == 2 ? sizeof(uint32_t) : sizeof(gpu::SortPair))));
    DPL_TRY(ids.digits, makeTable(set.buffers, "digits", ids.digitWords(), scanSumWords(gpu::kSortDigits)));
    return {};
}

FrameIds FrameCache::idsOf(const SceneSet& set, const FrameShape& shape) const {
    FrameIds ids = set.ids;
    ids.viewCount = shape.views;
    ids.widthPx = shape.widthPx;
    ids.heightPx = shape.heightPx;
    ids.depth = shape.depth;
    ids.sceneDepth = shape.sceneDepth;
    ids.samples = shape.samples;
    ids.shuffle = backend_.info().shuffle;
    ids.drawInstances = ids.multiview && backend_.info().viewsAreInstances ? ids.viewCount : 1;
    return ids;
}

TargetDesc FrameCache::targetOf(const FrameIds& ids, const FrameShape& shape) const {
    return {ids.widthPx, ids.heightPx, ids.viewCount, ids.depth, ids.multiview, ids.samples, shape.encoded};
}

Result<RecordedFrame*> FrameCache::frame(SceneSet& set, const FrameShape& shape, TargetMaker makeTarget) {
    for (RecordedFrame& frame : set.frames)
        if (frame.shape == shape) return &frame;
    if (set.frames.size() >= kShapesKept) {
        const auto oldest = std::min_element(set.frames.begin(), set.frames.end(),
                                             [](const RecordedFrame& a, const RecordedFrame& b) { return a.lastUse < b.lastUse; });
        free(*oldest);
        set.frames.erase(oldest);
    }
    const FrameIds ids = idsOf(set, shape);
    const std::optional<TilePlan> tiles = tilesOf(ids, shape.fill, backend_.info());
    DPL_TRY(FrameTarget target, tiles ? FrameTarget::none() : makeTarget(targetOf(ids, shape)));
    RecordedFrame made(backend_, shape, std::move(target));
    made.key = ++lastKey_;
    made.ids = ids;
    made.ids.target = made.target.id();
    if (const Status recorded = record(set, made, tiles ? &*tiles : nullptr); !recorded) {
        free(made);
        return recorded.error();
    }
    set.frames.push_back(std::move(made));
    return &set.frames.back();
}

Status FrameCache::record(const SceneSet& set, RecordedFrame& frame, const TilePlan* tiles) {
    FrameIds& ids = frame.ids;
    DPL_RETURN_IF_ERROR(preparePipelines(set, frame, tiles));
    DPL_TRY(ids.projected, frame.buffers.create("projected", uint64_t(ids.allSplats) * ids.viewCount * sizeof(gpu::ProjectedSplat)));
    if (frame.shape.meshDepth) {
        DPL_TRY(ids.meshDepth, frame.buffers.create("mesh depth", pixelsOf(frame.shape) * 4));
    }
    if (tiles) {
        DPL_RETURN_IF_ERROR(makeTileLists(frame, *tiles));
    }
    for (FrameSlot& slot : frame.slots) {
        DPL_RETURN_IF_ERROR(recordSlot(set, frame, slot, tiles));
    }
    return {};
}

Status FrameCache::makeTileLists(RecordedFrame& frame, const TilePlan& tiles) {
    FrameIds& ids = frame.ids;
    frame.tileDepthOffset = tiles.push.firstDepth * 4ull;
    DPL_TRY(ids.tiles, makeTable(frame.buffers, "tile table", tiles.tableWords, tiles.sumWords));
    DPL_TRY(ids.tileSpans, frame.buffers.create("tile spans", tiles.spanBytes));
    DPL_TRY(ids.tileEntries, frame.buffers.create("tile entries", tiles.entryBytes));
    DPL_TRY(ids.tilePixels, frame.buffers.create("tile pixels", tiles.pixelBytes));
    return {};
}

/** Creates the pipelines for the other number of samples too, so that a camera that moves away from an avatar causes no shader
 *  compilation. The target and lists for it are made when they are needed. */
Status FrameCache::preparePipelines(const SceneSet& set, const RecordedFrame& frame, const TilePlan* tiles) {
    if (!set.mayTakeFourSamples || !backend_.info().fourSamples) return {};
    const uint32_t other = frame.shape.samples == 1 ? kCoverageSamples : 1;
    if (!tiles) {
        DPL_RETURN_IF_ERROR(backend_.drawPipeline(drawPipelineOf(frame.ids, other)));
        return {};
    }
    const TileKernels kernels = tileKernelsOf(frame.ids, other);
    for (const std::string& kernel : {kernels.fill, kernels.search}) {
        DPL_RETURN_IF_ERROR(backend_.computePipeline(kernel));
    }
    return {};
}

Status FrameCache::recordSlot(const SceneSet& set, RecordedFrame& frame, FrameSlot& slot, const TilePlan* tiles) {
    std::vector<SubjectIds> subjects = set.subjects;
    for (size_t k = 0; k < subjects.size(); ++k) {
        SubjectIds& subject = subjects[k];
        FrameSlot::Upload& upload = slot.uploads.emplace_back();
        DPL_TRY(upload.frame, frame.buffers.create("frame", sizeof(gpu::FrameData), BufferMemory::Upload));
        if (!subject.general) {
            const uint32_t paletteSize = store_.at(set.members[k]).paletteSize;
            DPL_TRY(upload.palette, frame.buffers.create("palette", paletteSize * sizeof(gpu::vec4), BufferMemory::Upload));
        }
        subject.uniforms = upload.frame, subject.palette = upload.palette;
    }
    if (frame.shape.sceneDepth) {
        DPL_TRY(slot.scene, frame.buffers.create("scene depth", pixelsOf(frame.shape) * 4, BufferMemory::Upload));
    }
    DPL_TRY(slot.finalCounts, frame.buffers.create("final counts", sizeof(gpu::FrameCounts), BufferMemory::Readback));
    FrameIds ids = frame.ids;
    ids.scene = slot.scene;
    FramePlan plan(backend_);
    planFrame(plan, ids, subjects, tiles, slot.finalCounts);
    DPL_TRY(slot.recorded, plan.finish(frame.shape.encoded ? FrameRun::Encoded : FrameRun::Submitted));
    return {};
}

void FrameCache::free(RecordedFrame& frame) {
    onFree_(frame);
    for (const FrameSlot& slot : frame.slots) backend_.destroyFrame(slot.recorded);
}

void FrameCache::free(SceneSet& set) {
    for (RecordedFrame& frame : set.frames) free(frame);
}

}  // namespace dpl
