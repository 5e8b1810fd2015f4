// SPDX-License-Identifier: Apache-2.0
// Rotated squares of a picture as inputs of networks. Private to reconstruction/input/observe and its tests.
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

/** Mirrors square planes left to right. */
void mirrorRows(std::vector<float>& planes, int side);

/** Grids of a detector's anchors: pixels a cell, anchors a cell. */
using AnchorGrids = std::array<std::array<int, 2>, 3>;

/** The centres of the anchors of an input with sides of `side` pixels, cell by cell. */
std::vector<Vec2d> anchorCentres(int side, const AnchorGrids& grids);

/** Resamples a plane of the crop to the picture; 0 outside the crop. */
cv::Mat spreadCrop(const float* plane, int side, const PersonCrop& crop, uint32_t width, uint32_t height);

}  // namespace dpl
