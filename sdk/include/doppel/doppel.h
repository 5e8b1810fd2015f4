// SPDX-License-Identifier: Apache-2.0
/* Doppel: load a person, pose them, draw them. The C API; C99 and C++.
 *
 *   DplContext context;  dplCreateContext(NULL, &context);
 *   DplAvatar avatar;    dplLoadAvatar(context, bytes, size, &avatar);
 *   dplSetPoseFromClip(avatar, 0, 1.25, DPL_TRUE);
 *   DplCamera camera = {sizeof camera, 512, 768, 900, 900, 256, 384, {1,0,0,0,  0,-1,0,1,  0,0,-1,3}};
 *   DplImage image = {sizeof image, 0, pixels, sizeof pixels};
 *   dplRender(context, avatar, &camera, 1, &image);
 *
 * Units and frames. Metres, seconds, radians, pixels. World and avatar: right-handed, +Y up; at rest the avatar stands at the
 * origin with its feet at y = 0, faces +Z, its left is +X. Quaternions are x, y, z, w. Cameras look along their +z, x right, y down.
 *
 * Threads. Every function may be called from any thread. Calls on one context and its avatars wait for one another; use one
 * context a thread to draw in parallel. dplLoadAvatar reads and converts without holding up other calls; they wait only while it
 * adds (on a GPU: uploads) the result. The text of dplGetLastError() belongs to the calling thread.
 *
 * Errors. Functions return DPL_OK or an error and write their outputs only on DPL_OK; dplGetLastError() then has a sentence for a
 * human. NULL where a pointer is needed, stale or foreign handles, sizes that do not fit and numbers that are not finite give
 * DPL_ERROR_INVALID_ARGUMENT, with a log line; nothing aborts and no C++ exception crosses this header.
 *
 * Growth. Structs begin with structSize: set it to sizeof the struct. Newer versions only add fields at the end; zero in an
 * added field means "as before". In arrays of structs all elements have the same structSize. */
#ifndef DOPPEL_DOPPEL_H
#define DOPPEL_DOPPEL_H

#include <stddef.h>
#include <stdint.h>

#if defined(DOPPEL_STATIC)
#define DPL_API
#elif defined(_WIN32)
#if defined(DOPPEL_BUILDING)
#define DPL_API __declspec(dllexport)
#else
#define DPL_API __declspec(dllimport)
#endif
#else
#define DPL_API __attribute__((visibility("default")))
#endif

/** Exported like DPL_API, but may still change before 1.0. */
#define DPL_EXPERIMENTAL DPL_API

#ifdef __cplusplus
extern "C" {
#endif

#define DPL_VERSION_MAJOR 0
#define DPL_VERSION_MINOR 1
#define DPL_VERSION_PATCH 0

/** Splats nearer to the camera than this are not drawn; they fade in up to DPL_NEAR_FADE_END_M. Metres. */
#define DPL_NEAR_LIMIT_M 0.05f
#define DPL_NEAR_FADE_END_M 0.15f
#define DPL_MAX_VIEWS 2u /**< views in one dplRender */
#define DPL_MAX_IMAGE_SIDE_PX 8192u
#define DPL_FALSE 0
#define DPL_TRUE 1

/** Opaque handles; 0 is no handle. They are numbers in disguise, never pointers: a stale one is detected. */
typedef struct DplContextHandle* DplContext;
typedef struct DplAvatarHandle* DplAvatar;

typedef enum DplResult {
    DPL_OK = 0,
    DPL_ERROR_INVALID_ARGUMENT = -1, /**< the call is wrong: fix the program */
    DPL_ERROR_NOT_FOUND = -2,        /**< a name or index that is not there */
    DPL_ERROR_CORRUPT_DATA = -3,     /**< the bytes are damaged or are not what they should be: get the file again */
    DPL_ERROR_VERSION = -4,          /**< the file is newer than this library: update the library */
    DPL_ERROR_UNSUPPORTED = -5,      /**< valid, but this build or machine does not do it */
    DPL_ERROR_OUT_OF_MEMORY = -6,
    DPL_ERROR_IO = -7,
    DPL_ERROR_DEVICE = -8,   /**< the graphics device failed or was lost: make a new context */
    DPL_ERROR_INTERNAL = -9, /**< a defect of this library: please report the text */
    DPL_RESULT_FORCE_INT32 = 0x7fffffff
} DplResult;

/** Version of the library that runs, major<<16 | minor<<8 | patch. Compare with the macros above to detect a mismatch. */
DPL_API uint32_t dplGetVersion(void);

/** The sentence of this thread's last failed call; "" when none failed. Valid until this thread's next call. Never NULL. */
DPL_API const char* dplGetLastError(void);

/** "DPL_ERROR_CORRUPT_DATA" for a code; "unknown result" for a number that is none. Static text. */
DPL_API const char* dplGetResultName(DplResult result);

/* ---------------------------------------------------------------- log */

typedef enum DplLogLevel {
    DPL_LOG_DEBUG = 0,
    DPL_LOG_INFO = 1,
    DPL_LOG_WARNING = 2,
    DPL_LOG_ERROR = 3,
    DPL_LOG_FORCE_INT32 = 0x7fffffff
} DplLogLevel;

/** text: UTF-8, not kept after the call. Called under a lock from any thread: do not call Doppel from it. */
typedef void (*DplLogCallback)(void* user, DplLogLevel level, const char* text);

/** Sends the library's log to `callback` (NULL: back to stderr, warnings and errors). For the whole process. */
DPL_API DplResult dplSetLogCallback(DplLogCallback callback, void* user);

/* ---------------------------------------------------------------- context */

typedef enum DplRenderer {
    DPL_RENDERER_AUTO = 0,     /**< a real GPU if there is one, else the CPU; never a GPU emulated on the CPU */
    DPL_RENDERER_SOFTWARE = 1, /**< the CPU */
    DPL_RENDERER_VULKAN = 2,   /**< Vulkan 1.1 on any device, an emulated one too; DPL_ERROR_UNSUPPORTED where there is none */
    DPL_RENDERER_FORCE_INT32 = 0x7fffffff
} DplRenderer;

/** How a GPU fills pixels. The pictures agree within the rounding of blending; the times do not. */
typedef enum DplFill {
    DPL_FILL_AUTO = 0,  /**< a self-test draws known pixels both ways on the device, and the faster right one is kept: once a process,
                           device, driver version and library */
    DPL_FILL_QUADS = 1, /**< one blended quad a splat; not tested */
    DPL_FILL_TILES = 2, /**< compute tiles that walk their splats front to back; a frame whose lists would overflow, or whose splats have a
                           low-pass below 0.076 px² (trained avatars: 1/12), is filled by quads; not tested */
    DPL_FILL_FORCE_INT32 = 0x7fffffff
} DplFill;

typedef struct DplContextInfo {
    uint32_t structSize;
    DplRenderer renderer;
    uint32_t threadCount;    /**< CPU threads, the caller's included; 0: one a core. At most 256. Pictures do not depend on it. */
    uint32_t flags;          /**< none is defined: 0 */
    DplFill fill;            /**< of GPUs; experimental */
    const char* cacheFolder; /**< an existing folder (UTF-8) that keeps what the self-test of DPL_FILL_AUTO found, one small file a device,
                                for the next process; NULL: not kept. Experimental */
} DplContextInfo;

/** Makes a context: a renderer and its threads. info NULL: all defaults. Free it with dplDestroyContext.
 *  DPL_ERROR_UNSUPPORTED: the wanted renderer is not in this build or finds no device. DPL_ERROR_DEVICE: DPL_RENDERER_VULKAN with
 * DPL_FILL_AUTO, and the device draws wrong pixels both ways; the text says how wrong. DPL_RENDERER_AUTO then draws on the CPU and logs
 * why. */
DPL_API DplResult dplCreateContext(const DplContextInfo* info, DplContext* context);

/** Frees a context. Its avatars stay valid handles for queries and poses, and are still to be destroyed; drawing them fails.
 *  0 does nothing and is DPL_OK. */
DPL_API DplResult dplDestroyContext(DplContext context);

/** What draws, for people: "software (2 threads)", "vulkan: NVIDIA H100 ... (tiles)". *name lives as long as the context. */
DPL_API DplResult dplGetRendererName(DplContext context, const char** name);

/* ---------------------------------------------------------------- avatars */

/** Loads an avatar (.glb) from memory, or general splats: 3D Gaussian splatting PLY, PlayCanvas compressed PLY, SPZ 2 to 4, .glb with
 *  KHR_gaussian_splatting; told apart by content. The bytes are copied or decoded; the caller may free them on return.
 *  *avatar is written only on DPL_OK; free it with dplDestroyAvatar. An avatar starts in its rest pose. General splats stand still in the
 *  coordinates of their file (many PLY files have y down), have no joints and no clips, and are drawn by the same dplRender.
 *  DPL_ERROR_CORRUPT_DATA: damaged file. DPL_ERROR_VERSION: the text names both versions. DPL_ERROR_UNSUPPORTED: a kind that is not
 *  drawn, or more splats than the device can bind; the text says what would help. */
DPL_API DplResult dplLoadAvatar(DplContext context, const uint8_t* data, size_t size, DplAvatar* avatar);

/** Frees an avatar. 0 does nothing and is DPL_OK. Before or after its context. */
DPL_API DplResult dplDestroyAvatar(DplAvatar avatar);

typedef struct DplAvatarInfo {
    uint32_t structSize; /**< set by the caller; fields beyond it are not written */
    const char* name;    /**< UTF-8; lives as long as the avatar */
    uint32_t jointCount; /**< 0: general splats, which cannot be posed */
    uint32_t splatCount;
    uint32_t vertexCount;
    uint32_t triangleCount;
    uint32_t layerCount;
    uint32_t clipCount; /**< grows by dplLoadClip */
    uint32_t shDegree;
    float restMin[3]; /**< box of the mesh at rest, metres; of general splats: of the middle 98 % of their centres along each axis */
    float restMax[3];
} DplAvatarInfo;

DPL_API DplResult dplGetAvatarInfo(DplAvatar avatar, DplAvatarInfo* info);

typedef struct DplJointInfo {
    uint32_t structSize;
    const char* name;         /**< lives as long as the avatar */
    const char* humanoidBone; /**< VRM humanoid name ("leftUpperArm") or ""; lives as long as the avatar */
    int32_t parent;           /**< index of the parent, which is smaller; -1: a root */
    float restPosition[3];    /**< metres, avatar space at rest */
} DplJointInfo;

/** joint < jointCount, else DPL_ERROR_NOT_FOUND. */
DPL_API DplResult dplGetJointInfo(DplAvatar avatar, uint32_t joint, DplJointInfo* info);

/** Index of the joint with this name, or with this humanoid bone if no joint has the name. DPL_ERROR_NOT_FOUND: the text lists the names.
 */
DPL_API DplResult dplFindJoint(DplAvatar avatar, const char* name, uint32_t* joint);

/* ---------------------------------------------------------------- poses and clips */

/** Poses the avatar. rotations: jointCount local quaternions (x, y, z, w), normalised here; joint frames are parallel to the
 *  world at rest, so the identity everywhere is the rest pose. rootTranslation: three floats, metres, or NULL for the origin.
 *  The arrays are copied. DPL_ERROR_INVALID_ARGUMENT: wrong joint count, or a rotation that is not finite or zero: the text
 *  names the joint; the old pose stays. Also for general splats, as in the other functions that pose. */
DPL_API DplResult dplSetPose(DplAvatar avatar, const float* rotations, uint32_t jointCount, const float* rootTranslation);

/** Copies the pose of the avatar: rotations of 4·jointCount floats and rootTranslation of 3 floats; either may be NULL. */
DPL_API DplResult dplGetPose(DplAvatar avatar, float* rotations, uint32_t jointCount, float* rootTranslation);

/** World positions of all joints in the present pose, 3·jointCount floats, metres. */
DPL_API DplResult dplGetJointPositions(DplAvatar avatar, float* positions, uint32_t jointCount);

typedef struct DplClipInfo {
    uint32_t structSize;
    const char* name; /**< lives as long as the avatar */
    double durationS;
    uint32_t keyCount;
} DplClipInfo;

/** clip < clipCount, else DPL_ERROR_NOT_FOUND. */
DPL_API DplResult dplGetClipInfo(DplAvatar avatar, uint32_t clip, DplClipInfo* info);

/** Poses the avatar by a clip at a time in seconds from its start. loop: the time wraps around; else it is clamped to the clip. */
DPL_API DplResult dplSetPoseFromClip(DplAvatar avatar, uint32_t clip, double timeS, int loop);

typedef enum DplClipFlag {
    DPL_CLIP_KEEP_LEAD_IN = 1, /**< keep the blend from a rest pose with which many BVH files begin; else those few frames are dropped */
    DPL_CLIP_KEEP_PLACE = 2,   /**< keep the place in the recorded room; else the clip starts above the origin */
    DPL_CLIP_IN_PLACE = 4,     /**< no horizontal travel at all: a treadmill */
    DPL_CLIP_FORCE_INT32 = 0x7fffffff
} DplClipFlag;

typedef struct DplClipOptions {
    uint32_t structSize;
    uint32_t flags;     /**< DplClipFlag, or-ed */
    const char* name;   /**< name of the new clip; NULL: the file's own, or "clip N" */
    uint32_t animation; /**< which animation of a glTF file with several; 0 for BVH */
} DplClipOptions;

/** Reads a motion (BVH text, or glTF/GLB with a skin and an animation) and retargets it onto this avatar by humanoid bone names.
 *  *clip: its index. The bytes are not kept; options may be NULL. Scale, rest pose and axes of the file may differ from the avatar's.
 *  DPL_ERROR_CORRUPT_DATA: damaged file. DPL_ERROR_UNSUPPORTED: the skeletons share too few bones; the text lists the joints. */
DPL_API DplResult dplLoadClip(DplAvatar avatar, const uint8_t* data, size_t size, const DplClipOptions* options, uint32_t* clip);

/* ---------------------------------------------------------------- drawing */

/** A pinhole camera in the OpenCV habit. (0,0) is the top left corner of the image: the first pixel's centre is (0.5, 0.5). */
typedef struct DplCamera {
    uint32_t structSize;
    uint32_t widthPx, heightPx; /**< 1 .. DPL_MAX_IMAGE_SIDE_PX; all views of one call have the same size */
    float fx, fy;               /**< focal lengths, pixels, > 0 */
    float cx, cy;               /**< principal point, pixels; off-axis frusta are welcome */
    float viewFromWorld[12];    /**< 3×4, row by row: X_view = R X_world + t with rows [R0 R1 R2 t]; R must be a rotation */
    const float* sceneDepthM;   /**< depth of what the app has drawn already: view z in metres of its opaque scene at the pixel centres of
                                   this view, tight rows; read during   the call. A splat adds nothing to a pixel where its centre's own view
                                   z   is larger; equal is seen. 0, less, infinite and NaN: nothing is   there. A depth buffer holds something
                                   else:   z = near·far / (far − d·(far − near)) for the usual d of 0 … 1. NULL: no scene */
    size_t sceneDepthCount;     /**< floats in sceneDepthM, at least widthPx·heightPx */
} DplCamera;

typedef enum DplImageFlag {
    DPL_IMAGE_STRAIGHT_ALPHA = 1, /**< colour divided by alpha; else premultiplied */
    DPL_IMAGE_OVER = 2, /**< composite over the premultiplied pixels that rgba holds; else over transparent black. Not with straight alpha:
                           an invalid argument */
    DPL_IMAGE_FORCE_INT32 = 0x7fffffff
} DplImageFlag;

/** What the pixels of an image mean. Avatars are blended in a layer of their own, 8 bits a channel and display-referred as they were
 * trained; the layer meets the image once, and the format says in which light. Alpha is linear in all of them. Where the layer is empty an
 * image that is drawn over keeps its bytes. */
typedef enum DplImageFormat {
    DPL_FORMAT_RGBA8 = 0, /**< 4 bytes a pixel, display-referred (sRGB) values that are blended as they are: a *_UNORM target of a
                             display-referred renderer */
    DPL_FORMAT_RGBA8_SRGB =
        1, /**< 4 bytes a pixel, blended in linear light: the layer is un-premultiplied, decoded by the sRGB curve and premultiplied, what
              the image holds is decoded, the sum encoded and rounded to the nearest code. What blending into a *_SRGB attachment gives */
    DPL_FORMAT_RGBA16F = 2, /**< 8 bytes a pixel, four IEEE halves of linear light (1 = display white, above it is kept): the layer is
                               un-premultiplied, decoded and premultiplied */
    DPL_FORMAT_FORCE_INT32 = 0x7fffffff
} DplImageFormat;

/** Where one view goes: the caller's memory, written row by row, top row first, during the call. Nothing is written unless the call returns
 * DPL_OK. */
typedef struct DplImage {
    uint32_t structSize;
    uint32_t flags;    /**< DplImageFlag, or-ed */
    uint8_t* rgba;     /**< pixels of `format`, R first, any alignment; NULL: not wanted */
    size_t rgbaBytes;  /**< size of rgba, at least heightPx·rowBytes */
    size_t rowBytes;   /**< bytes from row to row of rgba; 0: tight */
    float* depthM;     /**< view z in metres, weighted by what each splat adds to the pixel, tight rows, 0 where nothing is drawn; NULL: not
                          wanted */
    size_t depthCount; /**< floats in depthM, at least widthPx·heightPx */
    DplImageFormat format; /**< of rgba */
    float* meshDepthM; /**< view z in metres of the posed mesh's nearest surface at pixel centres, either side of it and whatever its splats
                          show there, tight rows, 0 where it has none beyond DPL_NEAR_LIMIT_M; NULL: not wanted. General splats have no
                          mesh: an invalid argument */
    size_t meshDepthCount; /**< floats in meshDepthM, at least widthPx·heightPx */
} DplImage;

/** Draws the avatar in its present pose into 1 or 2 views and returns when the pixels are in the caller's memory.
 *  views and images: viewCount elements each. An avatar belongs to the context it was loaded with; another is an invalid argument. */
DPL_API DplResult dplRender(DplContext context, DplAvatar avatar, const DplCamera* views, uint32_t viewCount, const DplImage* images);

/* dplRender in two halves, for programs that draw every frame: dplDraw never waits for pixels. */

typedef enum DplDrawFlag {
    DPL_DRAW_DEPTH = 1,      /**< depth too; needed when dplReadImages is to give it */
    DPL_DRAW_MESH_DEPTH = 2, /**< the same of DplImage::meshDepthM */
    DPL_DRAW_FORCE_INT32 = 0x7fffffff
} DplDrawFlag;

/** Starts drawing the avatar in its present pose and returns; on the CPU it draws here. From the fourth frame of a size, view count,
 *  flags and scene depth or none on it allocates nothing, and it waits only when three such frames are still being drawn
 * (DplFrameStats::waits). The pose and the views are copied. */
DPL_EXPERIMENTAL DplResult dplDraw(DplContext context, DplAvatar avatar, const DplCamera* views, uint32_t viewCount, uint32_t flags);

/** Waits for the avatar's last dplDraw and writes its pixels to the caller's memory. viewCount as there. DPL_ERROR_INVALID_ARGUMENT:
 * nothing was drawn yet, another viewCount, an image too small, or a depth that was not drawn. */
DPL_EXPERIMENTAL DplResult dplReadImages(DplContext context, DplAvatar avatar, const DplImage* images, uint32_t viewCount);

/* ---------------------------------------------------------------- several avatars in one picture */

#define DPL_MAX_TOGETHER 16u /**< avatars and sets of general splats in one picture */

/** dplRender of several avatars in one picture: their splats are sorted together, so they may stand close, hold hands and embrace. avatars:
 * avatarCount different ones of this context, 1 to DPL_MAX_TOGETHER, general splats among them; place them by their root translation. The
 * picture is the first one's: dplReadImages, dplGetFrameStats and dplGetPassTime of that avatar are about it. The context keeps what it
 * needs for the last four rows of avatars; a row is its avatars in their order. DPL_ERROR_UNSUPPORTED: together they have more splats than
 * the device can bind. */
DPL_EXPERIMENTAL DplResult dplRenderTogether(DplContext context, const DplAvatar* avatars, uint32_t avatarCount, const DplCamera* views,
                                             uint32_t viewCount, const DplImage* images);

/** dplDraw of several avatars in one picture. */
DPL_EXPERIMENTAL DplResult dplDrawTogether(DplContext context, const DplAvatar* avatars, uint32_t avatarCount, const DplCamera* views,
                                           uint32_t viewCount, uint32_t flags);

/* ---------------------------------------------------------------- level of detail */

/** How many splats are drawn of avatars and general splats that cover few pixels, or of many at once. Zeros: all of them, always. What is
 * left out is made up for by what is kept, which grows; all of it follows distance, pose and lens without steps, and both eyes of a frame
 * show the same splats. */
typedef struct DplDetail {
    uint32_t structSize;
    float splatsPerPixel; /**< of a surface, kept at least where a pixel covers more of them than that: DPL_DETAIL_USUAL (12) is hard to
                             tell from all, 6 is a little coarser; nearer, all are drawn, and the picture has the same bytes as without. 0:
                             no level of detail by distance. Counted at the point of the avatar nearest to the camera, for each of its
                             regions by its own density; of general splats, which may be a room about the camera, where each region of 128
                             comes nearest to it */
    uint32_t splatBudget; /**< of all that one call draws, whatever the views show of it: splatsPerPixel is lowered, for all alike, until
                             they fit. 0: no limit. Regions of general splats that lie behind the cameras do not count; at least one splat
                             of 128 is kept, even when the budget has no room for that */
} DplDetail;

#define DPL_DETAIL_USUAL 12.0f

/** For all drawing of this context from the next call on; may change with every frame and costs nothing to change. detail: copied; NULL: as
 * after creation, everything is drawn. DPL_ERROR_INVALID_ARGUMENT: splatsPerPixel is negative or not finite. Set a budget to hold a frame
 * rate with several avatars; set splatsPerPixel where people walk away from the camera. */
DPL_EXPERIMENTAL DplResult dplSetDetail(DplContext context, const DplDetail* detail);

/* ---------------------------------------------------------------- measuring */

/** What the avatar's last finished frame drew and cost. All but residentBytes is 0 before the first. */
typedef struct DplFrameStats {
    uint32_t structSize;
    uint32_t viewCount;
    uint32_t splatsDrawn; /**< that some view shows; the CPU draws view by view and gives the largest of them */
    uint32_t trianglesInView,
        trianglesFacing; /**< survivors on the GPU: triangles with splats that touch a view; of these, with splats not turned away */
    uint32_t splatsInView, splatsFacing; /**< the splats on them */
    uint32_t chunkCount,
        chunksProjected;    /**< runs of 128 neighbouring splats; those that have one left are projected. On the CPU these six are 0 */
    uint32_t passCount;     /**< of dplGetPassTime; 0 on the CPU and on GPUs without timestamps */
    uint64_t residentBytes; /**< held for all avatars and frames of the context by what draws: graphics memory, or memory on the CPU */
    uint64_t waits;         /**< since the context was made: how often drawing found three frames in flight and waited for the first */
    double gpuMs;           /**< GPU time of the frame, the sum over its passes; 0 without timestamps */
    uint64_t avatarBytes;   /**< of this avatar alone, whatever is drawn: splats, mesh, weights and pose correctives, on the CPU and the GPU
                               together */
    uint64_t splatBytes;    /**< of these: the splats */
    uint64_t bytesDecided, bytesDecoded; /**< of splat codes that the frame read: to tell which splats may show, and of those splats. On a
                                            GPU from survivors and layout */
    uint32_t tileEntries;                /**< splat-tile pairs of all views; 0 where quads or the CPU fill */
    uint32_t tilesOverflowed;            /**< 1: these did not fit, quads have filled this frame */
    uint32_t
        splatsAllowed; /**< of all that was drawn together: how many dplSetDetail left to draw at most, whatever the views show of them */
    float detailShare; /**< of this avatar's splats, 0 to 1: the same when it was drawn last, by itself or together */
    uint32_t componentCount, componentsInView; /**< head, trunk, hands, legs and garments of all that was drawn together; those that some
                                                  view may show. The others are not posed. 0 where nothing is culled */
} DplFrameStats;

/** Never waits for a frame that is still being drawn. */
DPL_EXPERIMENTAL DplResult dplGetFrameStats(DplAvatar avatar, DplFrameStats* stats);

typedef struct DplPassTime {
    uint32_t structSize;
    const char* label;   /**< "splat.project"; lives until the next dplGetFrameStats of the avatar */
    double milliseconds; /**< GPU time; a pass that runs in several rounds is listed once a round */
} DplPassTime;

/** pass < passCount of the last dplGetFrameStats of this avatar, else DPL_ERROR_NOT_FOUND; in the order in which they ran. */
DPL_EXPERIMENTAL DplResult dplGetPassTime(DplAvatar avatar, uint32_t pass, DplPassTime* time);

#ifdef __cplusplus
}
#endif
#endif
