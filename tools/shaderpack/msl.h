// SPDX-License-Identifier: Apache-2.0
// SPIR-V to Metal Shading Language and reflection through the SPIRV-Cross C API.
#pragma once

#include "sdk/backend/shader_pack.h"

namespace dpl {

constexpr uint32_t kMslPushBuffer = 29;  // binding b -> buffer(b), push constants here; 24 and 25 belong to SPIRV-Cross

/** Fills workgroup, pushBytes, bindings, structs of `shader` from its SPIR-V. */
Status reflectShader(Shader& shader);

enum class MslPlatform { Ios, Macos };

/** `multiview`: the vertex or fragment stage reads the view index; Metal then draws instances × views into layers. */
Result<std::string> translateToMsl(const Shader& shader, MslPlatform platform, bool multiview);

/** Rules that Apple's compiler would hold and we can read from the text: one resource per buffer index, index ≤ 30,
 *  ≤ 32 KiB of threadgroup memory, none of the GLSL names that SPIRV-Cross is known to leave behind. */
Status lintMsl(std::string_view name, std::string_view text);

}  // namespace dpl
