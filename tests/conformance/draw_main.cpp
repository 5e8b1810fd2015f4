// SPDX-License-Identifier: Apache-2.0
// conformance_draw KIT PICTURES [tiles|quads]: draws the kit on the CPU, or through Vulkan with this fill. For systems for which the rest
// of the kit is not built.
#include <cstdio>
#include <string_view>

#include "tests/conformance/kit_draw.h"

int main(int argc, char** argv) {
    const std::string_view fill = argc == 4 ? argv[3] : "";
    if (argc != 3 && fill != "tiles" && fill != "quads") {
        std::fprintf(stderr, "usage: conformance_draw KIT PICTURES [tiles|quads]\n");
        return 2;
    }
    const auto name = argc == 3 ? dpl::drawKit(argv[1], argv[2], DPL_RENDERER_SOFTWARE)
                                : dpl::drawKit(argv[1], argv[2], DPL_RENDERER_VULKAN, fill == "tiles" ? DPL_FILL_TILES : DPL_FILL_QUADS);
    if (!name)
        std::fprintf(stderr, "conformance_draw: %s\n", name.error().message.c_str());
    else
        std::printf("%s: pictures in %s\n", name->c_str(), argv[2]);
    return name ? 0 : 2;
}
