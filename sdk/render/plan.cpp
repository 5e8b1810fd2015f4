// SPDX-License-Identifier: Apache-2.0
#include "sdk/render/plan.h"

namespace dpl {

FramePlan::Builder<ComputeStep> FramePlan::compute(std::string label, std::string_view shader) {
    auto pipeline = backend_.computePipeline(shader);
    if (!pipeline) keepError(pipeline.error());
    ComputeStep step;
    step.label = std::move(label);
    if (pipeline) step.pipeline = *pipeline;
    steps_.push_back(std::move(step));
    return {*this, std::get<ComputeStep>(steps_.back())};
}

FramePlan::Builder<DrawStep> FramePlan::draw(std::string label, const DrawPipelineDesc& desc, TargetId target, uint32_t view) {
    auto pipeline = backend_.drawPipeline(desc);
    if (!pipeline) keepError(pipeline.error());
    DrawStep step;
    step.label = std::move(label);
    step.target = target;
    step.view = view;
    if (pipeline) step.pipeline = *pipeline;
    steps_.push_back(std::move(step));
    return {*this, std::get<DrawStep>(steps_.back())};
}

Result<FrameId> FramePlan::finish(FrameRun run) {
    if (!status_) return status_.error();
    return backend_.createFrame(std::move(steps_), run);
}

}  // namespace dpl
