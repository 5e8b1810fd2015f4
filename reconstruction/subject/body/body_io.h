// SPDX-License-Identifier: Apache-2.0
// Reads and writes a BodyModel as binary glTF 2.0 (.glb). A body written here is one skinned primitive with morph targets. Data without
// a glTF field (the morphs' joint offsets and ranges, keypoints, layers) is stored in mesh.extras.doppelBody. Any skinned .glb can be read.
#pragma once

#include <filesystem>
#include <span>
#include <string_view>
#include <vector>

#include "reconstruction/subject/body/body_model.h"
#include "sdk/core/result.h"

namespace dpl {

/** Encodes a body that passes checkBody. Deterministic. A stock glTF viewer shows the morphs as sliders that move the skin only, because
 *  glTF morphs do not move joints. */
Result<std::vector<uint8_t>> encodeBody(const BodyModel& body);

/** Decodes a body from encodeBody() exactly, or imports any other skinned .glb. The import folds rest rotations and scales into the mesh,
 *  so that every joint frame is parallel to the world. It turns each skinned primitive into a layer, sets the morphs' joint offsets to
 *  zero, adds the bone length morphs, and finds humanoid bones and keypoints by joint names.
 *  `name` appears in messages and names the body when the file does not. Errors: Unsupported when the mesh has no skin weights,
 *  CorruptData when the bytes are damaged. */
Result<BodyModel> decodeBody(std::span<const uint8_t> bytes, std::string_view name);

/** The same for files. writeBody writes a temporary file and renames it. Errors name the file. */
Result<BodyModel> readBody(const std::filesystem::path& path);
Status writeBody(const BodyModel& body, const std::filesystem::path& path);

}  // namespace dpl
