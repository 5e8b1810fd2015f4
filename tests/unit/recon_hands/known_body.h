// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "reconstruction/input/capture/hand_keypoints.h"
#include "reconstruction/subject/sample/builtin_body.h"

namespace dpl {

/** The built-in body, made once. */
inline const BodyModel& knownBody() {
    static const BodyModel kBody = makeBuiltinBody();
    return kBody;
}

/** The names of both hands' points, left first. */
inline std::vector<std::string> handNames() {
    return {handKeypointNames().begin(), handKeypointNames().end()};
}

}  // namespace dpl
