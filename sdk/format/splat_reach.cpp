// SPDX-License-Identifier: Apache-2.0
#include "sdk/format/splat_reach.h"

#include <algorithm>
#include <cmath>

#include "sdk/math/projection.h"

namespace dpl {

std::vector<TriangleReach> reachOfTriangles(const CodedSplats& s, size_t triangles) {
    std::vector<TriangleReach> out(triangles);
    for (const SplatChunk& c : s.chunks) {
        const float low = std::log(c.scaleMinM), width = std::log(c.scaleMaxM) - low;
        for (uint32_t i = c.firstSplat; i < c.firstSplat + c.splatCount; ++i) {
            TriangleReach& triangle = out[s.parents[c.firstParent + s.parent[i]]];
            const uint32_t place = s.place[i], size = s.size[i];
            const bool gated = size & kSingleFaceBit;
            triangle.gatedSplats += gated;
            triangle.freeSplats += !gated;
            const float opacity = float(size >> 22 & 255) / 255;
            if (!(opacity > float(kMinAlpha))) continue;  // never seen
            const float rootLevel = std::sqrt(2 * std::log(opacity / float(kMinAlpha)));
            const int u = int(place & 2047) - kUvZero, v = int(place >> 11 & 2047) - kUvZero;
            triangle.overshoots |= u < 0 || v < 0 || u + v > int(kUvSteps);
            triangle.rootLevel = std::max(triangle.rootLevel, rootLevel);
            const float largest =
                std::exp(low + width * float(std::max(size & kScaleCodes, size >> 11 & kScaleCodes)) / kScaleCodes) * 1.00001f;
            triangle.reachM = std::max(triangle.reachM, rootLevel * largest);
        }
    }
    return out;
}

}  // namespace dpl
