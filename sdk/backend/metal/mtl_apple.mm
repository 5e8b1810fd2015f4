// SPDX-License-Identifier: Apache-2.0
// Apple's body of the seam, under ARC. Each function is one call; what it means is in mtl_seam.h and in Apple's documentation.
// It has been type-checked against declarations of ours (tests/metal/apple_stubs), and neither compiled by Apple's compiler nor run.
#import <Foundation/Foundation.h>
#import <Metal/Metal.h>
#include <TargetConditionals.h>

#include "sdk/backend/metal/mtl_seam.h"

#if !__has_feature(objc_arc)
#error "compile this file with -fobjc-arc"
#endif

namespace dpl::mtl {
namespace {

// From handles to objects and back. A bridge cast neither retains nor releases; __bridge_retained gives a handle that is owned.
id<MTLBuffer> objectOf(BufferRef ref) {
    return (__bridge id<MTLBuffer>)ref.object;
}
id<MTLTexture> objectOf(TextureRef ref) {
    return (__bridge id<MTLTexture>)ref.object;
}
id<MTLLibrary> objectOf(LibraryRef ref) {
    return (__bridge id<MTLLibrary>)ref.object;
}
id<MTLFunction> objectOf(FunctionRef ref) {
    return (__bridge id<MTLFunction>)ref.object;
}
id<MTLComputePipelineState> objectOf(ComputePipelineRef ref) {
    return (__bridge id<MTLComputePipelineState>)ref.object;
}
id<MTLRenderPipelineState> objectOf(RenderPipelineRef ref) {
    return (__bridge id<MTLRenderPipelineState>)ref.object;
}
id<MTLDepthStencilState> objectOf(DepthStencilRef ref) {
    return (__bridge id<MTLDepthStencilState>)ref.object;
}
id<MTLFence> objectOf(FenceRef ref) {
    return (__bridge id<MTLFence>)ref.object;
}
id<MTLSharedEvent> objectOf(EventRef ref) {
    return (__bridge id<MTLSharedEvent>)ref.object;
}
NSString* objectOf(LabelRef ref) {
    return (__bridge NSString*)ref.object;
}
id<MTLCommandBuffer> objectOf(CommandsRef ref) {
    return (__bridge id<MTLCommandBuffer>)ref.object;
}
id<MTLComputeCommandEncoder> objectOf(ComputeEncoderRef ref) {
    return (__bridge id<MTLComputeCommandEncoder>)ref.object;
}
id<MTLBlitCommandEncoder> objectOf(BlitEncoderRef ref) {
    return (__bridge id<MTLBlitCommandEncoder>)ref.object;
}
id<MTLRenderCommandEncoder> objectOf(RenderEncoderRef ref) {
    return (__bridge id<MTLRenderCommandEncoder>)ref.object;
}
id<MTLDrawable> objectOf(DrawableRef ref) {
    return (__bridge id<MTLDrawable>)ref.object;
}

template <class Handle>
Handle owned(id object) {
    return {(__bridge_retained void*)object};
}

NSString* textOf(std::string_view text) {
    return [[NSString alloc] initWithBytes:text.data() length:text.size() encoding:NSUTF8StringEncoding];
}
std::string textOf(NSString* text) {
    return text ? std::string(text.UTF8String) : std::string();
}
MTLSize sizeOf(Size size) {
    return MTLSizeMake(size.x, size.y, size.z);
}

void describe(MTLRenderPipelineColorAttachmentDescriptor* to, const PipelineColour& from) {
    to.pixelFormat = MTLPixelFormat(from.format);
    to.writeMask = from.writes ? MTLColorWriteMaskAll : MTLColorWriteMaskNone;
    to.blendingEnabled = from.blends;
    to.rgbBlendOperation = to.alphaBlendOperation = MTLBlendOperationAdd;
    to.sourceRGBBlendFactor = MTLBlendFactorOne;
    to.destinationRGBBlendFactor = MTLBlendFactor(from.rgbTo);
    to.sourceAlphaBlendFactor = MTLBlendFactor(from.alphaFrom);
    to.destinationAlphaBlendFactor = MTLBlendFactor(from.alphaTo);
}

void describe(MTLRenderPassAttachmentDescriptor* to, const PassAttachment& from) {
    to.texture = objectOf(from.texture);
    to.slice = from.slice;
    to.resolveTexture = objectOf(from.resolve);
    to.resolveSlice = from.resolveSlice;
    to.loadAction = MTLLoadAction(from.load);
    to.storeAction = MTLStoreAction(from.store);
}

class AppleSeam final : public Seam {
public:
    AppleSeam(id<MTLDevice> device, id<MTLCommandQueue> queue) : device_(device), queue_(queue) {}

    std::string name() const override { return textOf(device_.name); }
    std::string systemVersion() const override { return textOf(NSProcessInfo.processInfo.operatingSystemVersionString); }
    bool isSoftware() const override { return false; }
    bool isMacText() const override { return TARGET_OS_OSX; }
    bool supportsFamily(GpuFamily family) const override { return [device_ supportsFamily:MTLGPUFamily(family)]; }
    bool supportsSampleCount(uint32_t samples) const override { return [device_ supportsTextureSampleCount:samples]; }
    bool supports32BitMsaa() const override { return device_.supports32BitMSAA; }
    bool hasUnifiedMemory() const override { return device_.hasUnifiedMemory; }
    uint64_t maxBufferBytes() const override { return device_.maxBufferLength; }
    uint64_t workingSetBytes() const override { return device_.recommendedMaxWorkingSetSize; }

    using Seam::release;
    void release(void* object) override {
        if (object) (void)(__bridge_transfer id)object;
    }
    void retain(void* object) override { (void)(__bridge_retained void*)(__bridge id)object; }

    BufferRef newBuffer(uint64_t bytes, StorageMode storage, std::string_view label) override {
        const MTLResourceOptions mode = storage == StorageMode::Shared ? MTLResourceStorageModeShared : MTLResourceStorageModePrivate;
        id<MTLBuffer> made = [device_ newBufferWithLength:bytes options:mode | MTLResourceHazardTrackingModeUntracked];
        made.label = textOf(label);
        return owned<BufferRef>(made);
    }
    std::byte* contents(BufferRef buffer) override { return static_cast<std::byte*>(objectOf(buffer).contents); }
    uint64_t allocatedBytes(BufferRef buffer) override { return objectOf(buffer).allocatedSize; }
    TextureRef newTexture(const TextureDesc& desc, std::string_view label) override {
        MTLTextureDescriptor* how = [[MTLTextureDescriptor alloc] init];
        how.textureType = MTLTextureType(desc.type);
        how.pixelFormat = MTLPixelFormat(desc.format);
        how.width = desc.widthPx;
        how.height = desc.heightPx;
        how.arrayLength = desc.layers;
        how.sampleCount = desc.samples;
        how.storageMode = MTLStorageMode(desc.storage);
        how.usage = desc.usage;
        how.hazardTrackingMode = desc.tracked ? MTLHazardTrackingModeTracked : MTLHazardTrackingModeUntracked;
        id<MTLTexture> made = [device_ newTextureWithDescriptor:how];
        made.label = textOf(label);
        return owned<TextureRef>(made);
    }
    uint64_t allocatedBytes(TextureRef texture) override { return objectOf(texture).allocatedSize; }
    TextureFacts factsOf(TextureRef texture) override {
        id<MTLTexture> t = objectOf(texture);
        TextureFacts facts;
        facts.type = TextureType(t.textureType);
        facts.format = PixelFormat(t.pixelFormat);
        facts.widthPx = uint32_t(t.width);
        facts.heightPx = uint32_t(t.height);
        facts.layers = uint32_t(t.arrayLength);
        facts.samples = uint32_t(t.sampleCount);
        facts.storage = StorageMode(t.storageMode);
        facts.usage = uint32_t(t.usage);
        return facts;
    }
    FenceRef newFence() override { return owned<FenceRef>([device_ newFence]); }
    EventRef newSharedEvent() override { return owned<EventRef>([device_ newSharedEvent]); }
    uint64_t signaledValue(EventRef event) override { return objectOf(event).signaledValue; }
    LabelRef newLabel(std::string_view text) override { return owned<LabelRef>(textOf(text)); }

    LibraryRef newLibrary(std::string_view msl, std::string& error) override {
        MTLCompileOptions* options = [[MTLCompileOptions alloc] init];
        options.languageVersion = MTLLanguageVersion2_3;
        options.fastMathEnabled = NO;
        NSError* why = nil;
        id<MTLLibrary> made = [device_ newLibraryWithSource:textOf(msl) options:options error:&why];
        if (!made) error = textOf(why.localizedDescription);
        return owned<LibraryRef>(made);
    }
    FunctionRef newFunction(LibraryRef library, std::string_view name) override {
        return owned<FunctionRef>([objectOf(library) newFunctionWithName:textOf(name)]);
    }
    ComputePipelineRef newComputePipeline(FunctionRef function, std::string& error) override {
        NSError* why = nil;
        id<MTLComputePipelineState> made = [device_ newComputePipelineStateWithFunction:objectOf(function) error:&why];
        if (!made) error = textOf(why.localizedDescription);
        return owned<ComputePipelineRef>(made);
    }
    uint32_t maxThreads(ComputePipelineRef pipeline) override { return uint32_t(objectOf(pipeline).maxTotalThreadsPerThreadgroup); }
    RenderPipelineRef newRenderPipeline(const RenderPipelineDesc& desc, std::string& error) override {
        MTLRenderPipelineDescriptor* how = [[MTLRenderPipelineDescriptor alloc] init];
        how.label = textOf(desc.label);
        how.vertexFunction = objectOf(desc.vertex);
        how.fragmentFunction = objectOf(desc.fragment);
        for (NSUInteger i = 0; i < 2; ++i) describe(how.colorAttachments[i], desc.colours[i]);
        how.depthAttachmentPixelFormat = MTLPixelFormat(desc.depth);
        how.stencilAttachmentPixelFormat = MTLPixelFormat(desc.stencil);
        how.rasterSampleCount = desc.samples;
        how.inputPrimitiveTopology = desc.layered ? MTLPrimitiveTopologyClassTriangle : MTLPrimitiveTopologyClassUnspecified;
        NSError* why = nil;
        id<MTLRenderPipelineState> made = [device_ newRenderPipelineStateWithDescriptor:how error:&why];
        if (!made) error = textOf(why.localizedDescription);
        return owned<RenderPipelineRef>(made);
    }
    DepthStencilRef newDepthStencil(CompareFunction nearer, bool writes) override {
        MTLDepthStencilDescriptor* how = [[MTLDepthStencilDescriptor alloc] init];
        how.depthCompareFunction = MTLCompareFunction(nearer);
        how.depthWriteEnabled = writes;
        return owned<DepthStencilRef>([device_ newDepthStencilStateWithDescriptor:how]);
    }

    // These objects are autoreleased by Metal; the pools end that at once, whichever thread calls.
    CommandsRef commandBuffer() override {
        @autoreleasepool {
            return owned<CommandsRef>([queue_ commandBufferWithUnretainedReferences]);
        }
    }
    void commit(CommandsRef commands) override { [objectOf(commands) commit]; }
    void wait(CommandsRef commands) override { [objectOf(commands) waitUntilCompleted]; }
    CommandStatus status(CommandsRef commands) override { return CommandStatus(objectOf(commands).status); }
    CommandError error(CommandsRef commands, std::string& text) override {
        NSError* why = objectOf(commands).error;
        if (!why) return CommandError::None;
        text = textOf(why.localizedDescription);
        return [why.domain isEqualToString:MTLCommandBufferErrorDomain] ? CommandError(why.code) : CommandError::Internal;
    }
    double gpuStartS(CommandsRef commands) override { return objectOf(commands).GPUStartTime; }
    double gpuEndS(CommandsRef commands) override { return objectOf(commands).GPUEndTime; }
    void encodeWait(CommandsRef commands, EventRef event, uint64_t value) override {
        [objectOf(commands) encodeWaitForEvent:objectOf(event) value:value];
    }
    void encodeSignal(CommandsRef commands, EventRef event, uint64_t value) override {
        [objectOf(commands) encodeSignalEvent:objectOf(event) value:value];
    }
    void present(CommandsRef commands, DrawableRef drawable) override { [objectOf(commands) presentDrawable:objectOf(drawable)]; }

    ComputeEncoderRef computeEncoder(CommandsRef commands) override {
        @autoreleasepool {
            return owned<ComputeEncoderRef>([objectOf(commands) computeCommandEncoderWithDispatchType:MTLDispatchTypeConcurrent]);
        }
    }
    BlitEncoderRef blitEncoder(CommandsRef commands) override {
        @autoreleasepool {
            return owned<BlitEncoderRef>([objectOf(commands) blitCommandEncoder]);
        }
    }
    RenderEncoderRef renderEncoder(CommandsRef commands, const RenderPassDesc& desc) override {
        @autoreleasepool {
            MTLRenderPassDescriptor* how = [MTLRenderPassDescriptor renderPassDescriptor];
            for (NSUInteger i = 0; i < 2; ++i) {
                if (!desc.colours[i].texture) continue;
                const double* c = desc.colours[i].clear;
                describe(how.colorAttachments[i], desc.colours[i]);
                how.colorAttachments[i].clearColor = MTLClearColorMake(c[0], c[1], c[2], c[3]);
            }
            if (desc.depth.texture) {
                describe(how.depthAttachment, desc.depth);
                how.depthAttachment.clearDepth = desc.depth.clear[0];
            }
            how.renderTargetArrayLength = desc.layers;
            return owned<RenderEncoderRef>([objectOf(commands) renderCommandEncoderWithDescriptor:how]);
        }
    }
    void end(ComputeEncoderRef encoder) override { [objectOf(encoder) endEncoding]; }
    void end(BlitEncoderRef encoder) override { [objectOf(encoder) endEncoding]; }
    void end(RenderEncoderRef encoder) override { [objectOf(encoder) endEncoding]; }
    void waitFence(ComputeEncoderRef encoder, FenceRef fence) override { [objectOf(encoder) waitForFence:objectOf(fence)]; }
    void waitFence(BlitEncoderRef encoder, FenceRef fence) override { [objectOf(encoder) waitForFence:objectOf(fence)]; }
    void waitFence(RenderEncoderRef encoder, FenceRef fence, uint32_t beforeStages) override {
        [objectOf(encoder) waitForFence:objectOf(fence) beforeStages:MTLRenderStages(beforeStages)];
    }
    void updateFence(ComputeEncoderRef encoder, FenceRef fence) override { [objectOf(encoder) updateFence:objectOf(fence)]; }
    void updateFence(BlitEncoderRef encoder, FenceRef fence) override { [objectOf(encoder) updateFence:objectOf(fence)]; }
    void updateFence(RenderEncoderRef encoder, FenceRef fence, uint32_t afterStages) override {
        [objectOf(encoder) updateFence:objectOf(fence) afterStages:MTLRenderStages(afterStages)];
    }
    void pushLabel(ComputeEncoderRef encoder, LabelRef label) override { [objectOf(encoder) pushDebugGroup:objectOf(label)]; }
    void pushLabel(RenderEncoderRef encoder, LabelRef label) override { [objectOf(encoder) pushDebugGroup:objectOf(label)]; }
    void popLabel(ComputeEncoderRef encoder) override { [objectOf(encoder) popDebugGroup]; }
    void popLabel(RenderEncoderRef encoder) override { [objectOf(encoder) popDebugGroup]; }

    void setPipeline(ComputeEncoderRef encoder, ComputePipelineRef pipeline) override {
        [objectOf(encoder) setComputePipelineState:objectOf(pipeline)];
    }
    void setBuffer(ComputeEncoderRef encoder, BufferRef buffer, uint64_t offset, uint32_t index) override {
        [objectOf(encoder) setBuffer:objectOf(buffer) offset:offset atIndex:index];
    }
    void setBytes(ComputeEncoderRef encoder, const void* bytes, size_t size, uint32_t index) override {
        [objectOf(encoder) setBytes:bytes length:size atIndex:index];
    }
    void setTexture(ComputeEncoderRef encoder, TextureRef texture, uint32_t index) override {
        [objectOf(encoder) setTexture:objectOf(texture) atIndex:index];
    }
    void dispatch(ComputeEncoderRef encoder, Size groups, Size threadsOfGroup) override {
        [objectOf(encoder) dispatchThreadgroups:sizeOf(groups) threadsPerThreadgroup:sizeOf(threadsOfGroup)];
    }
    void dispatchIndirect(ComputeEncoderRef encoder, BufferRef args, uint64_t offset, Size threadsOfGroup) override {
        [objectOf(encoder) dispatchThreadgroupsWithIndirectBuffer:objectOf(args)
                                             indirectBufferOffset:offset
                                            threadsPerThreadgroup:sizeOf(threadsOfGroup)];
    }
    void barrier(ComputeEncoderRef encoder) override { [objectOf(encoder) memoryBarrierWithScope:MTLBarrierScopeBuffers]; }

    void copyBuffer(BlitEncoderRef encoder, BufferRef from, uint64_t fromOffset, BufferRef to, uint64_t toOffset, uint64_t bytes) override {
        [objectOf(encoder) copyFromBuffer:objectOf(from)
                             sourceOffset:fromOffset
                                 toBuffer:objectOf(to)
                        destinationOffset:toOffset
                                     size:bytes];
    }
    void copyTexture(BlitEncoderRef encoder, TextureRef from, uint32_t slice, uint32_t widthPx, uint32_t heightPx, BufferRef to,
                     uint64_t toOffset, uint32_t bytesPerRow) override {
        [objectOf(encoder) copyFromTexture:objectOf(from)
                               sourceSlice:slice
                               sourceLevel:0
                              sourceOrigin:MTLOriginMake(0, 0, 0)
                                sourceSize:MTLSizeMake(widthPx, heightPx, 1)
                                  toBuffer:objectOf(to)
                         destinationOffset:toOffset
                    destinationBytesPerRow:bytesPerRow
                  destinationBytesPerImage:NSUInteger(bytesPerRow) * heightPx];
    }

    void setPipeline(RenderEncoderRef encoder, RenderPipelineRef pipeline) override {
        [objectOf(encoder) setRenderPipelineState:objectOf(pipeline)];
    }
    void setVertexBuffer(RenderEncoderRef encoder, BufferRef buffer, uint64_t offset, uint32_t index) override {
        [objectOf(encoder) setVertexBuffer:objectOf(buffer) offset:offset atIndex:index];
    }
    void setVertexBytes(RenderEncoderRef encoder, const void* bytes, size_t size, uint32_t index) override {
        [objectOf(encoder) setVertexBytes:bytes length:size atIndex:index];
    }
    void setFragmentBuffer(RenderEncoderRef encoder, BufferRef buffer, uint64_t offset, uint32_t index) override {
        [objectOf(encoder) setFragmentBuffer:objectOf(buffer) offset:offset atIndex:index];
    }
    void setFragmentBytes(RenderEncoderRef encoder, const void* bytes, size_t size, uint32_t index) override {
        [objectOf(encoder) setFragmentBytes:bytes length:size atIndex:index];
    }
    void setFragmentTexture(RenderEncoderRef encoder, TextureRef texture, uint32_t index) override {
        [objectOf(encoder) setFragmentTexture:objectOf(texture) atIndex:index];
    }
    void setViewport(RenderEncoderRef encoder, double x, double y, double widthPx, double heightPx) override {
        [objectOf(encoder) setViewport:MTLViewport{x, y, widthPx, heightPx, 0, 1}];
    }
    void setDepthStencil(RenderEncoderRef encoder, DepthStencilRef state) override {
        [objectOf(encoder) setDepthStencilState:objectOf(state)];
    }
    void setCullNone(RenderEncoderRef encoder) override { [objectOf(encoder) setCullMode:MTLCullModeNone]; }
    void setFill(RenderEncoderRef encoder) override { [objectOf(encoder) setTriangleFillMode:MTLTriangleFillModeFill]; }
    void setNoDepthBias(RenderEncoderRef encoder) override { [objectOf(encoder) setDepthBias:0 slopeScale:0 clamp:0]; }
    void setOneAmplification(RenderEncoderRef encoder) override { [objectOf(encoder) setVertexAmplificationCount:1 viewMappings:nullptr]; }
    void draw(RenderEncoderRef encoder, PrimitiveType type, uint32_t vertices, uint32_t instances) override {
        [objectOf(encoder) drawPrimitives:MTLPrimitiveType(type) vertexStart:0 vertexCount:vertices instanceCount:instances];
    }
    void drawIndirect(RenderEncoderRef encoder, PrimitiveType type, BufferRef args, uint64_t offset) override {
        [objectOf(encoder) drawPrimitives:MTLPrimitiveType(type) indirectBuffer:objectOf(args) indirectBufferOffset:offset];
    }

private:
    id<MTLDevice> device_;
    id<MTLCommandQueue> queue_;
};

}  // namespace

Result<std::unique_ptr<Seam>> openSeam() {
    id<MTLDevice> device = MTLCreateSystemDefaultDevice();
    if (!device) return fail(Code::Unsupported, "this machine has no Metal device");
    id<MTLCommandQueue> queue = [device newCommandQueue];
    if (!queue) return fail(Code::Device, "{} makes no command queue", textOf(device.name));
    return std::unique_ptr<Seam>(std::make_unique<AppleSeam>(device, queue));
}

Result<std::unique_ptr<Seam>> lendSeam(void* device, void* queue) {
    if (!device || !queue) return fail(Code::InvalidArgument, "the device or the queue is NULL");
    id<MTLDevice> given = (__bridge id<MTLDevice>)device;
    id<MTLCommandQueue> lent = (__bridge id<MTLCommandQueue>)queue;
    if (lent.device != given) return fail(Code::InvalidArgument, "the queue belongs to another device");
    return std::unique_ptr<Seam>(std::make_unique<AppleSeam>(given, lent));
}

}  // namespace dpl::mtl
