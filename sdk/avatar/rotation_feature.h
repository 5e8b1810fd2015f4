// SPDX-License-Identifier: Apache-2.0
// A rotation as six numbers that are smooth everywhere, as pose correctives and lags take it.
#pragma once

#include "sdk/math/types.h"

namespace dpl {

/** Feature of a joint's local rotation: the first two columns of its matrix minus those of the identity, six numbers. */
template <class T>
inline void correctiveFeature(const glm::qua<T>& localRotation, T feature[6]) {
    const Mat3<T> r = glm::mat3_cast(glm::normalize(localRotation));
    for (int i = 0; i < 3; ++i) feature[i] = r[0][i] - T(i == 0), feature[3 + i] = r[1][i] - T(i == 1);
}

/** Adds ∂loss/∂ left turn of the rotation to g. gFeature: ∂loss/∂ its feature, six numbers. */
inline void addFeatureGradient(const Quatd& localRotation, const double gFeature[6], Vec3d& g) {
    const Mat3d r = glm::mat3_cast(glm::normalize(localRotation));
    g += glm::cross(r[0], Vec3d(gFeature[0], gFeature[1], gFeature[2])) + glm::cross(r[1], Vec3d(gFeature[3], gFeature[4], gFeature[5]));
}

}  // namespace dpl
