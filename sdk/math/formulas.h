// SPDX-License-Identifier: Apache-2.0
// The shared formulas (sdk/math/formulas/README.md) as C++ over float or double: static members of Formulas<T>. binding.h, projection.h,
// detail.h and sh.h wrap them with cameras and triangles.
#pragma once

#include <cmath>

#include "sdk/math/formulas/constants.h"
#include "sdk/math/types.h"

namespace dpl {
namespace formula_scope {  // makes the functions visible that the formulas call without a namespace

using glm::clamp;
using glm::cross;
using glm::dot;
using glm::length;
using glm::max;
using glm::normalize;
using std::abs;
using std::log;
using std::pow;
using std::sqrt;

template <class T>
inline T choose(bool condition, T yes, T no) {
    return condition ? yes : no;
}

template <class T>
struct Formulas {
    using real = T;
    using real2 = Vec2<T>;
    using real3 = Vec3<T>;
    using truth = bool;
    using uint = uint32_t;
#define DPL_FN static inline
#include "sdk/math/formulas/binding.inl"
#include "sdk/math/formulas/detail.inl"
#include "sdk/math/formulas/footprint.inl"
#include "sdk/math/formulas/pose.inl"
#include "sdk/math/formulas/sh.inl"
// These need files above.
#include "sdk/math/formulas/cull.inl"
#include "sdk/math/formulas/light.inl"
#undef DPL_FN
};

}  // namespace formula_scope

using formula_scope::Formulas;

}  // namespace dpl
