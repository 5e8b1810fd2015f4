// SPDX-License-Identifier: Apache-2.0
// GLSL to SPIR-V through glslang, with includes rooted at the source tree.
#pragma once

#include <filesystem>
#include <set>
#include <string>
#include <vector>

#include "sdk/backend/shader_pack.h"

namespace dpl {

struct GlslInput {
    std::filesystem::path root;  // what #include "shaders/..." starts from
    std::filesystem::path file;
    ShaderStage stage = ShaderStage::Compute;
    std::vector<std::string> defines;
};

/** SPIR-V 1.3 for Vulkan 1.1. Adds every included file to `dependencies`. The error text is the compiler's. */
Result<std::vector<uint32_t>> compileGlsl(const GlslInput& input, std::set<std::string>& dependencies);

Result<std::string> readTextFile(const std::filesystem::path& path);

}  // namespace dpl
