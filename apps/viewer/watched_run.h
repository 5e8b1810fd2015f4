// SPDX-License-Identifier: Apache-2.0
// Brings what a watched run tells into the viewer's state.
#pragma once

#include "apps/viewer/loader.h"
#include "apps/viewer/state.h"

namespace dpl {

/** Takes one look of the loader: what the run says, its held-back picture, and its avatar in place of that of before, which keeps place and
 *  turn. Errors: a sentence of which the user should hear. */
Status takeRunNews(ViewerState& state, platform::Shell& shell, LoadedFile news);

/** Forgets the run; its avatar stays as any other. */
void dropRun(ViewerState& state, platform::Shell& shell);

/** Turns an unfinished avatar. seconds: since the last frame. */
void turnRun(ViewerState& state, double seconds);

/** Where the held-back picture lies. Empty: there is none, or no room for it. width, height: of the picture in ImGui's coordinates; scale:
 *  pixels for one of them. */
std::vector<platform::PlacedPicture> picturesOfRun(const ViewerState& state, float width, float height, float scale);

}  // namespace dpl
