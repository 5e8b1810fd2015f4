// SPDX-License-Identifier: Apache-2.0
// Interface between splat_project.cpp, which hands out the work of projection, and its SIMD kernel project_kernel.cpp. Private to
// sdk/splat.
#pragma once

#include "sdk/splat/buffers.h"
#include "sdk/splat/packed_layout.h"

namespace dpl {

/** Constants of one view. */
struct ProjectView {
    float rotation[9];             // row-major; to the view's metres from the subject's, so it has the scale of a placed subject
    float translation[3], eye[3];  // of the view, and in the subject's space
    uint32_t widthPx, heightPx;
    float fx, fy, cx, cy, width, height;  // width, height: the same as floats, px
    float minX, maxX, minY, maxY;         // limits of x/z and y/z in the Jacobian
    float kappaPx2;                       // of a sample
    float reachPx;                        // of a sample from the pixel's centre, along an axis
    uint32_t samples;                     // a pixel
    bool compensated;
};

/** Projects `groups` packed groups; the first splat of the first one is `firstSplat`. */
struct ProjectTask {
    const ProjectView* view;
    const float* packed;
    uint32_t groups, firstSplat, shDegree;
    const TriangleView* triangles;  // null: general splats
    uint32_t triangleCount;         // triangles[triangleCount] is invalid; indices out of range read it
    uint32_t firstIndex;            // index of this call's splat 0 in SplatEngine::projected()
    ProjectedSplat* projected;      // at firstIndex; indexed by splat
    ForwardRecord<float>* records;  // the same, for bound splats; null: not recorded
    TileBox* boxes;                 // the same
    uint32_t *keys, *values;        // output: depth bits and indices of the block's visible splats
    BlockVisible* visible;          // in and out: counts of the block so far
};

void projectGroups(const ProjectTask& task);

}  // namespace dpl
