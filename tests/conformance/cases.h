// SPDX-License-Identifier: Apache-2.0
// The scenes of the conformance kit: tiny avatars with a pose and views. Each tests one thing that splat renderers get wrong.
#pragma once

#include <string>
#include <vector>

#include "sdk/avatar/rig.h"
#include "sdk/format/avatar_data.h"
#include "sdk/math/camera.h"

namespace dpl {

/** Allowed difference from the double-precision picture. Colour is composited over mid grey, peak 1, so that alpha counts too. */
struct ToleranceBand {
    double psnrDb = 50;         // lower limit over all pixels
    double coveredPsnrDb = 42;  // lower limit over pixels that either picture covers
    double maxLevels = 48;      // upper limit of one channel's error, 8-bit levels; allows one swap of neighbours in depth order
};

struct EarlierPose {
    Pose pose;
    int64_t timeNs = 0;
};

struct ConformanceCase {
    std::string name;   // also the name of its files
    std::string about;  // what the case tests
    AvatarData avatar;
    Pose pose;
    std::vector<Cameraf> views;  // one, or the two eyes
    bool mayBeBlank = false;     // the reference picture is empty
    ToleranceBand band;
    std::vector<EarlierPose> earlier;  // poses that are drawn before, oldest first; none: `pose` has no time
    int64_t timeNs = 0;                // of `pose`
};

/** All cases. Deterministic. */
std::vector<ConformanceCase> conformanceCases();

}  // namespace dpl
