// SPDX-License-Identifier: Apache-2.0
/* The posed surface of an avatar, on the CPU and whatever draws it: its shadow on the floor, its layers, what a ray meets, its mesh.
 * doppel.h includes this header; units, frames, threads, errors and struct sizes are as there. All of it is experimental.
 *
 * The surface is that of the current pose and transform. The first call after a new pose poses the vertices; those that follow reuse
 * them. Clothes are drawn by what they remember (dplSetPoseAtTime), so calls between drawing and the next pose see what was drawn. */
#ifndef DOPPEL_DOPPEL_SURFACE_H
#define DOPPEL_DOPPEL_SURFACE_H

#include "doppel.h"

#ifdef __cplusplus
extern "C" {
#endif

/* ---------------------------------------------------------------- a shadow on the floor */

#define DPL_CONTACT_SHADOW_PX 64u /**< width and height of the picture of a contact shadow */

/** Where the picture of a contact shadow lies in the world. Its points are corner + u·across + v·along with u, v from 0 to 1; the centre of
 *  the pixel in column x and row y has u = (x + 1/2)/64, v = (y + 1/2)/64. Experimental. */
typedef struct DplContactShadow {
    uint32_t structSize;
    uint32_t darkest; /**< largest alpha of the picture; 0: nothing is near the floor, and there is nothing to draw */
    float corner[3];  /**< metres, on the floor: outer corner of the first pixel */
    float across[3];  /**< metres: along the first row, from end to end */
    float along[3];   /**< metres: along the first column, from end to end; as long as `across`, and at a right angle to it */
} DplContactShadow;

/** The shadow by which feet stand on a floor: how much of an even sky the lowest 0.3 m of the posed mesh hide from it. Draw it as black of
 *  this alpha onto the floor, before the avatar; scale the alpha by how even the light of your scene is. It is soft, wider the farther its
 *  foot is from the floor, and gone from 0.3 m on: of the avatar, so of 3 m where its transform scales by 10.
 *  floorM: height of the app's level floor, metres, world y. NULL: the plane on which the avatar stands at rest (y = 0 of avatar space,
 *  placed by its transform). alpha: DPL_CONTACT_SHADOW_PX² bytes, row by row; its outermost pixels are 0, so a texture may clamp to them.
 *  The picture lies on a fixed grid of the avatar's space and has one of a few sizes, so it does not swim. Equal input gives equal bytes.
 *  DPL_ERROR_INVALID_ARGUMENT: a floor that is not finite or beyond 100 km, too few bytes, NULL, or general splats, which have no mesh.
 *  Formulas and times: docs/reference/surface.md. */
DPL_EXPERIMENTAL DplResult dplGetContactShadow(DplAvatar avatar, const float* floorM, uint8_t* alpha, size_t alphaBytes,
                                               DplContactShadow* shadow);

/* ---------------------------------------------------------------- layers */

/** What dplGetLayerInfo tells of a layer: the body, a garment, the hair. Experimental. */
typedef struct DplLayerInfo {
    uint32_t structSize;
    uint32_t triangleCount;
    const char* name; /**< "body", "top" ...; lives as long as the avatar */
    const char* role; /**< "body", "garment" or "hair"; lives as long as the avatar */
    uint32_t hidden;  /**< DPL_TRUE after dplHideLayer */
} DplLayerInfo;

/** layer: 0 to layerCount - 1 of dplGetAvatarInfo, else DPL_ERROR_NOT_FOUND. An avatar without clothes as layers is one layer, its body. */
DPL_EXPERIMENTAL DplResult dplGetLayerInfo(DplAvatar avatar, uint32_t layer, DplLayerInfo* info);

/** Hides a layer in every picture from now on, or shows it again (DPL_FALSE); all renderers and the depth of the mesh follow. What lies
 *  below shows. A hidden layer casts no contact shadow and is not picked. Level of detail still counts its splats.
 *  Most scans know nothing of what their clothes cover, so most layers cannot be hidden; clothes over other clothes can, and those that
 *  `doppel dress` has put over skin that was seen. The first call for a layer takes up to a tenth of a second.
 *  DPL_ERROR_UNSUPPORTED: the layer is the body, nothing lies below it, or more than 5 % of what would show carries no splats; the text
 *  says which. DPL_ERROR_NOT_FOUND: no such layer. DPL_ERROR_INVALID_ARGUMENT: general splats. */
DPL_EXPERIMENTAL DplResult dplHideLayer(DplAvatar avatar, uint32_t layer, int hidden);

/* ---------------------------------------------------------------- picking */

/** What a ray meets first. Experimental. */
typedef struct DplPick {
    uint32_t structSize;
    uint32_t hit;    /**< DPL_FALSE: the ray meets no avatar, and all that follows is 0 */
    uint32_t avatar; /**< index among the avatars of the call */
    uint32_t layer;  /**< of that avatar, for dplGetLayerInfo; 0, its body, where it has no clothes as layers */
    uint32_t joint;  /**< that with the largest weight at the point, for dplGetJointInfo */
    float distanceM; /**< from the ray's origin, metres of the world */
    float point[3];  /**< metres, world */
    float normal[3]; /**< unit, world: of the triangle, towards the side that the ray comes from */
} DplPick;

/** Finds what a ray meets first: the avatar, its layer, the joint that moves the place, and the point. Either side of the posed mesh
 *  counts, so a ray from within meets the surface too; what lies behind the origin does not count. Splats are not asked, so the point may
 *  lie where they are faint, and a few millimetres below or above them.
 *  avatars: 1 to DPL_MAX_TOGETHER avatars, of any contexts. origin: three floats, metres, world. direction: three floats of any length
 *  above 0.
 *  DPL_ERROR_INVALID_ARGUMENT: a number that is not finite, a direction of length 0, an origin beyond 100 km, NULL, or general splats among
 *  the avatars (the text names them by their number): they have no mesh. */
DPL_EXPERIMENTAL DplResult dplPick(const DplAvatar* avatars, uint32_t avatarCount, const float* origin, const float* direction,
                                   DplPick* pick);

/* ---------------------------------------------------------------- the posed mesh */

/** Copies the posed mesh, for programs that cast its shadow or collide with it: the surface that the splats lie on, clothes included.
 *  positions: 3 floats a vertex, metres, in the avatar's own space, which dplSetTransform places in the world; vertexCount of
 *  dplGetAvatarInfo. NULL, with a vertexCount of 0: not wanted.
 *  triangles: 3 vertex numbers each; triangleCount of dplGetAvatarInfo. A triangle of a hidden layer (dplHideLayer) is three zeros. They
 *  change with hidden layers alone, so most programs read them once. NULL, with a triangleCount of 0: not wanted.
 *  DPL_ERROR_INVALID_ARGUMENT: other counts, or general splats, which have no mesh. */
DPL_EXPERIMENTAL DplResult dplGetPosedMesh(DplAvatar avatar, float* positions, uint32_t vertexCount, uint32_t* triangles,
                                           uint32_t triangleCount);

#ifdef __cplusplus
}
#endif
#endif
