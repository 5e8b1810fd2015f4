// SPDX-License-Identifier: Apache-2.0
// Frozen (tests/baseline/README.md). Work sizes and numbers that C++ and GLSL must agree on. The footprint constants equal those of
// sdk/math/projection.h and binding.h, brightness those of sdk/avatar/pose_correctives.h; plain_records.cpp holds them together.
#ifndef DPL_PLAIN_LIMITS_H
#define DPL_PLAIN_LIMITS_H
#include "tools/bench/baseline/shaders/shared/shim.h"
DPL_PLAIN_BEGIN

DPL_PLAIN_CONST uint kMaxViews = 2u;

// Group sizes. No kernel assumes a subgroup width: scans go through shared memory.
DPL_PLAIN_CONST uint kVertexGroup = 128u;
DPL_PLAIN_CONST uint kSplatGroup = 128u;
DPL_PLAIN_CONST uint kScanGroup = 256u;
DPL_PLAIN_CONST uint kCompactItemsPerLane = 4u;
DPL_PLAIN_CONST uint kCompactBlock = 1024u;  // kScanGroup * kCompactItemsPerLane
DPL_PLAIN_CONST uint kSortGroup = 128u;
DPL_PLAIN_CONST uint kSortItemsPerLane = 16u;
DPL_PLAIN_CONST uint kSortBlock = 2048u;  // kSortGroup * kSortItemsPerLane
DPL_PLAIN_CONST uint kSortDigitBits = 4u;
DPL_PLAIN_CONST uint kSortDigits = 16u;
DPL_PLAIN_CONST uint kSortRounds = 8u;  // 32-bit float keys

DPL_PLAIN_CONST uint kTriangleMask = 0x00FFFFFFu;  // SplatRecord.triangleAndFlags: triangle in the low 24 bits, flags above
DPL_PLAIN_CONST uint kFlagShift = 24u;
DPL_PLAIN_CONST uint kGateFlag = 1u;               // kSplatSingleFace
DPL_PLAIN_CONST uint kInvisibleKey = 0xFFFFFFFFu;  // no view shows the splat

DPL_PLAIN_CONST float kGpuMinTriangleAreaM2 = 1e-10;
DPL_PLAIN_CONST float kGpuMaxTriangleAspect = 1e4;
DPL_PLAIN_CONST float kGpuMaxAlpha = 0.99;
DPL_PLAIN_CONST float kGpuMinAlpha = 0.003921568627450980;
DPL_PLAIN_CONST float kGpuMinCompensation = 0.005;
DPL_PLAIN_CONST float kGpuNearM = 0.05;
DPL_PLAIN_CONST float kGpuNearFadeEndM = 0.15;
DPL_PLAIN_CONST float kGpuGateEnd = 0.1;
DPL_PLAIN_CONST float kGpuMinLight = 0.2;
DPL_PLAIN_CONST float kGpuMaxLight = 3.0;

DPL_PLAIN_END
#endif
