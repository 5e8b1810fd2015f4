// SPDX-License-Identifier: Apache-2.0
#include "tools/shaderpack/glsl.h"

#include <glslang/Public/ResourceLimits.h>
#include <glslang/Public/ShaderLang.h>
#include <glslang/SPIRV/GlslangToSpv.h>

#include <fstream>
#include <memory>
#include <sstream>

namespace dpl {
namespace {

/** Finds includes below `root` and records them. */
class RootedIncluder : public glslang::TShader::Includer {
public:
    RootedIncluder(std::filesystem::path root, std::set<std::string>& dependencies) : root_(std::move(root)), dependencies_(dependencies) {}

    IncludeResult* includeLocal(const char* header, const char*, size_t) override {
        auto text = readTextFile(root_ / header);
        if (!text) return nullptr;
        dependencies_.insert((root_ / header).string());
        auto* kept = new std::string(std::move(*text));
        return new IncludeResult(header, kept->data(), kept->size(), kept);
    }
    void releaseInclude(IncludeResult* result) override {
        if (!result) return;
        delete static_cast<std::string*>(result->userData);
        delete result;
    }

private:
    std::filesystem::path root_;
    std::set<std::string>& dependencies_;
};

EShLanguage languageOf(ShaderStage stage) {
    return stage == ShaderStage::Compute ? EShLangCompute : stage == ShaderStage::Vertex ? EShLangVertex : EShLangFragment;
}

}  // namespace

Result<std::string> readTextFile(const std::filesystem::path& path) {
    std::ifstream in(path, std::ios::binary);
    if (!in) return fail(Code::NotFound, "cannot read {}", path.string());
    std::ostringstream text;
    text << in.rdbuf();
    return text.str();
}

Result<std::vector<uint32_t>> compileGlsl(const GlslInput& input, std::set<std::string>& dependencies) {
    static const bool ready = glslang::InitializeProcess();
    if (!ready) return fail(Code::Internal, "glslang cannot be initialised");
    DPL_TRY(std::string source, readTextFile(input.file));
    dependencies.insert(input.file.string());
    std::string preamble = "#extension GL_GOOGLE_include_directive : require\n";
    for (const std::string& define : input.defines) preamble += "#define " + define + " 1\n";

    const EShLanguage language = languageOf(input.stage);
    const std::string name = input.file.string();
    const char *text = source.c_str(), *fileName = name.c_str();
    const int length = int(source.size());
    glslang::TShader shader(language);
    shader.setStringsWithLengthsAndNames(&text, &length, &fileName, 1);
    shader.setPreamble(preamble.c_str());
    shader.setEnvInput(glslang::EShSourceGlsl, language, glslang::EShClientVulkan, 100);
    shader.setEnvClient(glslang::EShClientVulkan, glslang::EShTargetVulkan_1_1);
    shader.setEnvTarget(glslang::EShTargetSpv, glslang::EShTargetSpv_1_3);
    RootedIncluder includer(input.root, dependencies);
    const EShMessages messages = EShMessages(EShMsgSpvRules | EShMsgVulkanRules);
    if (!shader.parse(GetDefaultResources(), 450, false, messages, includer)) return fail(Code::InvalidArgument, "{}", shader.getInfoLog());
    glslang::TProgram program;
    program.addShader(&shader);
    if (!program.link(messages)) return fail(Code::InvalidArgument, "{}: {}", name, program.getInfoLog());
    std::vector<uint32_t> spirv;
    glslang::SpvOptions options;
    options.disableOptimizer = true;  // drivers optimise, and Debian's optimiser library may be of another version than glslang
    options.validate = false;
    glslang::GlslangToSpv(*program.getIntermediate(language), spirv, &options);
    if (spirv.empty()) return fail(Code::Internal, "{}: glslang produced no SPIR-V", name);
    return spirv;
}

}  // namespace dpl
