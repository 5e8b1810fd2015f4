// SPDX-License-Identifier: Apache-2.0
// Linear blend skinning of one vertex (docs/reference/binding.md). Four joints move a vertex, with unorm8 weights that sum to 255. The
// transform [R | t] of a joint takes rest positions to the world.
#pragma once

#include "sdk/math/types.h"

namespace dpl {

/** m · (p, 1). */
template <class T>
Vec3<T> transformed(const Mat3x4<T>& m, const Vec3<T>& p) {
    return m[0] * p.x + m[1] * p.y + m[2] * p.z + m[3];
}

/** Σ w_k · (G_k · rest) / 255. worldFromRest: G of every joint. Joints with weight 0 are not read, so their index may be out of range. */
template <class T>
Vec3<T> skinVertex(const Vec3<T>& rest, const glm::u16vec4& joints, const glm::u8vec4& weights, const Mat3x4<T>* worldFromRest) {
    Vec3<T> sum(0);
    for (int k = 0; k < 4; ++k)
        if (weights[k] != 0) sum += T(weights[k]) * transformed(worldFromRest[joints[k]], rest);
    return sum * (T(1) / T(255));
}

/** Σ w_k · G_k / 255. Use it when both the position and directions of a vertex are transformed. */
template <class T>
Mat3x4<T> blendedTransform(const glm::u16vec4& joints, const glm::u8vec4& weights, const Mat3x4<T>* worldFromRest) {
    Mat3x4<T> sum(T(0));
    for (int k = 0; k < 4; ++k)
        if (weights[k] != 0) sum += T(weights[k]) / T(255) * worldFromRest[joints[k]];
    return sum;
}

}  // namespace dpl
