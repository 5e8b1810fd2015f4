// SPDX-License-Identifier: Apache-2.0
// The user's hand controllers: where they point, the select button, and a stick to turn things. Works with any controller through the
// simple controller profile, and with the sticks of Touch, Index, WMR and Vive controllers.
#pragma once

#include "platform/openxr/openxr.h"

namespace dpl::xr {

struct Controller {
    bool tracked = false;   // aim is valid
    XrPosef aim{};          // in world space; points along its -z
    bool select = false;    // held
    bool selected = false;  // pressed since the last frame
    float turn = 0;         // -1 (left) to 1 (right)
};

struct Controllers {
    Controller hands[2];  // left, right
};

}  // namespace dpl::xr
