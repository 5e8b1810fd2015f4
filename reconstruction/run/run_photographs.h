// SPDX-License-Identifier: Apache-2.0
// The photographs that a finished reconstruction was made of, for tools that go back to them.
#pragma once

#include <filesystem>
#include <vector>

#include "reconstruction/input/capture/train_frame.h"

namespace dpl {

/** The still frames that trained an avatar, with cameras in metres and the poses that training gave them. Validation and held-out frames
 *  are not among them, nor frames without a mask. poses: poses.json of the run; empty: beside the avatar. Pictures are read when asked for.
 *  Errors name the file: another scan, another avatar than the run wrote (its clothes or shape may be others), no such frame. */
Result<std::vector<TrainFrame>> stillPhotographs(const std::filesystem::path& avatar, const std::filesystem::path& scan,
                                                 const std::filesystem::path& poses);

}  // namespace dpl
