// SPDX-License-Identifier: Apache-2.0
// The tables of a glTF's JSON: buffer views, accessors, meshes, nodes, skins, animations. Internal.
#pragma once

#include "sdk/format/gltf_model.h"
#include "sdk/format/load_json.h"

namespace dpl {

/** Reads them into `model`, whose other fields stay. Every value that is read must be of the type that glTF names; numbers of things are
 *  limited. Does NOT check indices and ranges: those too large for their type become its largest. Throws std::bad_alloc. */
Status readGltfTables(const nlohmann::json& root, const ReadLimits& limits, GltfModel& model);

}  // namespace dpl
