// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sdk/draw/renderer.h"

namespace dpl {

/** The CPU renderer: it poses avatars and draws them with the splat engine. threadCount 0: one a core; pictures do not depend on it. The
 * views of one draw share posing, and so do later draws with the same pose. A warm frame (same subjects and image size) allocates nothing.
 */
std::unique_ptr<Renderer> createSoftwareRenderer(uint32_t threadCount);

}  // namespace dpl
