// SPDX-License-Identifier: Apache-2.0
/* The splats of a picture, projected and sorted but not blended, for a program that blends them with a graphics API that libdoppel does
 * not know, such as WebGL2 (platform/web). Units, frames, threads, errors and struct sizes are as in doppel.h. All of it is experimental.
 */
#ifndef DOPPEL_DOPPEL_SPLATS_H
#define DOPPEL_DOPPEL_SPLATS_H

#include "doppel.h"

#ifdef __cplusplus
extern "C" {
#endif

/** A splat on the screen. With dx and dy from its centre to a pixel, px,
 *      alpha = min(0.99, opacity · exp(-½ (conicA (dx + slope dy)² + inverseVarianceY dy²)))
 *  and the splat adds nothing where alpha is below 1/255. Near fade, single-face gate, level of detail and the low-pass of a pixel are in
 *  these numbers. 32 bytes. Experimental. */
typedef struct DplScreenSplat {
    float x, y;                         /**< centre, px: the top left pixel has its centre at (0.5, 0.5), y goes down */
    float depthM;                       /**< view z, metres */
    float conicA, slope;                /**< px⁻²; and without a unit */
    float inverseVarianceY;             /**< px⁻² */
    uint16_t red, green, blue, opacity; /**< 65535 is 1; colour is display-referred and not multiplied by opacity */
} DplScreenSplat;

/** What dplProject wrote. Experimental. */
typedef struct DplProjection {
    uint32_t structSize;
    uint32_t counts[DPL_MAX_VIEWS]; /**< splats of each view; those of the second view follow those of the first */
    uint32_t samples;               /**< 1: a pixel is blended at its centre. 4: at (0.375, 0.125), (0.875, 0.375), (0.125, 0.625) and
                                         (0.625, 0.875) from its top left corner, and is the mean of the four results */
} DplProjection;

/** dplDrawTogether, but instead of pixels it writes the splats that the pixels would be made of, farthest first: blend them in this order,
 *  each over what is there, onto transparent black. Only a context that draws on the CPU can. Scene depth of the views is not read. The
 *  frame counts for dplSetFrameBudget and dplGetFrameStats, and dplReadImages has no picture of it. A warm call allocates nothing.
 *  splats: room for `capacity` of them; the sum of splatCount of the avatars, once a view, is always enough.
 *  DPL_ERROR_INVALID_ARGUMENT: as dplDrawTogether, or more splats than capacity; what `splats` then holds is undefined.
 *  DPL_ERROR_UNSUPPORTED: the context draws on a GPU. */
DPL_EXPERIMENTAL DplResult dplProject(DplContext context, const DplAvatar* avatars, uint32_t avatarCount, const DplCamera* views,
                                      uint32_t viewCount, DplScreenSplat* splats, uint32_t capacity, DplProjection* projection);

#ifdef __cplusplus
}
#endif
#endif
