// SPDX-License-Identifier: Apache-2.0
// doppel-viewer: avatars and splats in a window.
#include <cstdio>
#include <exception>

#include "apps/viewer/viewer.h"

int main(int argc, char** argv) {
    using namespace dpl;
    Timings timings;
    timings.mark("program loaded");
    int exitCode = 0;
    const auto options = readOptions(argc, argv, &exitCode);
    if (!options) return exitCode;
    try {
        Viewer viewer(*options, timings);
        exitCode = viewer.run();
    } catch (const std::exception& error) {  // the window or the graphics device failed
        std::fprintf(stderr, "doppel-viewer: %s\n", error.what());
        exitCode = 1;
    }
    if (options->timings) timings.print();
    return exitCode;
}
