// SPDX-License-Identifier: Apache-2.0
/* Includes doppel.h, doppel_convert.h, doppel_png.h and doppel_splats.h in a strict C99 program: they compile without warnings, their
 * constants are constant expressions, structs keep their layout. In builds with Vulkan, doppel_vulkan.h too. */
#include <doppel/doppel.h>
#include <doppel/doppel_convert.h>
#include <doppel/doppel_png.h>
#include <doppel/doppel_splats.h>
#ifdef WITH_VULKAN
#include <doppel/doppel_vulkan.h>
#endif

#include <stddef.h>
#include <stdio.h>
#include <string.h>

static int failures = 0;

#define CHECK(condition)                                                   \
    do {                                                                   \
        if (!(condition)) {                                                \
            printf("%s:%d: failed: %s\n", __FILE__, __LINE__, #condition); \
            ++failures;                                                    \
        }                                                                  \
    } while (0)

int main(void) {
    DplContextInfo info;
    DplContext context = NULL;
    DplAvatar avatar = NULL;
    const char* name = NULL;
    unsigned char junk[4] = {1, 2, 3, 4};

    /* Fields may be added at the end of a struct; none may move. The offsets are those of version 1.0 on a 64-bit machine. */
    if (sizeof(void*) == 8) {
        CHECK(sizeof(DplContextInfo) == 32 && offsetof(DplContextInfo, threadCount) == 8 && offsetof(DplContextInfo, fill) == 16);
        CHECK(sizeof(DplCamera) == 96 && offsetof(DplCamera, viewFromWorld) == 28 && offsetof(DplCamera, sceneDepthM) == 80);
        CHECK(sizeof(DplImage) == 72 && offsetof(DplImage, rgba) == 8 && offsetof(DplImage, depthM) == 32 &&
              offsetof(DplImage, format) == 48 && offsetof(DplImage, meshDepthM) == 56);
        CHECK(sizeof(DplAvatarInfo) == 80 && offsetof(DplAvatarInfo, name) == 8 && offsetof(DplAvatarInfo, restMin) == 44 &&
              offsetof(DplAvatarInfo, fileSplatCount) == 68);
        CHECK(sizeof(DplFileAxes) == 44 && offsetof(DplFileAxes, loadedFromFile) == 8);
        CHECK(sizeof(DplLoadInfo) == 40 && offsetof(DplLoadInfo, data) == 8 && offsetof(DplLoadInfo, release) == 24);
        CHECK(sizeof(DplLoadStatus) == 12 && offsetof(DplLoadStatus, progress) == 8);
        CHECK(sizeof(DplExpressionInfo) == 24 && offsetof(DplExpressionInfo, drawn) == 16);
        CHECK(sizeof(DplJointInfo) == 40 && offsetof(DplJointInfo, restPosition) == 28);
        CHECK(sizeof(DplClipInfo) == 32 && offsetof(DplClipInfo, durationS) == 16);
        CHECK(sizeof(DplClipOptions) == 32 && offsetof(DplClipOptions, animation) == 16 && offsetof(DplClipOptions, animationName) == 24);
        CHECK(sizeof(DplClipLayer) == 40 && offsetof(DplClipLayer, timeS) == 8 && offsetof(DplClipLayer, shiftM) == 32);
        CHECK(sizeof(DplFaceMotion) == 32 && offsetof(DplFaceMotion, heardNs) == 8 && offsetof(DplFaceMotion, glances) == 24);
        CHECK(sizeof(DplGaze) == 40 && offsetof(DplGaze, headWeight) == 16 && offsetof(DplGaze, eyeLimitRad) == 32);
        CHECK(sizeof(DplContactShadow) == 44 && offsetof(DplContactShadow, along) == 32);
        CHECK(sizeof(DplLayerInfo) == 32 && offsetof(DplLayerInfo, hidden) == 24);
        CHECK(sizeof(DplPick) == 48 && offsetof(DplPick, distanceM) == 20 && offsetof(DplPick, normal) == 36);
        CHECK(sizeof(DplDetail) == 12);
        CHECK(sizeof(DplScreenSplat) == 32 && offsetof(DplScreenSplat, inverseVarianceY) == 20 && offsetof(DplScreenSplat, opacity) == 30);
        CHECK(sizeof(DplBufferElement) == 32 && offsetof(DplBufferElement, offsetBytes) == 16);
        CHECK(sizeof(DplBuffer) == 32 && offsetof(DplBuffer, elements) == 8 && offsetof(DplBuffer, dataBytes) == 24);
        CHECK(sizeof(DplWritten) == 16 && offsetof(DplWritten, saturated) == 8);
        CHECK(sizeof(DplSplatOptions) == 24 && offsetof(DplSplatOptions, eye) == 8 && offsetof(DplSplatOptions, shDegree) == 16);
        CHECK(sizeof(DplProjection) == 16 && offsetof(DplProjection, samples) == 12);
        CHECK(sizeof(DplCaptureDetail) == 52 && offsetof(DplCaptureDetail, views) == 36);
        CHECK(sizeof(DplPoseTrust) == 24 && offsetof(DplPoseTrust, farthestJoint) == 16);
        CHECK(sizeof(DplTrackerInfo) == 32 && offsetof(DplTrackerInfo, restRotations) == 16);
        CHECK(sizeof(DplTrackFrame) == 40 && offsetof(DplTrackFrame, timeNs) == 8 && offsetof(DplTrackFrame, confidence) == 32);
        CHECK(sizeof(DplTrackerStatus) == 36 && offsetof(DplTrackerStatus, rateHz) == 20);
        CHECK(sizeof(DplFrameStats) == 144 && offsetof(DplFrameStats, frameMs) == 120 && offsetof(DplFrameStats, budgetState) == 140 &&
              offsetof(DplFrameStats, splatsAllowed) == 104 && offsetof(DplFrameStats, componentCount) == 112 &&
              offsetof(DplFrameStats, avatarBytes) == 64 && offsetof(DplFrameStats, tileEntries) == 96 &&
              offsetof(DplFrameStats, residentBytes) == 40);
        CHECK(sizeof(DplPassTime) == 24 && offsetof(DplPassTime, milliseconds) == 16);
#ifdef WITH_VULKAN
        CHECK(sizeof(DplVulkanBuffer) == 32 && offsetof(DplVulkanBuffer, buffer) == 16 && offsetof(DplVulkanBuffer, bytes) == 24);
        CHECK(sizeof(DplVulkanDevice) == 88 && offsetof(DplVulkanDevice, enabledFeatures) == 48);
        CHECK(sizeof(DplVulkanPass) == 40 && offsetof(DplVulkanPass, colourFormat) == 28);
        CHECK(sizeof(DplVulkanRequirement) == 32 && offsetof(DplVulkanRequirement, buys) == 24);
        CHECK(sizeof(DplVulkanSceneDepth) == 40 && offsetof(DplVulkanSceneDepth, scale) == 32);
        CHECK(sizeof(DplVulkanSubmission) == 72 && offsetof(DplVulkanSubmission, fence) == 64);
        CHECK(sizeof(DplVulkanTarget) == 56 && offsetof(DplVulkanTarget, layoutAfter) == 48);
#endif
    }
    CHECK(sizeof(DplResult) == 4 && sizeof(DplRenderer) == 4 && sizeof(DplFill) == 4 && sizeof(DplDrawFlag) == 4 &&
          sizeof(DplImageFormat) == 4 && sizeof(DplBudgetState) == 4 && sizeof(DplLoadState) == 4 && sizeof(DplTrackFormat) == 4 &&
          sizeof(DplTrackerFlag) == 4 && sizeof(DplTrackerState) == 4 && sizeof(DplLayerFlag) == 4);

    CHECK(sizeof(DplClipDepth) == 4 && sizeof(DplAxes) == 4 && dplSecondsBetween(1, 1000000001) == 1);
    CHECK(dplWritePng(NULL, junk, 1, 1) == DPL_ERROR_INVALID_ARGUMENT && dplWritePng("", junk, 0, 1) == DPL_ERROR_INVALID_ARGUMENT);

    CHECK(dplGetVersion() == ((DPL_VERSION_MAJOR << 16) | (DPL_VERSION_MINOR << 8) | DPL_VERSION_PATCH));
    CHECK(strcmp(dplGetResultName(DPL_ERROR_VERSION), "DPL_ERROR_VERSION") == 0);
    CHECK(dplGetLastError() != NULL && dplGetLastError()[0] == 0);
    memset(&info, 0, sizeof info);
    info.structSize = sizeof info;
    info.renderer = DPL_RENDERER_SOFTWARE;
    info.threadCount = 1;
    CHECK(dplCreateContext(&info, &context) == DPL_OK);
    CHECK(dplGetRendererName(context, &name) == DPL_OK && strcmp(name, "software (1 thread)") == 0);
    CHECK(dplLoadAvatar(context, junk, sizeof junk, &avatar) != DPL_OK);
    CHECK(avatar == NULL && dplGetLastError()[0] != 0);
    CHECK(dplDestroyContext(context) == DPL_OK);
    if (failures == 0) printf("doppel.h is C99 and libdoppel %u.%u answers\n", (unsigned)DPL_VERSION_MAJOR, (unsigned)DPL_VERSION_MINOR);
    return failures != 0;
}
