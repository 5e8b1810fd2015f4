// SPDX-License-Identifier: Apache-2.0
// The networks that observe pictures: their files, and where `doppel setup` (tools/models) installs them.
#pragma once

#include <filesystem>
#include <string>

namespace dpl {

/** Files of a folder of networks. The first one or, without it, the light one is needed; with the others more is found. */
namespace network_files {
inline constexpr const char* kPose = "blazepose_full.onnx";
inline constexpr const char* kLightPose = "blazepose_lite.onnx";
inline constexpr const char* kHeavyPose = "blazepose_heavy.onnx";
inline constexpr const char* kDetector = "blazepose_detector.onnx";
inline constexpr const char* kCloseups = "selfie_seg.onnx";
inline constexpr const char* kClothes = "skin_clothes_hair_pan.onnx";
inline constexpr const char* kHands = "hand_landmarks.onnx";
inline constexpr const char* kPalms = "palm_detector.onnx";
inline constexpr const char* kAll[] = {kPose, kHeavyPose, kLightPose, kDetector, kCloseups, kClothes, kHands, kPalms};
}  // namespace network_files

/** $XDG_DATA_HOME/doppel/models, or ~/.local/share/doppel/models where that variable is empty or relative, as the XDG base directory
 *  specification says. Empty without $HOME. */
std::filesystem::path userModelsFolder();

/** userModelsFolder() if it holds a pose network, else empty. */
std::filesystem::path installedModels();

/** What to run so that the networks are found, as a part of a sentence. */
std::string howToGetNetworks();

}  // namespace dpl
