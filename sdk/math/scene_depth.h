// SPDX-License-Identifier: Apache-2.0
// What an app's depth buffer hides: a splat adds nothing to a pixel whose opaque scene is nearer than the splat's own view z. Equal depths
// are seen.
#pragma once

#include <limits>

namespace dpl {

/** The largest view z that is seen in a pixel: infinite where nothing is there, which is everything that is not above 0, not a number
 * included. */
inline float farthestSeenM(float sceneDepthM) {
    return sceneDepthM > 0 ? sceneDepthM : std::numeric_limits<float>::infinity();
}

}  // namespace dpl
