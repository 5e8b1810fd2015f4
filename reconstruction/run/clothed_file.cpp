// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/run/clothed_file.h"

#include "sdk/core/arrays.h"
#include "sdk/core/files.h"
#include "sdk/format/check_mesh.h"

namespace dpl {
namespace {

constexpr uint32_t kMagic = 0x484c4344;  // "DCLH"
constexpr uint32_t kVersion = 1;

void putText(Writer& out, const std::string& text) {
    putArray(out, std::vector<char>(text.begin(), text.end()));
}

Result<std::string> getText(Reader& in) {
    std::vector<char> text;
    DPL_RETURN_IF_ERROR(getArray(in, text));
    return std::string(text.begin(), text.end());
}

Status readBody(Reader& in, ClothedMesh& c) {
    DPL_TRY(uint32_t magic, in.u32());
    DPL_TRY(uint32_t version, in.u32());
    if (magic != kMagic || version != kVersion) return fail(Code::Version, "not a file of layers of version {}", kVersion);
    DPL_RETURN_IF_ERROR(getArray(in, c.mesh.restPositions));
    DPL_RETURN_IF_ERROR(getArray(in, c.mesh.colours));
    DPL_RETURN_IF_ERROR(getArray(in, c.mesh.jointIndices));
    DPL_RETURN_IF_ERROR(getArray(in, c.mesh.jointWeights));
    DPL_RETURN_IF_ERROR(getArray(in, c.mesh.triangles));
    DPL_RETURN_IF_ERROR(getArray(in, c.triangleLabel));
    DPL_TRY(const uint32_t layers, in.u32());
    for (uint32_t i = 0; i < layers; ++i) {
        LayerData layer;
        DPL_TRY(layer.name, getText(in));
        DPL_TRY(layer.role, getText(in));
        DPL_TRY(layer.firstVertex, in.u32());
        DPL_TRY(layer.vertexCount, in.u32());
        DPL_TRY(layer.firstTriangle, in.u32());
        DPL_TRY(layer.triangleCount, in.u32());
        c.mesh.layers.push_back(std::move(layer));
    }
    return {};
}

}  // namespace

Status writeClothedFile(const ClothedMesh& c, const std::filesystem::path& path) {
    Writer out;
    out.value(kMagic), out.value(kVersion);
    putArray(out, c.mesh.restPositions), putArray(out, c.mesh.colours), putArray(out, c.mesh.jointIndices);
    putArray(out, c.mesh.jointWeights), putArray(out, c.mesh.triangles), putArray(out, c.triangleLabel);
    out.value(uint32_t(c.mesh.layers.size()));
    for (const LayerData& layer : c.mesh.layers) {
        putText(out, layer.name), putText(out, layer.role);
        out.value(layer.firstVertex), out.value(layer.vertexCount), out.value(layer.firstTriangle), out.value(layer.triangleCount);
    }
    return writeFileAtomically(path, out.finish());
}

Result<ClothedMesh> readClothedFile(const std::filesystem::path& path, size_t jointCount) {
    DPL_TRY(auto bytes, readFile(path));
    ClothedMesh c;
    Reader in(bytes);
    Status read = readBody(in, c);
    if (read) read = checkMesh(c.mesh, jointCount);
    if (read) read = checkFinite(c.mesh);
    if (read) read = checkLayers(c.mesh);
    if (read && !c.triangleLabel.empty() && c.triangleLabel.size() != c.mesh.triangles.size())
        read = fail(Code::CorruptData, "{} triangle labels for {} triangles", c.triangleLabel.size(), c.mesh.triangles.size());
    if (!read) return fail(read.error().code, "{}: {}; delete it and run again", path.string(), read.error().message);
    return c;
}

}  // namespace dpl
