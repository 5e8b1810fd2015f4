// SPDX-License-Identifier: Apache-2.0
// The trainer's backward formulas. Needs binding.glsl.
#include "sdk/math/formulas/pose.inl"
#define real33 mat3
#define atan2(y, x) atan(y, x)
#include "reconstruction/training/trainer/backward.inl"
