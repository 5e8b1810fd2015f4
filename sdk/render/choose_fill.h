// SPDX-License-Identifier: Apache-2.0
// Which way of filling pixels a device draws rightly, and which of the right ones is faster.
#pragma once

#include <optional>

#include "sdk/draw/renderer.h"

namespace dpl {

/** A figure of general splats in front of a camera, made in code: some hundred tiles, layers of translucent splats, some larger than tiles.
 */
struct FillScene {
    StaticSplatData splats;
    Cameraf camera;
};
FillScene fillTestScene();

/** Draws the scene both ways on `renderer`, compares with `wantRgba` (the scene by a renderer that is trusted) and times both on the
 * device. Leaves the faster of those that are right set, and says in `reason` why, for people. Code::Device when none is right. */
Result<Fill> chooseFill(Renderer& renderer, const FillScene& scene, std::span<const uint8_t> wantRgba, std::string& reason);

}  // namespace dpl
