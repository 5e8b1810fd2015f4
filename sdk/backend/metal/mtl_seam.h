// SPDX-License-Identifier: Apache-2.0
// The seam between the Metal backend, which is plain C++, and Metal. Each function is the one Apple call that its comment names, so that a
// body is a list of one-line calls. Nothing is decided behind it.
//
//   Apple body       mtl_apple.mm: Objective-C++ under ARC. Needs Apple's SDK; on Linux it is only type-checked (tests/metal)
//   software device  runs the same MSL on the CPU and checks what Metal's validation would; for tests on Linux
//
// Handles. A Ref is the pointer of an Objective-C object, without its type: an `id<MTLBuffer>` of an app is a BufferRef by a cast.
// Functions that begin with `new`, commandBuffer() and the encoder functions give a handle that the caller owns: end it with release(). All
// other functions borrow. A null Ref means failure where a function returns one, and "none" where it takes one.
//
// Threads. Every function may be called from any thread, but one encoder or command buffer from one thread at a time. wait() blocks; no
// other function does.
//
// Errors. What needs an NSError writes its text to `error` and returns a null Ref. Everything else is a caller's mistake: Metal's
// validation layer aborts, the software device records a fault.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <string_view>

#include "sdk/core/result.h"

namespace dpl::mtl {

template <class Tag>
struct Ref {
    void* object = nullptr;
    explicit operator bool() const { return object != nullptr; }
    bool operator==(const Ref&) const = default;
};
using BufferRef = Ref<struct BufferTag>;                    // id<MTLBuffer>
using TextureRef = Ref<struct TextureTag>;                  // id<MTLTexture>
using LibraryRef = Ref<struct LibraryTag>;                  // id<MTLLibrary>
using FunctionRef = Ref<struct FunctionTag>;                // id<MTLFunction>
using ComputePipelineRef = Ref<struct ComputePipelineTag>;  // id<MTLComputePipelineState>
using RenderPipelineRef = Ref<struct RenderPipelineTag>;    // id<MTLRenderPipelineState>
using DepthStencilRef = Ref<struct DepthStencilTag>;        // id<MTLDepthStencilState>
using FenceRef = Ref<struct FenceTag>;                      // id<MTLFence>
using EventRef = Ref<struct EventTag>;                      // id<MTLSharedEvent>
using LabelRef = Ref<struct LabelTag>;                      // NSString*
using CommandsRef = Ref<struct CommandsTag>;                // id<MTLCommandBuffer>
using ComputeEncoderRef = Ref<struct ComputeEncoderTag>;    // id<MTLComputeCommandEncoder>
using BlitEncoderRef = Ref<struct BlitEncoderTag>;          // id<MTLBlitCommandEncoder>
using RenderEncoderRef = Ref<struct RenderEncoderTag>;      // id<MTLRenderCommandEncoder>
using DrawableRef = Ref<struct DrawableTag>;                // id<MTLDrawable>

// Values of these enums are Apple's; mtl_apple.mm asserts each.
enum class GpuFamily : int32_t { Apple4 = 1004, Apple5 = 1005, Apple6 = 1006, Mac2 = 2002 };  // MTLGPUFamily
enum class PixelFormat : uint32_t {                                                           // MTLPixelFormat
    None = 0,
    RG16Float = 65,
    RGBA8Unorm = 70,
    RGBA8UnormSrgb = 71,
    BGRA8Unorm = 80,
    BGRA8UnormSrgb = 81,
    RGB10A2Unorm = 90,
    RG32Float = 105,
    RGBA16Float = 115,
    Depth16Unorm = 250,
    Depth32Float = 252,
    Depth24UnormStencil8 = 255,
    Depth32FloatStencil8 = 260,
};
enum class TextureType : uint32_t { Flat = 2, Array = 3, FlatSamples = 4, ArraySamples = 8 };  // MTLTextureType2D...
enum class StorageMode : uint32_t { Shared = 0, Private = 2, Memoryless = 3 };                 // MTLStorageMode
enum class CompareFunction : uint32_t { Less = 1, Greater = 4, Always = 7 };                   // MTLCompareFunction
enum class PrimitiveType : uint32_t { Triangle = 3, Strip = 4 };                               // MTLPrimitiveType
enum class BlendFactor : uint32_t { Zero = 0, One = 1, OneMinusSourceAlpha = 5 };              // MTLBlendFactor
enum class LoadAction : uint32_t { DontCare = 0, Load = 1, Clear = 2 };                        // MTLLoadAction
enum class StoreAction : uint32_t { DontCare = 0, Store = 1, Resolve = 2 };                    // MTLStoreAction...MultisampleResolve
enum class CommandStatus : uint32_t {                                                          // MTLCommandBufferStatus
    NotEnqueued = 0,
    Enqueued = 1,
    Committed = 2,
    Scheduled = 3,
    Completed = 4,
    Error = 5,
};
enum class CommandError : uint32_t {  // MTLCommandBufferError
    None = 0,
    Internal = 1,
    Timeout = 2,
    PageFault = 3,
    AccessRevoked = 4,
    NotPermitted = 7,  // an iOS app in the background
    OutOfMemory = 8,
    InvalidResource = 9,
    Memoryless = 10,
    DeviceRemoved = 11,
    StackOverflow = 12,
};
// Bits.
constexpr uint32_t kUsageShaderRead = 1, kUsageShaderWrite = 2, kUsageRenderTarget = 4;  // MTLTextureUsage
constexpr uint32_t kStageVertex = 1, kStageFragment = 2;                                 // MTLRenderStages

/** MTLTextureDescriptor. Hazard tracking is off unless `tracked`; see docs/adr on Metal. */
struct TextureDesc {
    TextureType type = TextureType::Array;
    PixelFormat format = PixelFormat::RGBA8Unorm;
    uint32_t widthPx = 1, heightPx = 1;
    uint32_t layers = 1;   // arrayLength
    uint32_t samples = 1;  // sampleCount
    StorageMode storage = StorageMode::Private;
    uint32_t usage = kUsageRenderTarget;
    bool tracked = false;  // MTLHazardTrackingModeTracked, as textures of an app usually are; else Untracked
};

/** Properties of an MTLTexture. */
struct TextureFacts {
    TextureType type = TextureType::Flat;
    PixelFormat format = PixelFormat::None;  // may hold values that the enum does not name
    uint32_t widthPx = 0, heightPx = 0, layers = 0, samples = 0;
    StorageMode storage = StorageMode::Private;
    uint32_t usage = 0;
};

/** A colour attachment of MTLRenderPipelineDescriptor. With `blends`: rgb = One * source + rgbTo * destination, alpha = alphaFrom * source
 * + alphaTo * destination, both added. */
struct PipelineColour {
    PixelFormat format = PixelFormat::None;  // None: no attachment
    bool blends = false;
    bool writes = true;  // writeMask: all or none
    BlendFactor rgbTo = BlendFactor::OneMinusSourceAlpha;
    BlendFactor alphaFrom = BlendFactor::One, alphaTo = BlendFactor::OneMinusSourceAlpha;
};

/** MTLRenderPipelineDescriptor. There is no vertex descriptor: vertex functions read buffers. */
struct RenderPipelineDesc {
    std::string_view label;
    FunctionRef vertex, fragment;
    PipelineColour colours[2];
    PixelFormat depth = PixelFormat::None, stencil = PixelFormat::None;
    uint32_t samples = 1;  // rasterSampleCount
    bool layered = false;  // inputPrimitiveTopology: Triangle, which layered rendering needs; else Unspecified
};

/** A colour or depth attachment of MTLRenderPassDescriptor. */
struct PassAttachment {
    TextureRef texture;  // none: no attachment
    TextureRef resolve;  // of StoreAction::Resolve
    uint32_t slice = 0, resolveSlice = 0;
    LoadAction load = LoadAction::Clear;
    StoreAction store = StoreAction::Store;
    double clear[4] = {0, 0, 0, 0};  // clearColor; of depth the first is clearDepth
};
/** MTLRenderPassDescriptor. */
struct RenderPassDesc {
    PassAttachment colours[2];
    PassAttachment depth;
    uint32_t layers = 0;  // renderTargetArrayLength; 0: no layered rendering
};

/** Widths along x, y and z of an MTLSize. */
struct Size {
    uint32_t x = 1, y = 1, z = 1;
};

/** An MTLDevice and one MTLCommandQueue of it. */
class Seam {
public:
    virtual ~Seam() = default;  // releases device and queue

    // The device.
    virtual std::string name() const = 0;                          // MTLDevice.name
    virtual std::string systemVersion() const = 0;                 // NSProcessInfo.operatingSystemVersionString
    virtual bool isSoftware() const = 0;                           // no call: false in the Apple body
    virtual bool isMacText() const = 0;                            // no call: TARGET_OS_OSX; which text of a shader fits
    virtual bool supportsFamily(GpuFamily family) const = 0;       // supportsFamily:
    virtual bool supportsSampleCount(uint32_t samples) const = 0;  // supportsTextureSampleCount:
    virtual bool supports32BitMsaa() const = 0;                    // MTLDevice.supports32BitMSAA
    virtual bool hasUnifiedMemory() const = 0;                     // MTLDevice.hasUnifiedMemory
    virtual uint64_t maxBufferBytes() const = 0;                   // MTLDevice.maxBufferLength
    virtual uint64_t workingSetBytes() const = 0;                  // MTLDevice.recommendedMaxWorkingSetSize

    // Objects.
    virtual void release(void* object) = 0;  // objc_release, by ending a __bridge_transfer
    virtual void retain(void* object) = 0;   // objc_retain, by __bridge_retained
    template <class Tag>
    void release(Ref<Tag>& ref) {  // and forgets it; a null handle is fine
        if (ref) release(ref.object);
        ref = {};
    }
    /** storage: Shared or Private. Hazard tracking is off. */
    virtual BufferRef newBuffer(uint64_t bytes, StorageMode storage, std::string_view label) = 0;  // newBufferWithLength:options:, label
    virtual std::byte* contents(BufferRef buffer) = 0;                                             // MTLBuffer.contents; of Shared buffers
    virtual uint64_t allocatedBytes(BufferRef buffer) = 0;                                         // MTLResource.allocatedSize
    virtual TextureRef newTexture(const TextureDesc& desc, std::string_view label) = 0;            // newTextureWithDescriptor:, label
    virtual uint64_t allocatedBytes(TextureRef texture) = 0;  // MTLResource.allocatedSize; 0 for memoryless textures
    virtual TextureFacts factsOf(TextureRef texture) = 0;     // properties of MTLTexture
    virtual FenceRef newFence() = 0;                          // newFence
    virtual EventRef newSharedEvent() = 0;                    // newSharedEvent
    virtual uint64_t signaledValue(EventRef event) = 0;       // MTLSharedEvent.signaledValue
    virtual LabelRef newLabel(std::string_view text) = 0;     // initWithBytes:length:encoding: of NSString

    // Pipelines. Options: MTLLanguageVersion2_3 and fastMathEnabled = NO, because shaders use infinities and test for NaN.
    virtual LibraryRef newLibrary(std::string_view msl, std::string& error) = 0;     // newLibraryWithSource:options:error:
    virtual FunctionRef newFunction(LibraryRef library, std::string_view name) = 0;  // newFunctionWithName:
    virtual ComputePipelineRef newComputePipeline(FunctionRef function,
                                                  std::string& error) = 0;  // newComputePipelineStateWithFunction:error:
    virtual uint32_t maxThreads(ComputePipelineRef pipeline) = 0;           // maxTotalThreadsPerThreadgroup
    virtual RenderPipelineRef newRenderPipeline(const RenderPipelineDesc& desc,
                                                std::string& error) = 0;               // newRenderPipelineStateWithDescriptor:error:
    virtual DepthStencilRef newDepthStencil(CompareFunction nearer, bool writes) = 0;  // newDepthStencilStateWithDescriptor:

    // Command buffers of the seam's queue. They do not retain what they use: the backend keeps it until they have run.
    virtual CommandsRef commandBuffer() = 0;                                  // commandBufferWithUnretainedReferences
    virtual void commit(CommandsRef commands) = 0;                            // commit
    virtual void wait(CommandsRef commands) = 0;                              // waitUntilCompleted
    virtual CommandStatus status(CommandsRef commands) = 0;                   // MTLCommandBuffer.status
    virtual CommandError error(CommandsRef commands, std::string& text) = 0;  // MTLCommandBuffer.error; Internal for other domains
    virtual double gpuStartS(CommandsRef commands) = 0;                       // GPUStartTime, seconds; once completed
    virtual double gpuEndS(CommandsRef commands) = 0;                         // GPUEndTime
    virtual void encodeWait(CommandsRef commands, EventRef event, uint64_t value) = 0;    // encodeWaitForEvent:value:
    virtual void encodeSignal(CommandsRef commands, EventRef event, uint64_t value) = 0;  // encodeSignalEvent:value:
    virtual void present(CommandsRef commands, DrawableRef drawable) = 0;                 // presentDrawable:

    // Encoders. A command buffer has one open encoder at a time; encodeWait and encodeSignal need that none is open.
    virtual ComputeEncoderRef computeEncoder(CommandsRef commands) = 0;  // computeCommandEncoderWithDispatchType: MTLDispatchTypeConcurrent
    virtual BlitEncoderRef blitEncoder(CommandsRef commands) = 0;        // blitCommandEncoder
    virtual RenderEncoderRef renderEncoder(CommandsRef commands, const RenderPassDesc& desc) = 0;  // renderCommandEncoderWithDescriptor:
    virtual void end(ComputeEncoderRef encoder) = 0;                                               // endEncoding
    virtual void end(BlitEncoderRef encoder) = 0;                                                  // endEncoding
    virtual void end(RenderEncoderRef encoder) = 0;                                                // endEncoding
    // Waits take effect where the encoder begins, updates where it ends. One encoder may wait for a fence and then update it, not the
    // other way round. A fence orders encoders of one queue, in the order in which their command buffers are committed.
    virtual void waitFence(ComputeEncoderRef encoder, FenceRef fence) = 0;                         // waitForFence:
    virtual void waitFence(BlitEncoderRef encoder, FenceRef fence) = 0;                            // waitForFence:
    virtual void waitFence(RenderEncoderRef encoder, FenceRef fence, uint32_t beforeStages) = 0;   // waitForFence:beforeStages:
    virtual void updateFence(ComputeEncoderRef encoder, FenceRef fence) = 0;                       // updateFence:
    virtual void updateFence(BlitEncoderRef encoder, FenceRef fence) = 0;                          // updateFence:
    virtual void updateFence(RenderEncoderRef encoder, FenceRef fence, uint32_t afterStages) = 0;  // updateFence:afterStages:
    virtual void pushLabel(ComputeEncoderRef encoder, LabelRef label) = 0;                         // pushDebugGroup:
    virtual void pushLabel(RenderEncoderRef encoder, LabelRef label) = 0;                          // pushDebugGroup:
    virtual void popLabel(ComputeEncoderRef encoder) = 0;                                          // popDebugGroup
    virtual void popLabel(RenderEncoderRef encoder) = 0;                                           // popDebugGroup

    // Compute. Dispatches run at once with those before them, up to the last barrier.
    virtual void setPipeline(ComputeEncoderRef encoder, ComputePipelineRef pipeline) = 0;                      // setComputePipelineState:
    virtual void setBuffer(ComputeEncoderRef encoder, BufferRef buffer, uint64_t offset, uint32_t index) = 0;  // setBuffer:offset:atIndex:
    virtual void setBytes(ComputeEncoderRef encoder, const void* bytes, size_t size, uint32_t index) = 0;      // setBytes:length:atIndex:
    virtual void setTexture(ComputeEncoderRef encoder, TextureRef texture, uint32_t index) = 0;                // setTexture:atIndex:
    virtual void dispatch(ComputeEncoderRef encoder, Size groups, Size threadsOfGroup) = 0;  // dispatchThreadgroups:threadsPerThreadgroup:
    /** args: three u32, the groups. */
    virtual void dispatchIndirect(
        ComputeEncoderRef encoder, BufferRef args, uint64_t offset,
        Size threadsOfGroup) = 0;  // dispatchThreadgroupsWithIndirectBuffer:indirectBufferOffset:threadsPerThreadgroup:
    virtual void barrier(ComputeEncoderRef encoder) = 0;  // memoryBarrierWithScope: MTLBarrierScopeBuffers

    // Blit.
    virtual void copyBuffer(BlitEncoderRef encoder, BufferRef from, uint64_t fromOffset, BufferRef to, uint64_t toOffset,
                            uint64_t bytes) = 0;  // copyFromBuffer:sourceOffset:toBuffer:destinationOffset:size:
    /** Level 0 of one slice, whole; rows without padding. */
    virtual void copyTexture(BlitEncoderRef encoder, TextureRef from, uint32_t slice, uint32_t widthPx, uint32_t heightPx, BufferRef to,
                             uint64_t toOffset, uint32_t bytesPerRow) = 0;  // copyFromTexture:sourceSlice:...destinationBytesPerImage:

    // Render.
    virtual void setPipeline(RenderEncoderRef encoder, RenderPipelineRef pipeline) = 0;  // setRenderPipelineState:
    virtual void setVertexBuffer(RenderEncoderRef encoder, BufferRef buffer, uint64_t offset,
                                 uint32_t index) = 0;  // setVertexBuffer:offset:atIndex:
    virtual void setVertexBytes(RenderEncoderRef encoder, const void* bytes, size_t size,
                                uint32_t index) = 0;  // setVertexBytes:length:atIndex:
    virtual void setFragmentBuffer(RenderEncoderRef encoder, BufferRef buffer, uint64_t offset,
                                   uint32_t index) = 0;  // setFragmentBuffer:offset:atIndex:
    virtual void setFragmentBytes(RenderEncoderRef encoder, const void* bytes, size_t size,
                                  uint32_t index) = 0;                                                  // setFragmentBytes:length:atIndex:
    virtual void setFragmentTexture(RenderEncoderRef encoder, TextureRef texture, uint32_t index) = 0;  // setFragmentTexture:atIndex:
    virtual void setViewport(RenderEncoderRef encoder, double x, double y, double widthPx,
                             double heightPx) = 0;                                      // setViewport:, znear 0, zfar 1
    virtual void setDepthStencil(RenderEncoderRef encoder, DepthStencilRef state) = 0;  // setDepthStencilState:
    virtual void setCullNone(RenderEncoderRef encoder) = 0;                             // setCullMode: MTLCullModeNone
    virtual void setFill(RenderEncoderRef encoder) = 0;                                 // setTriangleFillMode: MTLTriangleFillModeFill
    virtual void setNoDepthBias(RenderEncoderRef encoder) = 0;                          // setDepthBias:slopeScale:clamp: zeros
    virtual void setOneAmplification(RenderEncoderRef encoder) = 0;                     // setVertexAmplificationCount:viewMappings: 1, NULL
    virtual void draw(RenderEncoderRef encoder, PrimitiveType type, uint32_t vertices,
                      uint32_t instances) = 0;  // drawPrimitives:vertexStart:vertexCount:instanceCount:
    /** args: MTLDrawPrimitivesIndirectArguments, which has the layout of VkDrawIndirectCommand. */
    virtual void drawIndirect(RenderEncoderRef encoder, PrimitiveType type, BufferRef args,
                              uint64_t offset) = 0;  // drawPrimitives:indirectBuffer:indirectBufferOffset:
};

/** MTLCreateSystemDefaultDevice and a new queue. Unsupported: there is no Metal device. Of the body that is linked. */
Result<std::unique_ptr<Seam>> openSeam();

/** On an app's id<MTLDevice> and id<MTLCommandQueue>, which it retains. InvalidArgument: one is null, or the queue is another device's. */
Result<std::unique_ptr<Seam>> lendSeam(void* device, void* queue);

}  // namespace dpl::mtl
