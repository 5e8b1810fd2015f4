// SPDX-License-Identifier: Apache-2.0
// A scan as inputs of a stage: names, cameras and the hashes of its files.
#pragma once

#include <nlohmann/json.hpp>

#include "reconstruction/run/frame_table.h"

namespace dpl {

/** One entry a frame. A file that cannot be read has the text of the error as its hash, so the stage runs again when it is repaired. */
std::vector<FrameHashes> hashFrames(const Scan& scan);
/** The same after stages have changed the scan. `known`: hashes of `before`. Files that a frame of the same name had there are not read
 *  again, so each file is hashed once a run. */
std::vector<FrameHashes> hashFrames(const Scan& scan, const Scan& before, const std::vector<FrameHashes>& known);

/** Names the pictures of a scan, whatever is known about them: names of frames and hashes of their images. */
std::string hashOfScan(const Scan& scan, const std::vector<FrameHashes>& hashes);

/** The inputs of one frame. */
nlohmann::json frameInputs(const ScanFrame& frame, const FrameHashes& files);
/** The inputs that all frames share. */
nlohmann::json commonInputs(const Scan& scan);
/** What the poses of frames depend on: of every frame its camera, time and keypoints, and no picture. */
nlohmann::json posedInputs(const Scan& scan, const std::vector<FrameHashes>& hashes);
/** All inputs of all frames. */
nlohmann::json scanInputs(const Scan& scan, const std::vector<FrameHashes>& hashes);

}  // namespace dpl
