// SPDX-License-Identifier: Apache-2.0
// Buffers, textures, pipelines and events of the software device.
#include "tests/metal/software/idle_seam.h"
#include "tests/metal/software/seam.h"
#include "tools/shaderpack/msl.h"

namespace dpl::mtl {

std::unique_ptr<Seam> seamOn(std::shared_ptr<DeviceState> state) {
    if (state->options.work == SoftwareWork::Nothing) return idleSeam();
    return std::make_unique<SoftSeam>(std::move(state));
}

bool SoftSeam::supportsFamily(GpuFamily family) const {
    return family == GpuFamily::Apple4 || (family == GpuFamily::Apple5 && state_->options.layered);  // Apple6 would shuffle
}

void SoftSeam::retain(void* object) {
    const auto locked = state_->lock();
    if (auto* o = state_->get<Object>(object, "retain")) ++o->references;
}

BufferRef SoftSeam::newBuffer(uint64_t bytes, StorageMode storage, std::string_view label) {
    if (bytes == 0 || bytes > maxBufferBytes()) {
        state_->fault("newBufferWithLength: " + std::to_string(bytes) + " bytes for '" + std::string(label) + "'");
        return {};
    }
    if (storage == StorageMode::Memoryless) state_->fault("newBufferWithLength: a buffer cannot be memoryless");
    return {state_->add(std::make_unique<SoftBuffer>(bytes, storage, label))};
}

std::byte* SoftSeam::contents(BufferRef buffer) {
    auto* b = state_->get<SoftBuffer>(buffer.object, "contents");
    if (b && b->storage == StorageMode::Private) state_->fault("contents: " + b->name() + " is private");
    return b && b->storage == StorageMode::Shared ? b->memory.get() : nullptr;
}

uint64_t SoftSeam::allocatedBytes(BufferRef buffer) {
    auto* b = state_->get<SoftBuffer>(buffer.object, "allocatedSize");
    return b ? b->bytes : 0;
}

TextureRef SoftSeam::newTexture(const TextureDesc& desc, std::string_view label) {
    const bool array = desc.type == TextureType::Array || desc.type == TextureType::ArraySamples;
    const bool samples = desc.type == TextureType::FlatSamples || desc.type == TextureType::ArraySamples;
    const std::string name = "newTextureWithDescriptor '" + std::string(label) + "': ";
    if (desc.widthPx == 0 || desc.heightPx == 0 || desc.layers == 0 || desc.widthPx > 16384 || desc.heightPx > 16384 || desc.layers > 2048)
        state_->fault(name + "a size is zero or too large");
    else if (!array && desc.layers != 1)
        state_->fault(name + "a texture without layers has arrayLength " + std::to_string(desc.layers));
    else if (samples ? desc.samples < 2 || !supportsSampleCount(desc.samples) : desc.samples != 1)
        state_->fault(name + "sampleCount " + std::to_string(desc.samples) + " does not fit its type or the device");
    else if (texelBytes(desc.format) == 0)
        state_->fault(name + "the software device does not know MTLPixelFormat " + std::to_string(uint32_t(desc.format)));
    else if (isDepth(desc.format) && desc.storage == StorageMode::Shared)
        state_->fault(name + "a depth texture must be private or memoryless");
    else if (desc.storage == StorageMode::Memoryless && desc.usage != kUsageRenderTarget)
        state_->fault(name + "a memoryless texture can only be a render target");
    else if (samples && !state_->options.msaa32 && desc.format == PixelFormat::RG32Float)
        state_->fault(name + "the device has no multisampled textures of 32-bit floats");
    else
        return {state_->add(std::make_unique<SoftTexture>(desc, label))};
    return {};
}

uint64_t SoftSeam::allocatedBytes(TextureRef texture) {
    auto* t = state_->get<SoftTexture>(texture.object, "allocatedSize");
    return !t || t->desc.storage == StorageMode::Memoryless ? 0 : t->pixels.bytes();
}

TextureFacts SoftSeam::factsOf(TextureRef texture) {
    auto* t = state_->get<SoftTexture>(texture.object, "a property of a texture");
    if (!t) return {};
    const TextureDesc& d = t->desc;
    return {d.type, d.format, d.widthPx, d.heightPx, d.layers, d.samples, d.storage, d.usage};
}

uint64_t SoftSeam::signaledValue(EventRef event) {
    const auto locked = state_->lock();
    auto* e = state_->get<SoftEvent>(event.object, "signaledValue");
    if (!e) return 0;
    const uint64_t value = e->value;
    for (const auto& [at, ended] : e->ended)
        if (at <= value) state_->seen.insert(ended.begin(), ended.end());
    state_->look();
    return value;
}

LibraryRef SoftSeam::newLibrary(std::string_view msl, std::string& error) {
    if (const Status fine = lintMslStrictly("newLibraryWithSource", msl); !fine) {
        error = fine.error().message;
        return {};
    }
    const msl::Entry* entry = msl::entryOfText(msl);
    if (entry) return {state_->add(std::make_unique<SoftFunction>("library", entry))};
    error = "the software device has not compiled this text; add its shader to tests/metal/CMakeLists.txt";
    return {};
}

FunctionRef SoftSeam::newFunction(LibraryRef library, std::string_view name) {
    auto* l = state_->get<SoftFunction>(library.object, "newFunctionWithName");
    if (!l || name != "main0") return {};
    return {state_->add(std::make_unique<SoftFunction>("function", l->entry))};
}

ComputePipelineRef SoftSeam::newComputePipeline(FunctionRef function, std::string& error) {
    auto* f = state_->get<SoftFunction>(function.object, "newComputePipelineStateWithFunction");
    if (f && f->entry->stage == msl::Stage::Compute) return {state_->add(std::make_unique<SoftComputePipeline>(f->entry))};
    error = f ? f->entry->name + " is not a kernel" : "there is no function";
    return {};
}

uint32_t SoftSeam::maxThreads(ComputePipelineRef pipeline) {
    return state_->get<SoftComputePipeline>(pipeline.object, "maxTotalThreadsPerThreadgroup") ? 1024 : 0;
}

RenderPipelineRef SoftSeam::newRenderPipeline(const RenderPipelineDesc& desc, std::string& error) {
    auto* vertex = state_->get<SoftFunction>(desc.vertex.object, "vertexFunction");
    auto* fragment = state_->get<SoftFunction>(desc.fragment.object, "fragmentFunction");
    if (!vertex || vertex->entry->stage != msl::Stage::Vertex || !fragment || fragment->entry->stage != msl::Stage::Fragment) {
        error = "a stage has the wrong function";
        return {};
    }
    if (!supportsSampleCount(desc.samples)) error = "the device has no " + std::to_string(desc.samples) + " samples a pixel";
    const auto writesColour = [&](size_t i) { return fragment->entry->output("color(" + std::to_string(i) + ")") != nullptr; };
    for (size_t i = 0; i < 2; ++i) {
        const PipelineColour& colour = desc.colours[i];
        if (writesColour(i) && colour.format == PixelFormat::None)
            error = fragment->entry->name + " writes color(" + std::to_string(i) + "), which has no pixel format";
        if (colour.format != PixelFormat::None && (texelBytes(colour.format) == 0 || isDepth(colour.format)))
            error = "MTLPixelFormat " + std::to_string(uint32_t(colour.format)) + " is no colour format that the software device knows";
    }
    if (fragment->entry->output("depth") && desc.depth == PixelFormat::None)
        error = fragment->entry->name + " writes depth, and the pipeline has no depth format";
    if (desc.depth != PixelFormat::None && !isDepth(desc.depth)) error = "the depth format is none";
    if (vertex->entry->output("render_target_array_index") && !desc.layered)
        error = vertex->entry->name + " chooses a layer, and inputPrimitiveTopology is not set";
    if (desc.layered && !state_->options.layered) error = "the device has no layered rendering";
    if (!error.empty()) return {};
    return {state_->add(std::make_unique<SoftRenderPipeline>(desc, vertex->entry, fragment->entry))};
}

DepthStencilRef SoftSeam::newDepthStencil(CompareFunction nearer, bool writes) {
    return {state_->add(std::make_unique<SoftDepthStencil>(nearer, writes))};
}

}  // namespace dpl::mtl
