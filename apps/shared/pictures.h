// SPDX-License-Identifier: Apache-2.0
// Clips, cameras and pixels for programs that draw avatars: framing, turntables, stereo pairs, backgrounds.
#pragma once

#include <doppel/doppel.hpp>

#include "sdk/core/result.h"
#include "sdk/math/camera.h"
#include "sdk/math/types.h"

namespace dpl {

Error fromSdk(const doppel::Error& error);

/** Which way a file stands: "y-up" (avatars, glTF, SPZ), "y-down" (most 3D Gaussian splatting PLYs), "z-up" or "z-down". */
inline const std::vector<std::string> kAxesNames = {"y-up", "y-down", "z-up", "z-down"};
/** The rotation that stands such a file upright. Any other name: none. */
Mat3d uprightFromFile(const std::string& axes);
/** Values of --fill. */
inline const std::vector<std::string> kFillNames = {"auto", "quads", "tiles"};
DplFill fillOf(const std::string& name);

/** Index of the clip to play: one of the avatar's own by name, else a motion file retargeted onto it. */
Result<uint32_t> chooseClip(doppel::Avatar& avatar, const std::string& clip);

/** Looks at the middle of the avatar's rest box from `azimuthRad` (0: from the front, positive to its left), so that it fills the picture.
 */
Cameraf frameAvatar(const DplAvatarInfo& avatar, uint32_t widthPx, uint32_t heightPx, double azimuthRad,
                    const Mat3d& uprightFromFile = Mat3d(1));

constexpr double kEyeDistanceM = 0.063;

/** The camera moved along its own x axis: −½ and +½ eye distance give a stereo pair with parallel axes. */
Cameraf shiftedSideways(const Cameraf& camera, double metres);

/** RGBA8 pictures of all views, straight alpha, of avatars that are drawn together. */
Result<std::vector<std::vector<uint8_t>>> drawViews(const doppel::Context& context, std::span<const DplAvatar> row,
                                                    std::span<const Cameraf> views);

/** Views side by side over a soft grey gradient, RGB8; rows are views.size()·width wide. */
std::vector<uint8_t> sideBySide(std::span<const std::vector<uint8_t>> views, uint32_t widthPx, uint32_t heightPx);

}  // namespace dpl
