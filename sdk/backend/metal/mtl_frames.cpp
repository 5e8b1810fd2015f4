// SPDX-License-Identifier: Apache-2.0
// Frames. Metal replays no command buffer, so a frame is encoded anew in each run from steps that were prepared when it was created.
#include "sdk/backend/hazards.h"
#include "sdk/backend/metal/mtl_backend.h"

namespace dpl::mtl {

Result<ComputeEncoderRef> MetalBackend::Recorder::compute() {
    if (compute_ && barrier_) seam_.barrier(compute_);
    barrier_ = false;
    if (compute_) return compute_;
    close();
    compute_ = seam_.computeEncoder(commands_);
    if (!compute_) return fail(Code::Device, "Metal gave no compute encoder; is the command buffer committed, or an encoder open?");
    waitFor(compute_);
    return compute_;
}

Result<BlitEncoderRef> MetalBackend::Recorder::blit() {
    if (barrier_) close();  // a blit encoder has no barriers
    barrier_ = false;
    if (blit_) return blit_;
    close();
    blit_ = seam_.blitEncoder(commands_);
    if (!blit_) return fail(Code::Device, "Metal gave no blit encoder; is the command buffer committed, or an encoder open?");
    waitFor(blit_);
    return blit_;
}

void MetalBackend::Recorder::close() {
    if (compute_) {
        seam_.updateFence(compute_, backend_.written_);
        seam_.end(compute_);
        seam_.release(compute_);
    }
    if (blit_) {
        seam_.updateFence(blit_, backend_.written_);
        seam_.end(blit_);
        seam_.release(blit_);
    }
}

Status MetalBackend::Recorder::play(const RecordedStep& step) {
    label_ = step.label;
    barrier_ = step.barrier;
    return std::visit([&](const auto& s) { return play(s); }, step.step);
}

Status MetalBackend::Recorder::play(const FillStep& step) {
    DPL_TRY(const ComputeEncoderRef encoder, compute());
    const Buffer& buffer = backend_.buffers_.at(step.buffer.value);
    const Pipeline& pipeline = backend_.at(backend_.fill_);
    const gpu::FillPush push{uint32_t((buffer.desc.bytes + 3) / 4), step.value};  // buffers are made of whole 16 bytes
    seam_.pushLabel(encoder, label_);
    seam_.setPipeline(encoder, pipeline.compute);
    seam_.setBuffer(encoder, buffer.buffer, 0, 0);
    seam_.setBytes(encoder, &push, sizeof push, kPushIndex);
    seam_.dispatch(encoder, {(push.count + gpu::kFillWords - 1) / gpu::kFillWords}, {pipeline.shader->workgroup[0]});
    seam_.popLabel(encoder);
    return {};
}

Status MetalBackend::Recorder::play(const ComputeStep& step) {
    DPL_TRY(const ComputeEncoderRef encoder, compute());
    const Pipeline& pipeline = backend_.at(step.pipeline);
    const Size threads{pipeline.shader->workgroup[0], pipeline.shader->workgroup[1], pipeline.shader->workgroup[2]};
    seam_.pushLabel(encoder, label_);
    seam_.setPipeline(encoder, pipeline.compute);
    for (uint32_t i = 0; i < step.bindings.size(); ++i) {
        const Buffer& buffer = backend_.buffers_.at(step.bindings[i].buffer.value);
        seam_.setBuffer(encoder, buffer.lent ? buffer.lent : buffer.buffer, buffer.lentOffset, i);
    }
    if (step.push.size) seam_.setBytes(encoder, step.push.bytes.data(), step.push.size, kPushIndex);
    if (step.indirect.buffer)
        seam_.dispatchIndirect(encoder, backend_.buffers_.at(step.indirect.buffer.value).buffer, step.indirect.offset, threads);
    else
        seam_.dispatch(encoder, {step.groups}, threads);
    seam_.popLabel(encoder);
    return {};
}

PassAttachment MetalBackend::Recorder::attachment(const Target& target, uint32_t view, TextureRef drawn, TextureRef samples) const {
    PassAttachment made;
    made.texture = samples ? samples : drawn;
    made.slice = view;
    if (samples) {
        made.resolve = drawn;
        made.resolveSlice = view;
        if (!target.desc.multiview) made.slice = 0;
        made.store = StoreAction::Resolve;
    }
    made.clear[3] = 1;  // nothing drawn: black, transmittance 1
    return made;
}

Status MetalBackend::Recorder::play(const DrawStep& step) {
    close();
    const Target& target = backend_.targets_.at(step.target.value);
    const Pipeline& pipeline = backend_.at(step.pipeline);
    RenderPassDesc pass;
    pass.colours[0] = attachment(target, step.view, target.colour, target.colourSamples);
    if (target.desc.depth) {
        pass.colours[1] = attachment(target, step.view, target.depth, target.depthSamples);
        pass.colours[1].clear[3] = 0;
    }
    if (target.desc.multiview) pass.layers = target.desc.views;
    RenderEncoderRef encoder = seam_.renderEncoder(commands_, pass);
    if (!encoder) return fail(Code::Device, "Metal gave no render encoder; is the command buffer committed, or an encoder open?");
    waitFor(encoder, kStageVertex);
    seam_.pushLabel(encoder, label_);
    seam_.setPipeline(encoder, pipeline.render);
    seam_.setViewport(encoder, 0, 0, target.desc.widthPx, target.desc.heightPx);
    const size_t own = pipeline.shader->bindings.size();
    for (uint32_t i = 0; i < step.bindings.size(); ++i) {
        const BufferRef buffer = backend_.buffers_.at(step.bindings[i].buffer.value).buffer;
        i < own ? seam_.setVertexBuffer(encoder, buffer, 0, i) : seam_.setFragmentBuffer(encoder, buffer, 0, i);
    }
    if (step.push.size) {
        seam_.setVertexBytes(encoder, step.push.bytes.data(), step.push.size, kPushIndex);
        if (pipeline.fragment->pushBytes) seam_.setFragmentBytes(encoder, step.push.bytes.data(), step.push.size, kPushIndex);
    }
    const uint32_t viewMask[2] = {0, target.desc.views};
    if (target.desc.multiview) seam_.setVertexBytes(encoder, viewMask, sizeof viewMask, kViewMaskIndex);
    seam_.drawIndirect(encoder, pipeline.primitive, backend_.buffers_.at(step.args.buffer.value).buffer, step.args.offset);
    seam_.popLabel(encoder);
    seam_.updateFence(encoder, backend_.written_, kStageFragment);
    seam_.end(encoder);
    seam_.release(encoder);
    return {};
}

Status MetalBackend::Recorder::play(const ReadbackStep& step) {
    const Target& target = backend_.targets_.at(step.target.value);
    const uint32_t widthPx = target.desc.widthPx, heightPx = target.desc.heightPx, pixels = widthPx * heightPx;
    const Pipeline& round = backend_.at(backend_.round_);
    const BufferRef colour = backend_.buffers_.at(step.colour.value).buffer;
    DPL_TRY(const ComputeEncoderRef encoder, compute());
    seam_.pushLabel(encoder, label_);
    seam_.setPipeline(encoder, round.compute);
    seam_.setTexture(encoder, target.colour, 0);
    seam_.setBuffer(encoder, colour, 0, 1);
    for (uint32_t v = 0; v < target.desc.views; ++v) {
        const gpu::RoundPush push{widthPx, v * pixels, v};
        seam_.setBytes(encoder, &push, sizeof push, kPushIndex);
        seam_.dispatch(encoder, {(widthPx + gpu::kSceneGroup - 1) / gpu::kSceneGroup, heightPx}, {gpu::kSceneGroup});
    }
    seam_.popLabel(encoder);
    if (!step.depth) return {};
    const uint32_t bytes = backend_.info_.halfDepth ? 4 : 8;
    DPL_TRY(const BlitEncoderRef copies, blit());
    for (uint32_t v = 0; v < target.desc.views; ++v)
        seam_.copyTexture(copies, target.depth, v, widthPx, heightPx, backend_.buffers_.at(step.depth.value).buffer,
                          uint64_t(v) * pixels * bytes, widthPx * bytes);
    return {};
}

Status MetalBackend::Recorder::play(const CopyStep& step) {
    DPL_TRY(const BlitEncoderRef encoder, blit());
    const Buffer &from = backend_.buffers_.at(step.from.value), &to = backend_.buffers_.at(step.to.value);
    const bool back = to.desc.memory == BufferMemory::Readback;
    seam_.copyBuffer(encoder, from.buffer, back ? step.offset : 0, to.buffer, back ? 0 : step.offset,
                     back ? to.desc.bytes : from.desc.bytes);
    return {};
}

/** Encodes the steps. Allocates nothing; Metal makes the encoders. */
Status MetalBackend::play(const Frame& frame, CommandsRef commands) {
    Recorder recorder(*this, commands);
    for (const RecordedStep& step : frame.steps) {
        DPL_RETURN_IF_ERROR(recorder.play(step));
    }
    return {};
}

Result<FrameId> MetalBackend::createFrame(std::vector<Step> steps, FrameRun run) {
    DPL_RETURN_IF_ERROR(checkFrame(steps, *this, info_));
    for (const Step& step : steps)
        if (const auto* draw = std::get_if<DrawStep>(&step)) targets_.at(draw->target.value).drawn = true;
    for (const BufferId id : writtenBy(steps)) buffers_.at(id.value).written = true;
    Frame frame;
    frame.run = run;
    frame.born = encoded();
    frame.steps.reserve(steps.size());
    Hazards hazards;
    for (Step& step : steps) {
        const bool barrier = std::visit([&](const auto& s) { return hazards.before(s); }, step);
        const LabelRef label = seam_->newLabel(stepLabel(step));
        frame.steps.push_back({std::move(step), barrier, label});
    }
    const FrameId id{newId()};
    frames_.emplace(id.value, std::move(frame));
    return id;
}

void MetalBackend::freeFrame(Frame& frame) {
    if (frame.run == FrameRun::Submitted) (void)waitFor(frame);
    seam_->release(frame.commands);
    for (RecordedStep& step : frame.steps) seam_->release(step.label);
    frame.steps.clear();
}

void MetalBackend::destroyFrame(FrameId id) {
    const auto it = frames_.find(id.value);
    if (it == frames_.end()) return;
    freeFrame(it->second);  // command buffers do not need the labels any more
    frames_.erase(it);
}

Result<CommandsRef> MetalBackend::newCommands() {
    if (lost_) return fail(Code::Device, "the GPU failed before");
    const CommandsRef commands = seam_->commandBuffer();
    if (!commands) return fail(Code::Device, "Metal gave no command buffer");
    return commands;
}

/** Whether commands that have ended were run. */
Status MetalBackend::endOf(CommandsRef commands) {
    if (seam_->status(commands) != CommandStatus::Error) return {};
    std::string text;
    const CommandError error = seam_->error(commands, text);
    if (error == CommandError::NotPermitted)
        return fail(Code::Device, "the GPU refused the commands, as it does while an app is in the background: {}", text);
    lost_ = true;
    return fail(Code::Device, "the GPU did not run the commands: {}", text);
}

Status MetalBackend::commitAndWait(CommandsRef commands) {
    seam_->commit(commands);
    seam_->wait(commands);
    return endOf(commands);
}

Status MetalBackend::submit(FrameId id) {
    const auto it = frames_.find(id.value);
    if (it == frames_.end() || it->second.run != FrameRun::Submitted)
        return fail(Code::InvalidArgument, "the submitted frame does not exist");
    Frame& frame = it->second;
    DPL_RETURN_IF_ERROR(waitFor(frame));
    DPL_TRY(CommandsRef commands, newCommands());
    if (const Status played = play(frame, commands); !played) {
        seam_->release(commands);
        return played;
    }
    seam_->commit(commands);
    frame.commands = commands;
    frame.running = true;
    return {};
}

bool MetalBackend::finished(FrameId id) {
    const auto it = frames_.find(id.value);
    if (it == frames_.end() || !it->second.running) return true;
    Frame& frame = it->second;
    if (frame.run == FrameRun::Encoded) return false;  // the app knows; encode() learns it from the app's promise
    if (seam_->status(frame.commands) != CommandStatus::Completed) return false;  // wait() tells of an error
    ended(frame);
    return true;
}

Status MetalBackend::wait(FrameId id) {
    const auto it = frames_.find(id.value);
    return it == frames_.end() ? Status() : waitFor(it->second);
}

Status MetalBackend::waitFor(Frame& frame) {
    if (!frame.running || frame.run == FrameRun::Encoded) return {};
    seam_->wait(frame.commands);
    const Status status = endOf(frame.commands);
    ended(frame);
    return status;
}

void MetalBackend::ended(Frame& frame) {
    frame.running = false;
    if (!frame.commands) return;
    frame.ms = (seam_->gpuEndS(frame.commands) - seam_->gpuStartS(frame.commands)) * 1000;
    seam_->release(frame.commands);
}

std::vector<PassTime> MetalBackend::passTimes(FrameId id) {
    const double ms = frameMs(id);
    return ms > 0 ? std::vector<PassTime>{{"frame", ms}} : std::vector<PassTime>();
}

double MetalBackend::frameMs(FrameId id) {
    const auto it = frames_.find(id.value);
    return it == frames_.end() ? 0 : it->second.ms;
}

}  // namespace dpl::mtl
