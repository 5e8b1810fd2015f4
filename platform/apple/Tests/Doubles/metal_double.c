/* SPDX-License-Identifier: Apache-2.0 */
#include "MetalDouble.h"

#include <doppel/doppel.h>
#define DPL_METAL_POINTERS
#include <doppel/doppel_metal.h>
#include <stdio.h>
#include <string.h>

static char calls[4096], taken[4096];
static struct {
    const char* call;
    int result, times;
} failures[] = {{"prepare", 0, 0}, {"rebuild", 0, 0}, {"composer", 0, 0}};
#define FAILURES (sizeof failures / sizeof failures[0])
static uint32_t composers;

static DplResult call(const char* name, uint32_t number) {
    size_t used = strlen(calls);
    snprintf(calls + used, sizeof calls - used, "%s %u; ", name, number);
    for (size_t i = 0; i < FAILURES; ++i)
        if (failures[i].times > 0 && strcmp(failures[i].call, name) == 0) return --failures[i].times, (DplResult)failures[i].result;
    return DPL_OK;
}

const char* doubleTakeCalls(void) {
    strcpy(taken, calls);
    calls[0] = 0;
    return taken;
}

void doubleFail(const char* name, int result, int times) {
    for (size_t i = 0; i < FAILURES; ++i)
        if (strcmp(failures[i].call, name) == 0) failures[i].result = result, failures[i].times = times;
}

DplResult dplCreateMetalContext(const DplMetalDevice* device, const DplContextInfo* info, DplContext* context) {
    DplContextInfo software = *info;
    DplResult result = device->device && device->queue ? call("create", 0) : DPL_ERROR_INVALID_ARGUMENT;
    software.renderer = DPL_RENDERER_SOFTWARE;
    return result == DPL_OK ? dplCreateContext(&software, context) : result;
}

DplResult dplRebuildMetal(DplContext context, const DplMetalDevice* device) {
    return (void)context, device->queue ? call("rebuild", 0) : DPL_ERROR_INVALID_ARGUMENT;
}

DplResult dplCreateMetalComposer(DplContext context, const DplMetalPass* pass, uint32_t* composer) {
    (void)context;
    *composer = ++composers;
    return call("composer", pass->colourFormat);
}

DplResult dplMetalWriteSplats(DplAvatar avatar, void* commands, uint32_t slot, const DplSplatOptions* options, const DplMetalBuffer* buffer,
                              DplWritten* written) {
    (void)slot;
    if (!avatar || !options->eye || options->eye[2] != 3 || options->shDegree != 1) return DPL_ERROR_INVALID_ARGUMENT;
    if (!buffer) return written->count = options->splatBudget, call("count", options->splatBudget);
    if (!commands || !buffer->buffer || buffer->elements[1].offsetBytes != 12) return DPL_ERROR_INVALID_ARGUMENT;
    written->count = (uint32_t)(buffer->bytes / buffer->elements[0].strideBytes);
    return call("write", buffer->elementCount);
}

DplResult dplMetalPrepare(DplContext context, void* commands, uint32_t slot, const DplAvatar* avatars, uint32_t avatarCount,
                          const DplCamera* views, uint32_t viewCount, const DplMetalSceneDepth* depths) {
    (void)context, (void)avatars, (void)views, (void)depths;
    if (!commands || avatarCount != 1 || viewCount == 0) return DPL_ERROR_INVALID_ARGUMENT;
    return call("prepare", slot);
}

DplResult dplMetalUpload(DplContext context, void* commands, uint32_t slot) {
    return (void)context, (void)commands, call("upload", slot);
}

DplResult dplMetalDropSlot(DplContext context, uint32_t slot) {
    return (void)context, call("drop", slot);
}

DplResult dplMetalCompose(DplContext context, uint32_t composer, void* encoder, uint32_t slot, uint32_t view, int32_t x, int32_t y) {
    (void)context, (void)encoder, (void)slot, (void)view, (void)x, (void)y;
    return call("compose", composer);
}

DplResult dplMetalComposeDepth(DplContext context, uint32_t composer, void* encoder, uint32_t slot, uint32_t view, int32_t x, int32_t y,
                               float scale, float offset) {
    (void)context, (void)encoder, (void)slot, (void)view, (void)x, (void)y, (void)scale, (void)offset;
    return call("depth", composer);
}
