/* SPDX-License-Identifier: Apache-2.0 */
#include "tests/metal/metal_from_c.h"

#include <stddef.h>
#include <string.h>

#define TEXT_OF(x) #x
#define CHECK(...)                                       \
    do {                                                 \
        if (!(__VA_ARGS__)) return TEXT_OF(__VA_ARGS__); \
    } while (0)

/* Structs may only grow at their ends (docs/reference/abi.md). */
static const char* layouts(void) {
    if (sizeof(void*) != 8) return NULL;
    CHECK(sizeof(DplMetalDevice) == 24 && offsetof(DplMetalDevice, reserved) == 4 && offsetof(DplMetalDevice, device) == 8 &&
          offsetof(DplMetalDevice, queue) == 16);
    CHECK(sizeof(DplMetalPass) == 28 && offsetof(DplMetalPass, colourFormat) == 4 && offsetof(DplMetalPass, depthFormat) == 8 &&
          offsetof(DplMetalPass, samples) == 16 && offsetof(DplMetalPass, writesDepth) == 24);
    CHECK(sizeof(DplMetalSceneDepth) == 32 && offsetof(DplMetalSceneDepth, slice) == 4 && offsetof(DplMetalSceneDepth, texture) == 8 &&
          offsetof(DplMetalSceneDepth, x) == 16 && offsetof(DplMetalSceneDepth, scale) == 24 && offsetof(DplMetalSceneDepth, offset) == 28);
    CHECK(sizeof(DplMetalSubmission) == 72 && offsetof(DplMetalSubmission, textures) == 8 && offsetof(DplMetalSubmission, x) == 24 &&
          offsetof(DplMetalSubmission, waitEvent) == 32 && offsetof(DplMetalSubmission, signalEvent) == 40 &&
          offsetof(DplMetalSubmission, waitValue) == 48 && offsetof(DplMetalSubmission, signalValue) == 56 &&
          offsetof(DplMetalSubmission, drawable) == 64);
    CHECK(sizeof(DplMetalBuffer) == 32 && offsetof(DplMetalBuffer, elements) == 8 && offsetof(DplMetalBuffer, buffer) == 16 &&
          offsetof(DplMetalBuffer, bytes) == 24);
    return NULL;
}

const char* callMetalFromC(const struct FromC* app) {
    const float nearM = 0.1f;
    DplMetalDevice mine = {sizeof mine, 0, app->device, app->queue};
    DplMetalPass pass = {sizeof pass, app->colourFormat, app->depthFormat, 0, 1, 0, DPL_DRAW_DEPTH};
    DplMetalPass plain = {sizeof plain, app->colourFormat, 0, 0, 1, 0, 0};
    DplBufferElement position = {sizeof position, DPL_SPLAT_POSITION, DPL_NUMBER_FLOAT, 0, 0, 0};
    DplMetalBuffer rows = {sizeof rows, 1, &position, app->rows, app->rowsBytes};
    DplWritten written = {sizeof written, 0, 0};
    DplMetalSubmission how;
    DplContextInfo info;
    DplContext context = NULL;
    DplAvatar avatar = NULL;
    uint32_t withDepth = 0, without = 0;
    void* encoder;
    const char* wrong = layouts();
    if (wrong) return wrong;
    memset(&info, 0, sizeof info);
    info.structSize = sizeof info, info.fill = DPL_FILL_QUADS; /* DPL_FILL_AUTO would run its self-test */
    CHECK(dplCreateMetalContext(&mine, &info, &context) == DPL_OK);
    CHECK(dplLoadAvatar(context, app->avatar, app->avatarBytes, &avatar) == DPL_OK);
    CHECK(dplCreateMetalComposer(context, &pass, &withDepth) == DPL_OK);
    CHECK(dplCreateMetalComposer(context, &plain, &without) == DPL_OK);
    CHECK(dplMetalPrepare(context, app->prepared, 0, &avatar, 1, &app->view, 1, NULL) == DPL_OK);
    encoder = app->beginPass(app->program);
    CHECK(dplMetalCompose(context, withDepth, encoder, 0, 0, 0, 0) == DPL_OK);
    CHECK(dplMetalComposeDepth(context, withDepth, encoder, 0, 0, 0, 0, 0, nearM) == DPL_OK);
    CHECK(dplMetalUpload(context, app->uploaded, 1) == DPL_OK);
    CHECK(dplMetalWriteSplats(avatar, app->uploaded, 1, NULL, &rows, &written) == DPL_OK && written.count > 0);
    app->finish(app->program);
    memset(&how, 0, sizeof how);
    how.structSize = sizeof how, how.textureCount = 1, how.textures[0] = app->submitted;
    CHECK(dplMetalSubmit(context, without, 2, &avatar, 1, &app->view, 1, NULL, &how) == DPL_OK);
    CHECK(dplMetalDropSlot(context, 0) == DPL_OK);
    CHECK(dplDestroyMetalComposer(context, without) == DPL_OK);
    CHECK(dplDestroyMetalComposer(context, without) == DPL_ERROR_NOT_FOUND);
    app->finish(app->program);
    CHECK(dplRebuildMetal(context, &mine) == DPL_OK);
    CHECK(dplDestroyAvatar(avatar) == DPL_OK);
    CHECK(dplDestroyContext(context) == DPL_OK);
    return NULL;
}
