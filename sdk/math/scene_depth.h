// SPDX-License-Identifier: Apache-2.0
// Depth test against the app's opaque scene: a splat adds nothing to a pixel where the scene is nearer than the splat's view z. At equal
// depth the splat is drawn.
#pragma once

#include <limits>

namespace dpl {

/** Largest view z, metres, at which a splat still shows in a pixel. A scene depth that is 0, negative or NaN means "no scene here" and
 * gives infinity. */
inline float farthestSeenM(float sceneDepthM) {
    return sceneDepthM > 0 ? sceneDepthM : std::numeric_limits<float>::infinity();
}

}  // namespace dpl
