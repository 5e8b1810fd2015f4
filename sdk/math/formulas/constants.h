// SPDX-License-Identifier: Apache-2.0
// Numbers of the formulas, read by C++ and GLSL.
#ifndef DPL_FORMULA_CONSTANTS_H
#define DPL_FORMULA_CONSTANTS_H

#ifdef __cplusplus
#define DPL_NUMBER constexpr double
namespace dpl {
#else
#define DPL_NUMBER const float
#endif

// Projection: docs/reference/projection.md, docs/reference/footprint.md, docs/reference/gate.md.
DPL_NUMBER kMaxAlpha = 0.99;
DPL_NUMBER kMinAlpha = 1.0 / 255.0;
DPL_NUMBER kMinTransmittance = 1e-4;
DPL_NUMBER kMinCompensation = 0.005;
DPL_NUMBER kNearM = 0.05;         // splats whose centre is nearer are not drawn
DPL_NUMBER kNearFadeEndM = 0.15;  // they fade in up to here
DPL_NUMBER kClampMargin = 0.3;    // x/z and y/z are clamped to the image widened by this fraction of its half field of view
DPL_NUMBER kGateEnd = 0.1;        // single-face splats fade in over cosθ in [0, kGateEnd]

// Binding: docs/reference/binding.md.
DPL_NUMBER kMinTriangleAreaM2 = 1e-10;  // smaller triangles carry no splats
DPL_NUMBER kMaxTriangleAspect = 1e4;    // longest edge² / (2·area) of a posed triangle; splats of worse triangles are not drawn

// Level of detail: docs/reference/level-of-detail.md. The group size is kSplatGroup in shaders/shared/limits.h.
DPL_NUMBER kDetailFade = 0.5;  // splats whose rank lies within this share beyond the kept ones are fading
DPL_NUMBER kDetailGroup = 128.0;

// Spherical harmonics: docs/reference/spherical-harmonics.md.
DPL_NUMBER kShC0 = 0.28209479177387814;
DPL_NUMBER kShC1 = 0.4886025119029199;

// Coverage samples: docs/reference/coverage.md. Positions from the pixel's top left corner: the standard locations of four samples.
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
