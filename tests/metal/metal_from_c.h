/* SPDX-License-Identifier: Apache-2.0 */
/* Calls every function of doppel_metal.h from C. */
#ifndef DOPPEL_TESTS_METAL_FROM_C_H
#define DOPPEL_TESTS_METAL_FROM_C_H

#include <doppel/doppel_metal.h>

#ifdef __cplusplus
extern "C" {
#endif

/** A Metal program, as C sees it. Its objects are of one device. */
struct FromC {
    void *device, *queue;
    void *prepared, *uploaded; /* command buffers; prepare and compose go to the first, which is committed in finish() */
    void* submitted;           /* a texture without depth: dplMetalSubmit draws over it */
    uint32_t colourFormat, depthFormat;
    void* (*beginPass)(void* program); /* an encoder in `prepared`, with colour and depth */
    void (*finish)(void* program);     /* ends it, commits both command buffers and waits */
    void* program;
    const uint8_t* avatar; /* a file */
    size_t avatarBytes;
    void* rows; /* a buffer for the positions of its splats */
    size_t rowsBytes;
    DplCamera view;
};

/** NULL: everything did what the header says. Else the first check that failed. */
const char* callMetalFromC(const struct FromC* app);

#ifdef __cplusplus
}
#endif
#endif
