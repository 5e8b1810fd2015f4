// Work sizes and numbers that C++ and GLSL must agree on. The footprint constants equal those of sdk/math/projection.h and
// binding.h; sdk/render/shared_checks.cpp holds them together.
#ifndef DPL_SHARED_LIMITS_H
#define DPL_SHARED_LIMITS_H
#include "shaders/shared/shim.h"
DPL_SHARED_BEGIN

const uint kMaxViews = 2u;

// Group sizes. No kernel assumes a subgroup width: scans go through shared memory.
const uint kVertexGroup = 128u;
const uint kSplatGroup = 128u;
const uint kScanGroup = 256u;
const uint kCompactItemsPerLane = 4u;
const uint kCompactBlock = 1024u;    // kScanGroup * kCompactItemsPerLane
const uint kSortGroup = 128u;
const uint kSortItemsPerLane = 16u;
const uint kSortBlock = 2048u;       // kSortGroup * kSortItemsPerLane
const uint kSortDigitBits = 4u;
const uint kSortDigits = 16u;
const uint kSortRounds = 4u;         // 16-bit keys
const uint kMaxDepthKey = 65535u;

const uint kTriangleMask = 0x00FFFFFFu;  // SplatRecord.triangleAndFlags: triangle in the low 24 bits, flags above
const uint kFlagShift = 24u;
const uint kGateFlag = 1u;               // kSplatSingleFace
const uint kInvisibleKey = 0xFFFFFFFFu;  // no view shows the splat

const float kGpuMinTriangleAreaM2 = 1e-10;
const float kGpuMaxTriangleAspect = 1e4;
const float kGpuMaxAlpha = 0.99;
const float kGpuMinAlpha = 0.003921568627450980;
const float kGpuMinCompensation = 0.005;
const float kGpuNearM = 0.05;
const float kGpuNearFadeEndM = 0.15;
const float kGpuGateEnd = 0.1;

DPL_SHARED_END
#endif
