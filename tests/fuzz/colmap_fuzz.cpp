// SPDX-License-Identifier: Apache-2.0
// Fuzz target of the reader of COLMAP models. Input: a byte whose lowest bit says text or binary, two bytes (little endian) with the length
// of the file of cameras, that file, the file of images. No input may crash, and every accepted camera must be one that checkCamera
// accepts.
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>

#include "reconstruction/input/cameras/colmap_model.h"
#include "tests/fuzz/memory_watch.h"

namespace {

void mustHold(bool condition, const char* what) {
    if (condition) return;
    std::fprintf(stderr, "fuzz: %s\n", what);
    std::abort();
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
    if (size < 3) return 0;
    const std::string_view rest(reinterpret_cast<const char*>(data) + 3, size - 3);
    const size_t split = std::min<size_t>(rest.size(), data[1] | size_t(data[2]) << 8);
    dpl::test::startMemoryWatch();
    auto images = dpl::decodeColmapModel({(data[0] & 1) != 0, rest.substr(0, split), rest.substr(split)}, "model");
    mustHold(dpl::test::peakMemoryBytes() <= (1 << 20) + 64 * uint64_t(size), "more memory than colmap_model.h promises");
    if (!images) {
        mustHold(!images.error().message.empty(), "an error without a sentence");
        return 0;
    }
    mustHold(!images->empty(), "a model without images was accepted");
    for (dpl::ColmapImage& image : *images) {
        mustHold(bool(dpl::checkCamera(image.camera, "fuzz")), "an implausible camera was accepted");
        mustHold(bool(dpl::checkDistortion(image.lens, image.camera, "fuzz")), "an implausible lens was accepted");
        mustHold(std::isfinite(image.camera.eye().x), "an eye that is not finite");
    }
    return 0;
}
