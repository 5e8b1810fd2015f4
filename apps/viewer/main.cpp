// SPDX-License-Identifier: Apache-2.0
// doppel-viewer: avatars and splats in a window.
#include <cstdio>
#include <new>

#include "apps/viewer/viewer.h"

namespace dpl {
namespace {

Result<int> show(const ViewerOptions& options, Timings& timings) {
    try {
        DPL_TRY(const auto viewer, Viewer::create(options, timings));
        return viewer->run();
    } catch (const std::bad_alloc&) {
        return fail(Code::OutOfMemory, "out of memory; close other programs");
    }
}

}  // namespace
}  // namespace dpl

int main(int argc, char** argv) {
    using namespace dpl;
    Timings timings;
    timings.mark("program loaded");
    int exitCode = 0;
    const auto options = readOptions(argc, argv, &exitCode);
    if (!options) return exitCode;
    const auto ended = show(*options, timings);
    if (!ended) std::fprintf(stderr, "doppel-viewer: %s\n", ended.error().message.c_str());
    if (options->timings) timings.print();
    return ended ? *ended : 1;
}
