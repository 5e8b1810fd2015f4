// SPDX-License-Identifier: Apache-2.0
// The values of the seam's enums are Apple's.
#import <Metal/Metal.h>
#include <TargetConditionals.h>

#include "sdk/backend/metal/mtl_seam.h"

namespace dpl::mtl {

#define DPL_SAME(ours, theirs) static_assert(uint64_t(ours) == uint64_t(theirs))
DPL_SAME(GpuFamily::Apple4, MTLGPUFamilyApple4);
DPL_SAME(GpuFamily::Apple5, MTLGPUFamilyApple5);
DPL_SAME(GpuFamily::Apple6, MTLGPUFamilyApple6);
DPL_SAME(GpuFamily::Mac2, MTLGPUFamilyMac2);
DPL_SAME(PixelFormat::None, MTLPixelFormatInvalid);
DPL_SAME(PixelFormat::RG16Float, MTLPixelFormatRG16Float);
DPL_SAME(PixelFormat::RGBA8Unorm, MTLPixelFormatRGBA8Unorm);
DPL_SAME(PixelFormat::RGBA8UnormSrgb, MTLPixelFormatRGBA8Unorm_sRGB);
DPL_SAME(PixelFormat::BGRA8Unorm, MTLPixelFormatBGRA8Unorm);
DPL_SAME(PixelFormat::BGRA8UnormSrgb, MTLPixelFormatBGRA8Unorm_sRGB);
DPL_SAME(PixelFormat::RGB10A2Unorm, MTLPixelFormatRGB10A2Unorm);
DPL_SAME(PixelFormat::RG32Float, MTLPixelFormatRG32Float);
DPL_SAME(PixelFormat::RGBA16Float, MTLPixelFormatRGBA16Float);
DPL_SAME(PixelFormat::Depth16Unorm, MTLPixelFormatDepth16Unorm);
DPL_SAME(PixelFormat::Depth32Float, MTLPixelFormatDepth32Float);
#if TARGET_OS_OSX
DPL_SAME(PixelFormat::Depth24UnormStencil8, MTLPixelFormatDepth24Unorm_Stencil8);
#endif
DPL_SAME(PixelFormat::Depth32FloatStencil8, MTLPixelFormatDepth32Float_Stencil8);
DPL_SAME(TextureType::Flat, MTLTextureType2D);
DPL_SAME(TextureType::Array, MTLTextureType2DArray);
DPL_SAME(TextureType::FlatSamples, MTLTextureType2DMultisample);
DPL_SAME(TextureType::ArraySamples, MTLTextureType2DMultisampleArray);
DPL_SAME(StorageMode::Shared, MTLStorageModeShared);
DPL_SAME(StorageMode::Private, MTLStorageModePrivate);
DPL_SAME(StorageMode::Memoryless, MTLStorageModeMemoryless);
DPL_SAME(CompareFunction::Less, MTLCompareFunctionLess);
DPL_SAME(CompareFunction::Greater, MTLCompareFunctionGreater);
DPL_SAME(CompareFunction::Always, MTLCompareFunctionAlways);
DPL_SAME(PrimitiveType::Triangle, MTLPrimitiveTypeTriangle);
DPL_SAME(PrimitiveType::Strip, MTLPrimitiveTypeTriangleStrip);
DPL_SAME(BlendFactor::Zero, MTLBlendFactorZero);
DPL_SAME(BlendFactor::One, MTLBlendFactorOne);
DPL_SAME(BlendFactor::OneMinusSourceAlpha, MTLBlendFactorOneMinusSourceAlpha);
DPL_SAME(LoadAction::DontCare, MTLLoadActionDontCare);
DPL_SAME(LoadAction::Load, MTLLoadActionLoad);
DPL_SAME(LoadAction::Clear, MTLLoadActionClear);
DPL_SAME(StoreAction::DontCare, MTLStoreActionDontCare);
DPL_SAME(StoreAction::Store, MTLStoreActionStore);
DPL_SAME(StoreAction::Resolve, MTLStoreActionMultisampleResolve);
DPL_SAME(CommandStatus::NotEnqueued, MTLCommandBufferStatusNotEnqueued);
DPL_SAME(CommandStatus::Enqueued, MTLCommandBufferStatusEnqueued);
DPL_SAME(CommandStatus::Committed, MTLCommandBufferStatusCommitted);
DPL_SAME(CommandStatus::Scheduled, MTLCommandBufferStatusScheduled);
DPL_SAME(CommandStatus::Completed, MTLCommandBufferStatusCompleted);
DPL_SAME(CommandStatus::Error, MTLCommandBufferStatusError);
DPL_SAME(CommandError::None, MTLCommandBufferErrorNone);
DPL_SAME(CommandError::Internal, MTLCommandBufferErrorInternal);
DPL_SAME(CommandError::Timeout, MTLCommandBufferErrorTimeout);
DPL_SAME(CommandError::PageFault, MTLCommandBufferErrorPageFault);
DPL_SAME(CommandError::AccessRevoked, MTLCommandBufferErrorAccessRevoked);
DPL_SAME(CommandError::NotPermitted, MTLCommandBufferErrorNotPermitted);
DPL_SAME(CommandError::OutOfMemory, MTLCommandBufferErrorOutOfMemory);
DPL_SAME(CommandError::InvalidResource, MTLCommandBufferErrorInvalidResource);
DPL_SAME(CommandError::Memoryless, MTLCommandBufferErrorMemoryless);
#if TARGET_OS_OSX
DPL_SAME(CommandError::DeviceRemoved, MTLCommandBufferErrorDeviceRemoved);
#endif
DPL_SAME(CommandError::StackOverflow, MTLCommandBufferErrorStackOverflow);
DPL_SAME(kUsageShaderRead, MTLTextureUsageShaderRead);
DPL_SAME(kUsageShaderWrite, MTLTextureUsageShaderWrite);
DPL_SAME(kUsageRenderTarget, MTLTextureUsageRenderTarget);
DPL_SAME(kStageVertex, MTLRenderStageVertex);
DPL_SAME(kStageFragment, MTLRenderStageFragment);

}  // namespace dpl::mtl
