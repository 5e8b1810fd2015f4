// SPDX-License-Identifier: Apache-2.0
// conformance_draw KIT PICTURES: draws the kit on the CPU. For processors for which the rest of the kit is not built.
#include <cstdio>

#include "tests/conformance/kit_draw.h"

int main(int argc, char** argv) {
    if (argc != 3) {
        std::fprintf(stderr, "usage: conformance_draw KIT PICTURES\n");
        return 2;
    }
    const auto name = dpl::drawKit(argv[1], argv[2], DPL_RENDERER_SOFTWARE);
    if (!name)
        std::fprintf(stderr, "conformance_draw: %s\n", name.error().message.c_str());
    else
        std::printf("%s: pictures in %s\n", name->c_str(), argv[2]);
    return name ? 0 : 2;
}
