// SPDX-License-Identifier: Apache-2.0
// Compiles GLSL to SPIR-V with glslang. Includes are relative to the root of the source tree.
#pragma once

#include <filesystem>
#include <set>
#include <string>
#include <vector>

#include "sdk/backend/shader_pack.h"

namespace dpl {

struct GlslInput {
    std::filesystem::path root;  // folder that #include paths start from
    std::filesystem::path file;
    ShaderStage stage = ShaderStage::Compute;
    std::vector<std::string> defines;
};

/** SPIR-V 1.3 for Vulkan 1.1. Adds the file and every included file to `dependencies`. Errors carry the compiler's text. */
Result<std::vector<uint32_t>> compileGlsl(const GlslInput& input, std::set<std::string>& dependencies);

/** The whole file. NotFound: it cannot be opened. */
Result<std::string> readTextFile(const std::filesystem::path& path);

}  // namespace dpl
