// SPDX-License-Identifier: Apache-2.0
// Command buffers, the life of encoders, fences and events of the software device.
#include <algorithm>

#include "tests/metal/software/seam.h"

namespace dpl::mtl {
namespace {

constexpr size_t kSetBytesMax = 4096;  // of setBytes:length:atIndex:
constexpr size_t kKeptValues = 16;     // of an event

/** Removes scopes of command buffers that the CPU has seen end. */
void forgetSeen(Ended& ended, uint64_t seenCommands) {
    ended.erase(ended.begin(), ended.lower_bound((seenCommands + 1) << 21));
}

void merge(Ended& into, const Ended& from) {
    into.insert(from.begin(), from.end());
}

}  // namespace

SoftCommands* SoftSeam::openCommands(CommandsRef commands, const char* call) {
    auto* c = state_->get<SoftCommands>(commands.object, call);
    if (!c) return nullptr;
    if (c->status != CommandStatus::NotEnqueued) {
        state_->fault(std::string(call) + ": the command buffer was committed before");
        return nullptr;
    }
    if (c->open) {
        state_->fault(std::string(call) + ": the command buffer has an open " + c->open->name());
        return nullptr;
    }
    return c;
}

void SoftSeam::commit(CommandsRef commands) {
    if (auto* c = state_->get<SoftCommands>(commands.object, "commit")) state_->commit(*c);
}

void SoftSeam::wait(CommandsRef commands) {
    const auto locked = state_->lock();
    auto* c = state_->get<SoftCommands>(commands.object, "waitUntilCompleted");
    if (!c) return;
    if (c->status == CommandStatus::NotEnqueued) return state_->fault("waitUntilCompleted: the command buffer was not committed");
    while (c->status == CommandStatus::Committed) {
        if (state_->runOne()) continue;
        state_->fault("waitUntilCompleted: a command buffer waits for an event that nothing signals");
        SoftCommands* stuck = state_->committed.front();
        stuck->error = CommandError::Timeout, stuck->errorText = "waits for an event that nothing signals";
    }
    state_->saw(*c);
}

CommandStatus SoftSeam::status(CommandsRef commands) {
    const auto locked = state_->lock();
    auto* c = state_->get<SoftCommands>(commands.object, "status");
    if (!c) return CommandStatus::Error;
    const CommandStatus status = c->status;
    if (status == CommandStatus::Completed || status == CommandStatus::Error)
        state_->saw(*c);
    else
        state_->look();
    return status;
}

CommandError SoftSeam::error(CommandsRef commands, std::string& text) {
    const auto locked = state_->lock();
    auto* c = state_->get<SoftCommands>(commands.object, "error");
    if (!c) return CommandError::Internal;
    text = c->errorText;
    return c->error;
}

double SoftSeam::gpuStartS(CommandsRef commands) {
    auto* c = state_->get<SoftCommands>(commands.object, "GPUStartTime");
    return c ? c->startS : 0;
}

double SoftSeam::gpuEndS(CommandsRef commands) {
    auto* c = state_->get<SoftCommands>(commands.object, "GPUEndTime");
    return c ? c->endS : 0;
}

void SoftSeam::encodeWait(CommandsRef commands, EventRef event, uint64_t value) {
    SoftCommands* c = openCommands(commands, "encodeWaitForEvent");
    auto* e = state_->get<SoftEvent>(event.object, "encodeWaitForEvent");
    if (!c || !e) return;
    state_->pin(*c, e);
    c->work.push_back([c, e, value] {
        if (e->value < value) return false;
        const auto at = e->ended.lower_bound(value);
        if (at != e->ended.end()) merge(c->ended, at->second);
        return true;
    });
}

void SoftSeam::encodeSignal(CommandsRef commands, EventRef event, uint64_t value) {
    SoftCommands* c = openCommands(commands, "encodeSignalEvent");
    auto* e = state_->get<SoftEvent>(event.object, "encodeSignalEvent");
    if (!c || !e) return;
    state_->pin(*c, e);
    c->work.push_back([this, c, e, value] {
        if (value <= e->value) state_->fault("encodeSignalEvent: the value " + std::to_string(value) + " does not grow");
        e->value = std::max(e->value, value);
        Ended& ended = e->ended[value];
        merge(ended, c->ended), merge(ended, c->ran);
        forgetSeen(ended, c->seenCommands);
        if (e->ended.size() > kKeptValues) e->ended.erase(e->ended.begin());
        return true;
    });
}

void SoftSeam::present(CommandsRef commands, DrawableRef drawable) {
    openCommands(commands, "presentDrawable");
    if (!drawable) state_->fault("presentDrawable: the drawable is null");
}

SoftEncoder* SoftSeam::newEncoder(CommandsRef commands, EncoderKind kind) {
    SoftCommands* c = openCommands(commands, "a new encoder");
    if (!c) return nullptr;
    auto* encoder = state_->add(std::make_unique<SoftEncoder>(kind, c));
    c->open = encoder;
    c->work.push_back([c, running = encoder->running] {
        running->scope = (c->number << 20 | ++c->encoders) * 2;
        for (Ended& ended : running->ended) merge(ended, c->ended), forgetSeen(ended, c->seenCommands);
        return true;
    });
    return encoder;
}

SoftEncoder* SoftSeam::openEncoder(void* encoder, const char* call) {
    auto* e = state_->get<SoftEncoder>(encoder, call);
    if (!e) return nullptr;
    if (!e->commands) {
        state_->fault(std::string(call) + ": the encoder has ended");
        return nullptr;
    }
    return e;
}

void SoftSeam::endEncoder(void* encoder) {
    SoftEncoder* e = openEncoder(encoder, "endEncoding");
    if (!e) return;
    if (!e->labels.empty()) state_->fault("endEncoding: '" + e->labels.back() + "' was not popped");
    SoftCommands* c = e->commands;
    if (e->encoderKind == EncoderKind::Render) endPass(*c, *e);
    c->work.push_back([c, running = e->running, updates = e->updates] {
        for (const auto& [fence, stages] : updates) {
            Ended ended = running->ended[0];
            ended.insert(running->scope);
            if (stages & kStageFragment) {
                merge(ended, running->ended[1]);
                ended.insert(running->scope + 1);
            }
            fence->ended = std::move(ended);
        }
        for (const Ended& ended : running->ended) merge(c->ran, ended);
        c->ran.insert({running->scope, running->scope + 1});
        return true;
    });
    c->open = nullptr;
    e->commands = nullptr;
}

void SoftSeam::waitFor(void* encoder, FenceRef fence, uint32_t stages) {
    SoftEncoder* e = openEncoder(encoder, "waitForFence");
    auto* f = state_->get<SoftFence>(fence.object, "waitForFence");
    if (!e || !f) return;
    for (const auto& [updated, when] : e->updates)
        if (updated == f) fault(*e, "waitForFence after updateFence of the same fence waits for itself");
    state_->pin(*e->commands, f);
    SoftCommands* c = e->commands;
    c->work.push_back([c, f, stages, running = e->running] {
        if (stages & kStageVertex) merge(running->ended[0], f->ended);
        merge(running->ended[1], f->ended);  // fragments follow their vertices
        for (Ended& ended : running->ended) forgetSeen(ended, c->seenCommands);
        return true;
    });
}

void SoftSeam::update(void* encoder, FenceRef fence, uint32_t stages) {
    SoftEncoder* e = openEncoder(encoder, "updateFence");
    auto* f = state_->get<SoftFence>(fence.object, "updateFence");
    if (!e || !f) return;
    state_->pin(*e->commands, f);
    e->updates.push_back({f, stages});
}

void SoftSeam::push(void* encoder, LabelRef label) {
    SoftEncoder* e = openEncoder(encoder, "pushDebugGroup");
    auto* l = state_->get<SoftLabel>(label.object, "pushDebugGroup");
    if (e && l) e->labels.push_back(l->label);
}

void SoftSeam::pop(void* encoder) {
    SoftEncoder* e = openEncoder(encoder, "popDebugGroup");
    if (!e) return;
    if (e->labels.empty()) return state_->fault("popDebugGroup: nothing was pushed");
    e->labels.pop_back();
}

void SoftSeam::set(SoftEncoder& e, int stage, uint32_t index, BoundBuffer what) {
    if (index >= msl::kSlots) return fault(e, "buffer(" + std::to_string(index) + ") is bound, and Metal has buffer(0) to buffer(30)");
    BoundBuffer& slot = e.bindings[stage].buffers[index];
    if (slot.fresh) fault(e, "buffer(" + std::to_string(index) + ") is bound twice before a use");
    slot = std::move(what);
    slot.fresh = true;
}

void SoftSeam::bind(void* encoder, int stage, BufferRef buffer, uint64_t offset, uint32_t index) {
    SoftEncoder* e = openEncoder(encoder, "setBuffer");
    auto* b = state_->get<SoftBuffer>(buffer.object, "setBuffer");
    if (!e || !b) return;
    if (offset >= b->bytes) return fault(*e, "the offset " + std::to_string(offset) + " lies behind " + b->name());
    if (offset % 4 != 0) return fault(*e, "the offset " + std::to_string(offset) + " of " + b->name() + " is not a multiple of 4");
    set(*e, stage, index, {b, nullptr, offset});
    state_->pin(*e->commands, b);
}

void SoftSeam::bindBytes(void* encoder, int stage, const void* bytes, size_t size, uint32_t index) {
    SoftEncoder* e = openEncoder(encoder, "setBytes");
    if (!e) return;
    if (size == 0 || size > kSetBytesMax) return fault(*e, "setBytes of " + std::to_string(size) + " bytes; Metal takes 1 to 4096");
    const auto* from = static_cast<const std::byte*>(bytes);
    set(*e, stage, index, {nullptr, std::make_shared<std::vector<std::byte>>(from, from + size), 0});
}

void SoftSeam::bind(void* encoder, int stage, TextureRef texture, uint32_t index) {
    SoftEncoder* e = openEncoder(encoder, "setTexture");
    auto* t = state_->get<SoftTexture>(texture.object, "setTexture");
    if (!e || !t) return;
    if (index >= msl::kSlots) return fault(*e, "texture(" + std::to_string(index) + ") is bound, and Metal has texture(0) to texture(30)");
    e->bindings[stage].textures[index] = t;
    state_->pin(*e->commands, t);
}

}  // namespace dpl::mtl
