// SPDX-License-Identifier: Apache-2.0
// Files of a captured frame: pictures, depth and cameras, for comparisons with pictures that are drawn without a headset.
#pragma once

#include <filesystem>
#include <string>

#include "apps/xr/avatar_scene.h"
#include "platform/openxr/session.h"
#include "sdk/core/result.h"

namespace dpl {

/** What is true for the whole frame. */
struct CapturedFrame {
    std::string runtime, clip;
    uint64_t number = 0;
    double timeS = 0;
};

/** Writes into the folder, which is created:
 *    view_N.png        the colour codes as they were submitted (RGBA, sRGB; half floats are encoded), alpha as it was
 *    view_N_depth.pfm  view z of room and avatar, metres; 0: nothing. Little-endian, bottom row first
 *    views.json        cameras, poses and field of view of the eyes; where the avatar stands; times
 *  Returns the text of views.json. */
Result<std::string> writeCapture(const std::filesystem::path& folder, std::span<const xr::CapturedView> views, const AvatarScene& scene,
                                 const CapturedFrame& frame);

}  // namespace dpl
