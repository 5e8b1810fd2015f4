// SPDX-License-Identifier: Apache-2.0
#include "sdk/backend/shader_pack.h"

#include <zstd.h>
#include <zstd_errors.h>

#include <new>

#include "sdk/core/reader.h"
#include "sdk/core/writer.h"

namespace dpl {
namespace {

constexpr char kMagic[8] = {'D', 'P', 'L', 'S', 'H', 'A', 'D', 'R'};
constexpr uint32_t kMaxItems = 4096;         // in a list of a pack; the SDK's own lists hold a few dozen
constexpr size_t kMaxBodyBytes = 64u << 20;  // unpacked; the SDK's own pack with MSL has 5 MB
constexpr int kLevel = 19;                   // of zstd; takes half a second once a build

std::string hex(uint64_t value) {
    static const char* digits = "0123456789abcdef";
    std::string text(16, '0');
    for (int i = 15; i >= 0; --i, value >>= 4) text[size_t(i)] = digits[value & 15];
    return text;
}

void putText(Writer& out, std::string_view text) {
    out.value(uint32_t(text.size()));
    out.append({reinterpret_cast<const uint8_t*>(text.data()), text.size()});
}

Result<std::string> takeText(Reader& in) {
    DPL_TRY(uint32_t bytes, in.u32());
    DPL_TRY(auto raw, in.take(bytes));
    return std::string(reinterpret_cast<const char*>(raw.data()), raw.size());
}

Result<uint32_t> takeCount(Reader& in) {
    DPL_TRY(uint32_t count, in.u32());
    if (count > kMaxItems) return fail(Code::CorruptData, "{} items in a shader pack list, at most {} expected", count, kMaxItems);
    return count;
}

void putShader(Writer& out, const Shader& shader) {
    putText(out, shader.name);
    out.value(uint32_t(shader.stage));
    for (uint32_t size : shader.workgroup) out.value(size);
    out.value(shader.pushBytes);
    out.value(shader.sharedBytes);
    out.value(uint32_t(shader.bindings.size()));
    for (const ShaderBinding& b : shader.bindings) {
        putText(out, b.name);
        out.value(b.binding);
        out.value(uint32_t(b.uniform) | uint32_t(b.writes) << 1 | uint32_t(b.reads) << 2 | uint32_t(b.image) << 3 | b.texelWords << 4);
    }
    out.value(uint32_t(shader.structs.size()));
    for (const ShaderStruct& s : shader.structs) {
        putText(out, s.name);
        out.value(s.size);
        out.value(uint32_t(s.members.size()));
        for (const ShaderMember& m : s.members) {
            putText(out, m.name);
            out.value(m.offset);
        }
    }
    out.value(uint32_t(shader.spirv.size()));
    out.append({reinterpret_cast<const uint8_t*>(shader.spirv.data()), shader.spirv.size() * 4});
    putText(out, shader.mslIos);
    putText(out, shader.mslMacos);
}

Result<Shader> takeShader(Reader& in) {
    Shader shader;
    DPL_TRY(shader.name, takeText(in));
    DPL_TRY(uint32_t stage, in.u32());
    if (stage > uint32_t(ShaderStage::Fragment)) return fail(Code::CorruptData, "shader {} has unknown stage {}", shader.name, stage);
    shader.stage = ShaderStage(stage);
    for (uint32_t& size : shader.workgroup) {
        DPL_TRY(size, in.u32());
    }
    DPL_TRY(shader.pushBytes, in.u32());
    DPL_TRY(shader.sharedBytes, in.u32());
    DPL_TRY(uint32_t bindingCount, takeCount(in));
    for (uint32_t i = 0; i < bindingCount; ++i) {
        ShaderBinding b;
        DPL_TRY(b.name, takeText(in));
        DPL_TRY(b.binding, in.u32());
        DPL_TRY(uint32_t flags, in.u32());
        b.uniform = flags & 1, b.writes = flags & 2, b.reads = flags & 4, b.image = flags & 8, b.texelWords = flags >> 4;
        if (b.texelWords > 4 || b.texelWords == 3)
            return fail(Code::CorruptData, "shader {}: texels of {} words", shader.name, b.texelWords);
        shader.bindings.push_back(std::move(b));
    }
    DPL_TRY(uint32_t structCount, takeCount(in));
    for (uint32_t i = 0; i < structCount; ++i) {
        ShaderStruct s;
        DPL_TRY(s.name, takeText(in));
        DPL_TRY(s.size, in.u32());
        DPL_TRY(uint32_t memberCount, takeCount(in));
        for (uint32_t k = 0; k < memberCount; ++k) {
            ShaderMember m;
            DPL_TRY(m.name, takeText(in));
            DPL_TRY(m.offset, in.u32());
            s.members.push_back(std::move(m));
        }
        shader.structs.push_back(std::move(s));
    }
    DPL_TRY(uint32_t words, in.u32());
    if (words > in.remaining() / 4)
        return fail(Code::CorruptData, "shader {} claims {} SPIR-V words, {} bytes left", shader.name, words, in.remaining());
    DPL_TRY(auto code, in.take(size_t(words) * 4));
    shader.spirv.resize(words);
    if (words) std::memcpy(shader.spirv.data(), code.data(), code.size());
    DPL_TRY(shader.mslIos, takeText(in));
    DPL_TRY(shader.mslMacos, takeText(in));
    return shader;
}

std::vector<uint8_t> compress(std::span<const uint8_t> body) {
    std::vector<uint8_t> stream(ZSTD_compressBound(body.size()));
    const size_t got = ZSTD_compress(stream.data(), stream.size(), body.data(), body.size(), kLevel);
    if (ZSTD_isError(got)) throw std::bad_alloc();  // the only way to fail with a buffer of this size
    stream.resize(got);
    return stream;
}

Result<std::vector<uint8_t>> decompress(std::span<const uint8_t> stream, std::string_view origin) {
    const unsigned long long bytes = ZSTD_getFrameContentSize(stream.data(), stream.size());
    if (bytes > kMaxBodyBytes)  // the codes for "unknown" and "no stream" are larger too
        return fail(Code::CorruptData, "{} holds no stream of at most {} bytes", origin, kMaxBodyBytes);
    std::vector<uint8_t> body(bytes);
    const size_t got = ZSTD_decompress(body.data(), body.size(), stream.data(), stream.size());
    if (ZSTD_isError(got)) {
        if (ZSTD_getErrorCode(got) == ZSTD_error_memory_allocation) return fail(Code::OutOfMemory, "no memory to unpack {}", origin);
        return fail(Code::CorruptData, "{} cannot be unpacked: {}", origin, ZSTD_getErrorName(got));
    }
    body.resize(got);
    return body;
}

}  // namespace

const Shader* ShaderPack::find(std::string_view name) const {
    for (const Shader& shader : shaders)
        if (shader.name == name) return &shader;
    return nullptr;
}

uint64_t shaderHash(std::span<const uint8_t> bytes) {
    uint64_t hash = 0xcbf29ce484222325ull;
    for (uint8_t byte : bytes) hash = (hash ^ byte) * 0x100000001b3ull;
    return hash;
}

std::vector<uint8_t> writeShaderPack(const ShaderPack& pack) {
    Writer body;
    body.value(pack.interfaceHash);
    body.value(uint32_t(pack.shaders.size()));
    for (const Shader& shader : pack.shaders) putShader(body, shader);
    const std::vector<uint8_t> stream = compress(body.finish());
    Writer out;
    out.append({reinterpret_cast<const uint8_t*>(kMagic), sizeof(kMagic)});
    out.value(kShaderPackFormat);
    out.value(shaderHash(stream));
    out.append(stream);
    return out.finish();
}

Result<ShaderPack> readShaderPack(std::span<const uint8_t> bytes, std::string_view origin, uint64_t expectedInterface) {
    Reader head(bytes);
    auto magic = head.take(sizeof(kMagic));
    if (!magic || std::memcmp(magic->data(), kMagic, sizeof(kMagic)) != 0)
        return fail(Code::CorruptData, "{} is not a Doppel shader pack", origin);
    DPL_TRY(uint32_t format, head.u32());
    if (format != kShaderPackFormat)
        return fail(Code::Version, "{} has shader pack format {}, this build reads {}", origin, format, kShaderPackFormat);
    ShaderPack pack;
    DPL_TRY(pack.contentHash, head.value<uint64_t>());
    const auto stream = bytes.subspan(head.position());
    if (const uint64_t actual = shaderHash(stream); actual != pack.contentHash)
        return fail(Code::CorruptData, "{} is damaged: content hash {}, expected {}", origin, hex(actual), hex(pack.contentHash));
    DPL_TRY(const std::vector<uint8_t> body, decompress(stream, origin));
    Reader in(body);
    DPL_TRY(pack.interfaceHash, in.value<uint64_t>());
    if (pack.interfaceHash != expectedInterface)
        return fail(Code::Version,
                    "{} was built from shared structs {}, this SDK was compiled with {}; rebuild the pack with the SDK's shaders", origin,
                    hex(pack.interfaceHash), hex(expectedInterface));
    DPL_TRY(uint32_t count, takeCount(in));
    for (uint32_t i = 0; i < count; ++i) {
        DPL_TRY(Shader shader, takeShader(in));
        pack.shaders.push_back(std::move(shader));
    }
    return pack;
}

}  // namespace dpl
