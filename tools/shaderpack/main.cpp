// SPDX-License-Identifier: Apache-2.0
// shaderpack ROOT CATALOGUE OUT [NAMESPACE]: compiles every shader of the catalogue and writes the results into OUT. Include paths start at
// ROOT, shader paths at the catalogue's folder. Its subfolder shared/ is the interface with C++. Results, whose functions are in NAMESPACE
// (dpl):
//   shader_pack.cpp             the pack without MSL as bytes; functions embeddedShaderPack and embeddedShaderInterface
//   metal_pack.cpp              the same for the pack without SPIR-V; functions embeddedMetalPack and embeddedMetalInterface
//   shaders.dplpack             the full pack, with SPIR-V and MSL
//   msl/NAME.{ios,macos}.metal  the MSL as text
//   shader_pack.d               dependencies for ninja
#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <nlohmann/json.hpp>

#include "tools/shaderpack/glsl.h"
#include "tools/shaderpack/msl.h"

namespace fs = std::filesystem;

namespace dpl {
namespace {

Status writeFile(const fs::path& path, std::string_view text) {
    const fs::path temporary = path.string() + ".tmp";
    {
        std::ofstream out(temporary, std::ios::binary);
        out.write(text.data(), std::streamsize(text.size()));
        if (!out.flush()) return fail(Code::Io, "cannot write {}", temporary.string());
    }
    std::error_code error;
    fs::rename(temporary, path, error);
    if (error) return fail(Code::Io, "cannot rename {}: {}", temporary.string(), error.message());
    return {};
}

Result<ShaderStage> stageOf(const fs::path& file) {
    if (file.extension() == ".comp") return ShaderStage::Compute;
    if (file.extension() == ".vert") return ShaderStage::Vertex;
    if (file.extension() == ".frag") return ShaderStage::Fragment;
    return fail(Code::InvalidArgument, "{}: a shader's file name must end in .comp, .vert or .frag", file.string());
}

/** Hash of the names and texts of all shared headers, on which C++ and GLSL must agree. */
Result<uint64_t> hashInterface(const fs::path& shared) {
    std::vector<fs::path> files;
    for (const auto& entry : fs::directory_iterator(shared)) files.push_back(entry.path());
    std::sort(files.begin(), files.end());
    std::string all;
    for (const fs::path& file : files) {
        DPL_TRY(std::string text, readTextFile(file));
        all += file.filename().string() + '\0' + text;
    }
    return shaderHash({reinterpret_cast<const uint8_t*>(all.data()), all.size()});
}

/** C++ text with a pack and the functions embedded<kind>Pack and embedded<kind>Interface, which return it and its interface hash. */
std::string embedText(const std::vector<uint8_t>& bytes, uint64_t interfaceHash, const std::string& space, const std::string& kind) {
    std::string text =
        "// Written by tools/shaderpack; do not edit.\n#include <cstdint>\n#include <span>\nnamespace {\nconst uint8_t kPack[] = {";
    text.reserve(text.size() + bytes.size() * 4 + 512);
    for (size_t i = 0; i < bytes.size(); ++i) {
        if (i % 32 == 0) text += '\n';
        text += std::to_string(bytes[i]) + ',';
    }
    text += "\n};\n}  // namespace\n";
    const auto define = [&](const std::string& type, const std::string& function, const std::string& body) {
        text += type + " " + function + "();\n" + type + " " + function + "() { return " + body + "; }\n";
    };
    text += "namespace " + space + " {\n";
    define("std::span<const uint8_t>", "embedded" + kind + "Pack", "kPack");
    define("uint64_t", "embedded" + kind + "Interface", std::to_string(interfaceHash) + "ull");
    return text + "}\n";
}

Status run(const fs::path& root, const fs::path& cataloguePath, const fs::path& out, const std::string& space) {
    DPL_TRY(std::string text, readTextFile(cataloguePath));
    const auto catalogue = nlohmann::json::parse(text, nullptr, false);
    if (catalogue.is_discarded() || !catalogue.contains("shaders"))
        return fail(Code::CorruptData, "{} is not a shader catalogue", cataloguePath.string());
    std::set<std::string> dependencies = {cataloguePath.string()};
    ShaderPack pack;
    DPL_TRY(pack.interfaceHash, hashInterface(cataloguePath.parent_path() / "shared"));
    const uint32_t mostStorageBuffers = catalogue.value("storageBuffers", 4u);  // the minimum of Vulkan 1.1
    for (const auto& entry : catalogue["shaders"]) {
        Shader shader;
        shader.name = entry.at("name").get<std::string>();
        GlslInput input{root, cataloguePath.parent_path() / entry.at("file").get<std::string>()};
        DPL_TRY(input.stage, stageOf(input.file));
        shader.stage = input.stage;
        input.defines = entry.value("defines", std::vector<std::string>{});
        DPL_TRY(shader.spirv, compileGlsl(input, dependencies));
        DPL_RETURN_IF_ERROR(reflectShader(shader, mostStorageBuffers));
        const MslOptions wanted{entry.value("multiview", false), entry.value("eachSample", false)};
        DPL_TRY(shader.mslIos, translateToMsl(shader, MslPlatform::Ios, wanted));
        DPL_TRY(shader.mslMacos, translateToMsl(shader, MslPlatform::Macos, wanted));
        DPL_RETURN_IF_ERROR(lintMsl(shader.name + " (iOS)", shader.mslIos));
        DPL_RETURN_IF_ERROR(lintMsl(shader.name + " (macOS)", shader.mslMacos));
        const bool metalOnly = entry.value("metal", false), reads = !shader.bindings.empty() && !metalOnly;
        if (metalOnly) shader.spirv.clear();
        pack.shaders.push_back(std::move(shader));
        if (!reads) continue;
        input.defines.push_back("DPL_TEXELS");
        Shader texels{.name = pack.shaders.back().name + std::string(kTexelsSuffix), .stage = input.stage};
        DPL_TRY(texels.spirv, compileGlsl(input, dependencies));
        DPL_RETURN_IF_ERROR(reflectShader(texels, mostStorageBuffers));
        if (std::any_of(texels.bindings.begin(), texels.bindings.end(), [](const ShaderBinding& b) { return b.texelWords > 0; }))
            pack.shaders.push_back(std::move(texels));
    }
    fs::create_directories(out / "msl");
    for (const Shader& shader : pack.shaders) {
        if (shader.mslIos.empty()) continue;
        DPL_RETURN_IF_ERROR(writeFile(out / "msl" / (shader.name + ".ios.metal"), shader.mslIos));
        DPL_RETURN_IF_ERROR(writeFile(out / "msl" / (shader.name + ".macos.metal"), shader.mslMacos));
    }
    const std::vector<uint8_t> full = writeShaderPack(pack);
    DPL_RETURN_IF_ERROR(writeFile(out / "shaders.dplpack", {reinterpret_cast<const char*>(full.data()), full.size()}));
    ShaderPack metal = pack;
    std::erase_if(metal.shaders, [](const Shader& s) { return s.mslIos.empty(); });
    for (Shader& shader : metal.shaders) shader.spirv.clear();
    DPL_RETURN_IF_ERROR(writeFile(out / "metal_pack.cpp", embedText(writeShaderPack(metal), pack.interfaceHash, space, "Metal")));
    std::erase_if(pack.shaders, [](const Shader& s) { return s.spirv.empty(); });
    for (Shader& shader : pack.shaders) shader.mslIos.clear(), shader.mslMacos.clear();
    DPL_RETURN_IF_ERROR(writeFile(out / "shader_pack.cpp", embedText(writeShaderPack(pack), pack.interfaceHash, space, "Shader")));
    std::string depfile = (out / "shader_pack.cpp").string() + ":";
    for (const std::string& dependency : dependencies) depfile += " \\\n  " + dependency;
    return writeFile(out / "shader_pack.d", depfile + "\n");
}

}  // namespace
}  // namespace dpl

int main(int argc, char** argv) {
    if (argc != 4 && argc != 5) {
        std::cerr << "usage: shaderpack ROOT CATALOGUE OUT [NAMESPACE]\n";
        return 2;
    }
    if (auto status = dpl::run(argv[1], argv[2], argv[3], argc == 5 ? argv[4] : "dpl"); !status) {
        std::cerr << "shaderpack: " << status.error().message << '\n';
        return 1;
    }
    return 0;
}
