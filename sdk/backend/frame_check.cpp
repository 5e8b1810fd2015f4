#include "sdk/backend/frame_check.h"

#include <set>

namespace dpl {
namespace {

struct Checker {
    const ResourceView& resources;
    const DeviceInfo& device;
    std::set<uint32_t> filled;  // Device buffers that a step has written
    std::set<uint32_t> drawn;   // targets
    std::set<uint32_t> put;     // targets that hold pixels and wait for a draw that keeps them

    Status readable(const std::string& label, BufferId id) const {
        const BufferDesc* desc = resources.buffer(id);
        if (!desc) return fail(Code::InvalidArgument, "step {} uses a buffer that does not exist", label);
        if (desc->memory == BufferMemory::Device && !filled.count(id.value) && !resources.written(id))
            return fail(Code::InvalidArgument, "step {} reads buffer {}, which nothing has written", label, desc->label);
        return {};
    }

    Status bindings(const std::string& label, const Shader& shader, const Shader* fragment, const std::vector<Binding>& list, const PushBytes& push) {
        const size_t own = shader.bindings.size(), all = own + (fragment ? fragment->bindings.size() : 0);
        if (list.size() != all) return fail(Code::InvalidArgument, "step {} binds {} buffers, shader {} has {}", label, list.size(), shader.name, all);
        if (push.size != shader.pushBytes)
            return fail(Code::InvalidArgument, "step {} pushes {} bytes, shader {} wants {}", label, push.size, shader.name, shader.pushBytes);
        std::set<uint32_t> seen;
        for (size_t i = 0; i < list.size(); ++i) {
            const ShaderBinding& want = i < own ? shader.bindings[i] : fragment->bindings[i - own];
            const Access access = list[i].access;
            const BufferDesc* desc = resources.buffer(list[i].buffer);
            if (!desc) return fail(Code::InvalidArgument, "step {} binds a buffer that does not exist to {}", label, want.name);
            if ((access == Access::Uniform) != want.uniform) return fail(Code::InvalidArgument, "step {}: {} is {}a uniform block", label, want.name, want.uniform ? "" : "not ");
            const bool writes = access == Access::Write || access == Access::Update, reads = access != Access::Write;
            if (writes != want.writes || (want.reads && !reads))
                return fail(Code::InvalidArgument, "step {} declares another access to {} than shader {} has", label, want.name, shader.name);
            if (!want.uniform && desc->bytes > device.maxBindingBytes)
                return fail(Code::Unsupported, "step {}: buffer {} has {} bytes, this device binds at most {}", label, desc->label, desc->bytes, device.maxBindingBytes);
            if (!seen.insert(list[i].buffer.value).second) return fail(Code::InvalidArgument, "step {} binds buffer {} twice", label, desc->label);
            if (reads) { DPL_CHECK_OK(readable(label, list[i].buffer)); }
        }
        for (const Binding& b : list)
            if (b.access == Access::Write || b.access == Access::Update) filled.insert(b.buffer.value);
        return {};
    }

    Status indirect(const std::string& label, const IndirectArgs& args, uint64_t bytes) const {
        DPL_CHECK_OK(readable(label, args.buffer));
        if (args.offset % 4 || args.offset + bytes > resources.buffer(args.buffer)->bytes)
            return fail(Code::InvalidArgument, "step {}: indirect arguments at {} do not fit buffer {}", label, args.offset, resources.buffer(args.buffer)->label);
        return {};
    }

    Status operator()(const FillStep& step) {
        if (!resources.buffer(step.buffer)) return fail(Code::InvalidArgument, "step {} fills a buffer that does not exist", step.label);
        filled.insert(step.buffer.value);
        return {};
    }

    Status operator()(const ComputeStep& step) {
        const Shader* shader = resources.shader(step.pipeline);
        if (!shader || shader->stage != ShaderStage::Compute) return fail(Code::InvalidArgument, "step {} has no compute pipeline", step.label);
        if (step.indirect.buffer) {
            DPL_CHECK_OK(indirect(step.label, step.indirect, 12));
        } else if (step.groups == 0 || step.groups > device.maxGroups) {
            return fail(Code::Unsupported, "step {} wants {} workgroups; 1 to {} are possible", step.label, step.groups, device.maxGroups);
        }
        return bindings(step.label, *shader, nullptr, step.bindings, step.push);
    }

    Status operator()(const DrawStep& step) {
        const Shader* shader = resources.shader(step.pipeline);
        if (!shader || shader->stage != ShaderStage::Vertex) return fail(Code::InvalidArgument, "step {} has no draw pipeline", step.label);
        if (!resources.target(step.target)) return fail(Code::InvalidArgument, "step {} draws into a target that does not exist", step.label);
        if (step.keep != (put.erase(step.target.value) > 0))
            return fail(Code::InvalidArgument, "step {} {}", step.label, step.keep ? "keeps pixels that nothing has put there" : "clears pixels that were just put there");
        drawn.insert(step.target.value);
        DPL_CHECK_OK(indirect(step.label, step.args, 16));
        return bindings(step.label, *shader, resources.fragment(step.pipeline), step.bindings, step.push);
    }

    Status operator()(const PutPixelsStep& step) {
        const TargetDesc* target = resources.target(step.target);
        if (!target) return fail(Code::InvalidArgument, "step {} puts pixels into a target that does not exist", step.label);
        if (target->samples != 1) return fail(Code::InvalidArgument, "step {} puts pixels into a target of {} samples a pixel", step.label, target->samples);
        DPL_CHECK_OK(readable(step.label, step.pixels));
        const uint64_t pixels = uint64_t(target->widthPx) * target->heightPx * target->views, colourBytes = pixels * (target->halfColour ? 8 : 4);
        const uint64_t end = target->depth ? step.depthOffset + pixels * (device.halfDepth ? 4 : 8) : colourBytes;
        if ((target->depth && (step.depthOffset < colourBytes || step.depthOffset % 8)) || resources.buffer(step.pixels)->bytes < end)
            return fail(Code::InvalidArgument, "step {}: buffer {} does not hold colour and depth of {} pixels", step.label, resources.buffer(step.pixels)->label, pixels);
        put.insert(step.target.value);
        return {};
    }

    Status operator()(const CopyStep& step) {
        DPL_CHECK_OK(readable(step.label, step.from));
        const BufferDesc *from = resources.buffer(step.from), *to = resources.buffer(step.to);
        if (to && to->memory == BufferMemory::Device && from->memory == BufferMemory::Upload) {
            if (step.toOffset % 4 || step.toOffset > to->bytes || from->bytes > to->bytes - step.toOffset)
                return fail(Code::InvalidArgument, "step {}: {} bytes of {} do not fit buffer {} at {}", step.label, from->bytes, from->label, to->label, step.toOffset);
            filled.insert(step.to.value);
            return {};
        }
        if (!to || to->memory != BufferMemory::Readback || to->bytes > from->bytes)
            return fail(Code::InvalidArgument, "step {} copies {} into a buffer that is not a smaller read-back buffer", step.label, from->label);
        return {};
    }

    Status operator()(const ReadbackStep& step) {
        const TargetDesc* target = resources.target(step.target);
        if (!target || !(drawn.count(step.target.value) || resources.drawn(step.target))) return fail(Code::InvalidArgument, "step {} reads a target that nothing has drawn", step.label);
        const uint64_t pixels = uint64_t(target->widthPx) * target->heightPx * target->views;
        const BufferDesc* colour = resources.buffer(step.colour);
        if (!colour || colour->memory != BufferMemory::Readback || colour->bytes < pixels * 4)
            return fail(Code::InvalidArgument, "step {} needs a read-back buffer of {} bytes for colour", step.label, pixels * 4);
        if (!step.depth) return {};
        const uint64_t depthBytes = pixels * (device.halfDepth ? 4 : 8);
        const BufferDesc* depth = resources.buffer(step.depth);
        if (!target->depth) return fail(Code::InvalidArgument, "step {} wants depth from a target without it", step.label);
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
    Checker checker{resources, device, {}, {}, {}};
    for (const Step& step : steps) { DPL_CHECK_OK(std::visit(checker, step)); }
    return {};
}

}  // namespace dpl
