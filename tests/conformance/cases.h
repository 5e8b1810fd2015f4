// SPDX-License-Identifier: Apache-2.0
// The conformance kit's scenes: tiny avatars with a pose and views, each about one thing that a splat renderer gets wrong.
#pragma once

#include <string>
#include <vector>

#include "sdk/avatar/rig.h"
#include "sdk/format/avatar_data.h"
#include "sdk/math/camera.h"

namespace dpl {

/** How far a picture may be from the double-precision one. Colour over mid grey, peak 1; so alpha counts too. */
struct ToleranceBand {
    double psnrDb = 50;         // of all pixels: the product's bar
    double coveredPsnrDb = 42;  // of the pixels that either picture covers
    double maxLevels = 48;      // largest error of one channel, 8-bit levels: one splat that swaps places with its neighbour
};

struct ConformanceCase {
    std::string name;   // a file name too
    std::string about;  // what a wrong renderer does here
    AvatarData avatar;
    Pose pose;
    std::vector<Cameraf> views;  // one, or the two eyes
    bool mayBeBlank = false;     // nothing is to be drawn
    ToleranceBand band;
};

/** Deterministic. */
std::vector<ConformanceCase> conformanceCases();

}  // namespace dpl
