// SPDX-License-Identifier: Apache-2.0
// Maps the types and keywords of sdk/math/formulas (see its README) to GLSL. Include this before any of those files.
#ifndef DPL_FORMULAS_GLSL
#define DPL_FORMULAS_GLSL
#define DPL_FN
#define real float
#define real2 vec2
#define real3 vec3
#define truth bool
#define choose(condition, yes, no) ((condition) ? (yes) : (no))
#include "sdk/math/formulas/constants.h"
#endif
