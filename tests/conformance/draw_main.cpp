// SPDX-License-Identifier: Apache-2.0
// conformance_draw KIT PICTURES [tiles|quads|metal-tiles|metal-quads]: draws the kit on the CPU, or through Vulkan or Metal with this fill.
// For systems for which the rest of the kit is not built.
#include <cstdio>
#include <string_view>

#include "tests/conformance/kit_draw.h"

int main(int argc, char** argv) {
    const std::string_view how = argc == 4 ? argv[3] : "";
    const bool metal = how.starts_with("metal-");
    const std::string_view fill = metal ? how.substr(6) : how;
    if (argc != 3 && fill != "tiles" && fill != "quads") {
        std::fprintf(stderr, "usage: conformance_draw KIT PICTURES [tiles|quads|metal-tiles|metal-quads]\n");
        return 2;
    }
    const DplRenderer renderer = argc == 3 ? DPL_RENDERER_SOFTWARE : metal ? DPL_RENDERER_METAL : DPL_RENDERER_VULKAN;
    const auto name = dpl::drawKit(argv[1], argv[2], renderer, fill == "quads" ? DPL_FILL_QUADS : DPL_FILL_TILES);
    if (!name)
        std::fprintf(stderr, "conformance_draw: %s\n", name.error().message.c_str());
    else
        std::printf("%s: pictures in %s\n", name->c_str(), argv[2]);
    return name ? 0 : 2;
}
