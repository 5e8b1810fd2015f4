// SPDX-License-Identifier: Apache-2.0
// The residual of one observation in a bundle adjustment. Private to reconstruction/input/cameras and its tests.
#pragma once

#include <ceres/rotation.h>

#include "sdk/math/camera.h"

namespace dpl {

/** Miss of one observation, px. Parameters: rotation (quaternion xyzw), translation, [ln of the focal factor, k1], point. */
struct ReprojectionMiss {
    double fx, fy, cx, cy, k2, u, v;

    template <class T>
    bool operator()(const T* xyzw, const T* translation, const T* lens, const T* point, T* miss) const {
        using std::exp;
        const T wxyz[4] = {xyzw[3], xyzw[0], xyzw[1], xyzw[2]};
        T view[3];
        ceres::UnitQuaternionRotatePoint(wxyz, point, view);
        for (int i = 0; i < 3; ++i) view[i] += translation[i];
        if (view[2] < 1e-9) return false;  // behind the camera: the solver takes a smaller step
        const T x = view[0] / view[2], y = view[1] / view[2], r2 = x * x + y * y;
        const T scale = exp(lens[0]) * (1.0 + lens[1] * r2 + k2 * r2 * r2);
        miss[0] = fx * scale * x + cx - u;
        miss[1] = fy * scale * y + cy - v;
        return true;
    }
};

}  // namespace dpl
