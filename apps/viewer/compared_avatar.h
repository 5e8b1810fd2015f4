// SPDX-License-Identifier: Apache-2.0
// Brings comparisons of an avatar with the photographs of its scan into the viewer's state and window.
#pragma once

#include "apps/viewer/loader.h"
#include "apps/viewer/panels.h"
#include "apps/viewer/state.h"

namespace dpl {

/** Begins to compare the selected avatar. scan: where its pictures are; empty: where its run says. frame: the name of the first; empty:
 * any. InvalidArgument: nobody knows cameras and poses of this avatar; the sentence says what to do. */
Status beginComparing(ViewerState& state, platform::Shell& shell, const std::filesystem::path& scan, const std::string& frame);
void endComparing(ViewerState& state, platform::Shell& shell);

/** What the loader is to draw now. */
std::optional<CompareTask> comparisonToDraw(ViewerState& state);
/** Takes what it has drawn. An error: a sentence of which the user should hear. */
Status takeCompared(ViewerState& state, platform::Shell& shell, LoadedFile news);

/** The pictures of the comparison in the window, in ImGui's coordinates. Empty: none are there yet. */
struct ComparedPlaces {
    std::vector<platform::PlacedPicture> pictures;
    float left = 0, right = 0;  // of the one that the slider divides
};
ComparedPlaces placesOfComparison(const ViewerState& state, float width, float height);

}  // namespace dpl
