// SPDX-License-Identifier: Apache-2.0
// Depth buffers of an app, for tests: a tilted plane through the subject, rough in places, mixed with values that mean "no scene" and with
// extreme values.
#pragma once

#include <cstdint>
#include <limits>
#include <random>
#include <vector>

namespace dpl {

/** One float a pixel, view z. throughM: the plane's view z in the middle of the image. */
inline std::vector<float> randomSceneDepth(uint32_t seed, uint32_t widthPx, uint32_t heightPx, float throughM) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<float> uniform(0, 1);
    const float tiltX = 2 * uniform(random) - 1, tiltY = 2 * uniform(random) - 1, infinite = std::numeric_limits<float>::infinity();
    const float special[] = {0, -1, infinite, -infinite, std::numeric_limits<float>::quiet_NaN(), 1e-30f, 1e30f, 1e-40f};
    std::vector<float> depthM;
    for (uint32_t y = 0; y < heightPx; ++y)
        for (uint32_t x = 0; x < widthPx; ++x) {
            const float plane = throughM + tiltX * (float(x) / float(widthPx) - 0.5f) + tiltY * (float(y) / float(heightPx) - 0.5f);
            const uint32_t kind = random() % 32;
            depthM.push_back(kind < 8 ? special[kind] : kind < 12 ? plane + 0.6f * (uniform(random) - 0.5f) : plane);
        }
    return depthM;
}

}  // namespace dpl
