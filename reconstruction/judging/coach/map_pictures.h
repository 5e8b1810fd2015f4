// SPDX-License-Identifier: Apache-2.0
// The body map as pictures for the report: front and back of the surface at rest, with a colour scale.
#pragma once

#include <string>
#include <vector>

#include "reconstruction/judging/coach/body_map.h"

namespace dpl {

struct MapPicture {
    std::string title;  // "mm a pixel"
    std::vector<uint8_t> png;
};

/** A colour scale with marks; values run in equal steps of the logarithm. */
struct MapScale {
    const char* heading;
    std::vector<double> marks;  // from good to bad, or from bad to good
    bool smallIsGood;
};

/** Front and back of a surface at rest, coloured by a value for each of its triangles, with the scale below. Bright is good; a value below
 *  0, for what no picture shows, is grey. PNG. Errors: another number of values, or no triangle. */
Result<std::vector<uint8_t>> drawOnSurface(const MeshData& surface, const MapScale& scale, std::span<const double> values);

/** Three pictures: size of a pixel, pictures that show a place, blur. Bright is good; grey is in no still picture. */
Result<std::vector<MapPicture>> drawMap(const MeshData& surface, std::span<const SeenTriangle> map);

}  // namespace dpl
