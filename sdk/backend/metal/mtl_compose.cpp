// SPDX-License-Identifier: Apache-2.0
// Composes pictures into the passes of an app that lends its device.
#include "sdk/backend/metal/mtl_backend.h"

namespace dpl::mtl {
namespace {

/** How a format of a target stores light. */
struct TargetFormat {
    PixelFormat format;
    bool linear;  // blends linear light; else display-referred values
};
constexpr TargetFormat kTargetFormats[] = {
    {PixelFormat::RGBA8Unorm, false},    {PixelFormat::BGRA8Unorm, false}, {PixelFormat::RGBA8UnormSrgb, true},
    {PixelFormat::BGRA8UnormSrgb, true}, {PixelFormat::RGBA16Float, true}, {PixelFormat::RGB10A2Unorm, false},
};

// Indices of compose.depth. compose.frag has the first texture and buffers.
enum : uint32_t { kDrawn, kTiled, kCounts, kSums, kMesh };

bool isArray(TextureType type) {
    return type == TextureType::Array || type == TextureType::ArraySamples;
}
bool isFlat(TextureType type) {
    return type == TextureType::Flat || type == TextureType::FlatSamples;
}
bool hasDepth(PixelFormat format) {
    return format == PixelFormat::Depth16Unorm || format == PixelFormat::Depth32Float || format == PixelFormat::Depth24UnormStencil8 ||
           format == PixelFormat::Depth32FloatStencil8;
}

}  // namespace

/** Makes what all composers share. */
Status MetalBackend::makeComposing() {
    marks_ = seam_->newSharedEvent();
    if (!marks_) return fail(Code::Device, "{} makes no shared event", info_.name);
    DPL_TRY(readScene_[0][0], computePipeline("scene.read"));
    DPL_TRY(readScene_[0][1], computePipeline("scene.read.four"));
    DPL_TRY(readScene_[1][0], computePipeline("scene.read.flat"));
    DPL_TRY(readScene_[1][1], computePipeline("scene.read.flat.four"));
    keepDepth_ = seam_->newDepthStencil(CompareFunction::Always, false);
    nearer_[0] = seam_->newDepthStencil(CompareFunction::Less, true);
    nearer_[1] = seam_->newDepthStencil(CompareFunction::Greater, true);
    if (!keepDepth_ || !nearer_[0] || !nearer_[1]) return fail(Code::Device, "{} makes no depth stencil state", info_.name);
    return {};
}

Status MetalBackend::checkScene(uint32_t view, const SceneTexture& from) const {
    const TextureFacts facts = seam_->factsOf(from.texture);
    if (!hasDepth(facts.format))
        return fail(Code::InvalidArgument, "depth {} has a texture of MTLPixelFormat {}, which holds no depth that can be read", view,
                    uint32_t(facts.format));
    if (!(facts.usage & kUsageShaderRead) || facts.storage == StorageMode::Memoryless)
        return fail(Code::InvalidArgument,
                    "the texture of depth {} cannot be read; give it MTLTextureUsageShaderRead and another storage mode than memoryless",
                    view);
    if ((!isArray(facts.type) && !isFlat(facts.type)) || (facts.samples != 1 && facts.samples != 4) || from.slice >= facts.layers)
        return fail(Code::InvalidArgument,
                    "the texture of depth {} has MTLTextureType {}, {} samples and {} slices, of which slice {} is wanted; 2D textures and "
                    "arrays of them with 1 or 4 samples are possible",
                    view, uint32_t(facts.type), facts.samples, facts.layers, from.slice);
    return {};
}

Status MetalBackend::readScene(uint32_t, uint32_t, uint32_t viewOfFrame, uint32_t widthPx, uint32_t heightPx, const SceneTexture& from,
                               BufferId scene, AppCommands commands) {
    const TextureFacts facts = seam_->factsOf(from.texture);
    Recorder recorder(*this, {commands.handle});
    DPL_TRY(const ComputeEncoderRef encoder, recorder.compute());
    const Pipeline& pipeline = at(readScene_[isFlat(facts.type)][facts.samples == 4]);
    const gpu::ScenePush push{widthPx,    heightPx,   viewOfFrame * widthPx * heightPx, from.slice, float(from.x), float(from.y),
                              from.scale, from.offset};
    seam_->setPipeline(encoder, pipeline.compute);
    seam_->setTexture(encoder, from.texture, 0);
    seam_->setBuffer(encoder, buffers_.at(scene.value).buffer, 0, 1);
    seam_->setBytes(encoder, &push, sizeof push, kPushIndex);
    seam_->dispatch(encoder, {(widthPx + gpu::kSceneGroup - 1) / gpu::kSceneGroup, heightPx}, {pipeline.shader->workgroup[0]});
    return {};
}

/** Whether the pass blends light, rather than display-referred values. Unsupported: Doppel cannot draw in it. */
Result<bool> MetalBackend::blendsLight(const AppPass& pass) const {
    if (!lent_) return fail(Code::Unsupported, "only a context on the app's own Metal device composes into its passes");
    const auto* known =
        std::find_if(std::begin(kTargetFormats), std::end(kTargetFormats), [&](auto& f) { return f.format == pass.colour; });
    if (known == std::end(kTargetFormats))
        return fail(Code::Unsupported,
                    "targets of MTLPixelFormat {} are not possible; use RGBA8Unorm, BGRA8Unorm, both also with _sRGB, RGBA16Float or "
                    "RGB10A2Unorm",
                    uint32_t(pass.colour));
    if (pass.samples != 1 && (pass.samples != 4 || !info_.fourSamples))
        return fail(Code::Unsupported, "a pass of {} samples a pixel is not possible; 1 and 4 are", pass.samples);
    if (pass.layers > 0 && !info_.multiview)
        return fail(Code::Unsupported, "{} has no layered rendering (MTLGPUFamilyApple5, A12); use a pass for each view", info_.name);
    if (pass.layers > gpu::kMaxViews) return fail(Code::Unsupported, "{} layers are not possible; {} are", pass.layers, gpu::kMaxViews);
    if (pass.written != PictureDepth::None && !hasDepth(pass.depth))
        return fail(Code::Unsupported, "the pass writes depth, but its depthFormat is MTLPixelFormat {}, which holds none",
                    uint32_t(pass.depth));
    return known->linear;
}

Result<ComposerId> MetalBackend::createComposer(const AppPass& pass) {
    Composer composer;
    composer.pass = pass;
    DPL_TRY(composer.linear, blendsLight(pass));
    if (const Status made = makePipelines(composer); !made) {
        seam_->release(composer.pipeline);
        return made.error();
    }
    composers_.emplace(++lastId_, composer);
    return ComposerId{lastId_};
}

Status MetalBackend::makePipelines(Composer& composer) {
    const AppPass& pass = composer.pass;
    const auto shaderOf = [&](const char* name) { return pack_.find(std::string(name) + (pass.layers ? ".multiview" : "")); };
    const Shader *vertex = shaderOf("compose.vert"), *colour = shaderOf("compose.frag"), *depth = shaderOf("compose.depth");
    if (!vertex || !colour || !depth) return fail(Code::Internal, "the shader pack lacks shaders that compose");
    RenderPipelineDesc desc;
    desc.label = "compose";
    desc.colours[0].format = pass.colour;
    desc.colours[0].blends = true;  // premultiplied "over"
    desc.depth = pass.depth, desc.stencil = pass.stencil;
    desc.samples = pass.samples;
    desc.layered = pass.layers > 0;
    DPL_TRY(composer.pipeline, renderPipeline(desc, *vertex, *colour));
    if (pass.written == PictureDepth::None) return {};
    desc.label = "compose depth";
    desc.colours[0].blends = desc.colours[0].writes = false;
    DPL_TRY(composer.depthPipeline, renderPipeline(desc, *vertex, *depth));
    return {};
}

uint32_t MetalBackend::depthsWritten() const {
    uint32_t depths = 0;
    for (const auto& [id, composer] : composers_) depths |= uint32_t(composer.pass.written);
    return depths;
}

Status MetalBackend::destroyComposer(ComposerId id) {
    const auto it = composers_.find(id.value);
    if (it == composers_.end()) return fail(Code::NotFound, "there is no composer {}", id.value);
    retire(it->second.pipeline, 0);  // a slot that was encoded before may be composed with it
    retire(it->second.depthPipeline, 0);
    composers_.erase(it);
    return {};
}

Status MetalBackend::setLayers(uint32_t slot, std::span<const LayerPlace> places) {
    if (slot >= kAppSlots || places.empty() || places.size() > gpu::kMaxViews)
        return fail(Code::InvalidArgument, "slot {} with {} views does not exist", slot, places.size());
    LayerSlot& layers = layerSlots_[slot];
    for (uint32_t v = 0; v < places.size(); ++v) {
        const LayerPlace& place = places[v];
        const Target& target = targets_.at(place.target.value);
        const BufferRef counts = buffers_.at(place.counts.value).buffer;
        const auto orCounts = [&](BufferId id) { return id ? buffers_.at(id.value).buffer : counts; };  // for what is not read
        layers.views[v] = {target.colour,
                           target.depth ? target.depth : target.colour,
                           orCounts(place.tilePixels),
                           counts,
                           orCounts(place.meshDepth),
                           composePush(places, v, target.desc, /*shared=*/true, info_.halfDepth)};
    }
    layers.mesh = places[0].meshDepth.value != 0;
    layers.viewCount = uint32_t(places.size());
    return {};
}

Result<MetalBackend::Composed> MetalBackend::composedOf(ComposerId id, uint32_t slot, uint32_t view) const {
    const auto it = composers_.find(id.value);
    if (it == composers_.end()) return fail(Code::NotFound, "there is no composer {}", id.value);
    if (slot >= kAppSlots || layerSlots_[slot].viewCount == 0) return fail(Code::InvalidArgument, "slot {} was not prepared", slot);
    const uint32_t layers = it->second.pass.layers, prepared = layerSlots_[slot].viewCount;
    const Composed composed{it->second, layerSlots_[slot], layers ? 0 : view, layers ? layers : 1};
    if (composed.viewCount > prepared || composed.firstView > prepared - composed.viewCount)
        return fail(Code::InvalidArgument, "{} views are wanted, but slot {} was prepared with {}",
                    uint64_t(composed.firstView) + composed.viewCount, slot, prepared);
    return composed;
}

/** The fence of the next compose of a frame. Made when a frame composes more often than those before. */
Result<FenceRef> MetalBackend::nextFence() {
    if (composes_ == composed_.size()) {
        const FenceRef made = seam_->newFence();
        if (!made) return fail(Code::Device, "{} makes no fence", info_.name);
        composed_.push_back(made);
    }
    return composed_[composes_++];
}

Status MetalBackend::compose(ComposerId id, uint32_t slot, uint32_t view, int32_t x, int32_t y, RenderEncoderRef encoder) {
    DPL_TRY(const Composed composed, composedOf(id, slot, view));
    gpu::ComposePush push{};
    push.linear = composed.composer.linear ? 1 : 0;
    return drawPicture(composed, composed.composer.pipeline, keepDepth_, x, y, push, encoder);
}

Status MetalBackend::composeDepth(ComposerId id, uint32_t slot, uint32_t view, int32_t x, int32_t y, float scale, float offset,
                                  RenderEncoderRef encoder) {
    DPL_TRY(const Composed composed, composedOf(id, slot, view));
    const PictureDepth written = composed.composer.pass.written;
    DPL_RETURN_IF_ERROR(checkDepth(id, written, slot, composed.layers.depths, "DplMetalPass"));
    const bool mesh = written == PictureDepth::Mesh;
    if (mesh && !composed.layers.mesh) return {};
    gpu::ComposePush push{};
    push.mesh = mesh ? 1 : 0;
    push.scale = scale, push.offset = offset;
    return drawPicture(composed, composed.composer.depthPipeline, nearer_[offset > 0], x, y, push, encoder);
}

/** more: what depends on the pipeline. */
Status MetalBackend::drawPicture(const Composed& composed, RenderPipelineRef pipeline, DepthStencilRef state, int32_t x, int32_t y,
                                 const gpu::ComposePush& more, RenderEncoderRef encoder) {
    DPL_TRY(const FenceRef fence, nextFence());
    const bool depth = pipeline == composed.composer.depthPipeline;
    const gpu::ComposePush& any = composed.layers.views[0].push;
    seam_->waitFence(encoder, written_, kStageFragment);
    seam_->setPipeline(encoder, pipeline);
    seam_->setDepthStencil(encoder, state);
    seam_->setCullNone(encoder);
    seam_->setFill(encoder);
    seam_->setNoDepthBias(encoder);
    seam_->setOneAmplification(encoder);
    seam_->setViewport(encoder, x, y, any.widthPx, any.heightPx);  // clips the triangle to the picture
    const uint32_t viewMask[2] = {0, composed.viewCount};
    if (composed.composer.pass.layers) {
        seam_->setVertexBytes(encoder, viewMask, sizeof viewMask, kViewMaskIndex);
        seam_->setFragmentBytes(encoder, viewMask, sizeof viewMask, kViewMaskIndex);
    }
    uint32_t done = 0;
    for (uint32_t view = composed.firstView; view < composed.firstView + composed.viewCount; ++view) {
        if (done >> view & 1) continue;
        const LayerSlot::View& from = composed.layers.views[view];
        gpu::ComposePush push = from.push;
        done |= push.views;
        push.placeX = float(x), push.placeY = float(y);
        push.view = view;
        push.linear = more.linear, push.mesh = more.mesh, push.scale = more.scale, push.offset = more.offset;
        seam_->setFragmentTexture(encoder, from.drawn, kDrawn);
        seam_->setFragmentBuffer(encoder, from.tiled, 0, kTiled);
        seam_->setFragmentBuffer(encoder, from.counts, 0, kCounts);
        if (depth) {
            seam_->setFragmentTexture(encoder, from.sums, kSums);
            seam_->setFragmentBuffer(encoder, from.mesh, 0, kMesh);
        }
        seam_->setFragmentBytes(encoder, &push, sizeof push, kPushIndex);
        seam_->draw(encoder, PrimitiveType::Triangle, 3, composed.viewCount);
    }
    seam_->updateFence(encoder, fence, kStageFragment);
    return {};
}

}  // namespace dpl::mtl
