// SPDX-License-Identifier: Apache-2.0
// The edge of a mask: pixels that may be the person's or only in part, and what lies behind the person there.
#pragma once

#include "reconstruction/input/capture/frame_picture.h"

namespace dpl {

struct UnsureEdge {
    std::vector<uint8_t> unsure;  // 1: within the radius of the mask's edge, with background nearby. A row-major plane of the picture
    std::vector<float> behind;    // three channels a pixel, 0 … 255: colours of the background nearby; 0 where unsure is 0
};

/** The radius is a pixel, in which person and background mix; masks that networks found may be wrong within kFoundMaskEdge. Background is
 *  what lies farther outside; each unsure pixel takes its mean with a Gaussian weight. Where there is none nearby, as between arm and body,
 *  the mask decides. */
UnsureEdge unsureEdge(const FramePicture& picture);

}  // namespace dpl
