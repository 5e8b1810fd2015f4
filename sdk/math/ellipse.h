// SPDX-License-Identifier: Apache-2.0
// Flat splats as general Gaussians: sdk/math/formulas/ellipse.inl as C++. Apart from formulas.h, which everything includes, because few
// need it.
#pragma once

#include "sdk/math/formulas.h"

namespace dpl {
namespace formula_scope {

template <class T>
struct EllipseFormulas {
    using real = T;
    using truth = bool;
    using PlaneAxes = typename Formulas<T>::PlaneAxes;
#define DPL_FN static inline
#include "sdk/math/formulas/ellipse.inl"
#undef DPL_FN
};

}  // namespace formula_scope

using formula_scope::EllipseFormulas;

}  // namespace dpl
