// SPDX-License-Identifier: Apache-2.0
// Draws into textures of an app with command buffers of our own, on the queue that it lends.
#include "sdk/backend/metal/mtl_backend.h"

namespace dpl::mtl {

Result<AppCommands> MetalBackend::beginSubmission(ComposerId id, uint32_t slot, uint32_t viewCount, const AppSubmission& how) {
    const auto it = composers_.find(id.value);
    if (it == composers_.end()) return fail(Code::NotFound, "there is no composer {}", id.value);
    const AppPass& pass = it->second.pass;
    if (pass.depth != PixelFormat::None || pass.stencil != PixelFormat::None)
        return fail(Code::InvalidArgument, "composer {} has a depth or stencil attachment; a submission has none", id.value);
    if (how.textureCount != (pass.layers ? 1 : viewCount))
        return fail(Code::InvalidArgument, "{} textures for {} views and a composer of {} layers", how.textureCount, viewCount,
                    pass.layers);
    for (uint32_t i = 0; i < how.textureCount; ++i) {
        const TextureFacts facts = seam_->factsOf(how.textures[i]);
        const bool array = facts.type == TextureType::Array || facts.type == TextureType::ArraySamples;
        if (facts.format != pass.colour || facts.samples != pass.samples || (pass.layers > 0 && (!array || facts.layers < pass.layers)) ||
            !(facts.usage & kUsageRenderTarget))
            return fail(Code::InvalidArgument, "texture {} does not fit composer {}: MTLPixelFormat {}, {} samples, {} slices, usage {}", i,
                        id.value, uint32_t(facts.format), facts.samples, facts.layers, facts.usage);
    }
    seam_->release(submissions_[slot]);  // of a call that failed
    DPL_TRY(submissions_[slot], newCommands());
    if (how.waitEvent) seam_->encodeWait(submissions_[slot], how.waitEvent, how.waitValue);
    return AppCommands{submissions_[slot].object};
}

Status MetalBackend::submitTo(ComposerId id, uint32_t slot, const AppSubmission& how) {
    const CommandsRef commands = submissions_[slot];
    const AppPass& pass = composers_.at(id.value).pass;
    for (uint32_t i = 0; i < how.textureCount; ++i) {
        RenderPassDesc desc;
        desc.colours[0].texture = how.textures[i];
        desc.colours[0].load = LoadAction::Load;
        desc.layers = pass.layers;
        RenderEncoderRef encoder = seam_->renderEncoder(commands, desc);
        if (!encoder) return fail(Code::Device, "Metal gave no render encoder for texture {}", i);
        const Status composed = compose(id, slot, i, how.place, {encoder.object});
        seam_->end(encoder);
        seam_->release(encoder);
        DPL_RETURN_IF_ERROR(composed);
    }
    markSlot(slot, {commands.object});
    if (how.signalEvent) seam_->encodeSignal(commands, how.signalEvent, how.signalValue);
    if (how.drawable) seam_->present(commands, how.drawable);
    seam_->commit(commands);
    seam_->release(submissions_[slot]);
    return {};
}

}  // namespace dpl::mtl
