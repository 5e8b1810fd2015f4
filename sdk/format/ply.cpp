// SPDX-License-Identifier: Apache-2.0
#include "sdk/format/ply.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <optional>
#include <string>

#include "sdk/core/task.h"
#include "sdk/core/writer.h"
#include "sdk/format/ply_header.h"
#include "sdk/format/read_limits.h"
#include "sdk/math/sh.h"

namespace dpl {
namespace {

constexpr float kFlatShare = 1e-3f;  // thickness of a splat of two scales, as a share of the smaller one

float sigmoid(float x) {
    return float(1 / (1 + std::exp(-double(x))));
}

/** The columns of one row that become a splat. */
struct Columns {
    std::vector<size_t> place, dc, rest, scale, rotation;
    size_t opacity = 0;
    std::optional<size_t> filter;  // the 3D smoothing filter of Mip-Splatting, a standard deviation in metres
};

Result<Columns> columnsOf(const PlyRows& rows, SplatRemarks& remarks) {
    const auto& names = rows.element->columns;
    Columns c;
    DPL_TRY(c.place, plyColumns(rows, PlyType::F32, {"x", "y", "z"}));
    DPL_TRY(c.dc, plyColumns(rows, PlyType::F32, {"f_dc_0", "f_dc_1", "f_dc_2"}));
    DPL_TRY(c.scale, plyColumns(rows, PlyType::F32, {"scale_0", "scale_1"}));
    if (names.contains("scale_2")) {
        DPL_TRY(const size_t third, plyColumn(rows, PlyType::F32, "scale_2"));
        c.scale.push_back(third);
    }
    DPL_TRY(c.rotation, plyColumns(rows, PlyType::F32, {"rot_0", "rot_1", "rot_2", "rot_3"}));
    DPL_TRY(c.opacity, plyColumn(rows, PlyType::F32, "opacity"));
    DPL_TRY(c.rest, plyRestColumns(rows, PlyType::F32, remarks.shDegree));
    for (const char* name : {"filter_3D", "filter_3d"})
        if (names.contains(name)) {
            DPL_TRY(c.filter, plyColumn(rows, PlyType::F32, name));
        }
    if (c.scale.size() == 2) remarks.notes.push_back("two scales a splat (2D Gaussian splatting): read as flat splats");
    if (c.filter) remarks.notes.push_back("the column filter_3D is fused into sizes and opacities, as Mip-Splatting defines it");
    return c;
}

/** Mip-Splatting's 3D smoothing filter: variances add, and the opacity falls by the ratio of the volumes. */
void fuseFilter(double filterM, size_t axes, Vec3f& scaleM, float& opacity) {
    double share = 1;
    for (int k = 0; k < int(axes); ++k) {
        const double squared = double(scaleM[k]) * scaleM[k], filtered = squared + filterM * filterM;
        if (filtered > 0) share *= squared / filtered;
        scaleM[k] = float(std::sqrt(filtered));
    }
    opacity = float(opacity * std::sqrt(share));
}

}  // namespace

Result<StaticSplatData> readPly(std::span<const uint8_t> bytes, SplatRemarks* wanted) try {
    SplatRemarks unwanted;
    SplatRemarks& remarks = wanted ? *wanted : unwanted;
    DPL_TRY(const PlyHeader header, readPlyHeader(bytes));
    if (header.find("chunk")) return fail(Code::Unsupported, "a compressed PLY, not a plain one; read it with readSplats");
    DPL_TRY(const PlyRows vertices, plyRows(header, bytes, "vertex", ReadLimits().maxSplats));
    DPL_TRY(const Columns columns, columnsOf(vertices, remarks));
    noteShDegree(remarks);
    remarks.axes = axesOfComments(header.comments, remarks.notes);
    StaticSplatData s;
    s.compensated = antialiasedByComments(header.comments);
    s.shDegree = std::min(remarks.shDegree, kMaxShDegree);
    const uint32_t coefficients = shCoefficientCount(s.shDegree);
    const size_t n = vertices.count, perChannel = columns.rest.size() / 3, axes = columns.scale.size();
    s.position.resize(n), s.rotation.resize(n), s.scaleM.resize(n), s.opacity.resize(n), s.sh.resize(n * coefficients * 3);
    std::vector<uint32_t> broken;
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
        s.position[i] = {value(columns.place[0]), value(columns.place[1]), value(columns.place[2])};
        for (size_t k = 0; k < axes; ++k) s.scaleM[i][int(k)] = std::exp(activated(columns.scale[k]));
        const std::vector<size_t>& turn = columns.rotation;
        const Quatf q(value(turn[0]), value(turn[1]), value(turn[2]), value(turn[3]));  // wxyz in these files
        const float length = glm::length(q);
        s.rotation[i] = length > 1e-8f ? q / length : Quatf(1, 0, 0, 0);
        s.opacity[i] = sigmoid(activated(columns.opacity));
        if (columns.filter) fuseFilter(value(*columns.filter), axes, s.scaleM[i], s.opacity[i]);
        if (axes == 2) s.scaleM[i].z = kFlatShare * std::min(s.scaleM[i].x, s.scaleM[i].y);
        float* sh = s.sh.data() + i * coefficients * 3;
        for (int c = 0; c < 3; ++c) sh[c] = value(columns.dc[size_t(c)]);
        // The file holds all reds, then all greens, then all blues.
        for (uint32_t k = 1; k < coefficients; ++k)
            for (uint32_t c = 0; c < 3; ++c) sh[k * 3 + c] = value(columns.rest[c * perChannel + k - 1]);
        if (!ok || !std::isfinite(s.scaleM[i].x + s.scaleM[i].y + s.scaleM[i].z) || !std::isfinite(length)) broken.push_back(uint32_t(i));
    }
    DPL_RETURN_IF_ERROR(dropBroken(s, broken, remarks));
    return s;
} catch (const std::bad_alloc&) {
    return outOfMemory("read a PLY");
}

Result<std::vector<uint8_t>> writePly(const StaticSplatData& splats, const PlyWriteOptions& options) try {
    const size_t n = splats.position.size();
    const uint32_t coefficients = shCoefficientCount(splats.shDegree);
    if (splats.shDegree > kMaxShDegree || splats.rotation.size() != n || splats.scaleM.size() != n || splats.opacity.size() != n ||
        splats.sh.size() != n * coefficients * 3)
        return fail(Code::InvalidArgument, "the arrays of {} splats differ in length", n);
    StaticSplatData turned;
    if (!options.axes.empty()) {
        const auto axes = axesOfLetters(options.axes);
        if (!axes) return fail(Code::InvalidArgument, "axes '{}' of a PLY; letters such as RUB are known", options.axes);
        turned = splats;
        turnSplats(turned, glm::transpose(axes->uprightFromFile));
    }
    const StaticSplatData& s = options.axes.empty() ? splats : turned;
    const uint32_t restPerChannel = (options.padToDegree3 ? kMaxShCoefficients : coefficients) - 1;
    std::string header = "ply\nformat binary_little_endian 1.0\n";
    for (const std::string& comment : commentsOf(options.axes, s.compensated)) header += "comment " + comment + "\n";
    header += "element vertex " + std::to_string(n) + "\n";
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
} catch (const std::bad_alloc&) {
    return outOfMemory("write a PLY");
}

}  // namespace dpl
