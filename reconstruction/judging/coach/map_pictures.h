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

/** Three pictures: size of a pixel, pictures that show a place, blur. Bright is good; grey is in no still picture. */
Result<std::vector<MapPicture>> drawMap(const MeshData& surface, std::span<const SeenTriangle> map);

}  // namespace dpl
