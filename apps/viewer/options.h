// SPDX-License-Identifier: Apache-2.0
// The command line of doppel-viewer.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "apps/shared/checks.h"

namespace dpl {

struct ViewerOptions {
    std::vector<std::string> files;
    std::string compare;                                              // name of a frame, or how it begins
    std::string clip, animation, room = "auto", axes, fill = "auto";  // axes: empty: as the files state
    PictureSize size{1280, 800};
    double azimuthDeg = 0;
    float scale = 0;          // of panels and letters; 0: as the screen's
    float magnification = 8;  // of the scan's finest details, at most; 0: no limit
    std::filesystem::path screenshot, turntable;
    uint32_t frames = 0;  // 0: 1 for a screenshot, 120 for a turntable
    bool hidePanels = false, timings = false, validation = false;

    bool isScript() const { return !screenshot.empty() || !turntable.empty(); }
};

/** Reads the command line. Nothing: the program ends with *exitCode; what had to be said was printed. */
std::optional<ViewerOptions> readOptions(int argc, const char* const* argv, int* exitCode);

}  // namespace dpl
