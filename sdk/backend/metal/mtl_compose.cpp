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
enum : uint32_t { kDrawn, kTiled, kSums, kMesh };

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

/** A texture and a buffer for what compose binds and does not read. */
Result<MetalBackend::Unread> MetalBackend::makeUnread() {
    Unread made;
    DPL_TRY(made.target, createTarget({.widthPx = 1, .heightPx = 1, .multiview = info_.multiview, .sampled = true}));
    DPL_TRY(made.buffer, createBuffer({"unread", 16}));
    return made;
}

/** Makes what all composers share. */
Status MetalBackend::makeComposing() {
    marks_ = seam_->newSharedEvent();
    if (!marks_) return fail(Code::Device, "{} makes no shared event", info_.name);
    DPL_TRY(unread_, makeUnread());
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
    if ((!isArray(facts.type) && !isFlat(facts.type)) || (facts.samples != 1 && facts.samples != 4) || from.place.layer >= facts.layers)
        return fail(Code::InvalidArgument,
                    "the texture of depth {} has MTLTextureType {}, {} samples and {} slices, of which slice {} is wanted; 2D textures and "
                    "arrays of them with 1 or 4 samples are possible",
                    view, uint32_t(facts.type), facts.samples, facts.layers, from.place.layer);
    return {};
}

Status MetalBackend::readScene(const SceneRead& read, const SceneTexture& from) {
    const TextureFacts facts = seam_->factsOf(from.texture);
    Recorder recorder(*this, {read.commands.handle});
    DPL_TRY(const ComputeEncoderRef encoder, recorder.compute());
    const Pipeline& pipeline = at(readScene_[isFlat(facts.type)][facts.samples == 4]);
    const gpu::ScenePush push = scenePush(read, from.place);
    seam_->setPipeline(encoder, pipeline.compute);
    seam_->setTexture(encoder, from.texture, 0);
    seam_->setBuffer(encoder, buffers_.at(read.scene.value).buffer, 0, 1);
    seam_->setBytes(encoder, &push, sizeof push, kPushIndex);
    seam_->dispatch(encoder, {(read.widthPx + gpu::kSceneGroup - 1) / gpu::kSceneGroup, read.heightPx}, {pipeline.shader->workgroup[0]});
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
    DPL_TRY(const bool linear, blendsLight(pass));
    Composer composer;
    composer.pass = pass;
    if (const Status made = makePipelines(composer); !made) {
        seam_->release(composer.pipeline);
        return made.error();
    }
    const ComposerId id = addComposer({linear, pass.layers, pass.written});
    composers_.emplace(id.value, composer);
    return id;
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

void MetalBackend::retireComposer(ComposerId id) {
    const auto it = composers_.find(id.value);
    retire(it->second.pipeline, 0);  // a slot that was encoded before may be composed with it
    retire(it->second.depthPipeline, 0);
    composers_.erase(it);
}

void MetalBackend::setLayer(uint32_t slot, uint32_t view, const LayerPlace& place) {
    const Target& target = targets_.at((place.target ? place.target : unread_.target).value);
    const auto bound = [&](BufferId id) { return buffers_.at((id ? id : unread_.buffer).value).buffer; };
    layers_[slot][view] = {target.colour, target.depth ? target.depth : target.colour, bound(place.tilePixels), bound(place.meshDepth)};
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

Status MetalBackend::drawPicture(const PictureDraw& what, PassCommands pass) {
    DPL_TRY(const FenceRef fence, nextFence());
    const RenderEncoderRef encoder{pass.handle};
    const Composer& composer = composers_.at(what.composer.value);
    const gpu::ComposePush& any = what.push[0];
    seam_->waitFence(encoder, written_, kStageFragment);
    seam_->setPipeline(encoder, what.depth ? composer.depthPipeline : composer.pipeline);
    seam_->setDepthStencil(encoder, what.depth ? nearer_[what.greaterIsNearer] : keepDepth_);
    seam_->setCullNone(encoder);
    seam_->setFill(encoder);
    seam_->setNoDepthBias(encoder);
    seam_->setOneAmplification(encoder);
    seam_->setViewport(encoder, what.place.x, what.place.y, any.widthPx, any.heightPx);  // clips the triangle to the picture
    const uint32_t viewMask[2] = {0, what.layers};
    if (what.layers) {
        seam_->setVertexBytes(encoder, viewMask, sizeof viewMask, kViewMaskIndex);
        seam_->setFragmentBytes(encoder, viewMask, sizeof viewMask, kViewMaskIndex);
    }
    for (uint32_t i = 0; i < what.draws; ++i) {
        const gpu::ComposePush& push = what.push[i];
        const Layer& from = layers_[what.slot][push.view];
        seam_->setFragmentTexture(encoder, from.drawn, kDrawn);
        seam_->setFragmentBuffer(encoder, from.tiled, 0, kTiled);
        if (what.depth) {
            seam_->setFragmentTexture(encoder, from.sums, kSums);
            seam_->setFragmentBuffer(encoder, from.mesh, 0, kMesh);
        }
        seam_->setFragmentBytes(encoder, &push, sizeof push, kPushIndex);
        seam_->draw(encoder, PrimitiveType::Triangle, 3, std::max(what.layers, 1u));
    }
    seam_->updateFence(encoder, fence, kStageFragment);
    return {};
}

}  // namespace dpl::mtl
