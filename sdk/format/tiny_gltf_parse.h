// SPDX-License-Identifier: Apache-2.0
// The seam to tinygltf. Internal.
#pragma once

#include <string>

#include "sdk/core/result.h"
#include "sdk/format/gltf_model.h"

namespace dpl {

/** Parses glTF JSON that holds known keys only and one placeholder buffer of 4 bytes (gltf_parse.cpp makes it). Fills everything
 *  except bin, json, extension and Draco fields. Indices are NOT checked yet. No exception escapes. */
Result<GltfModel> parseWithTinyGltf(const std::string& json);

}  // namespace dpl
