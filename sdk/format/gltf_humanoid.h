// SPDX-License-Identifier: Apache-2.0
// Which nodes of a glTF are which humanoid bones, as VRM 0, VRM 1 and VRM animations state it. Internal.
#pragma once

#include "sdk/format/gltf_model.h"
#include "sdk/format/load_json.h"

namespace dpl {

/** Writes the bones of a file's root extensions (VRM, VRMC_vrm, VRMC_vrm_animation) into its nodes. CorruptData: a node that does not
 * exist, a node that is two bones, a bone that is two nodes. */
Status readHumanoidMap(const nlohmann::json& extensions, std::vector<GltfNode>& nodes);

}  // namespace dpl
