// SPDX-License-Identifier: Apache-2.0
// Every shader has MSL that passes the lint and has its buffers at the mapped indices. The lint refuses wrong MSL.
#include <gtest/gtest.h>

#include <regex>

#include "tools/shaderpack/glsl.h"
#include "tools/shaderpack/msl.h"

namespace dpl {
namespace {

/** All shaders except the typed-buffer variants, which have no MSL. */
ShaderPack fullPack() {
    auto text = readTextFile(DOPPEL_SHADER_DIR "/shaders.dplpack");
    EXPECT_TRUE(text) << (text ? "" : text.error().message);
    if (!text) return {};
    const std::span<const uint8_t> bytes(reinterpret_cast<const uint8_t*>(text->data()), text->size());
    auto pack = readShaderPack(bytes, "shaders.dplpack", embeddedShaderInterface());
    EXPECT_TRUE(pack) << (pack ? "" : pack.error().message);
    if (pack) std::erase_if(pack->shaders, [](const Shader& s) { return s.name.ends_with(kTexelsSuffix); });
    return pack ? *pack : ShaderPack{};
}

TEST(MetalText, everyShaderHasMslForIosAndMacosThatPassesTheLint) {
    const ShaderPack pack = fullPack();
    EXPECT_GE(pack.shaders.size(), 14u);
    for (const Shader& shader : pack.shaders) {
        for (const std::string* text : {&shader.mslIos, &shader.mslMacos}) {
            EXPECT_FALSE(text->empty()) << shader.name;
            const Status status = lintMsl(shader.name, *text);
            EXPECT_TRUE(status) << (status ? "" : status.error().message);
        }
    }
}

TEST(MetalText, bindingsAndPushConstantsSitWhereTheMapSays) {
    for (const Shader& shader : fullPack().shaders) {
        for (const std::string* text : {&shader.mslIos, &shader.mslMacos}) {
            for (const ShaderBinding& b : shader.bindings) {
                const std::string place = (b.image ? "texture(" : "buffer(") + std::to_string(b.binding) + ")";
                const std::regex want(b.name + (b.image ? R"( \[\[)" : R"(& \w+ \[\[)") +
                                      std::regex_replace(place, std::regex(R"([()])"), R"(\$&)") + R"(\]\])");
                EXPECT_TRUE(std::regex_search(*text, want)) << shader.name << ": " << b.name << " is not " << place;
            }
            if (shader.pushBytes && text->find("PushBlock&") != std::string::npos) {
                EXPECT_NE(text->find("[[buffer(29)]]"), std::string::npos) << shader.name;
            }
        }
    }
}

TEST(MetalText, theViewIndexIsRealAndClipSpaceIsFlipped) {
    for (const Shader& shader : fullPack().shaders) {
        if (shader.stage != ShaderStage::Vertex) continue;
        const bool multiview = shader.name.find("multiview") != std::string::npos;
        // Without its multiview option, SPIRV-Cross emits "gl_ViewIndex = 0" without a warning.
        EXPECT_EQ(shader.mslIos.find("render_target_array_index") != std::string::npos, multiview) << shader.name;
        EXPECT_EQ(shader.mslIos.find("spvViewMask") != std::string::npos, multiview) << shader.name;
        EXPECT_NE(shader.mslIos.find("gl_Position.y = -"), std::string::npos) << shader.name;
    }
}

TEST(MetalText, barriersOfSharedMemoryKeepTheThreadgroupFlag) {
    int barriers = 0;
    for (const Shader& shader : fullPack().shaders) {
        const std::regex barrier(R"(threadgroup_barrier\(([^)]*)\))");
        for (std::sregex_iterator it(shader.mslIos.begin(), shader.mslIos.end(), barrier), end; it != end; ++it, ++barriers)
            EXPECT_NE((*it)[1].str().find("mem_threadgroup"), std::string::npos) << shader.name << ": " << it->str();
    }
    EXPECT_GT(barriers, 10);
}

TEST(MetalLint, catchesWhatApplesCompilerWould) {
    const std::string head = "kernel void main0(";
    const auto lint = [&](const std::string& parameters, const std::string& body) {
        return bool(lintMsl("t", head + parameters + ")\n{\n" + body + "}\n"));
    };
    EXPECT_TRUE(lint("device A& a [[buffer(0)]], constant B& b [[buffer(29)]]", "    threadgroup uint x[256];\n"));
    EXPECT_FALSE(lint("device A& a [[buffer(0)]], constant B& b [[buffer(0)]]", ""));
    EXPECT_FALSE(lint("device A& a [[buffer(31)]]", ""));
    EXPECT_FALSE(lint("", "    threadgroup uint x[8193];\n"));
    EXPECT_TRUE(lint("", "    threadgroup uint x[8192];\n"));
    EXPECT_FALSE(lint("", "    threadgroup spvUnsafeArray<uint, 8193> x;\n"));
    EXPECT_FALSE(lint("", "    threadgroup Strange x;\n"));
    EXPECT_FALSE(lint("", "    atomicAdd(x, 1);\n"));
    EXPECT_FALSE(bool(lintMsl("t", "void helper() {}\n")));
}

}  // namespace
}  // namespace dpl
