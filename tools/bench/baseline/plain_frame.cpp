// SPDX-License-Identifier: Apache-2.0
#include "tools/bench/baseline/plain_frame.h"

#include <algorithm>
#include <array>
#include <cstring>

#include "sdk/avatar/pose_correctives.h"
#include "sdk/render/plan.h"

namespace dpl::plain {
namespace {

constexpr uint32_t kMaxEyes = 2;

uint32_t blocksOf(uint32_t count, uint32_t block) {
    return (count + block - 1) / block;
}

}  // namespace

Result<std::unique_ptr<Backend>> createBackend(const vk::DeviceRequest& request) {
    DPL_TRY(ShaderPack pack, readShaderPack(plain::embeddedShaderPack(), "the pack of frozen shaders", plain::embeddedShaderInterface()));
    return vk::createBackend(request, std::move(pack));
}

Frame::~Frame() {
    for (Eye& eye : eyes_) free(eye);
    for (BufferId id : owned_) backend_->destroyBuffer(id);
}

Result<BufferId> Frame::makeBuffer(std::vector<BufferId>& owned, const char* label, uint64_t bytes, BufferMemory memory) {
    DPL_TRY(BufferId id, backend_->createBuffer({label, std::max<uint64_t>(bytes, 16), memory}));
    owned.push_back(id);
    return id;
}

template <class T>
Result<BufferId> Frame::upload(const char* label, const std::vector<T>& items) {
    DPL_TRY(BufferId id, makeBuffer(owned_, label, items.size() * sizeof(T)));
    if (!items.empty()) {
        DPL_RETURN_IF_ERROR(backend_->write(id, 0, std::as_bytes(std::span(items))));
    }
    return id;
}

Status Frame::load(std::shared_ptr<const AvatarData> avatar) {
    DPL_RETURN_IF_ERROR(checkFits(*avatar, backend_->info()));
    const Records records = pack(*avatar);
    const SplatData& splats = avatar->splats;
    splats_ = {splats.count(), splats.shDegree, avatar->kappaPx2, avatar->compensated};
    vertexCount_ = uint32_t(avatar->mesh.restPositions.size());
    triangleCount_ = uint32_t(records.triangles.size());
    splatBytes_ = records.splats.size() * sizeof(SplatRecord) + splats.sh.size() * sizeof(float);
    avatarBytes_ = splatBytes_ + records.triangles.size() * sizeof(TriangleRecord) + records.vertices.size() * sizeof(VertexRecord) +
                   records.correctedVertices.size() * sizeof(CorrectedVertexRecord);
    Buffers& b = buffers_;
    if (avatar->correctives.empty()) {
        DPL_TRY(b.vertices, upload("vertices", records.vertices));
    } else {
        DPL_TRY(b.vertices, upload("vertices", records.correctedVertices));
    }
    DPL_TRY(b.triangles, upload("triangles", records.triangles));
    DPL_TRY(b.splats, upload("splats", records.splats));
    DPL_TRY(b.sh, upload("sh", splats.sh));
    DPL_TRY(b.posed, makeBuffer(owned_, "posed", vertexCount_ * sizeof(vec4)));
    DPL_TRY(b.triangleFrames, makeBuffer(owned_, "triangle frames", triangleCount_ * sizeof(TriangleFrame)));
    avatar_ = std::move(avatar);
    return makeWorkBuffers();
}

Status Frame::load(const StaticSplatData& splats) {
    DPL_RETURN_IF_ERROR(checkFits(splats, backend_->info()));
    splats_ = {splats.count(), splats.shDegree, splats.kappaPx2, splats.compensated};
    const std::vector<GeneralSplatRecord> records = pack(splats);
    avatarBytes_ = splatBytes_ = records.size() * sizeof(GeneralSplatRecord) + splats.sh.size() * sizeof(float);
    DPL_TRY(buffers_.splats, upload("splats", records));
    DPL_TRY(buffers_.sh, upload("sh", splats.sh));
    return makeWorkBuffers();
}

Status Frame::makeWorkBuffers() {
    const uint64_t splats = splats_.count;
    Buffers& b = buffers_;
    DPL_TRY(b.projected, makeBuffer(owned_, "projected", splats * sizeof(ProjectedSplat)));
    DPL_TRY(b.sortDepth, makeBuffer(owned_, "sort depth", splats * sizeof(uint)));
    DPL_TRY(b.blockSums, makeBuffer(owned_, "block sums", (blocksOf(splats_.count, kCompactBlock) + 1ull) * sizeof(uint)));
    DPL_TRY(b.counts, makeBuffer(owned_, "counts", sizeof(FrameCounts)));
    DPL_TRY(b.pairs, makeBuffer(owned_, "pairs", splats * sizeof(uvec2)));
    DPL_TRY(b.pairsSwap, makeBuffer(owned_, "pairs swap", splats * sizeof(uvec2)));
    DPL_TRY(b.histogram, makeBuffer(owned_, "histogram", (uint64_t(kSortDigits) * blocksOf(splats_.count, kSortBlock) + 1) * sizeof(uint)));
    return {};
}

namespace {

/** Survivors in splat order as (depth key, splat), and the indirect arguments of what follows. */
void addCompact(FramePlan& plan, uint32_t splatCount, BufferId sortDepth, BufferId blockSums, BufferId counts, BufferId pairs) {
    const uint32_t blocks = blocksOf(splatCount, kCompactBlock);
    const CompactPush push{splatCount, blocks};
    plan.compute("compact.count", "compact.count").reads(sortDepth).writes(blockSums).push(push).groups(blocks);
    plan.compute("compact.scan", "compact.scan").reads(counts).updates(blockSums).push(ScanPush{blocks, 0}).groups(1);
    plan.compute("compact.args", "compact.args").reads(blockSums).updates(counts).push(ArgsPush{blocks, 1}).groups(1);
    plan.compute("compact.scatter", "compact.scatter").reads(sortDepth, blockSums).writes(pairs).push(push).groups(blocks);
}

/** Stable radix sort by the 32-bit key, near first; the result is in `pairs`. */
void addSort(FramePlan& plan, BufferId counts, BufferId histogram, BufferId pairs, BufferId swap) {
    static_assert(kSortRounds % 2 == 0, "an even number of rounds ends in the buffer it began in");
    static_assert(kSortRounds * kSortDigitBits == 32);
    BufferId from = pairs, to = swap;
    const uint64_t args = offsetof(FrameCounts, sortGroupsX);
    for (uint32_t round = 0; round < kSortRounds; ++round) {
        const SortPush push{round * kSortDigitBits};
        plan.compute("sort.count", "sort.count").reads(counts, from).writes(histogram).push(push).groupsFrom(counts, args);
        plan.compute("sort.scan", "compact.scan").reads(counts).updates(histogram).push(ScanPush{0, 1}).groups(1);
        plan.compute("sort.scatter", "sort.scatter").reads(counts, from, histogram).writes(to).push(push).groupsFrom(counts, args);
        std::swap(from, to);
    }
}

}  // namespace

Status Frame::addQuads(FramePlan& plan, Eye& eye, uint32_t widthPx, uint32_t heightPx) {
    const Buffers& b = buffers_;
    const bool layered = backend_->info().multiview;
    DPL_TRY(eye.target,
            backend_->createTarget({.widthPx = widthPx, .heightPx = heightPx, .views = 1, .depth = false, .multiview = layered}));
    const DrawPipelineDesc pipeline{.vertex = layered ? "draw.vert.multiview" : "draw.vert.instances",
                                    .fragment = "draw.frag",
                                    .views = 1,
                                    .multiview = layered,
                                    .depth = false};
    plan.draw("draw.splats", pipeline, eye.target, 0)
        .reads(b.counts, b.pairs, b.projected)
        .push(DrawPush{float(widthPx), float(heightPx), 1, 1})
        .argsFrom(b.counts, offsetof(FrameCounts, drawVertices));
    return {};
}

Status Frame::addTiles(FramePlan& plan, Eye& eye, uint32_t widthPx, uint32_t heightPx) {
    TileBuffers& t = eye.tiles;
    DPL_TRY(t.counts, makeBuffer(eye.owned, "tile counts", sizeof(TileCounts)));
    DPL_TRY(t.pixels, makeBuffer(eye.owned, "tile pixels", uint64_t(widthPx) * heightPx * 4));
    DPL_TRY(eye.tileCounts, makeBuffer(eye.owned, "tile counts read back", sizeof(TileCounts), BufferMemory::Readback));
    for (const BufferId id : {t.counts, t.pixels}) {
        DPL_RETURN_IF_ERROR(backend_->write(id, 0, std::array<std::byte, 4>{}));
    }  // the backend refuses to read back a buffer that was never written, so write them once here
    if (splats_.count == 0) {
        plan.fill("tiles.begin", t.counts, 0);
        plan.fill("tiles.clear", t.pixels, 0);
        return {};
    }
    DPL_TRY(const TilePlan tiles, planTiles(splats_.count, widthPx, heightPx, backend_->info()));
    DPL_TRY(t.lists, makeBuffer(eye.owned, "tile lists", tiles.listWords * 4));
    DPL_TRY(t.entries, makeBuffer(eye.owned, "tile entries", tiles.push.entryCapacity * 4ull));
    DPL_RETURN_IF_ERROR(backend_->write(t.lists, 0, std::array<std::byte, 4>{}));  // as above: the backend requires a first write
    plain::addTiles(plan, tiles, splats_.count, buffers_.pairs, buffers_.projected, buffers_.counts, t);
    return {};
}

Status Frame::build(Eye& eye, uint32_t widthPx, uint32_t heightPx) {
    const Buffers& b = buffers_;
    DPL_TRY(eye.frame, makeBuffer(eye.owned, "frame", sizeof(FrameData), BufferMemory::Upload));
    DPL_TRY(eye.colourPixels, makeBuffer(eye.owned, "colour pixels", uint64_t(widthPx) * heightPx * 4, BufferMemory::Readback));
    DPL_TRY(eye.finalCounts, makeBuffer(eye.owned, "final counts", sizeof(FrameCounts), BufferMemory::Readback));

    FramePlan plan(*backend_);
    plan.fill("begin", b.counts, 0);
    const uint32_t stride = (splats_.shDegree + 1) * (splats_.shDegree + 1) * 3;
    const SplatPush splatPush{splats_.count, 1};
    const ColourPush colourPush{splats_.count, 1, splats_.shDegree, stride};
    if (splats_.count == 0) {  // the draw has zero instances and only clears the target
        plan.fill("no pairs", b.pairs, 0);
        plan.fill("no splats", b.projected, 0);
    } else {
        if (avatar_) {
            const bool corrected = !avatar_->correctives.empty();
            DPL_TRY(eye.palette, makeBuffer(eye.owned, "palette", paletteRows(*avatar_) * sizeof(vec4), BufferMemory::Upload));
            plan.compute("pose.skin", corrected ? "skin.corrected" : "skin")
                .reads(eye.palette, b.vertices)
                .writes(b.posed)
                .push(VertexPush{vertexCount_, 3 * uint32_t(avatar_->joints.size())})
                .threads(vertexCount_);
            plan.compute("pose.triangles", "triangles")
                .reads(b.triangles, b.posed)
                .writes(b.triangleFrames)
                .push(TrianglePush{triangleCount_})
                .threads(triangleCount_);
            plan.compute("splat.project", "project")
                .uniform(eye.frame)
                .reads(b.splats, b.triangleFrames)
                .writes(b.projected, b.sortDepth)
                .push(splatPush)
                .threads(splats_.count);
            plan.compute("splat.colour", corrected ? "colour.lit" : "colour")
                .uniform(eye.frame)
                .reads(b.splats, b.triangleFrames, b.sh)
                .updates(b.projected)
                .push(colourPush)
                .threads(splats_.count);
        } else {
            plan.compute("splat.project", "project.general")
                .uniform(eye.frame)
                .reads(b.splats)
                .writes(b.projected, b.sortDepth)
                .push(splatPush)
                .threads(splats_.count);
            plan.compute("splat.colour", "colour.general")
                .uniform(eye.frame)
                .reads(b.splats, b.sh)
                .updates(b.projected)
                .push(colourPush)
                .threads(splats_.count);
        }
        addCompact(plan, splats_.count, b.sortDepth, b.blockSums, b.counts, b.pairs);
        addSort(plan, b.counts, b.histogram, b.pairs, b.pairsSwap);
    }
    if (fill_ == PlainFill::Quads) {
        DPL_RETURN_IF_ERROR(addQuads(plan, eye, widthPx, heightPx));
    } else {
        DPL_RETURN_IF_ERROR(addTiles(plan, eye, widthPx, heightPx));
    }
    plan.copy("counts", b.counts, eye.finalCounts);
    DPL_TRY(eye.draw, plan.finish());

    FramePlan readback(*backend_);
    if (fill_ == PlainFill::Quads) {
        readback.readback("readback", eye.target, eye.colourPixels, {});
    } else {
        readback.copy("readback", eye.tiles.pixels, eye.colourPixels);
        readback.copy("readback", eye.tiles.counts, eye.tileCounts);
    }
    DPL_TRY(eye.readback, readback.finish());
    return {};
}

void Frame::free(Eye& eye) {
    backend_->destroyFrame(eye.draw);
    backend_->destroyFrame(eye.readback);
    backend_->destroyTarget(eye.target);
    for (BufferId id : eye.owned) backend_->destroyBuffer(id);
}

void Frame::writePalette(const Pose& pose, BufferId palette) {
    jointTransforms(avatar_->joints, pose, worldFromRest_);
    nodes_.clear();
    if (!avatar_->correctives.empty()) {
        correctiveCoefficients(avatar_->correctives, pose, coefficients_);
        correctiveNodes(avatar_->correctives, coefficients_, nodes_);
    }
    packPalette(worldFromRest_, nodes_, {reinterpret_cast<vec4*>(backend_->mapped(palette).data()), paletteRows(*avatar_)});
}

Status Frame::draw(const Pose& pose, std::span<const Cameraf> views) {
    drawn_ = 0;
    if (views.empty() || views.size() > kMaxEyes)
        return fail(Code::InvalidArgument, "{} views; the plain frame draws 1 to {}", views.size(), kMaxEyes);
    if (views.front().widthPx != views.back().widthPx || views.front().heightPx != views.back().heightPx)
        return fail(Code::InvalidArgument, "the views have different sizes");
    if (views[0].widthPx != widthPx_ || views[0].heightPx != heightPx_) {
        for (Eye& eye : eyes_) free(eye);
        eyes_.clear();
        widthPx_ = views[0].widthPx, heightPx_ = views[0].heightPx;
    }
    while (eyes_.size() < views.size()) {
        Eye eye;
        if (Status made = build(eye, widthPx_, heightPx_); !made) {
            free(eye);
            return made;
        }
        eyes_.push_back(std::move(eye));
    }
    for (size_t v = 0; v < views.size(); ++v) {
        Eye& eye = eyes_[v];
        DPL_RETURN_IF_ERROR(backend_->wait(eye.draw));
        const FrameData block = packFrame(splats_, views[v]);
        std::memcpy(backend_->mapped(eye.frame).data(), &block, sizeof block);
        if (avatar_ && splats_.count > 0) writePalette(pose, eye.palette);
        DPL_RETURN_IF_ERROR(backend_->submit(eye.draw));
    }
    drawn_ = views.size();
    return {};
}

Result<std::vector<std::span<const uint8_t>>> Frame::read() {
    if (drawn_ == 0) return fail(Code::InvalidArgument, "nothing was drawn");
    std::vector<std::span<const uint8_t>> pictures;
    for (size_t v = 0; v < drawn_; ++v) {
        DPL_RETURN_IF_ERROR(backend_->wait(eyes_[v].draw));  // the draw's times and counts are valid after this
        DPL_RETURN_IF_ERROR(backend_->run(eyes_[v].readback));
        if (fill_ == PlainFill::Tiles) {
            TileCounts counts;
            std::memcpy(&counts, backend_->mapped(eyes_[v].tileCounts).data(), sizeof counts);
            if (counts.overflowed) return fail(Code::Unsupported, "the lists of plain tiles hold too little for this frame; quads draw it");
        }
        const std::span<std::byte> pixels = backend_->mapped(eyes_[v].colourPixels);
        if (fill_ == PlainFill::Quads) opacityFromTransmittance(pixels);
        pictures.emplace_back(reinterpret_cast<const uint8_t*>(pixels.data()), size_t(widthPx_) * heightPx_ * 4);
    }
    return pictures;
}

std::vector<PassTime> Frame::passTimes() const {
    std::vector<PassTime> times;
    for (size_t v = 0; v < drawn_; ++v)
        for (const FrameId id : {eyes_[v].draw, eyes_[v].readback})
            for (PassTime& time : backend_->passTimes(id)) times.push_back(std::move(time));
    return times;
}

uint32_t Frame::splatsDrawn() const {
    uint32_t most = 0;
    for (size_t v = 0; v < drawn_; ++v) {
        FrameCounts counts;
        std::memcpy(&counts, backend_->mapped(eyes_[v].finalCounts).data(), sizeof counts);
        most = std::max(most, counts.visible);
    }
    return most;
}

}  // namespace dpl::plain
