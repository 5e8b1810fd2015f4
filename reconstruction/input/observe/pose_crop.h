// SPDX-License-Identifier: Apache-2.0
// Rotated squares of a picture as inputs of networks. Private to reconstruction/input/capture.
#pragma once

#include <array>
#include <opencv2/core.hpp>
#include <vector>

#include "reconstruction/input/observe/observations.h"

namespace dpl {

/** A point of a square picture of the crop with sides of `side` pixels, in the whole picture. */
Vec2d cropToPicture(const PersonCrop& crop, const Vec2d& px, double side);

/** The crop as a network's input: side × side, planar RGB, (value/255 − mean) / deviation. Black outside the picture. */
std::vector<float> cropToTensor(const ImageRgb8& image, const PersonCrop& crop, int side, const std::array<float, 3>& mean,
                                const std::array<float, 3>& deviation);

/** Resamples a plane of the crop to the picture; 0 outside the crop. */
cv::Mat spreadCrop(const float* plane, int side, const PersonCrop& crop, uint32_t width, uint32_t height);

}  // namespace dpl
