// SPDX-License-Identifier: Apache-2.0
// What the module exports beyond the C API. The C API's functions without structs are exported as they are (CMakeLists.txt); these here
// take and give numbers, so that doppel.js knows the layout of no struct. Handles, results and errors are those of the C API.
#include <cstdint>
#include <cstdlib>
#include <new>

#include <doppel/doppel.h>
#include <doppel/doppel_convert.h>
#include <doppel/doppel_posed.h>
#include <doppel/doppel_splats.h>
#include <doppel/doppel_surface.h>

#define EXPORT(name) extern "C" __attribute__((export_name(#name), used)) auto name

extern "C" [[noreturn]] __attribute__((import_module("doppel"), import_name("thrown"))) void doppelThrown(const char* typeName);

namespace {

/** Numbers of a camera as doppel.js writes them: width, height, fx, fy, cx, cy, then the 12 of DplCamera::viewFromWorld. */
DplCamera cameraOf(const double* numbers) {
    DplCamera camera{};
    camera.structSize = sizeof camera;
    camera.widthPx = uint32_t(numbers[0]), camera.heightPx = uint32_t(numbers[1]);
    camera.fx = float(numbers[2]), camera.fy = float(numbers[3]), camera.cx = float(numbers[4]), camera.cy = float(numbers[5]);
    for (int i = 0; i < 12; ++i) camera.viewFromWorld[i] = float(numbers[6 + i]);
    return camera;
}

}  // namespace

EXPORT(webAllocate)(size_t bytes)->void* {
    return std::malloc(bytes);
}
EXPORT(webFree)(void* memory)->void {
    std::free(memory);
}

/** A context on the CPU with one thread; 0 after an error. */
EXPORT(webCreateContext)()->DplContext {
    std::set_new_handler([] { doppelThrown("out of memory"); });
    DplContextInfo info{};
    info.structSize = sizeof info;
    info.renderer = DPL_RENDERER_SOFTWARE;
    info.threadCount = 1;
    DplContext context = nullptr;
    return dplCreateContext(&info, &context) == DPL_OK ? context : nullptr;
}

/** 0 after an error, whose code goes to *result. */
EXPORT(webLoadAvatar)(DplContext context, const uint8_t* data, size_t size, int32_t* result)->DplAvatar {
    DplAvatar avatar = nullptr;
    *result = dplLoadAvatar(context, data, size, &avatar);
    return avatar;
}

/** 12 numbers: joints, splats, clips, vertices, triangles, shDegree, restMin, restMax. */
EXPORT(webAvatarNumbers)(DplAvatar avatar, double* numbers)->DplResult {
    DplAvatarInfo info{};
    info.structSize = sizeof info;
    const DplResult result = dplGetAvatarInfo(avatar, &info);
    if (result != DPL_OK) return result;
    numbers[0] = info.jointCount, numbers[1] = info.splatCount, numbers[2] = info.clipCount;
    numbers[3] = info.vertexCount, numbers[4] = info.triangleCount, numbers[5] = info.shDegree;
    for (int k = 0; k < 3; ++k) numbers[6 + k] = info.restMin[k], numbers[9 + k] = info.restMax[k];
    return DPL_OK;
}
EXPORT(webAvatarName)(DplAvatar avatar)->const char* {
    DplAvatarInfo info{};
    info.structSize = sizeof info;
    return dplGetAvatarInfo(avatar, &info) == DPL_OK ? info.name : "";
}

/** 4 numbers: parent, restPosition. */
EXPORT(webJointNumbers)(DplAvatar avatar, uint32_t joint, double* numbers)->DplResult {
    DplJointInfo info{};
    info.structSize = sizeof info;
    const DplResult result = dplGetJointInfo(avatar, joint, &info);
    if (result != DPL_OK) return result;
    numbers[0] = info.parent;
    for (int k = 0; k < 3; ++k) numbers[1 + k] = info.restPosition[k];
    return DPL_OK;
}
/** bone: of the VRM humanoid instead of the file's own name. */
EXPORT(webJointName)(DplAvatar avatar, uint32_t joint, int bone)->const char* {
    DplJointInfo info{};
    info.structSize = sizeof info;
    if (dplGetJointInfo(avatar, joint, &info) != DPL_OK) return "";
    return bone ? info.humanoidBone : info.name;
}

/** Seconds; below 0 after an error. */
EXPORT(webClipDuration)(DplAvatar avatar, uint32_t clip)->double {
    DplClipInfo info{};
    info.structSize = sizeof info;
    return dplGetClipInfo(avatar, clip, &info) == DPL_OK ? info.durationS : -1;
}
EXPORT(webClipName)(DplAvatar avatar, uint32_t clip)->const char* {
    DplClipInfo info{};
    info.structSize = sizeof info;
    return dplGetClipInfo(avatar, clip, &info) == DPL_OK ? info.name : "";
}
/** flags: DplClipFlag. animation: index in a glTF file. name: may be null. */
EXPORT(webLoadClip)
(DplAvatar avatar, const uint8_t* data, size_t size, uint32_t flags, uint32_t animation, const char* name, uint32_t* clip)->DplResult {
    DplClipOptions options{};
    options.structSize = sizeof options;
    options.flags = flags, options.animation = animation, options.name = name;
    return dplLoadClip(avatar, data, size, &options, clip);
}

EXPORT(webSetDetail)(DplContext context, float splatsPerPixel, uint32_t splatBudget)->DplResult {
    DplDetail detail{};
    detail.structSize = sizeof detail;
    detail.splatsPerPixel = splatsPerPixel, detail.splatBudget = splatBudget;
    return dplSetDetail(context, &detail);
}

/** dplRender of one view into `rgba`, width · height · 4 bytes. flags: DplImageFlag. */
EXPORT(webRender)
(DplContext context, DplAvatar avatar, const double* cameraNumbers, uint32_t flags, uint8_t* rgba, size_t rgbaBytes)->DplResult {
    const DplCamera camera = cameraOf(cameraNumbers);
    DplImage image{};
    image.structSize = sizeof image;
    image.flags = flags;
    image.rgba = rgba, image.rgbaBytes = rgbaBytes;
    return dplRender(context, avatar, &camera, 1, &image);
}

/** dplProject of viewCount cameras, 18 numbers each. Writes 3 numbers: splats of the first view, of the second, samples. */
EXPORT(webProject)
(DplContext context, DplAvatar avatar, const double* cameraNumbers, uint32_t viewCount, DplScreenSplat* splats, uint32_t capacity,
 uint32_t* numbers)
    ->DplResult {
    DplCamera cameras[DPL_MAX_VIEWS];
    for (uint32_t v = 0; v < viewCount && v < DPL_MAX_VIEWS; ++v) cameras[v] = cameraOf(cameraNumbers + 18 * v);
    DplProjection made{};
    made.structSize = sizeof made;
    const DplResult result = dplProject(context, &avatar, 1, cameras, viewCount, splats, capacity, &made);
    numbers[0] = made.counts[0], numbers[1] = made.counts[1], numbers[2] = made.samples;
    return result;
}

/** dplWriteSplats. elements: 4 numbers each: property, number, offset, stride. eye: may be null. data: null only counts. Writes 2 numbers:
 *  splats, saturated numbers. */
EXPORT(webWriteSplats)
(DplAvatar avatar, const double* elements, uint32_t elementCount, const float* eye, uint32_t splatBudget, uint32_t shDegree, void* data,
 size_t bytes, double* numbers)
    ->DplResult {
    DplBufferElement places[DPL_MAX_BUFFER_ELEMENTS]{};
    for (uint32_t i = 0; i < elementCount && i < DPL_MAX_BUFFER_ELEMENTS; ++i) {
        const double* element = elements + 4 * i;
        places[i].structSize = sizeof places[i];
        places[i].property = uint32_t(element[0]), places[i].number = DplNumber(int32_t(element[1]));
        places[i].offsetBytes = uint64_t(element[2]), places[i].strideBytes = uint64_t(element[3]);
    }
    DplSplatOptions options{};
    options.structSize = sizeof options;
    options.splatBudget = splatBudget, options.eye = eye, options.shDegree = shDegree;
    DplBuffer buffer{};
    buffer.structSize = sizeof buffer;
    buffer.elementCount = elementCount, buffer.elements = places;
    buffer.data = data, buffer.dataBytes = bytes;
    DplWritten written{};
    written.structSize = sizeof written;
    const DplResult result = dplWriteSplats(avatar, &options, data ? &buffer : nullptr, &written);
    numbers[0] = written.count, numbers[1] = double(written.saturated);
    return result;
}

/** Writes 18 numbers, as cameraOf() reads them. vectors: eye, target, up. */
EXPORT(webLookAt)(const float* vectors, float fovYRad, uint32_t widthPx, uint32_t heightPx, double* numbers)->DplResult {
    DplCamera camera{};
    camera.structSize = sizeof camera;
    const DplResult result = dplCameraLookAt(vectors, vectors + 3, vectors + 6, fovYRad, widthPx, heightPx, &camera);
    if (result != DPL_OK) return result;
    numbers[0] = camera.widthPx, numbers[1] = camera.heightPx;
    numbers[2] = camera.fx, numbers[3] = camera.fy, numbers[4] = camera.cx, numbers[5] = camera.cy;
    for (int i = 0; i < 12; ++i) numbers[6 + i] = camera.viewFromWorld[i];
    return DPL_OK;
}

EXPORT(webLayerCount)(DplAvatar avatar)->uint32_t {
    DplAvatarInfo info{};
    info.structSize = sizeof info;
    return dplGetAvatarInfo(avatar, &info) == DPL_OK ? info.layerCount : 0;
}
/** part: 0 name, 1 role. */
EXPORT(webLayerText)(DplAvatar avatar, uint32_t layer, int part)->const char* {
    DplLayerInfo info{};
    info.structSize = sizeof info;
    if (dplGetLayerInfo(avatar, layer, &info) != DPL_OK) return "";
    return part ? info.role : info.name;
}
EXPORT(webLayerTriangles)(DplAvatar avatar, uint32_t layer)->uint32_t {
    DplLayerInfo info{};
    info.structSize = sizeof info;
    return dplGetLayerInfo(avatar, layer, &info) == DPL_OK ? info.triangleCount : 0;
}

/** Null past the last expression. It lives as long as the module. */
EXPORT(webExpressionName)(DplAvatar avatar, uint32_t expression)->const char* {
    DplExpressionInfo info{};
    info.structSize = sizeof info;
    return dplGetExpressionInfo(avatar, expression, &info) == DPL_OK ? info.name : nullptr;
}
/** Whether the person holds it. */
EXPORT(webExpressionDrawn)(DplAvatar avatar, uint32_t expression)->uint32_t {
    DplExpressionInfo info{};
    info.structSize = sizeof info;
    return dplGetExpressionInfo(avatar, expression, &info) == DPL_OK ? info.drawn : 0;
}

/** dplSetFaceMotion with times in milliseconds. */
EXPORT(webSetFaceMotion)
(DplAvatar avatar, double timeMs, uint32_t seed, float blinks, float glances, float holdS, double heardMs)->DplResult {
    DplFaceMotion motion{};
    motion.structSize = sizeof motion;
    motion.seed = seed, motion.heardNs = int64_t(heardMs * 1e6);
    motion.blinks = blinks, motion.glances = glances, motion.holdS = holdS;
    return dplSetFaceMotion(avatar, &motion, int64_t(timeMs * 1e6));
}

/** dplSetPoseAtTime with a time in milliseconds. */
EXPORT(webSetPoseAtTime)(DplAvatar avatar, const float* rotations, uint32_t jointCount, const float* root, double timeMs)->DplResult {
    return dplSetPoseAtTime(avatar, rotations, jointCount, root, int64_t(timeMs * 1e6));
}

/** A tracker for landmarks of MediaPipe Pose; 0 after an error, whose code goes to *result. flags: DplTrackerFlag. */
EXPORT(webCreateTracker)(DplAvatar avatar, uint32_t flags, int32_t* result)->DplTracker {
    DplTrackerInfo info{};
    info.structSize = sizeof info;
    info.format = DPL_TRACK_MEDIAPIPE_POSE;
    info.flags = flags;
    DplTracker tracker = nullptr;
    *result = dplCreateTracker(avatar, &info, &tracker);
    return tracker;
}
/** numbers: x, y, z of each landmark, then the visibility of each. */
EXPORT(webTrack)(DplTracker tracker, const float* numbers, uint32_t count, double timeMs)->DplResult {
    DplTrackFrame frame{};
    frame.structSize = sizeof frame;
    frame.jointCount = count;
    frame.timeNs = int64_t(timeMs * 1e6);
    frame.positions = numbers;
    frame.confidence = numbers + 3 * size_t(count);
    return dplTrackFrame(tracker, &frame);
}
/** Writes 4 numbers: state, driven joints, rate in Hz, delay in seconds. */
EXPORT(webSetPoseFromTracker)(DplTracker tracker, double timeMs, double* numbers)->DplResult {
    DplTrackerStatus status{};
    status.structSize = sizeof status;
    const DplResult result = dplSetPoseFromTracker(tracker, int64_t(timeMs * 1e6), &status);
    if (result != DPL_OK) return result;
    numbers[0] = status.state, numbers[1] = status.drivenJoints, numbers[2] = status.rateHz, numbers[3] = status.delayS;
    return DPL_OK;
}
