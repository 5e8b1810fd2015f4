// SPDX-License-Identifier: Apache-2.0
// The parts of the NeuMan reader that tests look at. Private to reconstruction/input/import.
#pragma once

#include <span>
#include <string_view>

#include "reconstruction/input/import/capture.h"

namespace dpl {

/** Whether a folder has the layout: images/, segmentations/ and a COLMAP model. */
bool isNeuman(const std::filesystem::path& folder);

enum class NeumanSplit : uint8_t { Train, Validation, Test };

/** The published split of so many frames in the order of the video. */
std::vector<NeumanSplit> neumanSplits(size_t frames);

/** File names of a split, one a line. */
Result<std::vector<std::string>> parseNeumanList(std::string_view text, const std::string& where);

/** A .npy file of 17 × 3 numbers: x, y in pixels and confidence, in COCO's order. */
Result<std::vector<Keypoint>> parseNeumanKeypoints(std::span<const uint8_t> bytes, const std::string& where);

}  // namespace dpl
