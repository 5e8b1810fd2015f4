// SPDX-License-Identifier: Apache-2.0
// The CPU renderer: rig and splat engine behind the Renderer seam.
#pragma once

#include "sdk/draw/renderer.h"

namespace dpl {

/** threadCount 0: one a core. A warm frame (same avatar and image size) allocates nothing; the views of one call share skinning and
 *  triangle frames, and so do later calls with the same pose. Pictures do not depend on threadCount. */
std::unique_ptr<Renderer> createSoftwareRenderer(uint32_t threadCount);

}  // namespace dpl
