// SPDX-License-Identifier: Apache-2.0
// Render passes and draws of the software device.
#include <algorithm>

#include "tests/metal/software/raster.h"
#include "tests/metal/software/seam.h"

namespace dpl::mtl {
namespace {

struct Attached {
    SoftTexture *texture = nullptr, *resolve = nullptr;
    PassAttachment how;
};

SoftTexture* textureOf(TextureRef texture) {
    return static_cast<SoftTexture*>(static_cast<Object*>(texture.object));
}

/** The attachments of a pass that was checked. */
std::vector<Attached> attachmentsOf(const RenderPassDesc& pass) {
    std::vector<Attached> list;
    for (const PassAttachment* a : {&pass.colours[0], &pass.colours[1], &pass.depth})
        if (a->texture) list.push_back({textureOf(a->texture), textureOf(a->resolve), *a});
    return list;
}

}  // namespace

bool SoftSeam::checkAttachment(const PassAttachment& a, const RenderPassDesc& desc, bool depth) {
    auto* t = state_->get<SoftTexture>(a.texture.object, "renderCommandEncoderWithDescriptor");
    if (!t) return false;
    const auto wrong = [&](const std::string& text) {
        state_->fault("renderCommandEncoderWithDescriptor: " + t->name() + " " + text);
        return false;
    };
    const uint32_t layers = std::max(desc.layers, 1u);
    if (!(t->desc.usage & kUsageRenderTarget)) return wrong("is an attachment, and its usage has no MTLTextureUsageRenderTarget");
    if (isDepth(t->desc.format) != depth) return wrong("has a format of another kind of attachment");
    if (a.slice + layers > t->desc.layers) return wrong("has no slice " + std::to_string(a.slice + layers - 1));
    const bool memoryless = t->desc.storage == StorageMode::Memoryless;
    if (memoryless && a.load == LoadAction::Load) return wrong("is memoryless and cannot be loaded");
    if (memoryless && a.store == StoreAction::Store) return wrong("is memoryless and cannot be stored");
    if (a.store != StoreAction::Resolve) return true;
    auto* r = state_->get<SoftTexture>(a.resolve.object, "resolveTexture");
    if (!r) return false;
    if (t->desc.samples == 1 || r->desc.samples != 1 || r->desc.format != t->desc.format || r->desc.widthPx != t->desc.widthPx ||
        r->desc.heightPx != t->desc.heightPx || !(r->desc.usage & kUsageRenderTarget) || a.resolveSlice + layers > r->desc.layers)
        return wrong("cannot be resolved into " + r->name());
    return true;
}

RenderEncoderRef SoftSeam::renderEncoder(CommandsRef commands, const RenderPassDesc& desc) {
    uint32_t widthPx = 0, heightPx = 0, samples = 0;
    for (const PassAttachment* a : {&desc.colours[0], &desc.colours[1], &desc.depth}) {
        if (!a->texture) continue;
        if (!checkAttachment(*a, desc, a == &desc.depth)) return {};
        const TextureDesc& t = textureOf(a->texture)->desc;
        if (widthPx != 0 && (t.widthPx != widthPx || t.heightPx != heightPx || t.samples != samples)) {
            state_->fault("renderCommandEncoderWithDescriptor: attachments differ in size or samples");
            return {};
        }
        widthPx = t.widthPx, heightPx = t.heightPx, samples = t.samples;
    }
    if (widthPx == 0) {
        state_->fault("renderCommandEncoderWithDescriptor: there is no attachment");
        return {};
    }
    if (desc.layers > 0 && !state_->options.layered) {
        state_->fault("renderCommandEncoderWithDescriptor: the device has no layered rendering");
        return {};
    }
    SoftEncoder* e = newEncoder(commands, EncoderKind::Render);
    if (!e) return {};
    e->pass = desc;
    e->view[2] = widthPx, e->view[3] = heightPx;
    beginPass(*e->commands, *e);
    return {e};
}

void SoftSeam::beginPass(SoftCommands& c, SoftEncoder& e) {
    for (const Attached& a : attachmentsOf(e.pass)) {
        state_->pin(c, a.texture);
        if (a.resolve) state_->pin(c, a.resolve);
    }
    c.work.push_back([pass = e.pass] {
        for (const Attached& a : attachmentsOf(pass))
            for (uint32_t layer = 0; layer < std::max(pass.layers, 1u); ++layer) {
                const double* clear = a.how.clear;
                const uint32_t slice = a.how.slice + layer;
                if (a.how.load == LoadAction::Clear) a.texture->pixels.clear(slice, {clear[0], clear[1], clear[2], clear[3]});
                if (a.how.load == LoadAction::DontCare) a.texture->pixels.spoil(slice);
            }
        return true;
    });
}

void SoftSeam::endPass(SoftCommands& c, SoftEncoder& e) {
    c.work.push_back([this, commands = &c, pass = e.pass, running = e.running] {
        const uint32_t layers = std::max(pass.layers, 1u);
        for (const Attached& a : attachmentsOf(pass)) {
            // The pass as a whole: its fence waits are encoded by now.
            state_->use(a.texture, a.how.slice, a.how.slice + layers, true, *commands, *running, 1, "a render pass");
            if (a.resolve)
                state_->use(a.resolve, a.how.resolveSlice, a.how.resolveSlice + layers, true, *commands, *running, 1, "a resolve");
            for (uint32_t layer = 0; layer < layers; ++layer) {
                if (a.how.store == StoreAction::Resolve)
                    a.texture->pixels.resolve(a.how.slice + layer, a.resolve->pixels, a.how.resolveSlice + layer);
                if (a.how.store != StoreAction::Store) a.texture->pixels.spoil(a.how.slice + layer);
            }
        }
        return true;
    });
}

void SoftSeam::setPipeline(RenderEncoderRef encoder, RenderPipelineRef pipeline) {
    SoftEncoder* e = openEncoder(encoder.object, "setRenderPipelineState");
    auto* p = state_->get<SoftRenderPipeline>(pipeline.object, "setRenderPipelineState");
    if (!e || !p) return;
    e->render = p;
    state_->pin(*e->commands, p);
}

void SoftSeam::setViewport(RenderEncoderRef encoder, double x, double y, double widthPx, double heightPx) {
    SoftEncoder* e = openEncoder(encoder.object, "setViewport");
    if (!e) return;
    if (!(widthPx > 0 && heightPx > 0)) return fault(*e, "the viewport is empty");
    const double view[4] = {x, y, widthPx, heightPx};
    std::copy_n(view, 4, e->view);
}

void SoftSeam::setDepthStencil(RenderEncoderRef encoder, DepthStencilRef state) {
    SoftEncoder* e = openEncoder(encoder.object, "setDepthStencilState");
    auto* s = state_->get<SoftDepthStencil>(state.object, "setDepthStencilState");
    if (!e || !s) return;
    e->depthState = s;
    state_->pin(*e->commands, s);
}

/** Whether the pipeline fits the pass. */
bool SoftSeam::fits(const SoftEncoder& e) {
    const RenderPipelineDesc& p = e.render->desc;
    const auto formatOf = [](const PassAttachment& a) { return a.texture ? textureOf(a.texture)->desc.format : PixelFormat::None; };
    std::string wrong;
    for (size_t i = 0; i < 2; ++i)
        if (p.colours[i].format != formatOf(e.pass.colours[i]))
            wrong = "color(" + std::to_string(i) + ") has MTLPixelFormat " + std::to_string(uint32_t(formatOf(e.pass.colours[i]))) +
                    ", and the pipeline was made for " + std::to_string(uint32_t(p.colours[i].format));
    if (p.depth != formatOf(e.pass.depth)) wrong = "the depth attachment has another format than the pipeline was made for";
    for (const Attached& a : attachmentsOf(e.pass))
        if (a.texture->desc.samples != p.samples)
            wrong = a.texture->name() + " has " + std::to_string(a.texture->desc.samples) + " samples, and the pipeline was made for " +
                    std::to_string(p.samples);
    if (e.pass.layers > 0 && !p.layered) wrong = "the pass has layers, and the pipeline sets no inputPrimitiveTopology";
    if (wrong.empty()) return true;
    fault(e, e.render->name() + ": " + wrong);
    return false;
}

void SoftSeam::draw(RenderEncoderRef encoder, PrimitiveType type, uint32_t vertices, uint32_t instances) {
    encodeDraw(encoder.object, type, vertices, instances, nullptr, 0);
}

void SoftSeam::drawIndirect(RenderEncoderRef encoder, PrimitiveType type, BufferRef args, uint64_t offset) {
    if (SoftBuffer* buffer = argsAt(args, offset, 16, "drawPrimitives:indirectBuffer"))
        encodeDraw(encoder.object, type, 0, 0, buffer, offset);
}

void SoftSeam::encodeDraw(void* encoder, PrimitiveType type, uint32_t vertices, uint32_t instances, SoftBuffer* args, uint64_t offset) {
    SoftEncoder* e = openEncoder(encoder, "drawPrimitives");
    if (!e) return;
    if (!e->render) return fault(*e, "a draw without a pipeline");
    if (!args && (vertices == 0 || instances == 0)) return fault(*e, "a draw of no vertices or no instances");
    const msl::Entry &vertex = *e->render->vertex, &fragment = *e->render->fragment;
    const auto forVertex = std::make_shared<Ready>(ready(*e, 0, vertex));
    const auto forFragment = std::make_shared<Ready>(ready(*e, 1, fragment));
    if (!fits(*e) || !forVertex->fine || !forFragment->fine || state_->options.work == SoftwareWork::NoShaders) return;
    Draw d;
    d.vertex = &vertex, d.fragment = &fragment;
    d.vertexBindings = forVertex->bindings, d.fragmentBindings = forFragment->bindings;
    d.type = type, d.vertices = vertices, d.instances = instances;
    d.viewX = e->view[0], d.viewY = e->view[1], d.viewWidthPx = e->view[2], d.viewHeightPx = e->view[3];
    d.layers = e->pass.layers, d.samples = e->render->desc.samples;
    for (size_t i = 0; i < 2; ++i)
        if (e->pass.colours[i].texture)
            d.colours[i] = {&textureOf(e->pass.colours[i].texture)->pixels, e->pass.colours[i].slice, e->render->desc.colours[i]};
    if (e->pass.depth.texture) {
        d.depth = &textureOf(e->pass.depth.texture)->pixels;
        d.depthSlice = e->pass.depth.slice;
        if (e->depthState) d.nearer = e->depthState->nearer, d.writesDepth = e->depthState->writes;
    }
    SoftCommands* c = e->commands;
    if (args) state_->pin(*c, args);
    c->work.push_back([this, c, d, args, offset, forVertex, forFragment, running = e->running, what = e->place()]() mutable {
        if (args) state_->use(args, offset, offset + 16, false, *c, *running, 0, what);
        for (int stage = 0; stage < 2; ++stage)
            for (const Ready::Use& use : (stage == 0 ? forVertex : forFragment)->uses)
                state_->use(use.resource, use.begin, use.end, use.writes, *c, *running, stage, what);
        if (args) {
            uint32_t list[4];  // MTLDrawPrimitivesIndirectArguments
            std::memcpy(list, args->memory.get() + offset, sizeof list);
            d.vertices = list[0], d.instances = list[1], d.firstVertex = list[2], d.firstInstance = list[3];
            if (uint64_t(d.vertices) * d.instances > 1u << 26) {
                state_->fault(what + ": draws " + std::to_string(d.vertices) + " vertices " + std::to_string(d.instances) +
                              " times; were its arguments written?");
                return true;
            }
        }
        mtl::draw(d, state_->faults);
        return true;
    });
}

}  // namespace dpl::mtl
