// SPDX-License-Identifier: Apache-2.0
#include "sdk/backend/frame_check.h"

#include <set>

namespace dpl {
namespace {

struct Checker {
    const ResourceView& resources;
    const DeviceInfo& device;
    std::set<uint32_t> filled;  // Device buffers that a step has written
    std::set<uint32_t> drawn;   // targets

    Status readable(const std::string& label, BufferId id) const {
        const BufferDesc* desc = resources.buffer(id);
        if (!desc) return fail(Code::InvalidArgument, "step {} uses a buffer that does not exist", label);
        if (desc->memory == BufferMemory::Device && !filled.count(id.value) && !resources.written(id))
            return fail(Code::InvalidArgument, "step {} reads buffer {}, which nothing has written", label, desc->label);
        return {};
    }

    Status bindings(const std::string& label, const Shader& shader, const Shader* fragment, const std::vector<Binding>& list,
                    const PushBytes& push) {
        const size_t own = shader.bindings.size(), all = own + (fragment ? fragment->bindings.size() : 0);
        if (list.size() != all)
            return fail(Code::InvalidArgument, "step {} binds {} buffers, shader {} has {}", label, list.size(), shader.name, all);
        if (push.size != shader.pushBytes)
            return fail(Code::InvalidArgument, "step {} pushes {} bytes, shader {} wants {}", label, push.size, shader.name,
                        shader.pushBytes);
        std::set<uint32_t> seen;
        for (size_t i = 0; i < list.size(); ++i) {
            const ShaderBinding& want = i < own ? shader.bindings[i] : fragment->bindings[i - own];
            const Access access = list[i].access;
            const BufferDesc* desc = resources.buffer(list[i].buffer);
            if (!desc) return fail(Code::InvalidArgument, "step {} binds a buffer that does not exist to {}", label, want.name);
            if (want.image) return fail(Code::InvalidArgument, "step {}: {} is an image; only a composer reads images", label, want.name);
            if ((access == Access::Uniform) != want.uniform)
                return fail(Code::InvalidArgument, "step {}: {} is {}a uniform block", label, want.name, want.uniform ? "" : "not ");
            const bool writes = access == Access::Write || access == Access::Update, reads = access != Access::Write;
            if (writes != want.writes || (want.reads && !reads))
                return fail(Code::InvalidArgument, "step {} declares another access to {} than shader {} has", label, want.name,
                            shader.name);
            if (!want.uniform && desc->bytes > device.maxBindingBytes)
                return fail(Code::Unsupported, "step {}: buffer {} has {} bytes, this device binds at most {}", label, desc->label,
                            desc->bytes, device.maxBindingBytes);
            if (!seen.insert(list[i].buffer.value).second)
                return fail(Code::InvalidArgument, "step {} binds buffer {} twice", label, desc->label);
            if (reads) {
                DPL_RETURN_IF_ERROR(readable(label, list[i].buffer));
            }
        }
        for (const Binding& b : list)
            if (b.access == Access::Write || b.access == Access::Update) filled.insert(b.buffer.value);
        return {};
    }

    Status indirect(const std::string& label, const IndirectArgs& args, uint64_t bytes) const {
        DPL_RETURN_IF_ERROR(readable(label, args.buffer));
        if (args.offset % 4 || args.offset + bytes > resources.buffer(args.buffer)->bytes)
            return fail(Code::InvalidArgument, "step {}: indirect arguments at {} do not fit buffer {}", label, args.offset,
                        resources.buffer(args.buffer)->label);
        return {};
    }

    Status operator()(const FillStep& step) {
        if (!resources.buffer(step.buffer)) return fail(Code::InvalidArgument, "step {} fills a buffer that does not exist", step.label);
        filled.insert(step.buffer.value);
        return {};
    }

    Status operator()(const ComputeStep& step) {
        const Shader* shader = resources.shader(step.pipeline);
        if (!shader || shader->stage != ShaderStage::Compute)
            return fail(Code::InvalidArgument, "step {} has no compute pipeline", step.label);
        if (step.indirect.buffer) {
            DPL_RETURN_IF_ERROR(indirect(step.label, step.indirect, 12));
        } else if (step.groups == 0 || step.groups > device.maxGroups) {
            return fail(Code::Unsupported, "step {} wants {} workgroups; 1 to {} are possible", step.label, step.groups, device.maxGroups);
        }
        return bindings(step.label, *shader, nullptr, step.bindings, step.push);
    }

    Status operator()(const DrawStep& step) {
        const Shader* shader = resources.shader(step.pipeline);
        if (!shader || shader->stage != ShaderStage::Vertex) return fail(Code::InvalidArgument, "step {} has no draw pipeline", step.label);
        if (!resources.target(step.target))
            return fail(Code::InvalidArgument, "step {} draws into a target that does not exist", step.label);
        const TargetDesc& target = *resources.target(step.target);
        if (step.view >= (target.multiview ? 1 : target.views))
            return fail(Code::InvalidArgument, "step {} draws view {} of a target that has {}{}", step.label, step.view, target.views,
                        target.multiview ? " at once" : "");
        if (target.multiview || step.view + 1 == target.views) drawn.insert(step.target.value);
        DPL_RETURN_IF_ERROR(indirect(step.label, step.args, 16));
        return bindings(step.label, *shader, resources.fragment(step.pipeline), step.bindings, step.push);
    }

    Status operator()(const CopyStep& step) {
        DPL_RETURN_IF_ERROR(readable(step.label, step.from));
        const BufferDesc *from = resources.buffer(step.from), *to = resources.buffer(step.to);
        const bool forward = from->memory == BufferMemory::Upload || from->memory == BufferMemory::Device;
        if (to && to->memory == BufferMemory::Device && forward && step.from != step.to) {
            if (step.offset % 4 || step.offset > to->bytes || from->bytes > to->bytes - step.offset)
                return fail(Code::InvalidArgument, "step {}: {} bytes of {} do not fit buffer {} at {}", step.label, from->bytes,
                            from->label, to->label, step.offset);
            filled.insert(step.to.value);
            return {};
        }
        if (!to || to->memory != BufferMemory::Readback || step.offset % 4 || step.offset > from->bytes ||
            to->bytes > from->bytes - step.offset)
            return fail(Code::InvalidArgument,
                        "step {} copies {} from byte {}; the destination must be a read-back buffer that is no larger than the rest",
                        step.label, from->label, step.offset);
        return {};
    }

    Status operator()(const ReadbackStep& step) {
        const TargetDesc* target = resources.target(step.target);
        if (!target || !(drawn.count(step.target.value) || resources.drawn(step.target)))
            return fail(Code::InvalidArgument, "step {} reads a target that nothing has drawn", step.label);
        const uint64_t pixels = uint64_t(target->widthPx) * target->heightPx * target->views;
        const BufferDesc* colour = resources.buffer(step.colour);
        if (!colour || colour->memory != BufferMemory::Readback || colour->bytes < pixels * 4)
            return fail(Code::InvalidArgument, "step {} needs a read-back buffer of {} bytes for colour", step.label, pixels * 4);
        if (!step.depth) return {};
        const uint64_t depthBytes = pixels * (device.halfDepth ? 4 : 8);
        const BufferDesc* depth = resources.buffer(step.depth);
        if (!target->depth) return fail(Code::InvalidArgument, "step {} reads depth from a target that has no depth", step.label);
        if (!depth || depth->memory != BufferMemory::Readback || depth->bytes < depthBytes)
            return fail(Code::InvalidArgument, "step {} needs a read-back buffer of {} bytes for depth", step.label, depthBytes);
        return {};
    }
};

}  // namespace

const std::string& stepLabel(const Step& step) {
    return std::visit([](const auto& s) -> const std::string& { return s.label; }, step);
}

Status checkFrame(std::span<const Step> steps, const ResourceView& resources, const DeviceInfo& device) {
    Checker checker{resources, device, {}, {}};
    for (const Step& step : steps) {
        DPL_RETURN_IF_ERROR(std::visit(checker, step));
    }
    return {};
}

std::vector<BufferId> writtenBy(std::span<const Step> steps) {
    std::vector<BufferId> list;
    const auto add = [&](const std::vector<Binding>& bindings) {
        for (const Binding& b : bindings)
            if (b.access == Access::Write || b.access == Access::Update) list.push_back(b.buffer);
    };
    for (const Step& step : steps) {
        if (const auto* fill = std::get_if<FillStep>(&step)) list.push_back(fill->buffer);
        if (const auto* compute = std::get_if<ComputeStep>(&step)) add(compute->bindings);
        if (const auto* draw = std::get_if<DrawStep>(&step)) add(draw->bindings);
    }
    return list;
}

}  // namespace dpl
