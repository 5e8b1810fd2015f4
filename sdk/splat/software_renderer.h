// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sdk/draw/renderer.h"

namespace dpl {

/** The CPU renderer: it poses avatars and draws them with the splat engine. threadCount 0: one thread a core; pictures do not depend on it.
 * An avatar is posed once for all views of a draw, and not again for later draws with the same pose. A warm frame (same subjects and image
 * size) allocates nothing. */
std::unique_ptr<Renderer> createSoftwareRenderer(uint32_t threadCount);

}  // namespace dpl
