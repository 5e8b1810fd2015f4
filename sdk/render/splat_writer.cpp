// SPDX-License-Identifier: Apache-2.0
#include "sdk/render/splat_writer.h"

#include <algorithm>
#include <cstring>

#include "sdk/render/passes/skin.h"
#include "sdk/render/passes/triangles.h"
#include "sdk/render/passes/write.h"
#include "sdk/visibility/kept_splats.h"

namespace dpl {
namespace {

constexpr size_t kLevelsKept = 4;

/** What skin and triangles read. They also judge what a view sees, which nobody reads here: any view does. */
gpu::FrameData poseOnly(const LoadedSubject& subject, uint32_t hidden) {
    static const Cameraf kAnyView{1, 1, 1, 1, 0.5f, 0.5f};
    return packFrame(subject.splats, {&kAnyView, 1}, 1, {}, 1, hidden);
}

std::vector<KeptSplat> keptSplats(const AvatarRecords& records, uint32_t groupCount, const SplatDetail& detail) {
    std::vector<SplatChunk> chunks(groupCount / 2);
    std::vector<SplatGroup> groups(groupCount);
    std::memcpy(static_cast<void*>(chunks.data()), records.codes.data(), chunks.size() * sizeof(SplatChunk));
    std::memcpy(static_cast<void*>(groups.data()), records.codes.data() + records.where.firstGroupDetail,
                groups.size() * sizeof(SplatGroup));
    std::vector<KeptSplat> kept;
    keepSplats(chunks, groups, detail, kept);
    return kept;
}

gpu::vec4 rowOf(const Placement& placement, int row) {
    const Mat3d& r = placement.rotation;
    return {float(placement.scale * r[0][row]), float(placement.scale * r[1][row]), float(placement.scale * r[2][row]),
            float(placement.translation[row])};
}

void packTurn(const ShRotator& rotator, gpu::WriteData& data) {
    uint32_t direction = 0, number = 0;
    for (uint32_t band = 1; band <= kMaxShDegree; ++band) {
        const uint32_t size = 2 * band + 1;
        for (uint32_t i = 0; i < size; ++i) {
            const Vec3d& d = rotator.direction(band, i);
            data.shDirections[direction++] = {float(d.x), float(d.y), float(d.z), 0};
            for (uint32_t k = 0; k < size; ++k, ++number) (&data.shInverse[number / 4].x)[number % 4] = float(rotator.inverse(band, i, k));
        }
    }
}

}  // namespace

SplatWriter::~SplatWriter() {
    for (auto& [id, output] : outputs_) free(output);
}

void SplatWriter::free(Output& output) {
    for (Slot& slot : output.slots)
        for (Recording& recording : slot.recordings)
            if (recording.recorded) backend_.destroyFrame(recording.recorded);
}

void SplatWriter::remove(RenderAvatarId avatar) {
    const auto found = outputs_.find(avatar);
    if (found == outputs_.end()) return;
    free(found->second);
    outputs_.erase(found);
}

SplatWriter::Output& SplatWriter::outputOf(RenderAvatarId avatar) {
    return outputs_.try_emplace(avatar, backend_).first->second;
}

/** Drops what was recorded for a budget. */
void SplatWriter::forget(Output& output, uint32_t budget) {
    for (Slot& slot : output.slots)
        for (Recording& recording : slot.recordings)
            if (recording.recorded && recording.budget == budget) {
                backend_.destroyFrame(recording.recorded);
                recording.recorded = {};
            }
}

Result<SplatWriter::Level*> SplatWriter::levelOf(Output& output, const LoadedSubject& subject, uint32_t budget) {
    for (Level& level : output.levels)
        if (level.budget == budget) {
            level.lastUse = ++uses_;
            return &level;
        }
    if (output.levels.size() >= kLevelsKept) {
        const auto oldest = std::min_element(output.levels.begin(), output.levels.end(),
                                             [](const Level& a, const Level& b) { return a.lastUse < b.lastUse; });
        forget(output, oldest->budget);
        output.levels.erase(oldest);
    }
    Level level(backend_);
    level.budget = budget, level.lastUse = ++uses_;
    level.detail = subject.detail.detailWithin(budget);
    std::vector<KeptSplat> kept;
    if (!level.detail.full()) kept = keptSplats(subject.records->avatar, subject.ids.groupCount, level.detail);
    level.keptRows = uint32_t(kept.size());
    level.rows = level.detail.full() ? subject.ids.splatCount : level.keptRows;
    DPL_TRY(level.kept, level.buffers.create("kept splats", kept.size() * sizeof(gpu::KeptRecord), BufferMemory::Upload));
    auto* record = reinterpret_cast<gpu::KeptRecord*>(backend_.mapped(level.kept).data());
    for (const KeptSplat& k : kept) *record++ = {k.splat, k.chunk * gpu::kChunkWords, k.weight, k.growth};
    output.levels.push_back(std::move(level));
    return &output.levels.back();
}

Result<uint32_t> SplatWriter::rows(RenderAvatarId avatar, uint32_t budget) {
    DPL_TRY(const Level* level, levelOf(outputOf(avatar), store_.at(avatar), budget));
    return level->rows;
}

/** The next recording of the app's frame. */
Result<SplatWriter::Recording*> SplatWriter::recordingOf(Output& output, const LoadedSubject& subject, const Level& level,
                                                         const AppWrite& app) {
    Slot& slot = output.slots[app.slot];
    if (slot.joined != app.joined) slot.used = 0, slot.joined = app.joined;
    if (slot.used >= kMostWritesAFrame)
        return fail(Code::InvalidArgument, "slot {} has {} writes of this avatar already; begin each frame by preparing its slot", app.slot,
                    slot.used);
    if (slot.used == slot.recordings.size()) {
        Recording made;
        DPL_TRY(made.frame, output.buffers.create("frame of a write", sizeof(gpu::FrameData), BufferMemory::Upload));
        DPL_TRY(made.palette, output.buffers.create("palette of a write", subject.paletteSize * sizeof(gpu::vec4), BufferMemory::Upload));
        DPL_TRY(made.data, output.buffers.create("write", sizeof(gpu::WriteData), BufferMemory::Upload));
        DPL_TRY(made.rows, output.buffers.create("rows of the app", 16, BufferMemory::Lent));
        slot.recordings.push_back(made);
    }
    Recording& recording = slot.recordings[slot.used];
    if (recording.recorded && recording.budget != level.budget) {
        backend_.destroyFrame(recording.recorded);
        recording.recorded = {};
    }
    if (!recording.recorded) {
        DPL_RETURN_IF_ERROR(record(output, subject, level, recording));
    }
    ++slot.used;
    return &recording;
}

Status SplatWriter::record(const Output& output, const LoadedSubject& subject, const Level& level, Recording& recording) {
    FrameIds frame;
    frame.counts = output.counts;
    SubjectIds ids = subject.ids;
    ids.uniforms = recording.frame, ids.palette = recording.palette;
    FramePlan plan(backend_);
    plan.fill("begin", frame.counts, 0);
    addSkin(plan, frame, ids);
    addTriangles(plan, frame, ids);
    addWrite(plan, frame, ids, {recording.data, level.kept, recording.rows, level.keptRows});
    DPL_TRY(recording.recorded, plan.finish(FrameRun::Encoded));
    recording.budget = level.budget;
    return {};
}

void SplatWriter::fill(const Recording& recording, const LoadedSubject& subject, const Level& level, const SplatWrite& write) {
    poseAvatar(subject, *write.what.pose, posed_);
    packPalette(posed_.worldFromRest, posed_.nodes, subject.avatar->light,
                {reinterpret_cast<gpu::vec4*>(backend_.mapped(recording.palette).data()), subject.paletteSize});
    const gpu::FrameData frame = poseOnly(subject, subject.components.ofLayers(write.what.hiddenLayers));
    std::memcpy(backend_.mapped(recording.frame).data(), &frame, sizeof frame);
    gpu::WriteData data{};
    data.worldFromOwnRow0 = rowOf(write.what.placement, 0), data.worldFromOwnRow1 = rowOf(write.what.placement, 1),
    data.worldFromOwnRow2 = rowOf(write.what.placement, 2);
    if (write.eye) data.eyeX = write.eye->x, data.eyeY = write.eye->y, data.eyeZ = write.eye->z, data.hasEye = 1;
    data.scale = float(write.what.placement.scale), data.shShare = level.detail.shShare, data.shDegree = write.shDegree;
    data.rows = level.rows, data.thinned = level.keptRows > 0 ? 1 : 0;
    data.elementCount = uint32_t(write.elements.size());
    std::copy(write.elements.begin(), write.elements.end(), data.elements);
    packTurn(rotator_, data);
    std::memcpy(backend_.mapped(recording.data).data(), &data, sizeof data);
}

Status SplatWriter::encode(const SplatWrite& write, const AppWrite& app) {
    const LoadedSubject& subject = store_.at(write.what.avatar);
    Output& output = outputOf(write.what.avatar);
    DPL_TRY(const Level* level, levelOf(output, subject, write.budget));
    if (level->rows == 0) return {};
    if (!output.counts) {
        DPL_TRY(output.counts, output.buffers.create("counts of writes", sizeof(gpu::FrameCounts)));
    }
    DPL_TRY(const Recording* recording, recordingOf(output, subject, *level, app));
    fill(*recording, subject, *level, write);
    DPL_RETURN_IF_ERROR(app.lend(recording->recorded, recording->rows));
    return backend_.encode(recording->recorded, app.slot, app.commands);
}

}  // namespace dpl
