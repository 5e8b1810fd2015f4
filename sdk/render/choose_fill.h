// SPDX-License-Identifier: Apache-2.0
// Chooses the faster fill of those that a device draws correctly.
#pragma once

#include <optional>

#include "sdk/draw/renderer.h"

namespace dpl {

/** A procedural figure of general splats in front of a camera: some hundred tiles, layers of translucent splats, some larger than a
 *  tile. */
struct FillScene {
    StaticSplatData splats;
    Cameraf camera;
};
FillScene fillTestScene();

/** Draws the scene with both fills on `renderer`, compares them with `wantRgba` (the same scene by a trusted renderer), and times both on
 *  the device in a larger picture. Sets the faster fill of those that are correct, and explains the choice in `reason`. Code::Device when
 *  neither is correct or the device was lost. OutOfMemory: a fill could not be tried. */
Result<Fill> chooseFill(Renderer& renderer, const FillScene& scene, std::span<const uint8_t> wantRgba, std::string& reason);

}  // namespace dpl
