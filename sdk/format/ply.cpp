#include "sdk/format/ply.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <map>
#include <string>
#include <string_view>

#include "sdk/core/reader.h"
#include "sdk/core/writer.h"
#include "sdk/format/read_limits.h"
#include "sdk/math/sh.h"

namespace dpl {
namespace {

constexpr size_t kMaxHeaderBytes = 64 * 1024;

struct Column {
    size_t offset = 0;
    bool isFloat = false;
};

struct Header {
    uint64_t vertexCount = 0;
    size_t stride = 0;
    size_t bodyAt = 0;
    std::map<std::string, Column, std::less<>> columns;
};

size_t typeBytes(std::string_view type) {
    static const std::map<std::string_view, size_t> sizes = {{"char", 1}, {"uchar", 1}, {"int8", 1}, {"uint8", 1}, {"short", 2}, {"ushort", 2}, {"int16", 2}, {"uint16", 2},
                                                             {"int", 4}, {"uint", 4}, {"int32", 4}, {"uint32", 4}, {"float", 4}, {"float32", 4}, {"double", 8}, {"float64", 8}};
    auto it = sizes.find(type);
    return it == sizes.end() ? 0 : it->second;
}

std::vector<std::string_view> words(std::string_view line) {
    std::vector<std::string_view> out;
    while (true) {
        const size_t from = line.find_first_not_of(" \t\r");
        if (from == std::string_view::npos) return out;
        const size_t end = std::min(line.find_first_of(" \t\r", from), line.size());
        out.push_back(line.substr(from, end - from));
        line.remove_prefix(end);
    }
}

Result<uint64_t> countOf(std::string_view text) {
    uint64_t value = 0;
    for (char c : text) {
        if (c < '0' || c > '9' || value > (1ull << 40)) return fail(Code::CorruptData, "PLY: a count of '{}'", text.substr(0, 32));
        value = value * 10 + uint64_t(c - '0');
    }
    return value;
}

Result<Header> readHeader(std::span<const uint8_t> bytes) {
    const std::string_view text(reinterpret_cast<const char*>(bytes.data()), std::min(bytes.size(), kMaxHeaderBytes));
    if (!text.starts_with("ply\n") && !text.starts_with("ply\r\n")) return fail(Code::Unsupported, "not a PLY file: it does not begin with 'ply'");
    Header header;
    bool binary = false, inVertex = false, afterVertex = false;
    for (size_t at = 0; at < text.size();) {
        const size_t end = text.find('\n', at);
        if (end == std::string_view::npos) break;
        const auto line = words(text.substr(at, end - at));
        at = end + 1;
        if (line.empty() || line[0] == "comment" || line[0] == "obj_info" || line[0] == "ply") continue;
        if (line[0] == "format") {
            binary = line.size() >= 2 && line[1] == "binary_little_endian";
        } else if (line[0] == "element" && line.size() == 3) {
            afterVertex = afterVertex || inVertex;
            inVertex = line[1] == "vertex";
            if (!inVertex && !afterVertex) return fail(Code::Unsupported, "PLY: element '{}' in front of the vertices (a compressed PLY?); convert it to a plain one", line[1]);
            if (inVertex) {
                DPL_TRY(header.vertexCount, countOf(line[2]));
            }
        } else if (line[0] == "property" && inVertex) {
            const size_t size = line.size() == 3 ? typeBytes(line[1]) : 0;
            if (size == 0) return fail(Code::Unsupported, "PLY: a vertex property that is a list or of unknown type");
            header.columns[std::string(line[2])] = {header.stride, line[1] == "float" || line[1] == "float32"};
            header.stride += size;
        } else if (line[0] == "end_header") {
            if (!binary) return fail(Code::Unsupported, "PLY: only binary_little_endian is read");
            header.bodyAt = at;
            return header;
        }
    }
    return fail(Code::CorruptData, "PLY: no end_header in the first {} bytes", text.size());
}

Result<size_t> columnAt(const Header& header, const std::string& name) {
    auto it = header.columns.find(name);
    if (it == header.columns.end() || !it->second.isFloat) return fail(Code::CorruptData, "PLY: no float property '{}'; is this a Gaussian splat file?", name);
    return it->second.offset;
}

Result<std::vector<size_t>> columnsAt(const Header& header, std::initializer_list<const char*> names) {
    std::vector<size_t> out;
    for (const char* name : names) {
        DPL_TRY(const size_t at, columnAt(header, name));
        out.push_back(at);
    }
    return out;
}

float sigmoid(float x) { return float(1 / (1 + std::exp(-double(x)))); }

}  // namespace

Result<StaticSplatData> readPly(std::span<const uint8_t> bytes) try {
    DPL_TRY(const Header header, readHeader(bytes));
    DPL_TRY(const auto place, columnsAt(header, {"x", "y", "z"}));
    DPL_TRY(const auto dc, columnsAt(header, {"f_dc_0", "f_dc_1", "f_dc_2"}));
    DPL_TRY(const auto scale, columnsAt(header, {"scale_0", "scale_1", "scale_2"}));
    DPL_TRY(const auto rotation, columnsAt(header, {"rot_0", "rot_1", "rot_2", "rot_3"}));
    DPL_TRY(const size_t opacity, columnAt(header, "opacity"));
    std::vector<size_t> rest;
    while (header.columns.contains("f_rest_" + std::to_string(rest.size()))) {
        DPL_TRY(const size_t at, columnAt(header, "f_rest_" + std::to_string(rest.size())));
        rest.push_back(at);
    }
    StaticSplatData s;
    while (s.shDegree < kMaxShDegree && (shCoefficientCount(s.shDegree) - 1) * 3 < rest.size()) ++s.shDegree;
    const uint32_t coefficients = shCoefficientCount(s.shDegree);
    if ((coefficients - 1) * 3 != rest.size()) return fail(Code::CorruptData, "PLY: {} f_rest properties; 0, 9, 24 or 45 are possible", rest.size());
    const size_t body = bytes.size() - header.bodyAt;
    if (header.vertexCount > body / header.stride) return fail(Code::CorruptData, "PLY: {} vertices of {} bytes do not fit in {} bytes: truncated", header.vertexCount, header.stride, body);
    if (header.vertexCount > ReadLimits().maxSplats) return fail(Code::CorruptData, "PLY: {} splats, the limit is {}", header.vertexCount, ReadLimits().maxSplats);
    const size_t n = header.vertexCount;
    s.position.resize(n), s.rotation.resize(n), s.scaleM.resize(n), s.opacity.resize(n), s.sh.resize(n * coefficients * 3);
    for (size_t i = 0; i < n; ++i) {
        const uint8_t* row = bytes.data() + header.bodyAt + i * header.stride;
        bool ok = true;
        auto value = [&](size_t at) {
            float v;
            std::memcpy(&v, row + at, 4);
            ok = ok && std::isfinite(v);
            return v;
        };
        s.position[i] = {value(place[0]), value(place[1]), value(place[2])};
        s.scaleM[i] = {std::exp(value(scale[0])), std::exp(value(scale[1])), std::exp(value(scale[2]))};
        const Quatf q(value(rotation[0]), value(rotation[1]), value(rotation[2]), value(rotation[3]));   // wxyz in these files
        const float length = glm::length(q);
        s.rotation[i] = length > 1e-8f ? q / length : Quatf(1, 0, 0, 0);
        s.opacity[i] = sigmoid(value(opacity));
        float* sh = s.sh.data() + i * coefficients * 3;
        for (int c = 0; c < 3; ++c) sh[c] = value(dc[size_t(c)]);
        // The file has all reds, then all greens, then all blues.
        for (uint32_t k = 1; k < coefficients; ++k)
            for (uint32_t c = 0; c < 3; ++c) sh[k * 3 + c] = value(rest[c * (coefficients - 1) + k - 1]);
        if (!ok || !std::isfinite(s.scaleM[i].x + s.scaleM[i].y + s.scaleM[i].z) || !std::isfinite(length)) return fail(Code::CorruptData, "PLY: splat {} has a number that is not finite", i);
    }
    return s;
} catch (const std::bad_alloc&) {
    return fail(Code::OutOfMemory, "no memory to read a PLY");
}

Result<std::vector<uint8_t>> writePly(const StaticSplatData& s, const PlyWriteOptions& options) {
    const size_t n = s.position.size();
    const uint32_t coefficients = shCoefficientCount(s.shDegree);
    if (s.shDegree > kMaxShDegree || s.rotation.size() != n || s.scaleM.size() != n || s.opacity.size() != n || s.sh.size() != n * coefficients * 3)
        return fail(Code::InvalidArgument, "the arrays of {} splats differ in length", n);
    const uint32_t restPerChannel = (options.padToDegree3 ? kMaxShCoefficients : coefficients) - 1;
    std::string header = "ply\nformat binary_little_endian 1.0\nelement vertex " + std::to_string(n) + "\n";
    auto property = [&](const std::string& name) { header += "property float " + name + "\n"; };
    for (const char* name : {"x", "y", "z"}) property(name);
    if (options.normals)
        for (const char* name : {"nx", "ny", "nz"}) property(name);
    for (int k = 0; k < 3; ++k) property("f_dc_" + std::to_string(k));
    for (uint32_t k = 0; k < restPerChannel * 3; ++k) property("f_rest_" + std::to_string(k));
    property("opacity");
    for (int k = 0; k < 3; ++k) property("scale_" + std::to_string(k));
    for (int k = 0; k < 4; ++k) property("rot_" + std::to_string(k));
    header += "end_header\n";
    Writer out;
    out.append({reinterpret_cast<const uint8_t*>(header.data()), header.size()});
    for (size_t i = 0; i < n; ++i) {
        out.value(s.position[i]);
        if (options.normals) out.value(Vec3f(0));
        const float* sh = s.sh.data() + i * coefficients * 3;
        for (int c = 0; c < 3; ++c) out.value(sh[c]);
        for (uint32_t c = 0; c < 3; ++c)
            for (uint32_t k = 1; k <= restPerChannel; ++k) out.value(k < coefficients ? sh[k * 3 + c] : 0.0f);
        const double alpha = std::clamp(double(s.opacity[i]), 1e-6, 1 - 1e-6);
        out.value(float(std::log(alpha / (1 - alpha))));
        for (int c = 0; c < 3; ++c) out.value(std::log(std::max(s.scaleM[i][c], 1e-9f)));   // a flat splat's third axis is 0
        const Quatf& q = s.rotation[i];
        for (float v : {q.w, q.x, q.y, q.z}) out.value(v);
    }
    return out.finish();
}

}  // namespace dpl
