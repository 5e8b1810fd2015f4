// SPDX-License-Identifier: Apache-2.0
// Reflects SPIR-V and translates it to Metal Shading Language through the C API of SPIRV-Cross.
#pragma once

#include "sdk/backend/shader_pack.h"

namespace dpl {

constexpr uint32_t kMslPushBuffer = 29;  // buffer index of push constants; binding b is buffer(b); SPIRV-Cross uses 24 and 25

/** Fills workgroup, pushBytes, bindings and structs of `shader` from its SPIR-V. InvalidArgument: it breaks a limit, for example more than
 *  mostStorageBuffers, more than 128 push-constant bytes, or gaps between bindings. */
Status reflectShader(Shader& shader, uint32_t mostStorageBuffers);

enum class MslPlatform { Ios, Macos };

struct MslOptions {
    bool multiview = false;   // vertex: draws instances × views into layers; fragment: reads the view index
    bool eachSample = false;  // fragment: shades each sample by itself, as a Vulkan pipeline with sampleShadingEnable
};

/** MSL 2.3. */
Result<std::string> translateToMsl(const Shader& shader, MslPlatform platform, const MslOptions& wanted);

/** Checks rules of Apple's compiler that can be checked in the text: an entry point, one resource per index of buffers and of textures,
 *  index ≤ 30, at most 32 KiB of threadgroup memory, and no GLSL names that SPIRV-Cross is known to leave. `name` starts the message. */
Status lintMsl(std::string_view name, std::string_view text);

/** Also checks that functions are defined in the text or are Metal's, and that what is passed by reference lies in the address space of the
 *  parameter. For tests: it knows the text that SPIRV-Cross emits now, and a later release must not stop the shader build. */
Status lintMslStrictly(std::string_view name, std::string_view text);

}  // namespace dpl
