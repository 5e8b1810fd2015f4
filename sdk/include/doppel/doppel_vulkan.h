// SPDX-License-Identifier: Apache-2.0
/* Draws avatars inside a Vulkan program's own frames: on its device, in its command buffers, into its images. No pixel is copied to the
 * CPU. Include it beside doppel.h; C99 and C++.
 *
 *   DplVulkanDevice mine = {sizeof mine, family, NULL, instance, physicalDevice, device, queue};
 *   dplCreateVulkanContext(&mine, NULL, &context);
 *   DplVulkanPass pass = {sizeof pass, 0, renderPass, 0, 4, 0, VK_FORMAT_R16G16B16A16_SFLOAT};
 *   dplCreateVulkanComposer(context, &pass, &composer);
 *
 *   each frame, with slot = frame % DPL_VULKAN_SLOTS, after the fence of the last frame with this slot:
 *     vkBeginCommandBuffer(commands, ...);
 *     dplVulkanPrepare(context, commands, slot, &avatar, 1, views, viewCount, NULL);    outside a render pass
 *     vkCmdBeginRenderPass(commands, ...);  the program draws its scene
 *     dplVulkanCompose(context, composer, commands, slot, 0, 0, 0);                inside it
 *     vkCmdEndRenderPass(commands);
 *
 * What prepare and compose record. Prepare records compute passes and a draw into an image of Doppel's, with barriers of its own. Compose
 * records one draw of one triangle. Neither submits, waits, reads back or allocates, except that the first prepare of a new size, number
 * of views, number of samples or set of avatars makes its pipelines and buffers: do it while loading. It does not submit or wait either.
 *
 * Slots. A slot names what one frame in flight uses. With dplVulkanPrepare the program promises that all commands it recorded with the
 * slot before have run. Use the slots in turn. Objects destroyed in between, such as avatars, live on until then. Prepare notices a slot
 * that comes too early: the GPU writes a number behind the commands of prepare. It cannot notice that those of compose still run;
 * dplVulkanSubmit can.
 *
 * Loads. What dplStartLoad uploads is copied by the commands of prepare: at most 1 MiB a frame, from a staging ring of 5 MiB that the load
 * made when it began to upload. A frame that draws no avatar calls dplVulkanUpload instead. The load is ready once the GPU has run the last
 * copy; if frames stop, it waits. Only dplLoadAvatar, and dplFinishLoad of a load that is not ready, submit to `queue`.
 *
 * Queues. All commands with slots of one context go to one queue family, and to queues in the order in which they were prepared.
 *
 * Images. The colour attachment is in the layout that the render pass gives it; dplVulkanCompose reads and writes it as colour attachment,
 * by blending, and leaves depth attachments alone. dplVulkanComposeDepth tests and writes the depth attachment, which is in a layout for
 * writing such as VK_IMAGE_LAYOUT_DEPTH_STENCIL_ATTACHMENT_OPTIMAL: stages early and late fragment tests, access depth stencil attachment
 * read and write. Stencil is kept. Prepare reads the depth images given to it (DplVulkanSceneDepth). One of them may be that attachment,
 * because prepare has copied it when the pass begins: the program changes its layout in between, after compute shader reads. */
#ifndef DOPPEL_DOPPEL_VULKAN_H
#define DOPPEL_DOPPEL_VULKAN_H

#include <doppel/doppel.h>
#include <vulkan/vulkan_core.h>

#ifdef __cplusplus
extern "C" {
#endif

#define DPL_VULKAN_SLOTS 3u            /**< frames in flight */
#define DPL_VULKAN_DEPTH_COVERAGE 0.5f /**< alpha of the picture from which on a pixel writes depth */

/** A device that the program opened. It must have what dplGetVulkanRequirement lists as required. All handles must outlive the context. */
typedef struct DplVulkanDevice {
    uint32_t structSize;
    uint32_t queueFamily;                          /**< with VK_QUEUE_GRAPHICS_BIT and VK_QUEUE_COMPUTE_BIT */
    PFN_vkGetInstanceProcAddr getInstanceProcAddr; /**< NULL: of the machine's Vulkan loader */
    VkInstance instance;
    VkPhysicalDevice physicalDevice;
    VkDevice device;
    VkQueue queue; /**< of queueFamily. Used by dplVulkanSubmit, dplLoadAvatar, dplFinishLoad of a load that is not ready, dplRender,
                    * dplDraw and the self-test of DPL_FILL_AUTO; never by prepare and compose */
    /** The chain given to vkCreateDevice, so that Doppel knows which features are enabled. Read during the call. NULL: none. */
    const VkPhysicalDeviceFeatures2* enabledFeatures;
    const VkAllocationCallbacks* allocator; /**< for all objects of Doppel; copied. NULL: the driver's own */
    /** Called around each use of `queue`, from the thread that uses it. Both or neither; NULL: only Doppel uses the queue meanwhile. */
    void (*lockQueue)(void* user);
    void (*unlockQueue)(void* user);
    void* user;
} DplVulkanDevice;

/** What dplGetVulkanRequirement tells. */
typedef struct DplVulkanRequirement {
    uint32_t structSize;
    const char* name; /**< for example "VkPhysicalDeviceMultiviewFeatures::multiview". Static text */
    int required;     /**< DPL_FALSE: optional */
    const char* buys; /**< what Doppel does with it. Static text */
} DplVulkanRequirement;

/** What Doppel wants of a device, one by one. index: from 0; DPL_ERROR_NOT_FOUND behind the last. No extension is needed. */
DPL_API DplResult dplGetVulkanRequirement(uint32_t index, DplVulkanRequirement* requirement);

/** Creates a context that draws on the program's device. info: as for dplCreateContext; `renderer` and `threadCount` are not read. NULL:
 * all defaults. Free it with dplDestroyContext once no submitted commands of its slots can still run; that call waits for loads on other
 * threads. dplRender and dplDraw work on it too.
 * DPL_ERROR_INVALID_ARGUMENT: a handle is NULL. DPL_ERROR_UNSUPPORTED: the device is older than Vulkan 1.1, or the queue family lacks
 * graphics or compute. */
DPL_API DplResult dplCreateVulkanContext(const DplVulkanDevice* device, const DplContextInfo* info, DplContext* context);

/** Replaces a lost device. Once a call has met VK_ERROR_DEVICE_LOST, or commands of Doppel's that do not end, every call that draws, loads
 *  or makes a composer returns DPL_ERROR_DEVICE. A frame asks the device nothing, so the program may be the first to know, by its own
 *  vkQueueSubmit; it may call this function at any time.
 *
 *  Avatars, poses, detail and frame budget stay: the context keeps a copy of what it uploads, no more than DplFrameStats::avatarBytes of
 * each avatar. Slots are empty, and composers and targets are gone: make them again. After an error all is as before, and the call can be
 * repeated. device: of a context made with dplCreateVulkanContext, the new device; the old one is used no more once the function returns
 * DPL_OK, and submitted commands of its slots can no longer run by then. NULL: of a context made with dplCreateContext, which opens a
 * device itself. Uploads all avatars with submissions, and waits for them. Other threads wait meanwhile. DPL_ERROR_INVALID_ARGUMENT: the
 * other kind of context, or one that draws on the CPU. Other errors as dplCreateVulkanContext and dplCreateContext. */
DPL_API DplResult dplRebuildVulkan(DplContext context, const DplVulkanDevice* device);

/** The pass in which a composer draws: a subpass of a render pass, or dynamic rendering. It has one colour attachment.
 *
 *  The colour format says how light is stored. RGBA8 and BGRA8 as UNORM, and A2B10G10R10 as UNORM: display-referred values, blended as they
 *  are. RGBA8 and BGRA8 as SRGB, and RGBA16F: linear light. These are the formulas of DplImageFormat. */
typedef struct DplVulkanPass {
    uint32_t structSize;
    uint32_t subpass;
    VkRenderPass renderPass; /**< or a compatible one; needed until dplCreateVulkanComposer returns. VK_NULL_HANDLE: dynamic rendering */
    uint32_t viewMask;       /**< of the subpass. 0: no multiview, each view has a pass or an image of its own */
    uint32_t samples;        /**< of the attachments, 1 or 4. 0: 1 */
    uint32_t writesDepth;    /**< what dplVulkanComposeDepth writes here: 0, DPL_DRAW_DEPTH or DPL_DRAW_MESH_DEPTH (DplDrawFlag) */
    VkFormat colourFormat;
    VkFormat depthFormat, stencilFormat; /**< of attachments that the pass has as well; read for dynamic rendering only */
} DplVulkanPass;

/** Compiles what composes into a pass, so that no frame does. While a composer with writesDepth lives, prepare draws that depth too, so
 * make composers before the first prepare. *composer: a number for dplVulkanCompose. It lives until dplDestroyVulkanComposer or as long as
 * the context. DPL_ERROR_UNSUPPORTED: another format, sample count or view mask, or a context that is not on the program's device; the text
 * says which. */
DPL_API DplResult dplCreateVulkanComposer(DplContext context, const DplVulkanPass* pass, uint32_t* composer);

/** Commands that use it may still run; see "Slots". DPL_ERROR_NOT_FOUND: no such composer. */
DPL_API DplResult dplDestroyVulkanComposer(DplContext context, uint32_t composer);

/** Depth that the program has drawn behind one view. A splat adds nothing to a pixel if it lies behind. Pixels outside the image have no
 *  scene. With four samples a pixel, the farthest counts.
 *
 *  stored depth = scale + offset / z, with z > 0 the distance along the view axis in metres:
 *    usual, 0 at the near plane n and 1 at the far plane f    scale f/(f-n)    offset -f n/(f-n)
 *    usual, infinite far plane                                scale 1          offset -n
 *    reversed, 1 at n and 0 at f                              scale -n/(f-n)   offset f n/(f-n)
 *    reversed, infinite far plane                             scale 0          offset n */
typedef struct DplVulkanSceneDepth {
    uint32_t structSize;
    uint32_t layer;       /**< of the image view that this view uses */
    VkImageView image;    /**< VK_IMAGE_VIEW_TYPE_2D_ARRAY of the depth aspect alone, usage SAMPLED, 1 or 4 samples; D16, D24S8, D32F ... */
    VkImageLayout layout; /**< in which prepare finds and leaves it, such as VK_IMAGE_LAYOUT_DEPTH_STENCIL_READ_ONLY_OPTIMAL */
    uint32_t samples;     /**< of the image, 1 or 4. 0: 1 */
    int32_t x, y;         /**< place of the view's top left pixel in the image, pixels */
    float scale, offset;
} DplVulkanSceneDepth;

/** Draws the avatars in their current poses into the picture of a slot. Arguments as dplDrawTogether. The views have the size of the
 *  picture, which may be smaller than the program's target. dplSetDetail and dplSetFrameBudget hold here too; what prepare
 *  drew and cost (dplGetFrameStats, dplGetPassTime) is known when the slot comes round.
 *  commands: recording, outside a render pass, of the device's queue family.
 *  depths: viewCount of them, or NULL: DplCamera::sceneDepthM counts, which the CPU copies. The program makes their writes visible to
 *  VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT with VK_ACCESS_SHADER_READ_BIT before, and writes them again only after that stage.
 *  DPL_ERROR_INVALID_ARGUMENT: no such slot, one whose last commands have not run (wait for their fence, or dplVulkanDropSlot), NULL
 *  commands, a context that is not on the program's device, or a depth that says nothing (offset 0, not finite, no image) or is in a
 *  layout that no shader can read, such as that of an attachment that the program still writes. After an error
 *  the program may submit or drop the command buffer, and composes nothing of what was to be prepared. */
DPL_API DplResult dplVulkanPrepare(DplContext context, VkCommandBuffer commands, uint32_t slot, const DplAvatar* avatars,
                                   uint32_t avatarCount, const DplCamera* views, uint32_t viewCount, const DplVulkanSceneDepth* depths);

/** Prepares no picture, and records what loads have to upload (see "Loads"): instead of dplVulkanPrepare, in frames without avatars.
 *  commands and slot: as there. */
DPL_API DplResult dplVulkanUpload(DplContext context, VkCommandBuffer commands, uint32_t slot);

/** A buffer of the program's for posed splats, and its layout. Experimental. */
typedef struct DplVulkanBuffer {
    uint32_t structSize;
    uint32_t elementCount; /**< 1 to DPL_MAX_BUFFER_ELEMENTS */
    const DplBufferElement* elements;
    VkBuffer buffer; /**< usage STORAGE_BUFFER, of the device; exclusive to its queue family, or concurrent */
    uint64_t bytes;  /**< of the buffer, from its start; offsets of elements count from there */
} DplVulkanBuffer;

/** Records what dplWriteSplats does into the program's command buffer: the splats of the current pose go into the program's buffer, in its
 *  layout. Properties, options, number and order of splats are as there (doppel_posed.h), and for the same avatar and splatBudget the same
 *  on the CPU. Works whether or not the frame draws the avatar: the commands pose its mesh anew, because the one that prepare has posed
 *  lacks what its views do not see. So each write costs the pose of the mesh as well; write several properties in one call.
 *  commands, slot: as dplVulkanPrepare, after dplVulkanPrepare, dplVulkanUpload or dplVulkanSubmit of this frame with the same slot; in
 *  the same command buffer or in one that is submitted later. At most 16 writes of an avatar in a frame.
 *  buffer: NULL only counts; commands and slot are then not read.
 *
 *  What differs from dplWriteSplats, because a GPU stores whole words of four bytes:
 *  - offsetBytes and strideBytes, also the stride that 0 stands for, must be multiples of 4. So a property of halves begins a word; with
 *    an odd number of halves, the other half of its last word stays as it is, and must lie in the buffer.
 *  - Numbers too large for a half become 65504, but DplWritten::saturated is 0: only a wait for the GPU could tell.
 *  - Where the opacity is 0, other numbers are finite but may differ from those of the CPU.
 *  - All elements together lie within what the device binds at once, maxStorageBufferRange.
 *
 *  Barriers. The commands begin behind all earlier work of the queue in the stages COMPUTE_SHADER, VERTEX_SHADER, FRAGMENT_SHADER,
 *  DRAW_INDIRECT and TRANSFER: such reads and writes of the buffer need no barrier of the program's. They end with a barrier from
 *  COMPUTE_SHADER, SHADER_WRITE to the same stages, SHADER_READ, SHADER_WRITE, TRANSFER_READ and TRANSFER_WRITE. Other uses need one of
 *  the program's: VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT, VK_ACCESS_SHADER_WRITE_BIT to, for example, VERTEX_INPUT and
 *  VERTEX_ATTRIBUTE_READ, ACCELERATION_STRUCTURE_BUILD or HOST and HOST_READ; and before the next write, from the stage that read to
 *  COMPUTE_SHADER.
 *
 *  Allocates where an avatar is written for the first time in a slot, or once more often in a frame than before, with another splatBudget;
 *  do it while loading. Neither submits nor waits.
 *  DPL_ERROR_INVALID_ARGUMENT: as dplWriteSplats; also an offset or a stride that is no multiple of 4, a slot that was not begun, NULL
 *  commands or VkBuffer, a context that is not on the program's device. Nothing is then recorded. DPL_ERROR_UNSUPPORTED: elements too far
 *  apart for one binding. */
DPL_EXPERIMENTAL DplResult dplVulkanWriteSplats(DplAvatar avatar, VkCommandBuffer commands, uint32_t slot, const DplSplatOptions* options,
                                                const DplVulkanBuffer* buffer, DplWritten* written);

/** Says that the commands recorded with the slot have run or will never run, for example because their command buffer was reset. Needed
 *  before the next prepare with the slot only if they never ran. DPL_ERROR_INVALID_ARGUMENT: no such slot. */
DPL_API DplResult dplVulkanDropSlot(DplContext context, uint32_t slot);

/** Composes the picture of a view over the colour attachment; where the picture is empty, the attachment keeps its bits.
 *  commands: inside the composer's pass. It may be another command buffer than that of prepare if it runs later. view: which picture; with
 *  a view mask all are composed and it is not read. x, y: of the picture's top left corner in the attachment, pixels; may be negative.
 *  Changes the graphics pipeline, descriptor set 0, push constants, viewport and scissor.
 *  DPL_ERROR_INVALID_ARGUMENT: the slot was not prepared with that many views. DPL_ERROR_NOT_FOUND: no such composer. */
DPL_API DplResult dplVulkanCompose(DplContext context, uint32_t composer, VkCommandBuffer commands, uint32_t slot, uint32_t view, int32_t x,
                                   int32_t y);

/** Writes the depth of the picture of a view into the depth attachment of the pass. A pixel of the picture writes where its alpha is at
 *  least DPL_VULKAN_DEPTH_COVERAGE and its depth is nearer than what is stored; elsewhere, the attachment keeps its bits. All samples of a
 *  pixel get the same depth. Later draws and depth layers of a headset see the avatars then. Changes no colour; call it before or after
 *  dplVulkanCompose.
 *
 *  With DPL_DRAW_DEPTH it writes DplImage::depthM, the mean of the splats by opacity; prepare then blends a second image. With
 *  DPL_DRAW_MESH_DEPTH it writes DplImage::meshDepthM, the front of the posed mesh; prepare then rasterises the mesh, and general splats
 *  write nothing.
 *
 *  composer: with writesDepth. scale, offset: of the attachment, as in DplVulkanSceneDepth; offset below 0: less is nearer (usual), above
 * 0: greater is nearer (reversed). Stored depth is clamped to 0 ... 1. Other arguments, changed state and errors as dplVulkanCompose.
 *  DPL_ERROR_INVALID_ARGUMENT also: a composer without writesDepth, one that was made after the slot was prepared, or scale and offset that
 *  say nothing (offset 0, not finite). */
DPL_API DplResult dplVulkanComposeDepth(DplContext context, uint32_t composer, VkCommandBuffer commands, uint32_t slot, uint32_t view,
                                        int32_t x, int32_t y, float scale, float offset);

/* Prepare, compose and submission in one call, for programs that give Doppel a place in their queue rather than in their command buffers.
 * It has its own command buffers, one for each slot, and its own pass, which loads what the image holds. Both forms may be used by one
 * context, with different slots. */

/** Images of the program's to draw over: one for each view, or one array for all. All handles outlive the target. */
typedef struct DplVulkanTarget {
    uint32_t structSize;
    uint32_t imageCount;               /**< 1 or 2: the number of views; 1 with a view mask */
    VkImageView images[DPL_MAX_VIEWS]; /**< usage COLOR_ATTACHMENT. 2D; with a view mask a 2D array, layer = view */
    VkFormat format;                   /**< and what it means for light: as DplVulkanPass::colourFormat */
    uint32_t samples;                  /**< 1 or 4. 0: 1 */
    uint32_t viewMask;                 /**< 0: an image for each view. Else the feature multiview, as in DplVulkanPass */
    uint32_t widthPx, heightPx;        /**< of the images */
    VkImageLayout layoutBefore;        /**< in which each submission finds the images */
    VkImageLayout layoutAfter;         /**< in which it leaves them */
} DplVulkanTarget;

/** Makes the pass, framebuffers and pipelines of a target. *target: a number for dplVulkanSubmit. It lives until dplDestroyVulkanTarget or
 *  as long as the context; dplRebuildVulkan ends it. DPL_ERROR_UNSUPPORTED: as dplCreateVulkanComposer. DPL_ERROR_INVALID_ARGUMENT: no
 * image, no size, or a layout that keeps no pixels. */
DPL_API DplResult dplCreateVulkanTarget(DplContext context, const DplVulkanTarget* desc, uint32_t* target);

/** Submissions that use it may still run; see "Slots". The images may be destroyed once these have run. DPL_ERROR_NOT_FOUND: no such
 *  target. */
DPL_API DplResult dplDestroyVulkanTarget(DplContext context, uint32_t target);

/** What a submission waits for and signals. Read during the call. */
typedef struct DplVulkanSubmission {
    uint32_t structSize;
    int32_t x, y; /**< of the picture's top left corner in the images, pixels; may be negative */
    uint32_t waitCount;
    const VkSemaphore* waits;               /**< waitCount of them, binary or timeline */
    const VkPipelineStageFlags* waitStages; /**< waitCount of them: stages that wait. What composes needs COLOR_ATTACHMENT_OUTPUT, the
                                               scene's depth needs COMPUTE_SHADER */
    const uint64_t* waitValues;             /**< waitCount of them, not read for binary semaphores. NULL: all are binary */
    uint32_t signalCount;
    const VkSemaphore* signals;   /**< signalCount of them, signalled when the images are done */
    const uint64_t* signalValues; /**< signalCount of them, not read for binary semaphores. NULL: all are binary */
    VkFence fence;                /**< signalled when the images are done. VK_NULL_HANDLE: none */
} DplVulkanSubmission;

/** Draws the avatars over the images of a target, with one submission to DplVulkanDevice::queue, between lockQueue and unlockQueue. Other
 *  arguments, and what the first call of a size makes, as dplVulkanPrepare; a target of two images needs two views.
 *  In the order of the queue, nothing else needs a barrier for the images: the pass waits for all commands before, and all commands behind
 *  wait for it. Later calls neither allocate nor wait for the GPU.
 *  slot: as in "Slots". A slot whose last submission the GPU has not finished is DPL_ERROR_INVALID_ARGUMENT: wait for its fence or its
 *  semaphore, and call again.
 *  After any error nothing was submitted: no semaphore is waited for or signalled, the fence is unsignalled, and the slot may be
 *  used again, unless it is in flight.
 *  DPL_ERROR_NOT_FOUND: no such target. Other errors as dplVulkanPrepare, and what vkQueueSubmit returns. */
DPL_API DplResult dplVulkanSubmit(DplContext context, uint32_t target, uint32_t slot, const DplAvatar* avatars, uint32_t avatarCount,
                                  const DplCamera* views, uint32_t viewCount, const DplVulkanSceneDepth* depths,
                                  const DplVulkanSubmission* how);

#ifdef __cplusplus
}
#endif
#endif
