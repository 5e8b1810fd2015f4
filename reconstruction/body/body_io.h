// SPDX-License-Identifier: Apache-2.0
// BodyModel <-> glTF 2.0 binary. Ours: one skinned primitive with morph targets, and in mesh.extras.doppelBody what glTF has no place
// for (joint offsets and ranges of morphs, keypoints, layers). A plain rigged glTF is a valid body too.
#pragma once

#include <filesystem>
#include <span>
#include <string_view>
#include <vector>

#include "reconstruction/body/body_model.h"
#include "sdk/core/result.h"

namespace dpl {

/** Encodes a body that passes checkBody. Deterministic. Any stock viewer shows it with its morphs as sliders (skin deformation only:
 *  glTF morphs do not move joints). */
Result<std::vector<uint8_t>> encodeBody(const BodyModel& body);

/** Decodes our own bodies exactly (values as stored), and any skinned .glb: rest rotations and scales are folded into the mesh so that
 *  every joint frame is parallel to the world, skinned primitives become layers, morph joint offsets are zero, bone length morphs are
 * added, humanoid bones and keypoints come from joint names. `name` is used when the file has none, and in messages. Unsupported with a
 * clear sentence when the mesh has no skin weights; CorruptData for damaged bytes. */
Result<BodyModel> decodeBody(std::span<const uint8_t> bytes, std::string_view name);

/** The same from and to files; writing goes to a temporary name first. Messages name the file. */
Result<BodyModel> readBody(const std::filesystem::path& path);
Status writeBody(const BodyModel& body, const std::filesystem::path& path);

}  // namespace dpl
