// SPDX-License-Identifier: Apache-2.0
// The best light for one drawn picture, found by looking at the true one: bounds what a model of light could gain.
#pragma once

#include <cstdint>
#include <vector>

#include "reconstruction/input/capture/scan.h"

namespace dpl {

/** The picture (RGBA, straight alpha, of the image's size) with each channel times the factor that brings it nearest to `truth` inside the
 *  mask, in least squares. */
std::vector<uint8_t> withBestGain(const std::vector<uint8_t>& rgba, const ImageRgb8& truth, const ImageGrey8& mask);

/** The same with one factor for all channels that varies smoothly over the picture: least squares in a Gaussian window of σ = `window`
 *  times the picture's height, > 0. A small window fits noise too, so a still picture, which lacks no light, tells what is overfit. */
std::vector<uint8_t> withBestLight(const std::vector<uint8_t>& rgba, const ImageRgb8& truth, const ImageGrey8& mask, double window);

}  // namespace dpl
