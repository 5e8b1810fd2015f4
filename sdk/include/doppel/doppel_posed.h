// SPDX-License-Identifier: Apache-2.0
/* Posed splats and posed vertices, written into memory of the program in a layout of its choice, for engines that draw splats or meshes
 * themselves. doppel.h includes this header; units, frames, threads, errors and struct sizes are as there. All of it is experimental.
 *
 *   DplBufferElement place[3] = {{sizeof place[0], DPL_SPLAT_POSITION, DPL_NUMBER_FLOAT, 0, 0, 32},      32 bytes a splat, interleaved
 *                                {sizeof place[0], DPL_SPLAT_ROTATION, DPL_NUMBER_HALF, 0, 12, 32}, ...};
 *   DplBuffer buffer = {sizeof buffer, 3, place, bytes, byteCount};
 *   dplWriteSplats(avatar, NULL, &buffer, &written);
 *
 * Everything is in the world: in the current pose, placed by the avatar's transform. Writing counts as drawing: clothes remember the pose
 * (dplSetPoseAtTime). The first call for an avatar takes milliseconds more and allocates; later ones of the same layout do not allocate. */
#ifndef DOPPEL_DOPPEL_POSED_H
#define DOPPEL_DOPPEL_POSED_H

#include "doppel.h"

#ifdef __cplusplus
extern "C" {
#endif

/* ---------------------------------------------------------------- a buffer */

/** How a number is stored, in the byte order of the machine. */
typedef enum DplNumber {
    DPL_NUMBER_FLOAT = 0, /**< 4 bytes */
    DPL_NUMBER_HALF = 1,  /**< 2 bytes, IEEE binary16. Larger magnitudes become 65504; DplWritten counts them */
    DPL_NUMBER_FORCE_INT32 = 0x7fffffff
} DplNumber;

#define DPL_MAX_BUFFER_ELEMENTS 16u /**< in one buffer */

/** Where one property lies in a buffer. Experimental. */
typedef struct DplBufferElement {
    uint32_t structSize;
    uint32_t property; /**< DplSplatProperty or DplVertexProperty */
    DplNumber number;
    uint32_t reserved;    /**< 0 */
    uint64_t offsetBytes; /**< from the start of the buffer to the first splat's or vertex's */
    uint64_t strideBytes; /**< from one to the next; 0: without gaps */
} DplBufferElement;

/** Memory of the caller, written during the call. Any alignment; bytes between the elements stay as they are. The same property may lie in
 *  it more than once. Experimental. */
typedef struct DplBuffer {
    uint32_t structSize;
    uint32_t elementCount; /**< 1 to DPL_MAX_BUFFER_ELEMENTS */
    const DplBufferElement* elements;
    void* data;
    uint64_t dataBytes;
} DplBuffer;

/** What was written. Experimental. */
typedef struct DplWritten {
    uint32_t structSize;
    uint32_t count;     /**< splats or vertices */
    uint64_t saturated; /**< numbers that were too large for a half */
} DplWritten;

/* ---------------------------------------------------------------- splats */

/** What a splat has: a Gaussian of covariance R·diag(scale²)·Rᵀ. */
typedef enum DplSplatProperty {
    DPL_SPLAT_POSITION = 0,   /**< 3 numbers: centre, metres */
    DPL_SPLAT_ROTATION = 1,   /**< 4: unit quaternion R, x y z w */
    DPL_SPLAT_SCALE = 2,      /**< 3: standard deviations along the axes of R, metres. Splats are flat; the last is 0.0001 */
    DPL_SPLAT_COVARIANCE = 3, /**< 6: xx, xy, xz, yy, yz, zz, m². Too small for most halves */
    DPL_SPLAT_OPACITY = 4,    /**< 1: 0 to 1. 0: not shown in this pose, or from this eye */
    /** 3: display-referred (sRGB) red, green, blue, 0 to 1, as seen from the eye; without an eye that of SH band 0 alone. */
    DPL_SPLAT_COLOUR = 5,
    /** 3·(shDegree + 1)²: spherical harmonics of the colour, turned into the world with the light of the pose in them; three channels of
     *  the first coefficient, then of the second and so on. Order and signs are those of 3D Gaussian splatting files:
     *  colour = 0.5 + Σ basis·coefficient, clamped to 0 and 1, for the unit direction from the eye to the splat. */
    DPL_SPLAT_SH = 6,
    DPL_SPLAT_ROTATION_WXYZ = 7, /**< 4: as DPL_SPLAT_ROTATION, w first */
    DPL_SPLAT_FORCE_INT32 = 0x7fffffff
} DplSplatProperty;

/** Which splats dplWriteSplats writes, and for whom. Zeros: all splats, for no eye, SH of degree 0. Experimental. */
typedef struct DplSplatOptions {
    uint32_t structSize;
    uint32_t splatBudget; /**< level of detail: most splats, but at least one of each group of 128; kept ones grow. 0: all of them */
    /** Where the viewer is: three floats, metres, world. The opacity then contains the gate by which most splats show their outside alone
     *  (docs/reference/gate.md). NULL: it does not, and splats show both sides. */
    const float* eye;
    uint32_t shDegree; /**< of DPL_SPLAT_SH, 0 to 3; bands that the avatar lacks are 0 */
} DplSplatOptions;

/** Writes the splats of the current pose. Their number and order depend on the avatar and splatBudget alone: a splat that shows nothing has
 *  opacity 0, and only finite numbers are written.
 *  A renderer draws them as dplRender does if it adds the low-pass of the avatar (1/12 px² where doppel has trained it) to the variances
 *  on the screen, lowers the opacity to keep the energy, and blends display-referred colours, farthest first by view z. Not in the
 *  numbers are the fade at the near plane, and the samples of a pixel far away.
 *  options: NULL means zeros. Level of detail is that of splatBudget, not of dplSetDetail. Splats of hidden layers have opacity 0.
 *  buffer: NULL only counts.
 *  DPL_ERROR_INVALID_ARGUMENT: an unknown property or number, a stride smaller than the property, elements that overlap or share a
 *  range at different strides, a buffer that is too short, an eye that is not finite, general splats. Nothing is then written, and the
 *  text says what is wrong.
 *  DPL_ERROR_UNSUPPORTED: the context draws on a GPU, which keeps the splats. dplVulkanWriteSplats and dplMetalWriteSplats write them into
 *  buffers of a GPU that the program lends. */
DPL_EXPERIMENTAL DplResult dplWriteSplats(DplAvatar avatar, const DplSplatOptions* options, const DplBuffer* buffer, DplWritten* written);

/* ---------------------------------------------------------------- mesh */

/** What a vertex has. */
typedef enum DplVertexProperty {
    DPL_VERTEX_POSITION = 0, /**< 3 numbers, metres */
    DPL_VERTEX_NORMAL = 1,   /**< 3: unit, the mean of its triangles by area; vertices at one place at rest share it */
    DPL_VERTEX_FORCE_INT32 = 0x7fffffff
} DplVertexProperty;

/** Writes the vertices of the current pose, DplAvatarInfo::vertexCount of them, on the CPU and whatever draws the avatar. Hidden layers are
 *  written too. Their triangles: dplGetPosedMesh. buffer: NULL only counts. Errors as of dplWriteSplats. */
DPL_EXPERIMENTAL DplResult dplWriteMesh(DplAvatar avatar, const DplBuffer* buffer, DplWritten* written);

#ifdef __cplusplus
}
#endif
#endif
