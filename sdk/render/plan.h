// SPDX-License-Identifier: Apache-2.0
// A frame as a list of steps that passes append to. A pass names its shader, its buffers in binding order and its threads;
// barriers follow from the access it declares.
//
//   plan.compute("splat.project", "project").uniform(ids.frame).reads(ids.splats, ids.frames).writes(ids.projected)
//       .push(SplatPush{n, views}).threads(n);
#pragma once

#include <cstring>
#include <type_traits>

#include "sdk/backend/backend.h"

namespace dpl {

class FramePlan {
public:
    explicit FramePlan(Backend& backend) : backend_(backend) {}

    template <class StepType>
    class Builder {
    public:
        Builder(FramePlan& plan, StepType& step) : plan_(plan), step_(step) {}
        // Binding numbers follow the order of these calls.
        Builder& uniform(BufferId buffer) { return bind(Access::Uniform, buffer); }
        template <class... Buffers>
        Builder& reads(Buffers... buffers) {
            return (bind(Access::Read, buffers), ..., *this);
        }
        template <class... Buffers>
        Builder& writes(Buffers... buffers) {
            return (bind(Access::Write, buffers), ..., *this);
        }
        template <class... Buffers>
        Builder& updates(Buffers... buffers) {
            return (bind(Access::Update, buffers), ..., *this);
        }
        template <class Push>
        Builder& push(const Push& value) {
            static_assert(std::is_trivially_copyable_v<Push> && sizeof(Push) <= 128);
            std::memcpy(step_.push.bytes.data(), &value, sizeof(Push));
            step_.push.size = sizeof(Push);
            return *this;
        }
        /** At least `count` invocations. */
        Builder& threads(uint32_t count) {
            const uint32_t size = plan_.backend_.workgroupSize(step_.pipeline);
            if (size) step_.groups = uint32_t((uint64_t(count) + size - 1) / size);
            return *this;
        }
        Builder& groups(uint32_t count) { return step_.groups = count, *this; }
        Builder& groupsFrom(BufferId args, uint64_t offset) { return step_.indirect = {args, offset}, *this; }
        Builder& argsFrom(BufferId args, uint64_t offset) { return step_.args = {args, offset}, *this; }

    private:
        Builder& bind(Access access, BufferId buffer) { return step_.bindings.push_back({buffer, access}), *this; }
        FramePlan& plan_;
        StepType& step_;
    };

    // A builder is valid until the next step is added.
    Builder<ComputeStep> compute(std::string label, std::string_view shader);
    Builder<DrawStep> draw(std::string label, const DrawPipelineDesc& pipeline, TargetId target, uint32_t view);
    void fill(std::string label, BufferId buffer, uint32_t value) { steps_.push_back(FillStep{std::move(label), buffer, value}); }
    void readback(std::string label, TargetId target, BufferId colour, BufferId depth) {
        steps_.push_back(ReadbackStep{std::move(label), target, colour, depth});
    }

    void copy(std::string label, BufferId from, BufferId to, uint64_t offset = 0) {
        steps_.push_back(CopyStep{std::move(label), from, to, offset});
    }

    /** The recorded frame, or the first error of any step. */
    Result<FrameId> finish(FrameRun run = FrameRun::Submitted);

private:
    void keepError(const Error& error) {
        if (status_) status_ = error;
    }

    Backend& backend_;
    std::vector<Step> steps_;
    Status status_;
};

}  // namespace dpl
