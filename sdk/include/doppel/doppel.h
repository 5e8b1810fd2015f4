// SPDX-License-Identifier: Apache-2.0
/* Doppel: load a person, pose them, draw them. The C API; C99 and C++.
 *
 *   DplContext context;  dplCreateContext(NULL, &context);
 *   DplAvatar avatar;    dplLoadAvatarFile(context, "avatar.glb", &avatar);
 *   dplSetPoseFromClip(avatar, 0, 1.25, DPL_TRUE);
 *   DplCamera camera = {sizeof camera};
 *   dplCameraLookAt(eye, target, up, 0.8f, 512, 768, &camera);      (doppel_convert.h)
 *   DplImage image = {sizeof image, 0, pixels, sizeof pixels};
 *   dplRender(context, avatar, &camera, 1, &image);
 *
 * Units and frames. Lengths are metres, times seconds, angles radians, image positions pixels. World and avatar are right-handed,
 * +Y up. In avatar space, an avatar at rest stands at the origin with its feet at y = 0 and faces +Z; its left is +X. Poses are of avatar
 * space, which dplSetTransform places in the world; until then both are one. Quaternions are x, y, z, w.
 * A camera looks along its +z axis, with x to the right and y down.
 *
 * Threads. Every function may be called from any thread. Calls on the same context and its avatars wait for one another; only while
 * dplLoadAvatar, dplLoadAvatarFile and dplLoadClip read their bytes, and during loads in the background (dplStartLoad), do other calls go
 * on. To draw in parallel, give each thread its own context. The text of dplGetLastError() belongs to the calling thread.
 *
 * Errors. A function returns DPL_OK or an error code, and writes its outputs only on DPL_OK. After an error, dplGetLastError() has a
 * sentence for a human. These mistakes give DPL_ERROR_INVALID_ARGUMENT, and a line in the log if a callback receives it: NULL where a
 * pointer is needed, a destroyed or foreign handle, a size that does not fit, a number that is not finite. Nothing aborts, and no C++
 * exception leaves the library.
 *
 * Versions. A program runs with every later library of the same major version, without being built again: functions, numbers of enums and
 * fields of structs stay and keep their meaning. What a later minor version adds is new functions, new numbers that a program must ask for,
 * and new fields at the end of structs. Exempt is what is marked DPL_EXPERIMENTAL. Full rules: docs/reference/abi.md.
 *
 * Struct sizes. Structs begin with structSize: set it to sizeof the struct, and the rest to zero before you fill it. The library reads and
 * writes no byte beyond it. Zero in a field keeps the behaviour of the version before the field. A size below that of the struct's first
 * version, or above 4096, is DPL_ERROR_INVALID_ARGUMENT. A library that is older than the program ignores fields that it does not know. All
 * elements of an array of structs must have the same structSize. */
#ifndef DOPPEL_DOPPEL_H
#define DOPPEL_DOPPEL_H

#include <stddef.h>
#include <stdint.h>

/** Marks what the library exports. Define DOPPEL_STATIC where you link the static archive. */
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

/** Marks a function that is exported like DPL_API but may change in a minor version. */
#define DPL_EXPERIMENTAL DPL_API

#ifdef __cplusplus
extern "C" {
#endif

#define DPL_VERSION_MAJOR 1           /**< of these headers; the rules are above */
#define DPL_VERSION_MINOR 0           /**< of these headers */
#define DPL_VERSION_PATCH 0           /**< of these headers */
#define DPL_VERSION_TEXT "1.0.0-rc.1" /**< of these headers; a release candidate may still change where a test of it demands it */

/** Near plane, metres of view z. Nearer splats are not drawn; they fade in between here and DPL_NEAR_FADE_END_M. */
#define DPL_NEAR_LIMIT_M 0.05f
#define DPL_NEAR_FADE_END_M 0.15f   /**< from here on splats are drawn in full, metres of view z */
#define DPL_MAX_VIEWS 2u            /**< views in one drawing call */
#define DPL_MAX_IMAGE_SIDE_PX 8192u /**< width and height of a view */
#define DPL_FALSE 0                 /**< no, in arguments of type int */
#define DPL_TRUE 1                  /**< yes, in arguments of type int */

/** A renderer and its threads. Opaque, as all handles; NULL is no handle. Handles hold numbers, not addresses, so the library detects the
 * use of a destroyed one. */
typedef struct DplContextHandle* DplContext;
typedef struct DplAvatarHandle* DplAvatar;   /**< an avatar, or general splats */
typedef struct DplLoadHandle* DplLoad;       /**< a load in the background */
typedef struct DplTrackerHandle* DplTracker; /**< what turns frames of a platform into poses */

/** How a function ended. */
typedef enum DplResult {
    DPL_OK = 0,
    DPL_ERROR_INVALID_ARGUMENT = -1, /**< the call is wrong; fix the program */
    DPL_ERROR_NOT_FOUND = -2,        /**< there is no such name, index or file */
    DPL_ERROR_CORRUPT_DATA = -3,     /**< the bytes are damaged or of another kind; get the file again */
    DPL_ERROR_VERSION = -4,          /**< the file is newer than this library; update the library */
    DPL_ERROR_UNSUPPORTED = -5,      /**< valid, but this build or this machine cannot do it */
    DPL_ERROR_OUT_OF_MEMORY = -6,
    DPL_ERROR_IO = -7,       /**< a file cannot be read; the text says why */
    DPL_ERROR_DEVICE = -8,   /**< the graphics device failed or was lost; dplRebuildVulkan (doppel_vulkan.h) keeps the avatars */
    DPL_ERROR_INTERNAL = -9, /**< a defect of this library; please report the text */
    DPL_RESULT_FORCE_INT32 = 0x7fffffff
} DplResult;

/** Version of the loaded library: major<<16 | minor<<8 | patch. Compare it with the macros above to detect a mismatch. */
DPL_API uint32_t dplGetVersion(void);

/** Describes the last call that failed on this thread; "" if none has. Never NULL. Valid until the next call on this thread. */
DPL_API const char* dplGetLastError(void);

/** Name of a result code, such as "DPL_ERROR_CORRUPT_DATA"; "unknown result" for any other number. Static text. */
DPL_API const char* dplGetResultName(DplResult result);

/* ---------------------------------------------------------------- log */

/** How much a log line matters. */
typedef enum DplLogLevel {
    DPL_LOG_DEBUG = 0,
    DPL_LOG_INFO = 1,
    DPL_LOG_WARNING = 2,
    DPL_LOG_ERROR = 3,
    DPL_LOG_FORCE_INT32 = 0x7fffffff
} DplLogLevel;

/** Receives one log line. text is UTF-8 and valid only during the call. The library may call from any thread and holds a lock while it
 *  does: do not call Doppel from the callback. */
typedef void (*DplLogCallback)(void* user, DplLogLevel level, const char* text);

/** Sends the log of the whole process to `callback`. user is passed on to it. NULL restores the default: to stderr go the
 *  warnings and errors that no call returns. What a call returns is only there, and in dplGetLastError(). */
DPL_API DplResult dplSetLogCallback(DplLogCallback callback, void* user);

/* ---------------------------------------------------------------- context */

/** What draws. */
typedef enum DplRenderer {
    DPL_RENDERER_AUTO = 0,     /**< a GPU if there is one, else the CPU; never a GPU that is emulated on the CPU */
    DPL_RENDERER_SOFTWARE = 1, /**< the CPU */
    DPL_RENDERER_VULKAN = 2,   /**< Vulkan 1.1 on any device, also an emulated one; DPL_ERROR_UNSUPPORTED if there is none */
    DPL_RENDERER_METAL = 3,    /**< Metal, on the device of the system; DPL_ERROR_UNSUPPORTED if there is none */
    DPL_RENDERER_FORCE_INT32 = 0x7fffffff
} DplRenderer;

/** How a GPU fills pixels. The pictures agree within the rounding of blending; the times differ. */
typedef enum DplFill {
    /** A self-test draws a known picture both ways on the device. The faster of the correct ways is used. The test runs once in a process
     *  for each device, driver version and version of this library. */
    DPL_FILL_AUTO = 0,
    DPL_FILL_QUADS = 1, /**< one blended quad per splat; no self-test */
    /** A compute kernel walks the splats of each tile from front to back; no self-test. Quads fill a frame if its tile lists would
     *  overflow, or if its splats have a low-pass variance below 0.076 px² (trained avatars have 1/12). */
    DPL_FILL_TILES = 2,
    DPL_FILL_FORCE_INT32 = 0x7fffffff
} DplFill;

/** How dplCreateContext makes a context. */
typedef struct DplContextInfo {
    uint32_t structSize;
    DplRenderer renderer;
    uint32_t threadCount; /**< CPU threads including the caller's, at most 256; 0: one per core. Pictures do not depend on it. */
    uint32_t flags;       /**< 0: no flag is defined */
    DplFill fill;         /**< GPU only */
    /** An existing folder (UTF-8 path). The result of the self-test of DPL_FILL_AUTO is kept there for later processes, in one small file
     *  per device. NULL: the result is not kept. */
    const char* cacheFolder;
} DplContextInfo;

/** Creates a context, which owns a renderer and its threads. info NULL: all defaults. Free it with dplDestroyContext.
 *  DPL_ERROR_UNSUPPORTED: this build lacks the renderer, or it found no device.
 *  DPL_ERROR_DEVICE: the device failed, or the self-test of DPL_FILL_AUTO found wrong pixels both ways; the text says how wrong.
 *  DPL_RENDERER_AUTO uses the CPU in all these cases and logs the reason. */
DPL_API DplResult dplCreateContext(const DplContextInfo* info, DplContext* context);

/** Frees a context, after the frame that another thread may be drawing with it. Its avatars can still be queried and posed, but not drawn;
 *  they must still be destroyed. NULL does nothing and gives DPL_OK. */
DPL_API DplResult dplDestroyContext(DplContext context);

/** Names the renderer for people: "software (2 threads)", "vulkan: NVIDIA H100 ... (tiles)". *name lives as long as the context, or until
 *  dplRebuildVulkan. */
DPL_API DplResult dplGetRendererName(DplContext context, const char** name);

/* ---------------------------------------------------------------- avatars */

/** Loads an avatar (.glb) or general splats from memory and recognises the format by the content. General splats may be 3D Gaussian
 *  splatting PLY, PlayCanvas compressed PLY, SPZ 2 to 4, or .glb with KHR_gaussian_splatting.
 *  The library copies or decodes the bytes; the caller may free them on return. Free *avatar with dplDestroyAvatar.
 *  An avatar starts in its rest pose. General splats stand still, upright if their file says how it stands, else in its coordinates
 *  (dplGetFileAxes). They have no joints and no clips; the same functions draw them.
 *  DPL_ERROR_CORRUPT_DATA: damaged file. DPL_ERROR_VERSION: the text names the versions of file and library. DPL_ERROR_UNSUPPORTED: another
 *  kind of file, or more splats than the device can bind; the text says what would help. */
DPL_API DplResult dplLoadAvatar(DplContext context, const uint8_t* data, size_t size, DplAvatar* avatar);

/** dplLoadAvatar for a file. path: UTF-8, on Windows too. The file is read within the call and may be changed or removed afterwards.
 *  Errors about the file name it. DPL_ERROR_NOT_FOUND: there is no such file. DPL_ERROR_IO: it cannot be read, or is a folder, a pipe or a
 *  device. DPL_ERROR_CORRUPT_DATA: it is damaged or empty, or another program is writing it. DPL_ERROR_UNSUPPORTED: also a file above 4
 * GiB. DPL_ERROR_OUT_OF_MEMORY: also when there is none for its bytes. Otherwise as dplLoadAvatar. */
DPL_EXPERIMENTAL DplResult dplLoadAvatarFile(DplContext context, const char* path, DplAvatar* avatar);

/** Limits DplFrameStats::residentBytes: what the renderer holds in graphics memory, or in memory if it draws on the CPU. 0: no limit, as
 *  after creation. An avatar with which a load would exceed the limit is loaded with less: without the highest SH bands, and if that is not
 *  enough, with the splats that level of detail keeps longest, grown to make up for the others; at least 1/16 of them. The same happens
 *  when the GPU has no more memory, with or without a limit. DplAvatarInfo::fileSplatCount and fileShDegree tell; the log does too.
 *  Only if the least does not fit, the load fails with DPL_ERROR_OUT_OF_MEMORY.
 *  Holds from the next load on; what is loaded stays. Pictures are made whatever the limit, and a load takes up to 8 MiB more while it
 * uploads, so leave room: residentBytes of a context that draws shows how much. */
DPL_API DplResult dplSetMemoryLimit(DplContext context, uint64_t bytes);

/* dplLoadAvatar in steps, for programs whose frames must go on. A thread of the library reads the file.
 *
 *   dplStartLoad ─► each frame dplGetLoadStatus, until DPL_LOAD_READY or DPL_LOAD_FAILED ─► dplFinishLoad        or dplCancelLoad
 *
 * A context runs its loads one after the other. */

/** How far a load is. */
typedef enum DplLoadState {
    DPL_LOAD_WAITING = 0,  /**< for earlier loads of the context */
    DPL_LOAD_DECODING = 1, /**< the file is read and converted */
    /** The avatar goes to the GPU in slices of up to 1 MiB. A context made with dplCreateContext submits them itself, one at a time,
     * between its frames. On a device of the program they are part of the program's frames: see "Loads" in doppel_vulkan.h. */
    DPL_LOAD_UPLOADING = 2,
    DPL_LOAD_READY = 3,  /**< dplFinishLoad gives the avatar and does not wait */
    DPL_LOAD_FAILED = 4, /**< dplFinishLoad gives the error and does not wait */
    DPL_LOAD_FORCE_INT32 = 0x7fffffff
} DplLoadState;

/** What dplStartLoad loads. */
typedef struct DplLoadInfo {
    uint32_t structSize;
    const uint8_t* data; /**< the file, as for dplLoadAvatar. Not copied: it must stay until `release` is called */
    size_t size;
    /** Called once, when `data` is needed no more: after decoding, or when the load fails or is cancelled. It runs on a thread of the
     * library or within a call about this load or its context. Do not call Doppel from it. NULL: `data` stays for the life of the context.
     */
    void (*release)(void* user);
    void* user; /**< passed on to release */
} DplLoadInfo;

/** Starts to load a file and returns at once. End the load with dplFinishLoad or dplCancelLoad, before or after its context.
 *  dplDestroyContext lets loads fail that are not ready, and waits until they have noticed. dplRebuildVulkan waits while a load converts a
 *  file for the GPU (up to a second for 500,000 splats) and uploads what loads have begun to upload; a load that meets a lost device waits
 * for it.
 */
DPL_API DplResult dplStartLoad(DplContext context, const DplLoadInfo* info, DplLoad* load);

/** What dplGetLoadStatus tells. */
typedef struct DplLoadStatus {
    uint32_t structSize;
    DplLoadState state;
    /** Part of the work that is done, 0 to 1; it never falls. Up to 0.5 the file is read, up to 0.7 converted, then uploaded. 1 only when
     * the load is ready. */
    float progress;
} DplLoadStatus;

/** How far a load is. Waits for nothing. */
DPL_API DplResult dplGetLoadStatus(DplLoad load, DplLoadStatus* status);

/** Ends a load and gives its avatar, or the error of the load: codes and texts are those of dplLoadAvatar. `load` is gone afterwards,
 * unless avatar is NULL. If the load is neither ready nor failed, this goes on as dplLoadAvatar does and waits, also while another thread
 * draws; then the rest is uploaded with submissions. */
DPL_API DplResult dplFinishLoad(DplLoad load, DplAvatar* avatar);

/** Drops a load in any state and does not wait for its thread, which gives back `data` and all memory at its next step: within 0.3 s for
 *  500,000 splats. Of a ready load, frees the avatar as dplDestroyAvatar does. NULL does nothing and gives DPL_OK. */
DPL_API DplResult dplCancelLoad(DplLoad load);

/** Frees an avatar, before or after its context. NULL does nothing and gives DPL_OK. */
DPL_API DplResult dplDestroyAvatar(DplAvatar avatar);

/** What dplGetAvatarInfo tells. */
typedef struct DplAvatarInfo {
    uint32_t structSize; /**< set by the caller; the library writes no field beyond this size */
    const char* name;    /**< UTF-8; lives as long as the avatar */
    uint32_t jointCount; /**< 0: general splats, which cannot be posed */
    uint32_t splatCount;
    uint32_t vertexCount;
    uint32_t triangleCount;
    uint32_t layerCount;
    uint32_t clipCount; /**< dplLoadClip adds one */
    uint32_t shDegree;  /**< highest degree of the spherical harmonics; 0: the colour does not depend on the direction */
    /** Bounding box of the mesh at rest, metres, avatar space. General splats: the middle 98 % of their centres, at least 3 deviations. */
    float restMin[3];
    float restMax[3];
    /** What the file holds. If memory was short, splatCount or shDegree is lower: see dplSetMemoryLimit. */
    uint32_t fileSplatCount, fileShDegree;
} DplAvatarInfo;

/** Tells of an avatar or of general splats. */
DPL_API DplResult dplGetAvatarInfo(DplAvatar avatar, DplAvatarInfo* info);

/** What dplGetFileAxes tells. */
typedef struct DplFileAxes {
    uint32_t structSize;
    /** DPL_TRUE: the file, or the standard of its format, says how it stands (avatars: y up). DPL_FALSE: nobody does, and general splats
     *  keep the coordinates of their file; in many PLY files y points down. */
    uint32_t stated;
    /** How loading turned the file upright, for programs that let people say otherwise (dplSetTransform): 3 columns. Orthogonal; of
     * determinant -1 if the file's axes are mirrored. The identity if nothing is stated. */
    float loadedFromFile[9];
} DplFileAxes;

/** Tells how the file of an avatar or of general splats stands. */
DPL_EXPERIMENTAL DplResult dplGetFileAxes(DplAvatar avatar, DplFileAxes* axes);

/** What dplGetJointInfo tells. */
typedef struct DplJointInfo {
    uint32_t structSize;
    const char* name;         /**< lives as long as the avatar */
    const char* humanoidBone; /**< VRM humanoid name ("leftUpperArm") or ""; lives as long as the avatar */
    int32_t parent;           /**< index of the parent, always smaller than the joint's own; -1: a root */
    float restPosition[3];    /**< metres, avatar space at rest */
} DplJointInfo;

/** joint: 0 to jointCount - 1, else DPL_ERROR_NOT_FOUND. */
DPL_API DplResult dplGetJointInfo(DplAvatar avatar, uint32_t joint, DplJointInfo* info);

/** Finds a joint by its name, or else by its humanoid bone. DPL_ERROR_NOT_FOUND: the text lists all names. */
DPL_API DplResult dplFindJoint(DplAvatar avatar, const char* name, uint32_t* joint);

/* ---------------------------------------------------------------- where it stands */

/** Places an avatar or general splats in the world; after the pose, in every picture from now on, until it is changed.
 *  worldFromAvatar: a 3×4 matrix, row by row, 12 floats, copied: X_world = s R X_avatar + t with rows [sR0 sR1 sR2 t]. R is a rotation,
 *  s one scale of 0.001 to 1000, t a translation in metres of at most 100 km. NULL: the identity, as after loading.
 *  The picture is that of a camera which was moved the other way. Pose, trust, what clothes remember and what keeps splats from
 *  stretching do not know of it. Depths, the near plane and its fade stay in metres of the world. Level of detail goes by the size in
 *  the world. It may change every frame at no cost.
 *  DPL_ERROR_INVALID_ARGUMENT: a number that is not finite, a mirror, a shear, more than one scale (each beyond 0.1 %), or a scale or
 *  translation out of range. The previous transform then stays. */
DPL_EXPERIMENTAL DplResult dplSetTransform(DplAvatar avatar, const float* worldFromAvatar);

/** Copies the current transform: 12 floats, as they were given. */
DPL_EXPERIMENTAL DplResult dplGetTransform(DplAvatar avatar, float* worldFromAvatar);

/* ---------------------------------------------------------------- poses and clips */

/** Poses the avatar; the arrays are copied.
 *  rotations: one local quaternion (x, y, z, w) per joint; the library normalises them. Joint frames are parallel to the world at rest, so
 *  the identity at every joint is the rest pose. rootTranslation: three floats, metres, avatar space; NULL: zero.
 *  DPL_ERROR_INVALID_ARGUMENT: wrong jointCount, general splats, a rotation that is zero or not finite (the text names the joint), or a
 *  root translation beyond 100 km. The previous pose then stays. */
DPL_API DplResult dplSetPose(DplAvatar avatar, const float* rotations, uint32_t jointCount, const float* rootTranslation);

/** The same for a picture that is shown at timeNs: nanoseconds of any one clock, such as that of a tracker. Clothes then remember: a shirt
 *  that rode up stays up for a while after the arms have come down. What they remember goes on once, when the pose is drawn, from the
 *  pose that was drawn before; several poses between two pictures, or one pose for two pictures, change nothing. After a gap of more than
 *  5 s, or when time runs backwards, it fades within 0.25 s. dplSetPoseFromTracker does the same with its displayTimeNs. dplSetPose
 *  knows no time: the clothes are those of the pose alone, and the same pose gives the same picture. In a clip they remember the clip. */
DPL_EXPERIMENTAL DplResult dplSetPoseAtTime(DplAvatar avatar, const float* rotations, uint32_t jointCount, const float* rootTranslation,
                                            int64_t timeNs);

/** Clothes forget: they are those of the current pose alone, as after dplSetPose. DPL_ERROR_INVALID_ARGUMENT: general splats. */
DPL_EXPERIMENTAL DplResult dplSettle(DplAvatar avatar);

/** Copies what the clothes remember in the current pose, and its time, for a save or another machine: *size bytes, at most 8192, which
 *  mean nothing to the program. state NULL: only *size is written. DPL_ERROR_INVALID_ARGUMENT: a smaller capacity, or general splats. */
DPL_EXPERIMENTAL DplResult dplGetMotionState(DplAvatar avatar, uint8_t* state, size_t capacity, size_t* size);

/** Restores it: poses that follow in time are drawn as they would have been after the one that was saved. An avatar of the same file
 *  takes it. DPL_ERROR_INVALID_ARGUMENT: other bytes, or those of another avatar; what is remembered then stays. */
DPL_EXPERIMENTAL DplResult dplSetMotionState(DplAvatar avatar, const uint8_t* state, size_t size);

/** How stiff the clothes are, until it is changed: 0 to 100; 1 as learned, and the same picture as without this call. It scales all that
 *  they do of motion, such as a swing, a lag or a ride up, by 2/(1 + stiffness): 3 halves it, 100 leaves next to nothing, 0 doubles it, but
 *  to no more than 1.3 times the largest of training. What they remember, and for how long, stays as it is, and so do offsets that follow
 *  the pose alone. Nothing changes for an avatar whose clothes learned no motion. The motion state does not hold it.
 *  DPL_ERROR_INVALID_ARGUMENT: out of range or not a number, or general splats. The previous stiffness then stays. */
DPL_EXPERIMENTAL DplResult dplSetClothStiffness(DplAvatar avatar, float stiffness);

/* ---------------------------------------------------------------- expressions */

/** How many expressions there are: ARKit's, by its names and in its order, "eyeBlinkLeft" to "tongueOut". Left is the subject's left. */
#define DPL_EXPRESSION_COUNT 52

/** One of the expressions. */
typedef struct DplExpressionInfo {
    uint32_t structSize;
    const char* name; /**< "mouthSmileLeft" ...; lives as long as the library */
    uint32_t drawn;   /**< DPL_TRUE: this avatar holds it; otherwise its weight changes nothing */
} DplExpressionInfo;

/** expression: 0 to DPL_EXPRESSION_COUNT - 1, else DPL_ERROR_NOT_FOUND. */
DPL_EXPERIMENTAL DplResult dplGetExpressionInfo(DplAvatar avatar, uint32_t expression, DplExpressionInfo* info);

/** Finds an expression by its name; the first letter may be a capital one. DPL_ERROR_NOT_FOUND: the text may name what
 *  was meant. It does not depend on the avatar. */
DPL_EXPERIMENTAL DplResult dplFindExpression(const char* name, uint32_t* expression);

/** Sets the face, until it is changed: beside the pose, which does not touch it. weights: DPL_EXPRESSION_COUNT numbers, copied; 0 is not at
 *  all, 1 fully. Numbers beyond that are taken as 0 or 1, as trackers overshoot a little. All zero: the same picture as without this call.
 *  An avatar without expressions takes them and does not change.
 *  DPL_ERROR_INVALID_ARGUMENT: another count, general splats, or a weight that is not a number (the text names it). The previous
 *  expression then stays. */
DPL_EXPERIMENTAL DplResult dplSetExpression(DplAvatar avatar, const float* weights, uint32_t count);

/** The same from a stream of another program, by its names. names: `count` of them, at most 1024: ARKit's, also as "eyeBlink_L", which are
 *  its raw values in Swift; MediaPipe's, of which `_neutral` says nothing; Live Link's, whose nine angles are left out; VRM's ("happy",
 *  "aa" ..., and VRM 0's "joy", "a" ...), mixtures of ARKit's; or OpenXR's ("JAW_DROP" or "XR_FACE_EXPRESSION2_JAW_DROP_FB" ...). What
 *  several move is added up and held in 0 to 1. names NULL: count must be 52 (ARKit's order), 61 (Live Link's), 63 or 70 (weights of
 *  XR_FB_face_tracking and XR_FB_face_tracking2).
 *  DPL_ERROR_INVALID_ARGUMENT also: another count without names, or an unknown name (the text names it). */
DPL_EXPERIMENTAL DplResult dplSetExpressionNamed(DplAvatar avatar, const char* const* names, const float* weights, uint32_t count);

/** Copies what the face shows: DPL_EXPRESSION_COUNT numbers, 0 to 1. It is the expression that was set, what dplSetFaceMotion adds, and
 * eyes within their limits: where the pose turns joints of eyes, they come first, and weights of eyeLook* take what is left of 0.6 rad to
 * the side and 0.4 rad up or down. */
DPL_EXPERIMENTAL DplResult dplGetExpression(DplAvatar avatar, float* weights, uint32_t count);

/** What a face does by itself, beside the expression that is set. All zeros: nothing. Experimental. */
typedef struct DplFaceMotion {
    uint32_t structSize;
    uint32_t seed;   /**< of the times of blinks and glances: people of one seed blink together */
    int64_t heardNs; /**< when a stream gave the expression, by the clock of timeNs; ignored if holdS is 0 */
    /** A stream that is silent for so long has stopped: what it set fades to neutral within 0.25 s from then on, and is back when it speaks
     *  again. 0 to 3600 s; 0.3 is usual. 0: what was set stays. */
    float holdS;
    float blinks;  /**< 0: none. 1: as people at rest do, about 17 a minute. Between: the lids close so far */
    float glances; /**< 0: none. 1: the eyes wander by up to 5 degrees. Between: so much of it. For eyes that no stream moves */
} DplFaceMotion;

/** Says what the face does by itself, and at which time the next picture is shown. Call it for each picture, in any order with other calls.
 *  Blinks and glances are functions of seed and time alone: the same picture follows from the same arguments, whatever the frame rate, and
 *  after a jump. They are added to what is set, and weights stay in 0 to 1. The pose stays: eyes that look at a point (dplLookAtPoint) keep
 *  doing so, and glances come on top. Without this call, or with zeros, the face shows what is set: the same bytes.
 *  timeNs: nanoseconds of any clock. The motion state does not hold it. An avatar without expressions takes it and does not change.
 *  DPL_ERROR_INVALID_ARGUMENT: a number that is not finite or out of range (the text names it), or general splats. The face then stays. */
DPL_EXPERIMENTAL DplResult dplSetFaceMotion(DplAvatar avatar, const DplFaceMotion* motion, int64_t timeNs);

/* ---------------------------------------------------------------- the pose that is set, and trust in it */

/** Copies the current pose: 4·jointCount floats to rotations, 3 floats to rootTranslation. Either may be NULL. */
DPL_API DplResult dplGetPose(DplAvatar avatar, float* rotations, uint32_t jointCount, float* rootTranslation);

/** World positions of all joints in the current pose and transform: 3·jointCount floats, metres. */
DPL_API DplResult dplGetJointPositions(DplAvatar avatar, float* positions, uint32_t jointCount);

/** What dplGetPoseTrust tells. */
typedef struct DplPoseTrust {
    uint32_t structSize;
    /** Share of the pose-dependent offsets and brightness that is drawn, 0 to 1. Below 1 the pose lies outside the trained ones. */
    float offsets;
    float away;             /**< distance from the mean trained pose over its limit, along what varied in training; above 1: outside */
    float offModes;         /**< distance from all that varied in training, over its limit; above 1: outside */
    uint32_t farthestJoint; /**< the joint with the largest distance */
    float farthestDistance;
} DplPoseTrust;

/** How far the current pose lies from the poses that the avatar was trained on, so that a program can warn, or hold a pose back.
 *  distances: jointCount floats, or NULL. Each is the distance of a joint's rotation from its mean in training, in standard deviations (of
 *  at least 3 degrees): up to 2 is usual, above 4 was hardly seen. -1: the avatar does not know, as of hips, hands, fingers and toes.
 *  DPL_ERROR_UNSUPPORTED: the avatar has no pose correctives, and with them no record of its training poses.
 *  DPL_ERROR_INVALID_ARGUMENT: wrong jointCount (ignored if distances is NULL), or general splats. */
DPL_API DplResult dplGetPoseTrust(DplAvatar avatar, DplPoseTrust* trust, float* distances, uint32_t jointCount);

/** What dplGetCaptureDetail tells of the surface that a joint moves. Four sides each, at rest: front (+Z), left (+X), back (-Z), right
 * (-X). 0: the scan's pictures do not show that side, or the file has no capture map. */
typedef struct DplCaptureDetail {
    uint32_t structSize;
    float pixelM[4];   /**< size of a picture's pixel on the surface, metres */
    float detailM[4];  /**< size of the finest detail that the pictures show, metres; larger than pixelM where they are blurred */
    uint32_t views[4]; /**< still pictures that look at it at less than 60 degrees to its normal; 255: that many or more */
} DplCaptureDetail;

/** How finely the scan that an avatar was made from shows it. Files that `doppel reconstruct` writes know it; for others all is 0.
 *  joint: 0 to jointCount - 1, else DPL_ERROR_NOT_FOUND. */
DPL_API DplResult dplGetCaptureDetail(DplAvatar avatar, uint32_t joint, DplCaptureDetail* detail);

/** The nearest distance, metres, from which a detail that the scan's pictures just show is drawn over `magnification` pixels: nearer, the
 *  avatar only grows larger. A viewer may keep its camera at least so far from `point`.
 *  point: three floats, metres, world: what the camera looks at, on or in the avatar in its current pose and transform; the joint nearest
 * to it decides. eye: where the camera is; only its direction from the point counts. focalPx: focal length in pixels of the picture.
 *  *distanceM is 0 when the file has no capture map, and for general splats.
 *  DPL_ERROR_INVALID_ARGUMENT: numbers that are not finite, focalPx or magnification not above 0, or NULL. */
DPL_API DplResult dplGetNearestDistance(DplAvatar avatar, const float* point, const float* eye, float focalPx, float magnification,
                                        float* distanceM);

/** Turns joints of the current pose back towards their mean in training, until no distance of dplGetPoseTrust exceeds `limit`, or as far as
 *  the mean. Other joints and the root stay. 4 keeps nearly all of what was seen and stops what never was.
 *  DPL_ERROR_UNSUPPORTED: no pose correctives. DPL_ERROR_INVALID_ARGUMENT: a limit that is not above 0 and finite, or general splats. */
DPL_API DplResult dplHoldPose(DplAvatar avatar, float limit);

/** What dplGetClipInfo tells. */
typedef struct DplClipInfo {
    uint32_t structSize;
    const char* name; /**< lives as long as the avatar */
    double durationS;
    uint32_t keyCount;
} DplClipInfo;

/** clip: 0 to clipCount - 1, else DPL_ERROR_NOT_FOUND. */
DPL_API DplResult dplGetClipInfo(DplAvatar avatar, uint32_t clip, DplClipInfo* info);

/** Poses the avatar as a clip does at timeS, in seconds from the start of the clip. loop DPL_TRUE: the time wraps around; DPL_FALSE: it is
 *  clamped to the clip. DPL_ERROR_NOT_FOUND: no such clip. DPL_ERROR_INVALID_ARGUMENT: timeS is not finite, or general splats. */
DPL_API DplResult dplSetPoseFromClip(DplAvatar avatar, uint32_t clip, double timeS, int loop);

/** Flags of DplClipOptions. */
typedef enum DplClipFlag {
    /** Keeps the frames of up to 0.1 s in which many BVH files blend from a rest pose into the motion. Otherwise they are dropped. */
    DPL_CLIP_KEEP_LEAD_IN = 1,
    DPL_CLIP_KEEP_PLACE = 2, /**< keeps the place in the recorded room; otherwise the clip starts above the origin */
    DPL_CLIP_IN_PLACE = 4,   /**< removes all horizontal travel, as on a treadmill */
    /** Bones point exactly where those of the recording do. Otherwise the head of a person who walks is levelled by a constant, feet
     *  that stand are held in place, and arms are kept out of the body; docs/reference/driving.md. */
    DPL_CLIP_AS_RECORDED = 8,
    DPL_CLIP_FORCE_INT32 = 0x7fffffff
} DplClipFlag;

/** How dplLoadClip reads a motion. */
typedef struct DplClipOptions {
    uint32_t structSize;
    uint32_t flags;            /**< DplClipFlag, combined by | */
    const char* name;          /**< name of the new clip; NULL: the name in the file, or "clip N" */
    uint32_t animation;        /**< index of the animation in a glTF file; 0 for BVH */
    const char* animationName; /**< name of the animation in a glTF file, or else its number; NULL: by `animation` */
} DplClipOptions;

/** Reads a motion (BVH text, or GLB with an animation) and retargets it onto this avatar by humanoid bones: those that the file states
 *  (VRM), or by the names and the shape of its skeleton. Scale, rest pose and axes of the file may differ from the avatar's. The bytes are
 *  not kept. options may be NULL. *clip: index of the new clip. What was chosen, left out or is lacking is a warning in the log.
 *  DPL_ERROR_CORRUPT_DATA: damaged file. DPL_ERROR_NOT_FOUND: no such animation in the file. DPL_ERROR_UNSUPPORTED: another kind of file,
 *  or too few bones in common; the text lists joints. DPL_ERROR_INVALID_ARGUMENT: general splats, which have no joints. */
DPL_API DplResult dplLoadClip(DplAvatar avatar, const uint8_t* data, size_t size, const DplClipOptions* options, uint32_t* clip);

/* ---------------------------------------------------------------- several clips, and looking at a point */

/* Walk and wave: layers of clips are mixed into one pose. The program says at each picture which clips play, at which time and with which
 * weight; doppel::Player of doppel.hpp does so for play, pause, speed, loops and cross-fades. Formulas: docs/reference/mixing.md. */

/** Flags of DplClipLayer. */
typedef enum DplLayerFlag {
    DPL_LAYER_LOOP = 1, /**< the time wraps around; otherwise it is clamped to the clip */
    /** With DPL_LAYER_LOOP: each round starts where the root stood at the end of the round before, so a recorded walk goes on. */
    DPL_LAYER_TRAVEL = 2,
    DPL_LAYER_FORCE_INT32 = 0x7fffffff
} DplLayerFlag;

#define DPL_MAX_CLIP_LAYERS 64u /**< layers in one mix */

/** A clip within a mix. Experimental. */
typedef struct DplClipLayer {
    uint32_t structSize;
    uint32_t clip;  /**< 0 to clipCount - 1 of the avatar */
    double timeS;   /**< seconds from the start of the clip */
    float weight;   /**< 0 or more */
    uint32_t joint; /**< the layer moves this joint and all below it (dplFindJoint); 0: the whole body, and where it stands */
    uint32_t flags; /**< DplLayerFlag, combined by | */
    /** Moves the whole clip: it is turned about the vertical (a quarter turn takes +Z to +X), then shifted along x and z, metres.
     *  dplJoinClipLayer finds them. All 0: as it is. */
    float headingRad;
    float shiftM[2];
} DplClipLayer;

/** Poses the avatar by a mix of 1 to DPL_MAX_CLIP_LAYERS layers for a picture that is shown at timeNs. Clothes remember by these times, as
 *  with dplSetPoseAtTime. The pose is a function of the layers alone: one layer of the whole body gives what dplSetPoseFromClip does.
 *  Layers of the same joint that follow one another cross-fade: each counts by its share of their weights. Those of the whole body
 *  (joint 0) come first. Layers after them replace their part of the body by the sum of their weights, at most 1, so a wave of weight 1 on
 *  "rightUpperArm" hides the walk there, and one of 0.5 meets it halfway. Joints turn the shorter way.
 *  DPL_ERROR_NOT_FOUND: no such clip or joint. A clip is of the avatar that loaded it: load it onto each avatar that plays it.
 *  DPL_ERROR_INVALID_ARGUMENT: a number that is not finite, a weight below 0, weights of the whole body that sum to 0, unknown flags,
 *  general splats. The text names the layer by its number; the previous pose stays. */
DPL_EXPERIMENTAL DplResult dplSetPoseFromClips(DplAvatar avatar, const DplClipLayer* layers, uint32_t layerCount, int64_t timeNs);

/** Sets headingRad and shiftM of `layer` so that it goes on from `before`: the root stands at the same place, each layer at its own timeS,
 *  and faces alike in the mean of the second around it. For a cross-fade of two recorded walks. Other fields stay, and so does the pose.
 *  Errors as dplSetPoseFromClips. */
DPL_EXPERIMENTAL DplResult dplJoinClipLayer(DplAvatar avatar, const DplClipLayer* before, DplClipLayer* layer);

/** How an avatar looks at a point. Experimental. */
typedef struct DplGaze {
    uint32_t structSize;
    float target[3];  /**< metres, in the space of the avatar's pose: +Z ahead at rest */
    float headWeight; /**< 0 to 1: the part of the way to the target that neck and head take together; 0.7 is usual */
    float eyeWeight;  /**< 0 to 1: the part of what is left that the eyes take; 1 is usual. Without joints of eyes: ignored. Joints
                           that move no vertex turn the eyes by the avatar's expressions */
    /** Most that neck and head turn away from straight ahead of the trunk, to the left or right, and up or down; 0: 1.05 and 0.7 rad. */
    float headLimitRad[2];
    float eyeLimitRad[2]; /**< the same of the eyes, from straight ahead of the head; 0: 0.6 and 0.4 rad */
} DplGaze;

/** Turns neck, head and eyes of the current pose towards a point. Call it once after each function that poses the avatar, before drawing:
 *  a second call turns farther. It is smooth in target and weights, so fade it by the weights. Turns approach their limits smoothly. From
 *  115 degrees off straight ahead the gaze fades, and a target straight behind leaves the pose as it is, so nothing flips. What clothes
 *  remember and the time of the pose stay.
 *  DPL_ERROR_UNSUPPORTED: no joint is known as the head; the text lists all. DPL_ERROR_INVALID_ARGUMENT: a number that is not finite, a
 *  weight outside 0 to 1, a limit below 0 or above 90 degrees, general splats, or a target within 0.12 m of the line from the neck to
 *  between the eyes, as the avatar's own neck is; the gaze has faded to nothing there. The pose then stays. */
DPL_EXPERIMENTAL DplResult dplLookAtPoint(DplAvatar avatar, const DplGaze* gaze);

/* ---------------------------------------------------------------- driving from trackers */

/* A tracker turns what a platform tells of a person into poses of one avatar.
 *
 *   dplCreateTracker ─► whenever the platform has news: dplTrackFrame ─► each picture: dplSetPoseFromTracker ─► draw     dplDestroyTracker
 *
 * Joints come as world rotations and positions in one space of the program's choice: right-handed, +Y up, metres (Unity's: left-handed),
 * such as ARKit's world. "left" is the person's own left. Times are nanoseconds of any one clock that frames and pictures share.
 *
 * Frames are smoothed by a One-Euro filter whose cut-offs follow from the rate and noise of the stream, and extrapolated to the time of the
 * picture, by at most 0.05 s. A joint without news holds for 0.3 s; then it passes over to the pose beneath within 0.5 s, and back within
 * 0.25 s when it is tracked again. Nothing jumps. Formulas, tables and measured errors: docs/reference/driving.md.
 *
 * Threads. dplTrackFrame never waits for drawing or loading, so a camera's thread may call it. */

/** What a frame holds: which joints, in which order. dplGetTrackJointName names them. */
typedef enum DplTrackFormat {
    /** 55 bones of the VRM 1.0 humanoid, parents first: hips, spine, chest ... Rest may be NULL: a T-pose that faces +Z, identity
       rotations. */
    DPL_TRACK_VRM = 0,
    /** 55 bones in the order of HumanBodyBones, as Transform.rotation and position give them in Unity's left-handed world. Rest: the same
     * of a T-pose. */
    DPL_TRACK_UNITY = 1,
    /** 91 joints of ARSkeleton3D: jointModelTransforms, each behind the anchor's transform. Rest: jointModelTransforms of
     *  ARSkeletonDefinition.neutralBodySkeleton3D. */
    DPL_TRACK_ARKIT_BODY = 2,
    /** 70 joints of XR_FB_body_tracking, which knows no legs: these stand below the hips. Rest: xrGetBodySkeletonFB. */
    DPL_TRACK_FB_BODY = 3,
    /** 53 poses of OpenXR: the head (view space), 26 joints of the left hand, 26 of the right (XrHandJointEXT). Rest: NULL. Arms reach for
     *  the wrists. The body stands below the head and turns once the head has turned 50 degrees away from it. */
    DPL_TRACK_OPENXR_HANDS = 4,
    /** 33 world landmarks of MediaPipe Pose. Positions only, and as MediaPipe gives them: y down, z away from the camera. rotations and
     * rest: NULL. confidence: visibility. Twists that points do not tell are chosen as arms and legs usually hang. */
    DPL_TRACK_MEDIAPIPE_POSE = 5,
    DPL_TRACK_FORCE_INT32 = 0x7fffffff
} DplTrackFormat;

/** Flags of DplTrackerInfo. */
typedef enum DplTrackerFlag {
    /** Neither smooths nor extrapolates: for OpenXR, whose runtimes give poses for the display time. */
    DPL_TRACKER_RAW = 1,
    /** The avatar stands where the person stands in the tracker's space, which avatar space then is. Otherwise it starts above the origin,
     * and its travel is scaled by the ratio of leg lengths. Feet stand on the avatar's floor, y = 0, either way. */
    DPL_TRACKER_KEEP_PLACE = 2,
    /** The avatar stays on its spot. With DPL_TRACK_OPENXR_HANDS, poses are then those of the avatar's own space, and its body turns not.
     */
    DPL_TRACKER_IN_PLACE = 4,
    /** The pose beneath, which joints without data take, is the avatar's current one: set a clip's before each dplSetPoseFromTracker.
     *  Otherwise it is the rest pose. */
    DPL_TRACKER_OVER_POSE = 8,
    DPL_TRACKER_FORCE_INT32 = 0x7fffffff
} DplTrackerFlag;

/** How dplCreateTracker makes a tracker. */
typedef struct DplTrackerInfo {
    uint32_t structSize;
    DplTrackFormat format;
    uint32_t flags; /**< DplTrackerFlag, combined by | */
    /** Joints of the rest pose: that of the format, or 0 without rest. */
    uint32_t restCount;
    const float* restRotations; /**< restCount quaternions (x, y, z, w), in one space. A bone that the model lacks: not finite */
    const float* restPositions; /**< 3·restCount floats, metres, in the same space */
} DplTrackerInfo;

/** Makes a tracker for an avatar; info is copied. Free it with dplDestroyTracker, before or after the avatar.
 *  DPL_ERROR_UNSUPPORTED: the avatar lacks hips, or both arms and legs; the text lists its joints. DPL_ERROR_CORRUPT_DATA: a rest that is
 * not a standing person, or whose left and right are swapped. DPL_ERROR_INVALID_ARGUMENT: no rest where one is needed, wrong restCount,
 * numbers that are not finite, general splats. */
DPL_API DplResult dplCreateTracker(DplAvatar avatar, const DplTrackerInfo* info, DplTracker* tracker);

/** NULL does nothing and gives DPL_OK. */
DPL_API DplResult dplDestroyTracker(DplTracker tracker);

/** Name of a joint in the platform's own words, such as "left_forearm_joint" or "LEFT_ARM_LOWER". Static text. joint: from 0;
 *  DPL_ERROR_NOT_FOUND behind the last, or no such format. */
DPL_API DplResult dplGetTrackJointName(DplTrackFormat format, uint32_t joint, const char** name);

/** What a platform knows of a person at one time. */
typedef struct DplTrackFrame {
    uint32_t structSize;
    uint32_t jointCount;     /**< that of the format */
    int64_t timeNs;          /**< when the person was seen */
    const float* rotations;  /**< 4·jointCount floats: quaternions (x, y, z, w) in the tracker's space. NULL: format of positions only */
    const float* positions;  /**< 3·jointCount floats, metres */
    const float* confidence; /**< jointCount floats, 0 to 1. Below 0.5: the joint is not tracked. NULL: all are */
} DplTrackFrame;

/** Gives a tracker what the platform knows; the arrays are copied. A joint with a number that is not finite, or a zero quaternion, counts
 * as not tracked. Frames not later than the last are dropped; one more than a second earlier begins a new stream. Both give DPL_OK.
 *  DPL_ERROR_CORRUPT_DATA, the frame is dropped and nothing is logged: left and right are swapped, or lengths are those of another
 * skeleton. DPL_ERROR_INVALID_ARGUMENT: wrong jointCount, or rotations or positions missing. */
DPL_API DplResult dplTrackFrame(DplTracker tracker, const DplTrackFrame* frame);

/** Whether a tracker poses its avatar. */
typedef enum DplTrackerState {
    DPL_TRACKER_WAITING = 0,  /**< for the first frame: the pose beneath shows */
    DPL_TRACKER_TRACKING = 1, /**< the last frame is at most 0.3 s old */
    DPL_TRACKER_LOST = 2,     /**< no usable frame for longer: the pose passes over to the one beneath, or has done so */
    DPL_TRACKER_STATE_FORCE_INT32 = 0x7fffffff
} DplTrackerState;

/** What dplSetPoseFromTracker tells. */
typedef struct DplTrackerStatus {
    uint32_t structSize;
    DplTrackerState state;
    uint32_t drivenJoints;  /**< joints of the avatar that follow the tracker now */
    uint32_t framesTaken;   /**< since creation */
    uint32_t framesDropped; /**< late, swapped or of another skeleton */
    float rateHz;           /**< of the stream; 0: not known yet */
    float noiseDeg;         /**< random part of a joint's rotation, standard deviation about one axis, median over joints */
    float delayS;           /**< by which the filter lags, median over joints that move; extrapolation makes up for it */
    float predictedS;       /**< by how much this pose was extrapolated */
} DplTrackerStatus;

/** Poses the tracker's avatar for a picture that is shown at displayTimeNs. status: NULL if not wanted. To stay near the trained poses,
 * call dplHoldPose afterwards. Before the first frame the pose beneath is set. DPL_ERROR_INVALID_ARGUMENT: the avatar was destroyed. */
DPL_API DplResult dplSetPoseFromTracker(DplTracker tracker, int64_t displayTimeNs, DplTrackerStatus* status);

/* ---------------------------------------------------------------- drawing */

/** A pinhole camera with OpenCV axes. (0, 0) is the top left corner of the image; the first pixel's centre is (0.5, 0.5). */
typedef struct DplCamera {
    uint32_t structSize;
    uint32_t widthPx, heightPx; /**< 1 to DPL_MAX_IMAGE_SIDE_PX; all views of one call have the same size */
    float fx, fy;               /**< focal lengths, pixels, > 0 */
    float cx, cy;               /**< principal point, pixels; may lie outside the image (off-axis frustum) */
    float viewFromWorld[12];    /**< 3×4, row by row: X_view = R X_world + t with rows [R0 R1 R2 t]; R must be a rotation */
    /** Depth of the opaque scene that the application has drawn: view z in metres at the pixel centres of this view, rows without padding.
     *  A splat adds nothing to a pixel if the view z of the splat's centre is larger than this. Zero, negative, infinite and NaN mean that
     *  nothing is there. A usual depth buffer d from 0 to 1 must be converted: z = near·far / (far − d·(far − near)). Read during the
     *  call. NULL: no scene. */
    const float* sceneDepthM;
    size_t sceneDepthCount; /**< floats in sceneDepthM, at least widthPx·heightPx */
} DplCamera;

/** Flags of DplImage. */
typedef enum DplImageFlag {
    DPL_IMAGE_STRAIGHT_ALPHA = 1, /**< colour divided by alpha; otherwise premultiplied */
    /** Composites over the premultiplied pixels that rgba holds; otherwise over transparent black. Together with
     *  DPL_IMAGE_STRAIGHT_ALPHA: DPL_ERROR_INVALID_ARGUMENT. */
    DPL_IMAGE_OVER = 2,
    DPL_IMAGE_FORCE_INT32 = 0x7fffffff
} DplImageFlag;

/** What the pixels of an image mean. Splats are blended into a separate layer of 8-bit display-referred (sRGB) values, as in training. The
 *  layer is then composited once into the image, in the light that the format names. Alpha is linear in all formats. With DPL_IMAGE_OVER,
 *  pixels where the layer is empty keep their bytes. */
typedef enum DplImageFormat {
    /** 4 bytes per pixel, display-referred (sRGB), blended without conversion: a *_UNORM target of a display-referred renderer. */
    DPL_FORMAT_RGBA8 = 0,
    /** 4 bytes per pixel, stored by the sRGB curve and blended in linear light, as a *_SRGB attachment does. The layer is un-premultiplied,
     *  decoded by the sRGB curve and premultiplied again; the pixels of the image are decoded; the sum is encoded and rounded to the
     *  nearest code. */
    DPL_FORMAT_RGBA8_SRGB = 1,
    /** 8 bytes per pixel: four IEEE half floats of linear light. 1 is display white; larger values are kept. The layer is un-premultiplied,
     *  decoded and premultiplied again. */
    DPL_FORMAT_RGBA16F = 2,
    DPL_FORMAT_FORCE_INT32 = 0x7fffffff
} DplImageFormat;

/** Receives one view: memory of the caller, written during the call, top row first. Nothing is written unless the call returns DPL_OK. */
typedef struct DplImage {
    uint32_t structSize;
    uint32_t flags;   /**< DplImageFlag, combined by | */
    uint8_t* rgba;    /**< pixels of `format`, R first, any alignment; NULL: not wanted */
    size_t rgbaBytes; /**< size of rgba, at least heightPx·rowBytes */
    size_t rowBytes;  /**< bytes from one row of rgba to the next; 0: rows without padding */
    /** View z in metres, averaged over the splats of a pixel with the weight that each has in its colour; 0 where nothing is drawn. Rows
     *  without padding. NULL: not wanted. */
    float* depthM;
    size_t depthCount;     /**< floats in depthM, at least widthPx·heightPx */
    DplImageFormat format; /**< of rgba */
    /** View z in metres of the nearest surface of the posed mesh at each pixel centre. Both sides of the mesh count, whatever its splats
     *  show there. 0 where no surface lies beyond DPL_NEAR_LIMIT_M. Rows without padding. NULL: not wanted. General splats have no mesh:
     *  DPL_ERROR_INVALID_ARGUMENT. */
    float* meshDepthM;
    size_t meshDepthCount; /**< floats in meshDepthM, at least widthPx·heightPx */
} DplImage;

/** Draws the avatar in its current pose and returns when the pixels are in the caller's memory.
 *  viewCount: 1 or 2 (DPL_MAX_VIEWS); views and images have that many elements. The avatar must have been loaded with this context, else
 *  DPL_ERROR_INVALID_ARGUMENT. */
DPL_API DplResult dplRender(DplContext context, DplAvatar avatar, const DplCamera* views, uint32_t viewCount, const DplImage* images);

/* dplRender in two halves, for programs that draw every frame: dplDraw does not wait for its pixels. */

/** Flags of dplDraw. */
typedef enum DplDrawFlag {
    DPL_DRAW_DEPTH = 1,      /**< draws depth too; dplReadImages needs it for DplImage::depthM */
    DPL_DRAW_MESH_DEPTH = 2, /**< draws the depth of the mesh too; dplReadImages needs it for DplImage::meshDepthM */
    DPL_DRAW_FORCE_INT32 = 0x7fffffff
} DplDrawFlag;

/** Starts to draw the avatar in its current pose and returns. The CPU renderer draws within this call. Pose and views are copied.
 *  flags: DplDrawFlag, combined by |. Frames are alike if they share size, view count, flags and whether there is a scene depth. From the
 *  fourth alike frame on, the call allocates nothing. It waits only if three alike frames are still being drawn
 *  (DplFrameStats::waits). */
DPL_API DplResult dplDraw(DplContext context, DplAvatar avatar, const DplCamera* views, uint32_t viewCount, uint32_t flags);

/** Waits for the avatar's last dplDraw and writes its pixels to the caller's memory. viewCount must be that of dplDraw.
 *  DPL_ERROR_INVALID_ARGUMENT: nothing was drawn yet, another viewCount, an image too small, or a depth that was not drawn. */
DPL_API DplResult dplReadImages(DplContext context, DplAvatar avatar, const DplImage* images, uint32_t viewCount);

/* ---------------------------------------------------------------- several avatars in one picture */

#define DPL_MAX_TOGETHER 16u /**< avatars and sets of general splats in one picture */

/** dplRender for several avatars in one picture. Their splats are sorted together, so the avatars may overlap: stand close, hold hands,
 *  embrace. avatars: 1 to DPL_MAX_TOGETHER different avatars or general splats of this context. Place them by dplSetTransform.
 *  The picture belongs to the first avatar: pass that one to dplReadImages, dplGetFrameStats and dplGetPassTime.
 *  The avatars of one picture, in their order, are a scene set. The context keeps resources for the last four sets of several avatars.
 *  DPL_ERROR_UNSUPPORTED: together they have more splats than the device can bind. */
DPL_API DplResult dplRenderTogether(DplContext context, const DplAvatar* avatars, uint32_t avatarCount, const DplCamera* views,
                                    uint32_t viewCount, const DplImage* images);

/** dplDraw for several avatars in one picture; see dplRenderTogether. */
DPL_API DplResult dplDrawTogether(DplContext context, const DplAvatar* avatars, uint32_t avatarCount, const DplCamera* views,
                                  uint32_t viewCount, uint32_t flags);

/* ---------------------------------------------------------------- level of detail */

/** Limits how many splats are drawn when avatars or general splats cover few pixels, or when there are many of them. Kept splats grow to
 *  make up for those left out. The choice changes continuously with distance, pose and lens, and both views of a frame use the same splats.
 *  With zeros, all splats are drawn. Formulas: docs/reference/level-of-detail.md. */
typedef struct DplDetail {
    uint32_t structSize;
    /** Splats per pixel of a surface to keep where a pixel covers more. DPL_DETAIL_USUAL (12) is hard to tell from all splats; 6 is a
     *  little coarser. Where a pixel covers fewer, all are drawn and the picture has the same bytes as without level of detail. 0: no level
     *  of detail by distance. The pixel is taken at the point of the avatar nearest to the camera, and each region of the avatar counts by
     *  its own density. For general splats, which may be a room around the camera, each group of 128 splats has its own nearest point. */
    float splatsPerPixel;
    /** Most splats that one call may draw, over all its avatars, before culling. splatsPerPixel is lowered for all alike until they fit.
     *  Groups of general splats behind the cameras do not count. At least one splat of each group of 128 is kept, even if that exceeds the
     *  budget. 0: no limit. */
    uint32_t splatBudget;
} DplDetail;

/** DplDetail::splatsPerPixel that is hard to tell from all splats. */
#define DPL_DETAIL_USUAL 12.0f

/** Sets the level of detail of everything this context draws from the next call on. Set splatsPerPixel where people walk away from the
 *  camera, and a budget where the number of splats is known that a device draws in time; dplSetFrameBudget finds it. It may change every
 *  frame at no cost. detail is copied; NULL: draw everything, as after creation. DPL_ERROR_INVALID_ARGUMENT: splatsPerPixel is negative or
 * not finite. */
DPL_API DplResult dplSetDetail(DplContext context, const DplDetail* detail);

/** Sets how long a frame may take, milliseconds; 0: no budget, as after creation. Frames that take longer are drawn with fewer splats, and
 *  frames that take less with more again, up to what dplSetDetail asks for. Give it the part of a display interval that is left for Doppel.
 *  A frame is one drawing call. Its time is GPU time; on the CPU renderer, the time of drawing without the copy into DplImage. On a GPU
 *  without timestamps nothing is limited. Pictures are steered apart by their first avatar.
 *  From one call to the next at most 8 % fewer or 2 % more splats keep their full opacity, and the others fade, so nothing pops. At least
 *  1/16 of them is kept. DplFrameStats says what was chosen.
 *  It may change every frame. Drawing neither waits nor allocates for it. Formulas: docs/reference/level-of-detail.md.
 *  DPL_ERROR_INVALID_ARGUMENT: milliseconds is negative or not finite. */
DPL_API DplResult dplSetFrameBudget(DplContext context, double milliseconds);

/* ---------------------------------------------------------------- measuring */

/** How a frame budget fares; see dplSetFrameBudget. */
typedef enum DplBudgetState {
    DPL_BUDGET_OFF = 0,         /**< no budget is set, or the avatar was first in no drawing call since */
    DPL_BUDGET_UNTIMED = 1,     /**< fewer than five frames were timed, or the GPU has no timestamps: nothing is limited */
    DPL_BUDGET_FREE = 2,        /**< all splats that dplSetDetail asks for are drawn */
    DPL_BUDGET_LIMITED = 3,     /**< fewer are drawn */
    DPL_BUDGET_UNREACHABLE = 4, /**< only 1/16 of them are drawn, and frames still take too long: draw fewer pixels, or fewer avatars */
    DPL_BUDGET_FORCE_INT32 = 0x7fffffff
} DplBudgetState;

/** What the avatar's last finished frame drew and cost. Before the avatar's first frame all are 0 except memory sizes and waits. */
typedef struct DplFrameStats {
    uint32_t structSize;
    uint32_t viewCount;
    uint32_t splatsDrawn; /**< splats that at least one view shows. The CPU draws view by view and gives the largest count of a view */
    /** Triangles that carry splats and touch a view; those of them with splats that do not face away. 0 on the CPU. */
    uint32_t trianglesInView, trianglesFacing;
    uint32_t splatsInView, splatsFacing; /**< splats on these triangles; 0 on the CPU */
    /** Groups of up to 128 neighbouring splats; those that have a splat left after culling and are projected. 0 on the CPU. */
    uint32_t chunkCount, chunksProjected;
    uint32_t passCount;     /**< passes for dplGetPassTime; 0 on the CPU and on GPUs without timestamps */
    uint64_t residentBytes; /**< memory that the renderer holds for all avatars and frames of the context: of the GPU, or of the CPU */
    uint64_t waits;         /**< how often, since the context was created, drawing waited because three frames were in flight */
    double gpuMs;           /**< GPU time of the frame, the sum over its passes; 0 without timestamps */
    /** Memory of this avatar alone on CPU and GPU together: splats, mesh, weights and pose correctives. */
    uint64_t avatarBytes;
    uint64_t splatBytes; /**< the part of avatarBytes that the splats take */
    /** Bytes of splat codes that the frame read: first to decide which splats may show, then to decode those. On a GPU they are computed
     *  from the counts above and the layout. */
    uint64_t bytesDecided, bytesDecoded;
    uint32_t tileEntries;     /**< pairs of splat and tile over all views; 0 where quads or the CPU fill */
    uint32_t tilesOverflowed; /**< 1: the tile lists were too small, so this frame took longer to fill */
    uint32_t splatsAllowed;   /**< most splats that dplSetDetail and the frame budget allowed for the whole scene set, before culling */
    float detailShare;        /**< share of this avatar's splats that level of detail kept when it was last drawn, 0 to 1 */
    /** Components of the whole scene set (head, trunk, hands, legs, garments); those that a view may show. The others are not posed. 0
     *  where nothing is culled. */
    uint32_t componentCount, componentsInView;
    /* What dplSetFrameBudget goes by and chose, of the drawing calls with this avatar as first. */
    double frameMs;      /**< time of the last finished frame, without reading back; 0 without timestamps */
    uint32_t keptWanted; /**< most splats that would keep their full opacity without a frame budget; others fade */
    uint32_t keptLimit;  /**< most that may keep it for the sake of the budget; 0: no limit */
    uint32_t framesOver; /**< timed frames above the budget since it was set */
    DplBudgetState budgetState;
} DplFrameStats;

/** Never waits for a frame that is still being drawn. */
DPL_API DplResult dplGetFrameStats(DplAvatar avatar, DplFrameStats* stats);

/** What dplGetPassTime tells. */
typedef struct DplPassTime {
    uint32_t structSize;
    const char* label;   /**< for example "splat.project"; lives until the avatar's next dplGetFrameStats */
    double milliseconds; /**< GPU time. A pass of several rounds appears once per round */
} DplPassTime;

/** pass: 0 to passCount - 1 of the avatar's last dplGetFrameStats, in the order in which they ran; else DPL_ERROR_NOT_FOUND. */
DPL_API DplResult dplGetPassTime(DplAvatar avatar, uint32_t pass, DplPassTime* time);

#ifdef __cplusplus
}
#endif

#include "doppel_posed.h"
#include "doppel_surface.h"
#endif
