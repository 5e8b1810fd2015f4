// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

namespace dpl {

/** GPU time of one step of a frame: measured by a backend, reported by a renderer. */
struct PassTime {
    std::string label;
    double milliseconds = 0;
};

}  // namespace dpl
