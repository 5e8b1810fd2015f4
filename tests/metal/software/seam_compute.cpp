// SPDX-License-Identifier: Apache-2.0
// Dispatches and copies of the software device, and what every shader needs before it runs.
#include <algorithm>

#include "tests/metal/software/seam.h"

namespace dpl::mtl {

Ready SoftSeam::ready(SoftEncoder& e, int stage, const msl::Entry& entry) {
    Ready ready;
    const auto missing = [&](const std::string& text) {
        fault(e, entry.name + " " + text);
        ready.fine = false;
    };
    for (const msl::Parameter& p : entry.parameters) {
        const std::string place = "(" + std::to_string(p.index) + ") '" + p.name + "'";
        if (p.given == msl::Given::Buffer) {
            const BoundBuffer& bound = e.bindings[stage].buffers[p.index];
            if (!bound.buffer && !bound.bytes) {
                missing("needs buffer" + place + ", which is not bound");
                continue;
            }
            std::byte* memory = bound.buffer ? bound.buffer->memory.get() + bound.offset : bound.bytes->data();
            const uint64_t bytes = bound.buffer ? bound.buffer->bytes - bound.offset : bound.bytes->size();
            if (bytes < p.bytes)
                missing("needs " + std::to_string(p.bytes) + " bytes in buffer" + place + ", which holds " + std::to_string(bytes));
            if (p.writes && bound.bytes) missing("writes buffer" + place + ", which is set as bytes");
            ready.bindings.buffers[p.index] = {memory, bytes};
            if (bound.buffer) ready.uses.push_back({bound.buffer, bound.offset, bound.buffer->bytes, p.writes, p.index});
            if (bound.bytes) ready.heldBytes.push_back(bound.bytes);
        } else if (p.given == msl::Given::Texture) {
            SoftTexture* bound = e.bindings[stage].textures[p.index];
            if (!bound) {
                missing("needs texture" + place + ", which is not bound");
                continue;
            }
            if (uint32_t(bound->desc.type) != uint32_t(p.shape)) missing("reads " + bound->name() + " as another type of texture");
            if (!(bound->desc.usage & kUsageShaderRead))
                missing("reads " + bound->name() + ", whose usage has no MTLTextureUsageShaderRead");
            ready.bindings.textures[p.index] = &bound->pixels;
            ready.uses.push_back({bound, 0, bound->desc.layers, false, msl::kSlots});
        }
    }
    for (BoundBuffer& slot : e.bindings[stage].buffers) slot.fresh = false;
    return ready;
}

SoftBuffer* SoftSeam::argsAt(BufferRef args, uint64_t offset, uint64_t bytes, const char* call) {
    auto* buffer = state_->get<SoftBuffer>(args.object, call);
    if (!buffer) return nullptr;
    if (offset % 4 == 0 && offset + bytes <= buffer->bytes) return buffer;
    state_->fault(std::string(call) + ": the arguments at byte " + std::to_string(offset) + " do not lie in " + buffer->name());
    return nullptr;
}

void SoftSeam::setPipeline(ComputeEncoderRef encoder, ComputePipelineRef pipeline) {
    SoftEncoder* e = openEncoder(encoder.object, "setComputePipelineState");
    auto* p = state_->get<SoftComputePipeline>(pipeline.object, "setComputePipelineState");
    if (!e || !p) return;
    e->compute = p;
    state_->pin(*e->commands, p);
}

void SoftSeam::dispatch(ComputeEncoderRef encoder, Size groups, Size threads) {
    encodeDispatch(encoder.object, groups, nullptr, 0, threads);
}

void SoftSeam::dispatchIndirect(ComputeEncoderRef encoder, BufferRef args, uint64_t offset, Size threads) {
    if (SoftBuffer* buffer = argsAt(args, offset, 12, "dispatchThreadgroupsWithIndirectBuffer"))
        encodeDispatch(encoder.object, {}, buffer, offset, threads);
}

void SoftSeam::encodeDispatch(void* encoder, Size groups, SoftBuffer* args, uint64_t offset, Size threads) {
    SoftEncoder* e = openEncoder(encoder, "dispatchThreadgroups");
    if (!e) return;
    if (!e->compute) return fault(*e, "a dispatch without a pipeline");
    const msl::Entry& entry = *e->compute->entry;
    if (glm::uvec3(threads.x, threads.y, threads.z) != entry.threads)
        return fault(*e, entry.name + " is dispatched with " + std::to_string(threads.x) + " x " + std::to_string(threads.y) + " x " +
                             std::to_string(threads.z) + " threads, and was written for " + std::to_string(entry.threads.x) + " x " +
                             std::to_string(entry.threads.y) + " x " + std::to_string(entry.threads.z));
    const auto found = std::make_shared<Ready>(ready(*e, 0, entry));
    if (!found->fine || state_->options.work == SoftwareWork::NoShaders) return;
    SoftCommands* c = e->commands;
    if (args) state_->pin(*c, args);
    c->work.push_back([this, c, found, args, offset, groups, &entry, running = e->running, what = e->place()] {
        if (args) state_->use(args, offset, offset + 12, false, *c, *running, 0, what);
        glm::uvec3 count(groups.x, groups.y, groups.z);
        if (args) std::memcpy(&count, args->memory.get() + offset, sizeof count);
        if (uint64_t(count.x) * count.y * count.z > 1u << 24) {
            state_->fault(what + ": dispatches " + std::to_string(count.x) + " x " + std::to_string(count.y) + " x " +
                          std::to_string(count.z) + " threadgroups; were its arguments written?");
            return true;
        }
        msl::running = {&entry, &found->bindings, false, &state_->faults};
        if (!msl::dispatch(entry, found->bindings, count, state_->options.laneOrder))
            state_->fault(what + ": threads of " + entry.name + " end while others wait at a barrier");
        for (const Ready::Use& use : found->uses) {
            const bool known = use.index < msl::kSlots && msl::running.high[use.index] > 0;  // else it may have used all of it
            state_->use(use.resource, known ? use.begin + msl::running.low[use.index] : use.begin,
                        known ? use.begin + msl::running.high[use.index] : use.end, use.writes, *c, *running, 0, what);
        }
        msl::running = {};
        return true;
    });
}

void SoftSeam::barrier(ComputeEncoderRef encoder) {
    if (SoftEncoder* e = openEncoder(encoder.object, "memoryBarrierWithScope"))
        e->commands->work.push_back([running = e->running] {
            ++running->interval;
            return true;
        });
}

void SoftSeam::copyBuffer(BlitEncoderRef encoder, BufferRef from, uint64_t fromOffset, BufferRef to, uint64_t toOffset, uint64_t bytes) {
    SoftEncoder* e = openEncoder(encoder.object, "copyFromBuffer");
    auto *source = state_->get<SoftBuffer>(from.object, "copyFromBuffer"), *target = state_->get<SoftBuffer>(to.object, "copyFromBuffer");
    if (!e || !source || !target) return;
    if (bytes == 0 || fromOffset + bytes > source->bytes || toOffset + bytes > target->bytes)
        return fault(*e, "a copy of " + std::to_string(bytes) + " bytes leaves " + source->name() + " or " + target->name());
    if (fromOffset % 4 != 0 || toOffset % 4 != 0 || bytes % 4 != 0)
        return fault(*e, "a copy into " + target->name() + " is not made of whole words, as macOS needs");
    SoftCommands* c = e->commands;
    state_->pin(*c, source), state_->pin(*c, target);
    c->work.push_back([this, c, source, fromOffset, target, toOffset, bytes, running = e->running] {
        state_->use(source, fromOffset, fromOffset + bytes, false, *c, *running, 0, "a copy from " + source->name());
        state_->use(target, toOffset, toOffset + bytes, true, *c, *running, 0, "a copy into " + target->name());
        std::memcpy(target->memory.get() + toOffset, source->memory.get() + fromOffset, bytes);
        return true;
    });
}

void SoftSeam::copyTexture(BlitEncoderRef encoder, TextureRef from, uint32_t slice, uint32_t widthPx, uint32_t heightPx, BufferRef to,
                           uint64_t toOffset, uint32_t bytesPerRow) {
    SoftEncoder* e = openEncoder(encoder.object, "copyFromTexture");
    auto* source = state_->get<SoftTexture>(from.object, "copyFromTexture");
    auto* target = state_->get<SoftBuffer>(to.object, "copyFromTexture");
    if (!e || !source || !target) return;
    const TextureDesc& desc = source->desc;
    if (desc.samples != 1 || desc.storage == StorageMode::Memoryless || slice >= desc.layers || widthPx > desc.widthPx ||
        heightPx > desc.heightPx)
        return fault(*e, source->name() + " cannot be copied so: it has samples, is memoryless, or is smaller");
    const uint64_t rowBytes = uint64_t(widthPx) * texelBytes(desc.format);
    if (bytesPerRow < rowBytes || toOffset + uint64_t(heightPx - 1) * bytesPerRow + rowBytes > target->bytes)
        return fault(*e, "the copy of " + source->name() + " does not fit into " + target->name());
    SoftCommands* c = e->commands;
    state_->pin(*c, source), state_->pin(*c, target);
    c->work.push_back([this, c, source, slice, heightPx, target, toOffset, bytesPerRow, rowBytes, running = e->running] {
        state_->use(source, slice, slice + 1, false, *c, *running, 0, "a copy from " + source->name());
        state_->use(target, toOffset, toOffset + uint64_t(heightPx) * bytesPerRow, true, *c, *running, 0, "a copy into " + target->name());
        for (uint32_t y = 0; y < heightPx; ++y)
            std::memcpy(target->memory.get() + toOffset + uint64_t(y) * bytesPerRow, source->pixels.row(y, slice), rowBytes);
        return true;
    });
}

}  // namespace dpl::mtl
