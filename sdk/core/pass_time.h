// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

namespace dpl {

/** GPU time of one pass of a frame. A backend measures it, a renderer reports it. */
struct PassTime {
    std::string label;
    double milliseconds = 0;
};

}  // namespace dpl
