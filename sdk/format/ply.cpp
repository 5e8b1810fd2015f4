// SPDX-License-Identifier: Apache-2.0
#include "sdk/format/ply.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <string>

#include "sdk/core/task.h"
#include "sdk/core/writer.h"
#include "sdk/format/ply_header.h"
#include "sdk/format/read_limits.h"
#include "sdk/math/sh.h"

namespace dpl {
namespace {

float sigmoid(float x) {
    return float(1 / (1 + std::exp(-double(x))));
}

}  // namespace

Result<StaticSplatData> readPly(std::span<const uint8_t> bytes) try {
    DPL_TRY(const PlyHeader header, readPlyHeader(bytes));
    if (header.find("chunk")) return fail(Code::Unsupported, "a compressed PLY, not a plain one; read it with readSplats");
    DPL_TRY(const PlyRows vertices, plyRows(header, bytes, "vertex", ReadLimits().maxSplats));
    DPL_TRY(const auto place, plyColumns(vertices, PlyType::F32, {"x", "y", "z"}));
    DPL_TRY(const auto dc, plyColumns(vertices, PlyType::F32, {"f_dc_0", "f_dc_1", "f_dc_2"}));
    DPL_TRY(const auto scale, plyColumns(vertices, PlyType::F32, {"scale_0", "scale_1", "scale_2"}));
    DPL_TRY(const auto rotation, plyColumns(vertices, PlyType::F32, {"rot_0", "rot_1", "rot_2", "rot_3"}));
    DPL_TRY(const size_t opacity, plyColumn(vertices, PlyType::F32, "opacity"));
    StaticSplatData s;
    DPL_TRY(const auto rest, plyRestColumns(vertices, PlyType::F32, s.shDegree));
    const uint32_t coefficients = shCoefficientCount(s.shDegree);
    const size_t n = vertices.count;
    s.position.resize(n), s.rotation.resize(n), s.scaleM.resize(n), s.opacity.resize(n), s.sh.resize(n * coefficients * 3);
    for (size_t i = 0; i < n; ++i) {
        if (i % kLook == 0) {
            DPL_RETURN_IF_ERROR(taskAt(double(i) / double(n)));
        }
        const uint8_t* row = vertices.row(i);
        bool ok = true;
        // Converters write opacities of 0 and 1 as −∞ and +∞, and axes without thickness as −∞. exp and sigmoid make them finite.
        auto activated = [&](size_t at) {
            float v;
            std::memcpy(&v, row + at, 4);
            ok = ok && !std::isnan(v);
            return v;
        };
        auto value = [&](size_t at) {
            const float v = activated(at);
            ok = ok && std::isfinite(v);
            return v;
        };
        s.position[i] = {value(place[0]), value(place[1]), value(place[2])};
        s.scaleM[i] = {std::exp(activated(scale[0])), std::exp(activated(scale[1])), std::exp(activated(scale[2]))};
        const Quatf q(value(rotation[0]), value(rotation[1]), value(rotation[2]), value(rotation[3]));  // wxyz in these files
        const float length = glm::length(q);
        s.rotation[i] = length > 1e-8f ? q / length : Quatf(1, 0, 0, 0);
        s.opacity[i] = sigmoid(activated(opacity));
        float* sh = s.sh.data() + i * coefficients * 3;
        for (int c = 0; c < 3; ++c) sh[c] = value(dc[size_t(c)]);
        // The file holds all reds, then all greens, then all blues.
        for (uint32_t k = 1; k < coefficients; ++k)
            for (uint32_t c = 0; c < 3; ++c) sh[k * 3 + c] = value(rest[c * (coefficients - 1) + k - 1]);
        if (!ok || !std::isfinite(s.scaleM[i].x + s.scaleM[i].y + s.scaleM[i].z) || !std::isfinite(length))
            return fail(Code::CorruptData, "PLY: splat {} has a number that is not finite", i);
    }
    return s;
} catch (const std::bad_alloc&) {
    return outOfMemory("read a PLY");
}

Result<std::vector<uint8_t>> writePly(const StaticSplatData& s, const PlyWriteOptions& options) {
    const size_t n = s.position.size();
    const uint32_t coefficients = shCoefficientCount(s.shDegree);
    if (s.shDegree > kMaxShDegree || s.rotation.size() != n || s.scaleM.size() != n || s.opacity.size() != n ||
        s.sh.size() != n * coefficients * 3)
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
        for (int c = 0; c < 3; ++c) out.value(std::log(std::max(s.scaleM[i][c], 1e-9f)));  // the third axis of a flat splat is 0
        const Quatf& q = s.rotation[i];
        for (float v : {q.w, q.x, q.y, q.z}) out.value(v);
    }
    return out.finish();
}

}  // namespace dpl
