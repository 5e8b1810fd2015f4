// SPDX-License-Identifier: Apache-2.0
// The product of the shader build: SPIR-V, optionally MSL, and what reflection found, in one checked blob.
//
//   "DPLSHADR" | u32 format | u64 contentHash of all that follows | u64 interfaceHash of shaders/shared | u32 count | shaders...
//
// tools/shaderpack writes it; backends read it. Little-endian.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "sdk/core/result.h"

namespace dpl {

constexpr uint32_t kShaderPackFormat = 2;

/** Suffix of a kernel that reads typed buffers (shaders/lib/reads.glsl), for devices with DeviceInfo::texels. It has no MSL. */
constexpr std::string_view kTexelsSuffix = ".texels";

enum class ShaderStage : uint32_t { Compute, Vertex, Fragment };

/** One member of a struct as the built shader lays it out. */
struct ShaderMember {
    std::string name;
    uint32_t offset = 0;
};
/** A struct that lives in a buffer, for the test that compares it with C++. */
struct ShaderStruct {
    std::string name;
    uint32_t size = 0;
    std::vector<ShaderMember> members;
};
struct ShaderBinding {
    std::string name;
    uint32_t binding = 0;
    bool uniform = false;  // else a storage buffer
    bool writes = false;
    bool reads = false;
    uint32_t texelWords = 0;  // a typed buffer, read in texels of 1, 2 or 4 words; 0: a plain one
};

struct Shader {
    std::string name;  // as in shaders/catalogue.json
    ShaderStage stage = ShaderStage::Compute;
    uint32_t workgroup[3] = {1, 1, 1};
    uint32_t pushBytes = 0;
    uint32_t sharedBytes = 0;             // workgroup memory
    std::vector<ShaderBinding> bindings;  // by binding number, dense from 0; a fragment shader's from the number of its vertex shader's
    std::vector<ShaderStruct> structs;
    std::vector<uint32_t> spirv;
    std::string mslIos, mslMacos;  // empty in a Vulkan-only pack
};

struct ShaderPack {
    uint64_t interfaceHash = 0;  // of the text of shaders/shared/*.h, what C++ was compiled against
    uint64_t contentHash = 0;    // of the pack's bytes
    std::vector<Shader> shaders;

    const Shader* find(std::string_view name) const;
};

uint64_t shaderHash(std::span<const uint8_t> bytes);  // FNV-1a, 64 bit
std::vector<uint8_t> writeShaderPack(const ShaderPack& pack);

/** Reads and checks a pack. `origin` names it in errors. Code::Version when it was built against other shared structs than
 *  `expectedInterface`; the text names both hashes. Code::CorruptData when its bytes do not match its own hash. */
Result<ShaderPack> readShaderPack(std::span<const uint8_t> bytes, std::string_view origin, uint64_t expectedInterface);

/** The pack this build embeds (generated; target doppel_shaders), and the interface hash of the headers it was compiled with. */
std::span<const uint8_t> embeddedShaderPack();
uint64_t embeddedShaderInterface();

}  // namespace dpl
