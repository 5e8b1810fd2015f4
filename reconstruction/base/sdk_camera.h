// SPDX-License-Identifier: Apache-2.0
// Converts a camera to the public API's struct.
#pragma once

#include <doppel/doppel.h>

#include "sdk/math/camera.h"

namespace dpl {

inline DplCamera sdkCamera(const Cameraf& camera) {
    DplCamera out{};
    out.structSize = sizeof out;
    out.widthPx = camera.widthPx, out.heightPx = camera.heightPx;
    out.fx = camera.fx, out.fy = camera.fy, out.cx = camera.cx, out.cy = camera.cy;
    for (int row = 0; row < 3; ++row) {
        for (int column = 0; column < 3; ++column) out.viewFromWorld[row * 4 + column] = camera.viewFromWorldRotation[column][row];
        out.viewFromWorld[row * 4 + 3] = camera.viewFromWorldTranslation[row];
    }
    return out;
}

}  // namespace dpl
