// SPDX-License-Identifier: Apache-2.0
// Clips, cameras and pixels for programs that draw avatars: framing, turntables, stereo pairs, backgrounds.
#pragma once

#include <doppel/doppel.hpp>

#include <array>
#include <filesystem>
#include <functional>

#include "sdk/core/result.h"
#include "sdk/math/camera.h"
#include "sdk/math/types.h"

namespace dpl {

Error fromSdk(const doppel::Error& error);

/** Up axis of a file: "y-up", "y-down" (most 3D Gaussian splatting PLYs), "z-up" or "z-down". */
inline const std::vector<std::string> kAxesNames = {"y-up", "y-down", "z-up", "z-down"};
/** What --axes says of itself in every program. */
constexpr const char* kAxesHelp = "The file's up axis, instead of the one that it states; many 3D Gaussian splatting PLYs are y-down";
/** The rotation that turns a file with these axes y-up. Identity for any other name. */
Mat3d uprightFromFile(const std::string& axes);
/** How loading turned (or mirrored) a file. */
Mat3d loadedFromFile(const DplFileAxes& axes);
/** The rotation that turns a loaded file upright. Loading has turned it by `loadedFromFile`, as the file states. `axes` is the user's
 *  word for the file, which replaces that; empty: no word. */
Mat3d uprightFromLoaded(const std::string& axes, const Mat3d& loadedFromFile);
/** For Avatar::setTransform: upright, moved aside along +X. */
std::array<float, 12> standing(const Mat3d& upright, double asideM);
/** Values of --fill. */
inline const std::vector<std::string> kFillNames = {"auto", "quads", "tiles"};
DplFill fillOf(const std::string& name);

/** Index of the clip to play. `clip` names one of the avatar's clips, or else a motion file, which is retargeted onto the avatar
 *  and called as the file is, without folder and ending.
 *  animation: name or number of one in a glTF file; empty: the first. */
Result<uint32_t> chooseClip(doppel::Avatar& avatar, const std::string& clip, const std::string& animation = {});
/** What --animation says of itself in every program. */
constexpr const char* kAnimationHelp = "With --clip FILE.glb: name or number (from 0) of the animation in it; default: the first";

/** A camera that looks at the middle of the avatar's rest box from `azimuthRad` (0: the front, positive towards the avatar's left) so that
 *  the avatar fills the picture. Small things are seen from so far, through a longer lens, that nothing fades at the near plane. */
Cameraf frameAvatar(const DplAvatarInfo& avatar, uint32_t widthPx, uint32_t heightPx, double azimuthRad,
                    const Mat3d& uprightFromFile = Mat3d(1));

constexpr double kEyeDistanceM = 0.063;

/** The camera moved along its own x axis. −½ and +½ eye distance give a stereo pair with parallel view directions. */
Cameraf shiftedSideways(const Cameraf& camera, double metres);

/** Draws `avatars` together and returns one RGBA8 picture per view, straight alpha. */
Result<std::vector<std::vector<uint8_t>>> drawViews(const doppel::Context& context, std::span<const DplAvatar> avatars,
                                                    std::span<const Cameraf> views);

/** Whether no pixel of any picture is covered. */
bool isEmpty(std::span<const std::vector<uint8_t>> views);

/** Name of the numbered frame i in a folder of frames, without ".png": "00012". */
std::string frameNumber(size_t i);
bool isFrameNumber(const std::string& name);

/** Removes the PNG files of a folder whose names without ".png" are those of frames, as an earlier run left them. Returns their number. */
Result<size_t> removeFrames(const std::filesystem::path& folder, const std::function<bool(const std::string& name)>& isFrame);

/** The views side by side over a grey gradient, as RGB8; the result is views.size()·widthPx wide. */
std::vector<uint8_t> sideBySide(std::span<const std::vector<uint8_t>> views, uint32_t widthPx, uint32_t heightPx);

}  // namespace dpl
