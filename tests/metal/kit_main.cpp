// SPDX-License-Identifier: Apache-2.0
// conformance_metal KIT PICTURES quads|tiles: draws the conformance kit through the Metal backend on the software device. Ends with 1 if
// the device found a fault, or if something of Doppel's is left on it.
#include <cstdio>
#include <string_view>

#include "sdk/include/doppel/doppel_metal.h"
#include "tests/conformance/kit_draw.h"
#include "tests/metal/software/software_device.h"

int main(int argc, char** argv) {
    const std::string_view fill = argc == 4 ? argv[3] : "";
    if (fill != "quads" && fill != "tiles") return std::fprintf(stderr, "usage: conformance_metal KIT PICTURES quads|tiles\n"), 2;
    dpl::mtl::SoftwareDevice device;
    const DplMetalDevice lent{sizeof lent, 0, device.device(), device.queue()};
    const DplContextInfo info{sizeof info, DPL_RENDERER_AUTO, 1, 0, fill == "quads" ? DPL_FILL_QUADS : DPL_FILL_TILES, nullptr};
    DplContext made = nullptr;
    if (dplCreateMetalContext(&lent, &info, &made) != DPL_OK) return std::fprintf(stderr, "conformance_metal: %s\n", dplGetLastError()), 2;
    int failed = 0;
    {
        doppel::Context context(made);
        const auto name = dpl::drawKit(argv[1], argv[2], context);
        if (!name) return std::fprintf(stderr, "conformance_metal: %s\n", name.error().message.c_str()), 2;
        std::printf("%s: pictures in %s\n", name->c_str(), argv[2]);
    }
    for (const std::string& fault : device.takeFaults()) failed = 1, std::fprintf(stderr, "fault: %s\n", fault.c_str());
    for (const std::string& object : device.alive()) failed = 1, std::fprintf(stderr, "not released: %s\n", object.c_str());
    return failed;
}
