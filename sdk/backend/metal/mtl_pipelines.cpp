// SPDX-License-Identifier: Apache-2.0
#include "sdk/backend/metal/mtl_backend.h"

namespace dpl::mtl {

/** Compiles the MSL of a shader. The function is the caller's. */
Result<FunctionRef> MetalBackend::function(const Shader& shader) {
    const std::string& text = seam_->isMacText() ? shader.mslMacos : shader.mslIos;
    if (text.empty()) return fail(Code::Internal, "the shader pack has no MSL of {}", shader.name);
    std::string error;
    LibraryRef library = seam_->newLibrary(text, error);
    if (!library) return fail(Code::Device, "Metal does not compile {}: {}", shader.name, error);
    const FunctionRef made = seam_->newFunction(library, "main0");
    seam_->release(library);
    if (!made) return fail(Code::Internal, "the MSL of {} has no function main0", shader.name);
    return made;
}

Status MetalBackend::makeCompute(Pipeline& p) {
    DPL_TRY(FunctionRef kernel, function(*p.shader));
    std::string error;
    p.compute = seam_->newComputePipeline(kernel, error);
    seam_->release(kernel);
    if (!p.compute) return fail(Code::Device, "Metal makes no pipeline of {}: {}", p.shader->name, error);
    const uint32_t threads = p.shader->workgroup[0] * p.shader->workgroup[1] * p.shader->workgroup[2], most = seam_->maxThreads(p.compute);
    if (threads > most)
        return fail(Code::Unsupported, "{} runs {} threads a threadgroup, {} allows {}", p.shader->name, threads, info_.name, most);
    return {};
}

Result<RenderPipelineRef> MetalBackend::renderPipeline(RenderPipelineDesc desc, const Shader& vertex, const Shader& fragment) {
    DPL_TRY(desc.vertex, function(vertex));
    auto second = function(fragment);
    std::string error;
    RenderPipelineRef made;
    if (second) {
        desc.fragment = *second;
        made = seam_->newRenderPipeline(desc, error);
        seam_->release(desc.fragment);
    }
    seam_->release(desc.vertex);
    if (!second) return second.error();
    if (!made) return fail(Code::Device, "Metal makes no pipeline of {} and {}: {}", vertex.name, fragment.name, error);
    return made;
}

Status MetalBackend::makeDraw(Pipeline& p, const DrawPipelineDesc& desc) {
    const Shader& fragment = *p.fragment;
    if (!fragment.bindings.empty() && fragment.bindings[0].binding != p.shader->bindings.size())
        return fail(Code::Unsupported, "the bindings of {} do not begin after the {} of {}", fragment.name, p.shader->bindings.size(),
                    p.shader->name);
    // Premultiplied "over", back to front; alpha holds the transmittance.
    PipelineColour colour;
    colour.format = kColourFormat;
    colour.blends = true;
    colour.alphaFrom = BlendFactor::Zero;
    RenderPipelineDesc wanted;
    wanted.label = p.key;
    wanted.colours[0] = colour;
    if (desc.depth) {
        wanted.colours[1] = colour;
        wanted.colours[1].format = depthSums();
    }
    wanted.samples = desc.samples;
    wanted.layered = desc.multiview;
    DPL_TRY(p.render, renderPipeline(wanted, *p.shader, fragment));
    return {};
}

PipelineId MetalBackend::findPipeline(std::string_view key) const {
    for (size_t i = 0; i < pipelines_.size(); ++i)
        if (pipelines_[i].key == key) return PipelineId{uint32_t(i) + 1};
    return {};
}

Result<PipelineId> MetalBackend::computePipeline(std::string_view name) {
    if (PipelineId known = findPipeline(name)) return known;
    Pipeline p;
    p.key = name;
    p.shader = pack_.find(name);
    if (!p.shader) return fail(Code::NotFound, "no shader {} in the pack", name);
    if (auto status = makeCompute(p); !status) {
        seam_->release(p.compute);
        return status.error();
    }
    pipelines_.push_back(std::move(p));
    return PipelineId{uint32_t(pipelines_.size())};
}

Result<PipelineId> MetalBackend::drawPipeline(const DrawPipelineDesc& desc) {
    Pipeline p;
    p.key = formatText("{}+{}+{}{}{}+{}{}", desc.vertex, desc.fragment, desc.views, desc.multiview ? "M" : "", desc.depth ? "D" : "",
                       desc.samples, desc.topology == Topology::List ? "T" : "");
    if (PipelineId known = findPipeline(p.key)) return known;
    p.shader = pack_.find(desc.vertex);
    p.fragment = pack_.find(desc.fragment + std::string(desc.samples > 1 ? kSamplesSuffix : ""));
    if (!p.shader || !p.fragment) return fail(Code::NotFound, "no shader {} or {} in the pack", desc.vertex, desc.fragment);
    p.primitive = desc.topology == Topology::List ? PrimitiveType::Triangle : PrimitiveType::Strip;
    DPL_RETURN_IF_ERROR(makeDraw(p, desc));
    pipelines_.push_back(std::move(p));
    return PipelineId{uint32_t(pipelines_.size())};
}

}  // namespace dpl::mtl
