// SPDX-License-Identifier: Apache-2.0
// Where an avatar differs from pictures that it was not made from, on its surface (docs/reference/metrics.md).
#pragma once

#include <span>
#include <vector>

#include "reconstruction/judging/report/report.h"
#include "sdk/math/camera.h"

namespace dpl {

/** How much a drawn picture differs from its frame about the middle of each triangle: the mean over 3 × 3 pixels of the person and three
 *  channels, levels of 255. Below 0: the frame does not show the triangle, as lookAt() of the body map has it.
 *  positions: V of the posed mesh, world. shown, truth: RGB over white; they and the mask have the camera's size. */
std::vector<float> differenceOnSurface(std::span<const Vec3f> positions, std::span<const Triangle> triangles, const Camerad& camera,
                                       const std::vector<uint8_t>& shown, const std::vector<uint8_t>& truth, const ImageGrey8& mask);

/** Mean over the frames of HeldOutFrame::onSurface, drawn on the mesh at rest, front and back. PNG; empty where no frame has it. */
Result<std::vector<uint8_t>> drawErrorMap(const MeshData& mesh, std::span<const HeldOutFrame> frames);

}  // namespace dpl
