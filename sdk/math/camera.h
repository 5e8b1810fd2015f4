// SPDX-License-Identifier: Apache-2.0
// A pinhole camera with OpenCV axes: x right, y down, z forward. (0,0) is the top left corner of the image, so the centre of the first
// pixel is (0.5, 0.5).
#pragma once

#include <cstdint>

#include "sdk/math/types.h"

namespace dpl {

template <class T>
struct PinholeCamera {
    uint32_t widthPx = 0, heightPx = 0;
    T fx = 0, fy = 0, cx = 0, cy = 0;  // pixels
    Mat3<T> viewFromWorldRotation{1};  // X_view = R X_world + t
    Vec3<T> viewFromWorldTranslation{0};

    Vec3<T> toView(const Vec3<T>& world) const { return viewFromWorldRotation * world + viewFromWorldTranslation; }
    /** World position of the eye. */
    Vec3<T> eye() const { return -(glm::transpose(viewFromWorldRotation) * viewFromWorldTranslation); }
    /** Image position, px, of a view-space point; z must not be 0. */
    Vec2<T> pixelOf(const Vec3<T>& view) const { return {fx * view.x / view.z + cx, fy * view.y / view.z + cy}; }

    template <class U>
    PinholeCamera<U> cast() const {
        return {widthPx, heightPx, U(fx), U(fy), U(cx), U(cy), Mat3<U>(viewFromWorldRotation), Vec3<U>(viewFromWorldTranslation)};
    }
    /** The same camera for an image of `factor` times the size. Sizes are rounded to whole pixels; focal lengths follow the rounded sizes,
     *  so the field of view stays. */
    PinholeCamera scaled(T factor) const {
        PinholeCamera c = *this;
        c.widthPx = uint32_t(T(widthPx) * factor + T(0.5));
        c.heightPx = uint32_t(T(heightPx) * factor + T(0.5));
        const T sx = T(c.widthPx) / T(widthPx), sy = T(c.heightPx) / T(heightPx);
        c.fx *= sx, c.cx *= sx, c.fy *= sy, c.cy *= sy;
        return c;
    }
};

using Cameraf = PinholeCamera<float>;
using Camerad = PinholeCamera<double>;

}  // namespace dpl
