// SPDX-License-Identifier: Apache-2.0
#include <map>
#include <regex>

#include "tools/shaderpack/lint_names.h"
#include "tools/shaderpack/msl.h"

namespace dpl {
namespace {

constexpr uint32_t kMaxMetalIndex = 30;  // of a buffer or a texture
constexpr uint64_t kMaxThreadgroupBytes = 32 * 1024;

const std::map<std::string, uint32_t> kScalarBytes = {{"uint", 4},   {"int", 4},    {"float", 4},   {"atomic_uint", 4}, {"uint2", 8},
                                                      {"float2", 8}, {"uint4", 16}, {"float4", 16}, {"half", 2},        {"ushort", 2}};

}  // namespace

Status lintMsl(std::string_view name, std::string_view text) {
    const std::string source(text);
    if (source.find("kernel ") == std::string::npos && source.find("vertex ") == std::string::npos &&
        source.find("fragment ") == std::string::npos)
        return fail(Code::InvalidArgument, "{}: the MSL has no entry point", name);

    std::map<std::pair<std::string, unsigned long>, int> uses;
    const std::regex index(R"(\[\[\s*(buffer|texture)\((\d+)\)\s*\]\])");
    for (std::sregex_iterator it(source.begin(), source.end(), index), end; it != end; ++it) {
        const unsigned long n = std::stoul((*it)[2]);
        if (n > kMaxMetalIndex) return fail(Code::InvalidArgument, "{}: {} is above {}", name, it->str(), kMaxMetalIndex);
        if (++uses[{(*it)[1], n}] > 1) return fail(Code::InvalidArgument, "{}: {} is used twice", name, it->str());
    }

    uint64_t groupBytes = 0;
    const std::regex local(R"(^\s+threadgroup\s+(?:spvUnsafeArray<(\w+),\s*(\d+)>|(\w+))\s+\w+((?:\[\d+\])*);)", std::regex::multiline);
    for (std::sregex_iterator it(source.begin(), source.end(), local), end; it != end; ++it) {
        const std::string type = (*it)[1].matched ? (*it)[1] : (*it)[3];
        const auto size = kScalarBytes.find(type);
        if (size == kScalarBytes.end())
            return fail(Code::Unsupported, "{}: threadgroup variable of unknown type {}; add its size to kScalarBytes", name, type);
        uint64_t count = (*it)[2].matched ? std::stoull((*it)[2]) : 1;
        const std::string extents = (*it)[4];
        const std::regex number(R"(\d+)");
        for (std::sregex_iterator e(extents.begin(), extents.end(), number); e != end; ++e) count *= std::stoull(e->str());
        groupBytes += count * size->second;
    }
    if (groupBytes > kMaxThreadgroupBytes)
        return fail(Code::InvalidArgument, "{}: {} bytes of threadgroup memory, at most {}", name, groupBytes, kMaxThreadgroupBytes);

    // GLSL text that SPIRV-Cross 1.3 is known to leave in MSL.
    const std::regex leftover(R"(\b(atomicAdd|atomicMin|atomicMax|gl_ViewIndex\s*=\s*0)\b)");
    if (std::smatch found; std::regex_search(source, found, leftover))
        return fail(Code::InvalidArgument, "{}: '{}' is not MSL", name, found.str());
    return {};
}

Status lintMslStrictly(std::string_view name, std::string_view text) {
    DPL_RETURN_IF_ERROR(lintMsl(name, text));
    const MslText parsed = parseMsl(text);
    DPL_RETURN_IF_ERROR(lintNames(name, parsed));
    return lintAddressSpaces(name, parsed);
}

}  // namespace dpl
