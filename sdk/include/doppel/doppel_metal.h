// SPDX-License-Identifier: Apache-2.0
/* Draws avatars inside a Metal program's own frames: on its device, in its command buffers, into its textures. No pixel is copied to the
 * CPU. For iOS 16, macOS 13 and visionOS 2 and later. Include it beside doppel.h; C99, C++, Objective-C and Swift. No
 * Apple device has run it yet.
 * The sibling for Vulkan, with the same ideas and names, is doppel_vulkan.h.
 *
 *   DplMetalDevice mine = {sizeof mine, 0, device, queue};
 *   dplCreateMetalContext(&mine, NULL, &context);
 *   DplMetalPass pass = {sizeof pass, MTLPixelFormatBGRA8Unorm_sRGB, MTLPixelFormatDepth32Float};
 *   dplCreateMetalComposer(context, &pass, &composer);
 *
 *   each frame, with slot = frame % DPL_METAL_SLOTS, after the completion handler of the last frame with this slot:
 *     id<MTLCommandBuffer> commands = [queue commandBuffer];
 *     dplMetalPrepare(context, commands, slot, &avatar, 1, views, viewCount, NULL);    while no encoder is open
 *     encoder = [commands renderCommandEncoderWithDescriptor:...];  the program draws its scene
 *     dplMetalCompose(context, composer, encoder, slot, 0, 0, 0);                      before endEncoding
 *     [encoder endEncoding]; [commands presentDrawable:drawable]; [commands commit];
 *
 * What prepare and compose encode. Prepare encodes a compute pass and a render pass into textures of Doppel's, with encoders of its own.
 * Compose encodes one draw of one triangle. Neither commits, waits, reads back or allocates memory of its own (Metal makes the encoders),
 * except that the first prepare of a new size, number of views, number of samples or set of avatars makes its pipelines and buffers: do it
 * while loading. It does not commit or wait either.
 *
 * Objects. In Objective-C an object is passed as such; elsewhere as a pointer, made by (__bridge void*) in Objective-C++ and by
 * Unmanaged.passUnretained(_:).toOpaque() in Swift. Doppel retains the device and the queue as long as the context, and for each slot the
 * command buffer that was encoded last. It keeps nothing else that a program passes: textures must live until their commands have run,
 * which a command buffer sees to if it retains what it uses. Doppel's own objects live long enough for command buffers of either kind.
 *
 * Slots. A slot names what one frame in flight uses. With dplMetalPrepare the program promises that all commands it encoded with the slot
 * before have run. Use the slots in turn. Objects destroyed in between, such as avatars, live on until then. Prepare notices a slot that
 * comes too early: the GPU signals an event behind the commands of prepare. It cannot notice that those of compose still
 * run.
 *
 * Loads. What dplStartLoad uploads is copied by the commands of prepare: at most 1 MiB a frame, from a staging ring of 5 MiB that the load
 * made when it began to upload. A frame that draws no avatar calls dplMetalUpload instead. The load is ready once the GPU has run the last
 * copy; if frames stop, for example in the background, it waits. Only dplLoadAvatar, and dplFinishLoad of a load that is not ready, commit
 * command buffers of their own.
 *
 * Queues. All commands with slots of one context go to the queue of DplMetalDevice, in the order in which they were prepared.
 *
 * Hazards. Doppel's buffers and textures are untracked; prepare and compose order them with fences, which also work across command buffers
 * of the queue. Textures of the program are ordered by Metal if they are tracked, as textures of MTKView, CAMetalLayer and
 * CompositorServices are and textures of newTextureWithDescriptor: are by default. Every object that Doppel uses is bound directly, so none
 * needs useResource: or a residency set.
 *
 * Errors of the GPU. A command buffer that fails, because an iOS app went to the background or because of anything else, is seen by the
 * prepare that takes its slot: DPL_ERROR_DEVICE once, with the reason. The first kind loses nothing but the frame, and prepare may be
 * called again. After the others each call fails with DPL_ERROR_DEVICE until dplRebuildMetal. */
#ifndef DOPPEL_DOPPEL_METAL_H
#define DOPPEL_DOPPEL_METAL_H

#include <doppel/doppel.h>

#if defined(__OBJC__) && !defined(DPL_METAL_POINTERS) /* the Swift module keeps plain pointers, which are alike on every platform */
#import <Metal/Metal.h>
/** An object of Metal in a struct, not retained. */
#define DPL_METAL_MEMBER(protocol) __unsafe_unretained id<protocol>
/** An object of Metal as a parameter. */
#define DPL_METAL_OBJECT(protocol) id<protocol>
#else
#define DPL_METAL_MEMBER(protocol) void*
#define DPL_METAL_OBJECT(protocol) void*
#endif

#ifdef __cplusplus
extern "C" {
#endif

#define DPL_METAL_SLOTS 3u            /**< frames in flight */
#define DPL_METAL_DEPTH_COVERAGE 0.5f /**< alpha of the picture from which on a pixel writes depth */

/** A device and a queue of the program's. Both are retained until the context is destroyed or rebuilt. */
typedef struct DplMetalDevice {
    uint32_t structSize;
    uint32_t reserved; /**< 0 */
    DPL_METAL_MEMBER(MTLDevice) device;
    DPL_METAL_MEMBER(MTLCommandQueue)
    queue; /**< of device. Doppel commits to it in dplMetalSubmit, dplLoadAvatar, dplFinishLoad of a load
            * that is not ready, dplRender, dplDraw and the self-test of DPL_FILL_AUTO; never in prepare
            * and compose. MTLCommandQueue is thread-safe, so there is no lock */
} DplMetalDevice;

/** Creates a context that draws on the program's device. info: as for dplCreateContext; `renderer` and `threadCount` are not read. NULL:
 * all defaults. Free it with dplDestroyContext once no committed commands of its slots can still run; that call waits for loads on other
 * threads. dplRender and dplDraw work on it too.
 * DPL_ERROR_INVALID_ARGUMENT: an object is NULL, or the queue belongs to another device. DPL_ERROR_UNSUPPORTED: a GPU older than
 * MTLGPUFamilyApple4 (A11) and MTLGPUFamilyMac2, or a build without Metal. */
DPL_API DplResult dplCreateMetalContext(const DplMetalDevice* device, const DplContextInfo* info, DplContext* context);

/** Replaces a device after DPL_ERROR_DEVICE. Avatars, poses, detail and frame budget stay, from a copy that the context keeps. Slots are
 * empty, and composers are gone: make them again. After an error all is as before, and the call can be repeated. device: of a context made
 * with dplCreateMetalContext, which may be the same device with a new queue; submitted commands of its slots can no longer run by then.
 * NULL: of a context made with dplCreateContext that draws by Metal. Uploads all avatars with command buffers of its own, and waits for
 * them. Other threads wait meanwhile. DPL_ERROR_INVALID_ARGUMENT: the other kind of context, or one that draws otherwise. Other errors as
 * dplCreateMetalContext and dplCreateContext. */
DPL_API DplResult dplRebuildMetal(DplContext context, const DplMetalDevice* device);

/** The render pass in which a composer draws. Doppel draws into colour attachment 0; the pass has no other, and no rasterisation rate map.
 *
 *  The colour format says how light is stored. RGBA8Unorm, BGRA8Unorm and RGB10A2Unorm: display-referred values, blended as they are.
 *  RGBA8Unorm_sRGB, BGRA8Unorm_sRGB and RGBA16Float: linear light. These are the formulas of DplImageFormat. */
typedef struct DplMetalPass {
    uint32_t structSize;
    uint32_t colourFormat;  /**< MTLPixelFormat of colour attachment 0 */
    uint32_t depthFormat;   /**< MTLPixelFormat of the depth attachment; 0 (MTLPixelFormatInvalid): the pass has none */
    uint32_t stencilFormat; /**< of the stencil attachment, which is kept; 0: none */
    uint32_t samples;       /**< of the attachments, 1 or 4. 0: 1 */
    uint32_t layers;        /**< renderTargetArrayLength: the layers are the views and one compose draws them all ("layered" layout of
                             * CompositorServices; vertex amplification is set to 1). 0: each view has a pass, a texture or a place of its
                             * own ("dedicated" and "shared" layouts) */
    uint32_t writesDepth;   /**< what dplMetalComposeDepth writes here: 0, DPL_DRAW_DEPTH or DPL_DRAW_MESH_DEPTH (DplDrawFlag) */
} DplMetalPass;

/** Compiles what composes into a pass, so that no frame does. While a composer with writesDepth lives, prepare draws that depth too, so
 * make composers before the first prepare. *composer: a number for dplMetalCompose. It lives until dplDestroyMetalComposer,
 * dplRebuildMetal or as long as the context. DPL_ERROR_UNSUPPORTED: another format or sample count, layers on a GPU older than
 * MTLGPUFamilyApple5 (A12), or a context that is not on the program's device; the text says which. */
DPL_API DplResult dplCreateMetalComposer(DplContext context, const DplMetalPass* pass, uint32_t* composer);

/** Commands that use it may still run; see "Slots". DPL_ERROR_NOT_FOUND: no such composer. */
DPL_API DplResult dplDestroyMetalComposer(DplContext context, uint32_t composer);

/** Depth that the program has drawn behind one view. A splat adds nothing to a pixel if it lies behind. Pixels outside the texture have no
 *  scene. With four samples a pixel, the farthest counts.
 *
 *  stored depth = scale + offset / z, with z > 0 the distance along the view axis in metres:
 *    usual, 0 at the near plane n and 1 at the far plane f    scale f/(f-n)    offset -f n/(f-n)
 *    usual, infinite far plane                                scale 1          offset -n
 *    reversed, 1 at n and 0 at f                              scale -n/(f-n)   offset f n/(f-n)
 *    reversed, infinite far plane (CompositorServices)        scale 0          offset n */
typedef struct DplMetalSceneDepth {
    uint32_t structSize;
    uint32_t slice; /**< of the texture that this view uses; 0 of one without slices */
    DPL_METAL_MEMBER(MTLTexture)
    texture;      /**< a depth format; 2D or 2D array, 1 or 4 samples; usage MTLTextureUsageShaderRead; not memoryless */
    int32_t x, y; /**< place of the view's top left pixel in the texture, pixels */
    float scale, offset;
} DplMetalSceneDepth;

/** Draws the avatars in their current poses into the picture of a slot. Arguments as dplDrawTogether. The views have the size of the
 *  picture, which may be smaller than the program's target. dplSetDetail holds here too. What prepare drew (dplGetFrameStats) is known when
 *  the slot comes round; Metal tells no times of a part of a command buffer, so DplFrameStats::passCount, gpuMs and frameMs are 0, its
 *  budgetState is DPL_BUDGET_UNTIMED, and dplSetFrameBudget has no effect. commands: of the device's queue, not committed, without an open
 * encoder. depths: viewCount of them, or NULL: DplCamera::sceneDepthM counts, which the CPU copies. The pass that drew a depth has ended,
 * and stored it. DPL_ERROR_INVALID_ARGUMENT: no such slot, one whose last commands have not run (wait for their completion handler, or
 * dplMetalDropSlot), NULL commands, a context that is not on the program's device, or a depth that says nothing (offset 0, not finite, no
 * texture) or cannot be read (usage, memoryless, no depth format). After an error the program may commit or drop the command buffer, and
 * composes nothing of what was to be prepared. DPL_ERROR_DEVICE: see "Errors of the GPU". */
DPL_API DplResult dplMetalPrepare(DplContext context, DPL_METAL_OBJECT(MTLCommandBuffer) commands, uint32_t slot, const DplAvatar* avatars,
                                  uint32_t avatarCount, const DplCamera* views, uint32_t viewCount, const DplMetalSceneDepth* depths);

/** Prepares no picture, and encodes what loads have to upload (see "Loads"): instead of dplMetalPrepare, in frames without avatars.
 *  commands and slot: as there. */
DPL_API DplResult dplMetalUpload(DplContext context, DPL_METAL_OBJECT(MTLCommandBuffer) commands, uint32_t slot);

/** A buffer of the program's for posed splats, and its layout. Experimental. */
typedef struct DplMetalBuffer {
    uint32_t structSize;
    uint32_t elementCount; /**< 1 to DPL_MAX_BUFFER_ELEMENTS */
    const DplBufferElement* elements;
    DPL_METAL_MEMBER(MTLBuffer) buffer; /**< of the device */
    uint64_t bytes;                     /**< of the buffer, from its start; offsets of elements count from there */
} DplMetalBuffer;

/** Encodes what dplWriteSplats does into the program's command buffer: the splats of the current pose go into the program's buffer, in its
 *  layout. Properties, options, number and order of splats are as there (doppel_posed.h), and for the same avatar and splatBudget the same
 *  on the CPU. Works whether or not the frame draws the avatar: the commands pose its mesh anew, because the one that prepare has posed
 *  lacks what its views do not see. So each write costs the pose of the mesh as well; write several properties in one call.
 *  commands, slot: as dplMetalPrepare, without an open encoder, after dplMetalPrepare, dplMetalUpload or dplMetalSubmit of this frame with
 *  the same slot; in the same command buffer or in one that is committed later to the same queue. At most 16 writes of an avatar in a
 *  frame.
 *  buffer: NULL only counts; commands and slot are then not read. The buffer must live until the commands have run.
 *
 *  What differs from dplWriteSplats, because a GPU stores whole words of four bytes:
 *  - offsetBytes and strideBytes, also the stride that 0 stands for, must be multiples of 4. So a property of halves begins a word; with
 *    an odd number of halves, the other half of its last word stays as it is, and must lie in the buffer.
 *  - Numbers too large for a half become 65504, but DplWritten::saturated is 0: only a wait for the GPU could tell.
 *  - Where the opacity is 0, other numbers are finite but may differ from those of the CPU.
 *  - All elements together lie within what the device binds at once.
 *
 *  Barriers. One compute encoder writes the buffer. Metal orders it with other uses if the buffer is tracked, as those of
 *  newBufferWithLength: are by default. Uses of an untracked buffer, or one of an untracked heap, need an event or a fence of the
 *  program's before and after. The CPU reads a shared buffer once the command buffer has completed.
 *
 *  Allocates where an avatar is written for the first time in a slot, or once more often in a frame than before, with another splatBudget;
 *  do it while loading. Neither commits nor waits.
 *  DPL_ERROR_INVALID_ARGUMENT: as dplWriteSplats; also an offset or a stride that is no multiple of 4, a slot that was not begun, NULL
 *  commands or MTLBuffer, a context that is not on the program's device. Nothing is then encoded. DPL_ERROR_UNSUPPORTED: elements too far
 *  apart for one binding. */
DPL_EXPERIMENTAL DplResult dplMetalWriteSplats(DplAvatar avatar, DPL_METAL_OBJECT(MTLCommandBuffer) commands, uint32_t slot,
                                               const DplSplatOptions* options, const DplMetalBuffer* buffer, DplWritten* written);

/** Says that the commands encoded with the slot have run or will never run, for example because their command buffer was not committed.
 *  Needed before the next prepare with the slot only if they never ran. DPL_ERROR_INVALID_ARGUMENT: no such slot. */
DPL_API DplResult dplMetalDropSlot(DplContext context, uint32_t slot);

/** Composes the picture of a view over the colour attachment; where the picture is empty, the attachment keeps its bits.
 *  encoder: of the composer's pass. Its command buffer may be another one than that of prepare if it is committed later to the same queue.
 *  view: which picture; with DplMetalPass::layers all are composed and it is not read. x, y: of the picture's top left corner in the
 *  attachment, pixels; may be negative. The scissor rectangle of the encoder holds.
 *  Changes pipeline, viewport, depth stencil state, cull mode, fill mode, depth bias, vertex amplification, buffers 24 and 29 of the vertex
 *  stage and buffers 1, 2, 4, 24 and 29 and textures 0 and 3 of the fragment stage.
 *  DPL_ERROR_INVALID_ARGUMENT: the slot was not prepared with that many views. DPL_ERROR_NOT_FOUND: no such composer. */
DPL_API DplResult dplMetalCompose(DplContext context, uint32_t composer, DPL_METAL_OBJECT(MTLRenderCommandEncoder) encoder, uint32_t slot,
                                  uint32_t view, int32_t x, int32_t y);

/** Writes the depth of the picture of a view into the depth attachment of the pass. A pixel of the picture writes where its alpha is at
 *  least DPL_METAL_DEPTH_COVERAGE and its depth is nearer than what is stored; elsewhere, the attachment keeps its bits. All samples of a
 *  pixel get the same depth. Later draws, and the reprojection of visionOS, see the avatars then. Changes no colour; call it before or
 *  after dplMetalCompose.
 *
 *  With DPL_DRAW_DEPTH it writes DplImage::depthM, the mean of the splats by opacity; prepare then blends a second texture. With
 *  DPL_DRAW_MESH_DEPTH it writes DplImage::meshDepthM, the front of the posed mesh; prepare then rasterises the mesh, and general splats
 *  write nothing.
 *
 *  composer: with writesDepth. scale, offset: of the attachment, as in DplMetalSceneDepth; offset below 0: less is nearer (usual), above 0:
 *  greater is nearer (reversed). Stored depth is clamped to 0 ... 1. Other arguments, changed state and errors as dplMetalCompose.
 *  DPL_ERROR_INVALID_ARGUMENT also: a composer without writesDepth, one that was made after the slot was prepared, or scale and offset that
 *  say nothing (offset 0, not finite). */
DPL_API DplResult dplMetalComposeDepth(DplContext context, uint32_t composer, DPL_METAL_OBJECT(MTLRenderCommandEncoder) encoder,
                                       uint32_t slot, uint32_t view, int32_t x, int32_t y, float scale, float offset);

/* Prepare, compose and commit in one call, for programs that hand Doppel textures rather than command buffers. Both forms may be used by
 * one context, with different slots. */

/** The textures of a submission, and what it waits for and signals. Read during the call; all objects live until the GPU has run it. */
typedef struct DplMetalSubmission {
    uint32_t structSize;
    uint32_t textureCount;                                /**< one for each view; 1 if the composer has layers, a 2D array then */
    DPL_METAL_MEMBER(MTLTexture) textures[DPL_MAX_VIEWS]; /**< usage MTLTextureUsageRenderTarget. What they hold is drawn over */
    int32_t x, y;                                         /**< of the picture's top left corner in the textures, pixels; may be negative */
    DPL_METAL_MEMBER(MTLSharedEvent) waitEvent;           /**< waited for before anything else. NULL: none */
    DPL_METAL_MEMBER(MTLSharedEvent) signalEvent;         /**< signalled when the textures are done. NULL: none */
    uint64_t waitValue, signalValue;
    DPL_METAL_MEMBER(MTLDrawable) drawable; /**< presented when the textures are done. NULL: none */
} DplMetalSubmission;

/** Draws the avatars over textures, with one command buffer of the queue. composer: of a pass with the format and samples of the textures
 *  and without depth. Other arguments, and what the first call of a size makes, as dplMetalPrepare. Later calls neither allocate memory of
 *  their own nor wait for the GPU.
 *  slot: as in "Slots". A slot whose last submission the GPU has not finished is DPL_ERROR_INVALID_ARGUMENT: wait for its event, and call
 *  again. After any error nothing was committed: no event is waited for or signalled, nothing is presented, and the slot may be used again,
 *  unless it is in flight.
 *  DPL_ERROR_INVALID_ARGUMENT also: a texture of another type, format, size or number of samples. DPL_ERROR_NOT_FOUND: no such composer.
 *  Other errors as dplMetalPrepare. */
DPL_API DplResult dplMetalSubmit(DplContext context, uint32_t composer, uint32_t slot, const DplAvatar* avatars, uint32_t avatarCount,
                                 const DplCamera* views, uint32_t viewCount, const DplMetalSceneDepth* depths,
                                 const DplMetalSubmission* how);

#ifdef __cplusplus
}
#endif
#endif
