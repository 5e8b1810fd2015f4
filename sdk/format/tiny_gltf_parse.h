// SPDX-License-Identifier: Apache-2.0
// The only use of tinygltf. Internal.
#pragma once

#include <string>

#include "sdk/core/result.h"
#include "sdk/format/gltf_model.h"

namespace dpl {

/** Parses the JSON that gltf_parse.cpp makes: known keys only, and one buffer of four zero bytes. Fills all fields but bin, json,
 *  extensions and Draco. Does NOT check indices. Throws nothing. */
Result<GltfModel> parseWithTinyGltf(const std::string& json);

}  // namespace dpl
