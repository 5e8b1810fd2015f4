// SPDX-License-Identifier: Apache-2.0
// The pictures that the benches of an app's frames draw, and how they pose the avatar.
#pragma once

#include <cstdio>
#include <cstdlib>
#include <vector>

#include "sdk/include/doppel/doppel.h"

namespace dpl::test {

struct Case {
    const char* name;
    uint32_t width, height, views;
};
inline constexpr Case kCases[] = {{"phone 945x2048", 945, 2048, 1}, {"headset 1920x1824 stereo", 1920, 1824, 2}};

/** Ends the bench with the library's words if a call failed. */
inline void must(DplResult result) {
    if (result == DPL_OK) return;
    std::fprintf(stderr, "bench: %s\n", dplGetLastError());
    std::exit(1);
}

/** One or two eyes, 64 mm apart, 3 m in front of the avatar. */
inline std::vector<DplCamera> viewsOf(const Case& what) {
    std::vector<DplCamera> views;
    for (uint32_t view = 0; view < what.views; ++view) {
        const float f = 60.0f * float(what.height) / 64, shift = what.views == 2 ? (view ? -0.032f : 0.032f) : 0;
        views.push_back({sizeof(DplCamera),
                         what.width,
                         what.height,
                         f,
                         f,
                         float(what.width) / 2,
                         float(what.height) / 2,
                         {1, 0, 0, shift, 0, -1, 0, 1, 0, 0, -1, 3}});
    }
    return views;
}

/** The pose of a frame of the file's first clip, at 60 a second; a file without a clip keeps its pose. */
inline void pose(DplAvatar avatar, uint32_t frame) {
    DplAvatarInfo info{sizeof info};
    must(dplGetAvatarInfo(avatar, &info));
    if (info.clipCount > 0) must(dplSetPoseFromClip(avatar, 0, double(frame) / 60, DPL_TRUE));
}

}  // namespace dpl::test
