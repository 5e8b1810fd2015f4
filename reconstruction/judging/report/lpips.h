// SPDX-License-Identifier: Apache-2.0
// LPIPS 0.1 with AlexNet: the distance of two pictures in the features of a network. The weights are the user's: they are not free to ship
// (docs/reference/neuman.md says how to save them).
#pragma once

#include <array>
#include <filesystem>
#include <span>
#include <vector>

#include "sdk/core/result.h"

namespace dpl {

class Lpips {
public:
    /** Reads an .npz of the arrays net.slice1.0.weight, net.slice1.0.bias … net.slice5.10.bias and lin0.model.1.weight …
     *  lin4.model.1.weight. Checks every shape; the channels of the layers may be fewer than AlexNet's. Errors name file and array. */
    static Result<Lpips> load(const std::filesystem::path& path);

    /** Distance of two pictures: three planes each (R, G, B), row-major, values −1 … 1. InvalidArgument: sizes do not fit, or the picture
     *  is too small for the network (below 31 pixels a side). Deterministic; call from any thread. Memory: the features of both pictures,
     *  about 30 bytes a pixel and 16 MiB. */
    Result<double> distance(std::span<const float> a, std::span<const float> b, uint32_t widthPx, uint32_t heightPx) const;

    static constexpr size_t kLayers = 5;

private:
    struct Layer {
        size_t inputs = 0, outputs = 0;
        std::vector<float> weights, biases;  // outputs × inputs × kernel², outputs
        std::vector<float> importance;       // outputs: the share of each channel in the distance
    };
    std::array<Layer, kLayers> layers_;
};

}  // namespace dpl
