// SPDX-License-Identifier: Apache-2.0
// Buffers and targets.
#include <cstring>

#include "sdk/backend/metal/mtl_backend.h"

namespace dpl::mtl {
namespace {

constexpr uint64_t kStagingBytes = 8u << 20;

}  // namespace

Status MetalBackend::makeBuffer(Buffer& b) {
    const StorageMode storage = b.desc.memory == BufferMemory::Device ? StorageMode::Private : StorageMode::Shared;
    const uint64_t bytes = (b.desc.bytes + 15) / 16 * 16;
    b.buffer = seam_->newBuffer(bytes, storage, b.desc.label);
    if (!b.buffer) return fail(Code::OutOfMemory, "no graphics memory: {} bytes for {}", bytes, b.desc.label);
    if (storage == StorageMode::Shared) b.mapped = seam_->contents(b.buffer);
    return {};
}

Result<BufferId> MetalBackend::createBuffer(const BufferDesc& desc) {
    if (desc.bytes == 0) return fail(Code::InvalidArgument, "buffer {} has no bytes", desc.label);
    Buffer b;
    b.desc = desc;
    if (desc.memory != BufferMemory::Lent) {
        DPL_RETURN_IF_ERROR(makeBuffer(b));
    }
    b.born = encoded();
    const BufferId id{newId()};
    buffers_.emplace(id.value, std::move(b));
    return id;
}

void MetalBackend::destroyBuffer(BufferId id) {
    const auto it = buffers_.find(id.value);
    if (it == buffers_.end()) return;
    dropCopies(id);
    retire(it->second.buffer, it->second.born);
    buffers_.erase(it);
}

Status MetalBackend::write(BufferId id, uint64_t offset, std::span<const std::byte> bytes) {
    const auto it = buffers_.find(id.value);
    if (it == buffers_.end() || offset % 4 || offset > it->second.desc.bytes || bytes.size() > it->second.desc.bytes - offset)
        return fail(Code::InvalidArgument, "a write of {} bytes at {} does not fit the buffer", bytes.size(), offset);
    Buffer staging;
    staging.desc = {"staging", std::min<uint64_t>(std::max<uint64_t>(bytes.size(), 16), kStagingBytes), BufferMemory::Upload};
    DPL_RETURN_IF_ERROR(makeBuffer(staging));
    Status status;
    for (size_t done = 0; status && done < bytes.size();) {
        const size_t part = std::min<size_t>(bytes.size() - done, staging.desc.bytes);
        std::memcpy(staging.mapped, bytes.data() + done, part);
        auto commands = newCommands();
        status = commands ? Status() : Status(commands.error());
        if (!status) break;
        status = encodeCopy(*commands, staging.buffer, 0, it->second.buffer, offset + done, part);
        if (status) status = commitAndWait(*commands);
        seam_->release(*commands);
        done += part;
    }
    seam_->release(staging.buffer);
    if (status) it->second.written = true;
    return status;
}

std::span<std::byte> MetalBackend::mapped(BufferId id) {
    const auto it = buffers_.find(id.value);
    if (it == buffers_.end() || !it->second.mapped) return {};
    return {it->second.mapped, size_t(it->second.desc.bytes)};
}

/** samples: the texture that is drawn into when the target has several samples a pixel, and resolved. */
Result<TextureRef> MetalBackend::makeTexture(const Target& t, PixelFormat format, bool samples, std::string_view label) {
    TextureDesc desc;
    desc.format = format;
    desc.widthPx = t.desc.widthPx, desc.heightPx = t.desc.heightPx;
    desc.layers = t.desc.views;
    desc.usage = kUsageRenderTarget | kUsageShaderRead;
    if (samples) {
        // Views that are drawn one after the other share one texture, because a GPU without layered rendering may lack arrays of samples.
        desc.type = t.desc.multiview ? TextureType::ArraySamples : TextureType::FlatSamples;
        if (!t.desc.multiview) desc.layers = 1;
        desc.samples = t.desc.samples;
        desc.usage = kUsageRenderTarget;
        if (memoryless_) desc.storage = StorageMode::Memoryless;
    }
    const TextureRef made = seam_->newTexture(desc, label);
    if (!made)
        return fail(Code::OutOfMemory, "no graphics memory for {}: {} x {} px, {} views, {} samples", label, desc.widthPx, desc.heightPx,
                    desc.layers, desc.samples);
    return made;
}

Status MetalBackend::makeTarget(Target& t) {
    const TargetDesc& desc = t.desc;
    if (desc.widthPx == 0 || desc.heightPx == 0 || desc.widthPx > info_.maxTargetPx || desc.heightPx > info_.maxTargetPx)
        return fail(Code::Unsupported, "a picture of {} x {} px is not possible; {} draws 1 to {} px a side", desc.widthPx, desc.heightPx,
                    info_.name, info_.maxTargetPx);
    if (desc.samples != 1 && (!info_.fourSamples || desc.samples != 4))
        return fail(Code::Unsupported, "{} samples a pixel are not possible on {}", desc.samples, info_.name);
    if (desc.multiview && !info_.multiview) return fail(Code::Unsupported, "{} has no layered rendering", info_.name);
    DPL_TRY(t.colour, makeTexture(t, kColourFormat, false, "colour"));
    if (desc.depth) {
        DPL_TRY(t.depth, makeTexture(t, depthSums(), false, "depth sums"));
    }
    if (desc.samples == 1) return {};
    DPL_TRY(t.colourSamples, makeTexture(t, kColourFormat, true, "colour samples"));
    if (desc.depth) {
        DPL_TRY(t.depthSamples, makeTexture(t, depthSums(), true, "depth sum samples"));
    }
    return {};
}

void MetalBackend::freeTarget(Target& t) {
    for (TextureRef* texture : {&t.colour, &t.depth, &t.colourSamples, &t.depthSamples}) seam_->release(*texture);
}

Result<TargetId> MetalBackend::createTarget(const TargetDesc& desc) {
    Target t;
    t.desc = desc;
    if (auto status = makeTarget(t); !status) {
        freeTarget(t);
        return status.error();
    }
    t.born = encoded();
    const TargetId id{newId()};
    targets_.emplace(id.value, std::move(t));
    return id;
}

void MetalBackend::destroyTarget(TargetId id) {
    const auto it = targets_.find(id.value);
    if (it == targets_.end()) return;
    Target& t = it->second;
    for (TextureRef* texture : {&t.colour, &t.depth, &t.colourSamples, &t.depthSamples}) retire(*texture, t.born);
    targets_.erase(it);
}

/** Without what was destroyed and waits for the commands that need it. */
uint64_t MetalBackend::residentBytes() const {
    uint64_t bytes = 0;
    for (const auto& [id, b] : buffers_)
        if (b.buffer) bytes += seam_->allocatedBytes(b.buffer);
    for (const auto& [id, t] : targets_)
        for (const TextureRef texture : {t.colour, t.depth, t.colourSamples, t.depthSamples})
            if (texture) bytes += seam_->allocatedBytes(texture);
    return bytes;
}

const BufferDesc* MetalBackend::buffer(BufferId id) const {
    const auto it = buffers_.find(id.value);
    return it == buffers_.end() ? nullptr : &it->second.desc;
}
const TargetDesc* MetalBackend::target(TargetId id) const {
    const auto it = targets_.find(id.value);
    return it == targets_.end() ? nullptr : &it->second.desc;
}
const Shader* MetalBackend::shader(PipelineId id) const {
    return id.value == 0 || id.value > pipelines_.size() ? nullptr : at(id).shader;
}
const Shader* MetalBackend::fragment(PipelineId id) const {
    return id.value == 0 || id.value > pipelines_.size() ? nullptr : at(id).fragment;
}
bool MetalBackend::written(BufferId id) const {
    return buffers_.at(id.value).written;
}
bool MetalBackend::drawn(TargetId id) const {
    return targets_.at(id.value).drawn;
}

}  // namespace dpl::mtl
