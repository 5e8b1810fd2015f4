// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/training/gpu/gpu_targets.h"

#include <algorithm>

#include "sdk/render/plan.h"
#include "shaders/training/shared/train.h"

namespace dpl {
namespace {

uint32_t bytes4(uint8_t a, uint8_t b, uint8_t c, uint8_t d) {
    return uint32_t(a) | uint32_t(b) << 8 | uint32_t(c) << 16 | uint32_t(d) << 24;
}

void pack(const PictureTarget& t, std::vector<uint32_t>& packed) {
    const size_t pixels = size_t(t.widthPx) * t.heightPx;
    const auto at = [](std::span<const uint8_t> plane, size_t i) { return plane.empty() ? uint8_t(0) : plane[i]; };
    packed.resize(pixels * gpu::kTrainPictureWords);
    uint32_t* words = packed.data();
    for (size_t i = 0; i < pixels; ++i, words += gpu::kTrainPictureWords) {
        words[0] = bytes4(t.rgb[i], t.rgb[pixels + i], t.rgb[2 * pixels + i], t.mask[i]);
        words[1] = bytes4(at(t.cloth, i), at(t.shown, i), at(t.unsure, i), 0);
        words[2] = t.behind.empty() ? 0 : bytes4(t.behind[i], t.behind[pixels + i], t.behind[2 * pixels + i], 0);
    }
}

}  // namespace

GpuTargets::~GpuTargets() {
    clear();
}

void GpuTargets::clear() {
    forgetPlace();
    for (const Kept& k : kept_) backend_.destroyBuffer(k.buffer);
    kept_.clear(), keptBytes_ = 0;
}

void GpuTargets::forgetPlace() {
    for (Kept& k : kept_)
        if (k.copy) backend_.destroyFrame(std::exchange(k.copy, FrameId()));
}

GpuTargets::Kept* GpuTargets::find(const TargetName& name) {
    const auto at = std::lower_bound(kept_.begin(), kept_.end(), name.frame, [](const Kept& k, uint32_t f) { return k.name.frame < f; });
    return at != kept_.end() && at->name == name ? &*at : nullptr;
}

Status GpuTargets::keep(const TargetName& name) {
    const auto bytes = std::as_bytes(std::span(packed_));
    if (keptBytes_ + bytes.size() > kBoundBytes) return {};
    Kept made{name, {}, {}};
    const auto buffer = backend_.createBuffer({"a target", bytes.size(), BufferMemory::Device});
    if (!buffer) return buffer.error().code == Code::OutOfMemory ? Status() : Status(buffer.error());
    made.buffer = *buffer;
    if (Status written = backend_.write(made.buffer, 0, bytes); !written) {
        backend_.destroyBuffer(made.buffer);
        return written;
    }
    keptBytes_ += bytes.size();
    const auto at = std::lower_bound(kept_.begin(), kept_.end(), name.frame, [](const Kept& k, uint32_t f) { return k.name.frame < f; });
    kept_.insert(at, made);
    return {};
}

Status GpuTargets::show(const PictureTarget& target, const std::optional<TargetName>& name, BufferId place) {
    if (name && !kept_.empty() && kept_.front().name.level != name->level) clear();
    Kept* kept = name ? find(*name) : nullptr;
    if (!kept) {
        pack(target, packed_);
        crossed_ += packed_.size() * 4;
        if (name) DPL_RETURN_IF_ERROR(keep(*name));
        kept = name ? find(*name) : nullptr;
        if (!kept) return backend_.write(place, 0, std::as_bytes(std::span(packed_)));
    }
    if (!kept->copy) {
        FramePlan plan(backend_);
        plan.copy("target", kept->buffer, place);
        DPL_TRY(kept->copy, plan.finish());
    }
    return backend_.run(kept->copy);
}

}  // namespace dpl
