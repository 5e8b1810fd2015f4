// SPDX-License-Identifier: Apache-2.0
// Constants of the formulas, compiled as C++ and as GLSL.
#ifndef DPL_FORMULA_CONSTANTS_H
#define DPL_FORMULA_CONSTANTS_H

#ifdef __cplusplus
#define DPL_NUMBER constexpr double
namespace dpl {
#else
#define DPL_NUMBER const float
#endif

// Projection: docs/reference/projection.md, docs/reference/footprint.md, docs/reference/gate.md.
DPL_NUMBER kMaxAlpha = 0.99;          // keeps 1 − α above 0, which the backward pass divides by
DPL_NUMBER kMinAlpha = 1.0 / 255.0;   // fainter contributions to a pixel are dropped
DPL_NUMBER kMinTransmittance = 1e-4;  // a pixel at or below it takes no further splat
DPL_NUMBER kMinCompensation = 0.005;  // keeps a trace of edge-on splats
DPL_NUMBER kNearM = 0.05;             // view z; splats whose centre is nearer are not drawn
DPL_NUMBER kNearFadeEndM = 0.15;      // view z; from kNearM up to here splats fade in
DPL_NUMBER kClampMargin = 0.3;        // the Jacobian clamps x/z and y/z to the image widened by this share of half its field of view
DPL_NUMBER kGateEnd = 0.1;            // single-face splats fade in over cosθ in [0, kGateEnd]

// Binding: docs/reference/binding.md.
DPL_NUMBER kMinTriangleAreaM2 = 1e-10;  // splats of smaller triangles are not drawn
DPL_NUMBER kMaxTriangleAspect = 1e4;    // longest edge² / (2·area) when posed; splats of thinner triangles are not drawn

// Bounds of the stretch of a triangle, as singular values of F. Within [kStretchLow, kStretchHigh] F is kept. Beyond, it approaches the
// bound ± its room. Triangles stretched from kStretchFade to kStretchGone fade out, and so do those squeezed from kSqueezeFade to 0.
DPL_NUMBER kStretchLow = 0.5;
DPL_NUMBER kStretchLowRoom = 0.25;
DPL_NUMBER kStretchHigh = 1.7;
DPL_NUMBER kStretchHighRoom = 0.3;
DPL_NUMBER kStretchFade = 3.0;
DPL_NUMBER kStretchGone = 4.0;
DPL_NUMBER kSqueezeFade = 0.25;

// Light of the scene, over its mean: docs/reference/light.md. The bounds keep the ratio of two irradiances finite.
DPL_NUMBER kMinIrradiance = 0.3;
DPL_NUMBER kMaxIrradiance = 3.0;

// Level of detail: docs/reference/level-of-detail.md. The group size is kSplatGroup in shaders/shared/limits.h.
DPL_NUMBER kDetailFade = 0.5;  // with k kept ranks, ranks from k to (1 + kDetailFade)·k fade out
DPL_NUMBER kDetailGroup = 128.0;

// Spherical harmonics: docs/reference/spherical-harmonics.md.
DPL_NUMBER kShC0 = 0.28209479177387814;
DPL_NUMBER kShC1 = 0.4886025119029199;

// Coverage samples: docs/reference/coverage.md. Positions from the pixel's top left corner, px: the standard sample locations of Vulkan.
#ifdef __cplusplus
constexpr unsigned kCoverageSamples = 4;
constexpr float kCoverageSamplePx[kCoverageSamples][2] =
#else
const uint kCoverageSamples = 4u;
const vec2 kCoverageSamplePx[kCoverageSamples] =
#endif
    {{0.375f, 0.125f}, {0.875f, 0.375f}, {0.125f, 0.625f}, {0.625f, 0.875f}};

#ifdef __cplusplus
}  // namespace dpl
#endif
#undef DPL_NUMBER
#endif
