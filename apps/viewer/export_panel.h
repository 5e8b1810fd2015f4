// SPDX-License-Identifier: Apache-2.0
// The window that exports, and how far an export is.
#pragma once

#include "apps/viewer/state.h"

namespace dpl {

void openExport(ViewerState& state);

/** Choice of what and where, if state.exports.open. It closes itself by that. size: of the picture in ImGui's coordinates. */
void drawExport(ViewerState& state, float width, float height);

/** How far the export is, and the button that ends it, above everything; nothing while there is none, or the window shows it. */
void drawExportProgress(ViewerState& state, float width);

}  // namespace dpl
