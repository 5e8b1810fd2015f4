// SPDX-License-Identifier: Apache-2.0
// Every shader has MSL that passes the lint and has its buffers at the mapped indices. The lint refuses wrong MSL.
#include <gtest/gtest.h>

#include <regex>

#include "tools/shaderpack/glsl.h"
#include "tools/shaderpack/msl.h"

namespace dpl {
namespace training {  // generated from shaders/training
uint64_t embeddedShaderInterface();
}
namespace {

std::vector<Shader> shadersOf(const std::string& file, uint64_t interface) {
    auto text = readTextFile(file);
    EXPECT_TRUE(text) << (text ? "" : text.error().message);
    if (!text) return {};
    const std::span<const uint8_t> bytes(reinterpret_cast<const uint8_t*>(text->data()), text->size());
    auto pack = readShaderPack(bytes, file, interface);
    EXPECT_TRUE(pack) << (pack ? "" : pack.error().message);
    return pack ? pack->shaders : std::vector<Shader>{};
}

/** All shaders, those of training too, except the typed-buffer variants, which have no MSL. */
std::vector<Shader> allShaders() {
    std::vector<Shader> all = shadersOf(DOPPEL_SHADER_DIR "/shaders.dplpack", embeddedShaderInterface());
    EXPECT_GE(all.size(), 14u);
#ifdef DOPPEL_TRAINING_SHADERS
    const std::vector<Shader> more = shadersOf(DOPPEL_SHADER_DIR "/training/shaders.dplpack", training::embeddedShaderInterface());
    EXPECT_GE(more.size(), 14u);
    all.insert(all.end(), more.begin(), more.end());
#endif
    std::erase_if(all, [](const Shader& s) { return s.name.ends_with(kTexelsSuffix); });
    return all;
}

TEST(MetalText, everyShaderHasMslForIosAndMacosThatPassesTheLint) {
    for (const Shader& shader : allShaders()) {
        for (const std::string* text : {&shader.mslIos, &shader.mslMacos}) {
            EXPECT_FALSE(text->empty()) << shader.name;
            const Status status = lintMslStrictly(shader.name, *text);
            EXPECT_TRUE(status) << (status ? "" : status.error().message);
        }
    }
}

TEST(MetalText, bindingsAndPushConstantsSitWhereTheMapSays) {
    for (const Shader& shader : allShaders()) {
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
    for (const Shader& shader : allShaders()) {
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
    for (const Shader& shader : allShaders()) {
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
    EXPECT_TRUE(lint("texture2d<float> a [[texture(0)]], device A& b [[buffer(0)]]", ""));
    EXPECT_FALSE(lint("texture2d<float> a [[texture(3)]], texture2d<float> b [[texture(3)]]", ""));
    EXPECT_FALSE(lint("texture2d<float> a [[texture(31)]]", ""));
}

/** Expects that `text` with a correct line passes, and that the wrong line in its place gives an error that contains `message`. */
void expectRefused(std::string text, const std::string& right, const std::string& wrong, const std::string& message) {
    const auto with = [&](const std::string& line) { return std::regex_replace(text, std::regex("HERE"), line); };
    const Status fine = lintMslStrictly("t", with(right)), status = lintMslStrictly("t", with(wrong));
    EXPECT_TRUE(fine) << right << ": " << (fine ? "" : fine.error().message);
    ASSERT_FALSE(status) << wrong;
    EXPECT_NE(status.error().message.find(message), std::string::npos) << status.error().message;
}

TEST(MetalLint, catchesNamesThatMetalDoesNotHave) {
    const std::string text = R"(
template<typename T>
static inline __attribute__((always_inline)) T twice(T x) { return x + T(x); }

struct Pair { float a; };

kernel void main0(device A& a [[buffer(0)]], texture2d<float> t [[texture(0)]])
{
    float x = float(a.words[0]);
    HERE
}
)";
    expectRefused(text, "x = twice(fast::max(x, 0.0));", "x = thrice(x);", "'thrice' is no function");
    expectRefused(text, "x = Pair{ x }.a;", "x = inversesqrt(x);", "'inversesqrt'");  // GLSL's name
    expectRefused(text, "x = rsqrt(x);", "x = std::sqrt(x);", "'std::sqrt'");
    expectRefused(text, "x = t.read(uint2(0), 0).x;", "x = t.fetch(uint2(0), 0).x;", "'fetch'");
    expectRefused(text, "if (x > 0.0) { x = 1.0; } // f(x)", "if (unpackHalf2x16(1u).x > 0.0) { x = 1.0; }", "'unpackHalf2x16'");
}

TEST(MetalLint, catchesAddressSpacesThatDoNotFit) {
    const std::string text = R"(
template<typename T, size_t Num>
struct spvUnsafeArray { T elements[Num]; };

constant uint4 kTable = uint4(1u, 2u, 3u, 4u);

static inline __attribute__((always_inline))
uint ofThread(thread const uint& x) { return x; }

static inline __attribute__((always_inline))
uint ofDevice(const device A& x, threadgroup uint (&sums)[256], thread spvUnsafeArray<uint, 3>& list) { return x.words[0] + sums[0]; }

kernel void main0(device A& a [[buffer(0)]], constant B& b [[buffer(29)]], uint lane [[thread_index_in_threadgroup]])
{
    threadgroup uint sums[256];
    uint local = lane;
    B copy = b;
    uint other[4];
    spvUnsafeArray<uint, 3> list;
    HERE
}
)";
    expectRefused(text, "local = ofThread(local);", "local = ofThread(a.count);",
                  "'x' is in thread memory, and is given one in device memory");
    expectRefused(text, "local = ofThread(copy.count);", "local = ofThread(b.count);", "given one in constant memory");
    expectRefused(text, "local = ofThread(sums[0] + 1u);", "local = ofThread(sums[0]);", "given one in threadgroup memory");
    expectRefused(text, "local = ofDevice(a, sums, list);", "local = ofDevice(b, sums, list);",
                  "'x' is in device memory, and is given one in constant memory");
    expectRefused(text, "local = ofDevice(a, sums, list);", "local = ofDevice(a, other, list);",
                  "'sums' is in threadgroup memory, and is given one in thread memory");
    expectRefused("HERE\nkernel void main0(device A& a [[buffer(0)]])\n{\n}\n", "constant uint k = 1u;", "uint k = 1u;", "not constant");
    expectRefused("uint f(HERE x) { return x; }\nkernel void main0(device A& a [[buffer(0)]])\n{\n}\n", "thread uint&", "uint&",
                  "'x' of f() has no address space");
}

}  // namespace
}  // namespace dpl
