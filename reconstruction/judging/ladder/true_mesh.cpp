// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/judging/ladder/true_mesh.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <map>
#include <nlohmann/json.hpp>

#include "sdk/core/files.h"
#include "sdk/core/reader.h"
#include "sdk/format/ply_header.h"

namespace dpl {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr size_t kMaxTruthFileBytes = 256u << 20;
constexpr uint32_t kMaxInfluences = 16;
constexpr size_t kFaceBytes = 1 + 3 * sizeof(int32_t) + 1;  // count, three indices, hidden

/** A point or rotation vector of the z-up file in the y-up world. */
template <class V>
V upright(const V& p) {
    return {p.x, p.z, -p.y};
}

Result<Vec3d> triple(const json& list, const std::string& where) {
    if (!list.is_array() || list.size() != 3) return fail(Code::CorruptData, "{}: three numbers expected", where);
    Vec3d out;
    for (int c = 0; c < 3; ++c) {
        if (!list[size_t(c)].is_number() || !std::isfinite(list[size_t(c)].get<double>()))
            return fail(Code::CorruptData, "{}: three finite numbers expected", where);
        out[c] = list[size_t(c)].get<double>();
    }
    return upright(out);
}

Result<json> readJson(const fs::path& path) {
    DPL_TRY(const auto bytes, readFile(path, kMaxTruthFileBytes));
    json out = json::parse(bytes.begin(), bytes.end(), nullptr, false);
    if (!out.is_object()) return fail(Code::CorruptData, "{}: not a JSON object; copy it again", path.string());
    return out;
}

Status readTemplate(const fs::path& path, TrueMesh& mesh) {
    DPL_TRY(const auto bytes, readFile(path, kMaxTruthFileBytes));
    DPL_TRY(const PlyHeader header, readPlyHeader(bytes));
    DPL_TRY(const PlyRows rows, plyRows(header, bytes, "vertex", 10'000'000));
    DPL_TRY(const auto columns, plyColumns(rows, PlyType::F32, {"x", "y", "z"}));
    for (size_t v = 0; v < rows.count; ++v) {
        Vec3f p;
        for (int c = 0; c < 3; ++c) std::memcpy(&p[c], rows.row(v) + columns[size_t(c)], sizeof(float));
        if (!std::isfinite(p.x) || !std::isfinite(p.y) || !std::isfinite(p.z))
            return fail(Code::CorruptData, "{}: vertex {} is not finite", path.string(), v);
        mesh.restPositions.push_back(upright(p));
    }
    const PlyElement* faces = header.find("face");
    const size_t facesAt = size_t(rows.row(rows.count) - bytes.data());
    if (!faces || faces->count > (bytes.size() - facesAt) / kFaceBytes)
        return fail(Code::CorruptData, "{}: its faces are missing or cut off; copy it again", path.string());
    Reader in{std::span<const uint8_t>(bytes).subspan(facesAt)};
    for (uint64_t t = 0; t < faces->count; ++t) {
        DPL_TRY(const uint8_t corners, in.value<uint8_t>());
        Triangle triangle;
        for (int c = 0; c < 3; ++c) {
            DPL_TRY(const int32_t index, in.value<int32_t>());
            if (corners != 3 || index < 0 || size_t(index) >= rows.count)
                return fail(Code::CorruptData, "{}: face {} is not a triangle of its vertices", path.string(), t);
            triangle[c] = uint32_t(index);
        }
        DPL_TRY(const uint8_t hidden, in.value<uint8_t>());
        mesh.triangles.push_back(triangle), mesh.hidden.push_back(hidden);
    }
    return {};
}

Status readWeights(const fs::path& path, TrueMesh& mesh) {
    DPL_TRY(const auto bytes, readFile(path, kMaxTruthFileBytes));
    if (bytes.size() < 12) return fail(Code::CorruptData, "{}: {} bytes are too few; copy it again", path.string(), bytes.size());
    Reader in(bytes);
    DPL_TRY(const uint32_t vertices, in.u32());
    DPL_TRY(const uint32_t joints, in.u32());
    DPL_TRY(mesh.influences, in.u32());
    const size_t values = mesh.restPositions.size() * size_t(mesh.influences);
    if (vertices != mesh.restPositions.size() || joints != mesh.joints.size() || mesh.influences == 0 || mesh.influences > kMaxInfluences ||
        in.remaining() != values * 8)
        return fail(Code::CorruptData, "{}: {} vertices, {} joints, {} influences and {} bytes do not fit the template", path.string(),
                    vertices, joints, mesh.influences, bytes.size());
    mesh.weightJoints.resize(values), mesh.weights.resize(values);
    for (int32_t& joint : mesh.weightJoints) {
        DPL_TRY(joint, in.value<int32_t>());
        if (joint < 0 || size_t(joint) >= mesh.joints.size()) return fail(Code::CorruptData, "{}: no joint {}", path.string(), joint);
    }
    for (float& weight : mesh.weights) {
        DPL_TRY(weight, in.f32());
        if (!(weight >= 0 && weight <= 1.001f)) return fail(Code::CorruptData, "{}: a weight is not from 0 to 1", path.string());
    }
    return {};
}

Status readSkeleton(const fs::path& path, const json& manifest, TrueMesh& mesh) {
    const json skeleton = manifest.value("skeleton", json::object());
    const json parents = skeleton.value("parents", json::array()), places = skeleton.value("rest_positions", json::array());
    if (places.empty() || !parents.is_array() || parents.size() != places.size())
        return fail(Code::CorruptData, "{}: its skeleton needs as many parents as rest_positions", path.string());
    for (size_t j = 0; j < places.size(); ++j) {
        DPL_TRY(const Vec3d place, triple(places[j], formatText("{}: rest position {}", path.string(), j)));
        if (!parents[j].is_number_integer() || parents[j].get<int64_t>() >= int64_t(j) || parents[j].get<int64_t>() < -1)
            return fail(Code::CorruptData, "{}: the parent of joint {} must come before it", path.string(), j);
        mesh.joints.push_back(place), mesh.parents.push_back(parents[j].get<int32_t>());
    }
    return {};
}

Status readParts(const fs::path& path, const json& geometry, TrueMesh& mesh) {
    mesh.clothTriangle.assign(mesh.triangles.size(), 0);
    for (const json& entry : geometry.value("parts", json::array())) {
        if (!entry.is_object()) continue;
        const uint64_t first = entry.value("first_triangle", uint64_t(0)), count = entry.value("triangle_count", uint64_t(0));
        if (first > mesh.triangles.size() || count > mesh.triangles.size() - first)
            return fail(Code::CorruptData, "{}: a part has triangles that the template lacks", path.string());
        const TruePart part{entry.value("label", std::string()), uint32_t(first), uint32_t(count), entry.value("cloth", false)};
        if (part.cloth) std::fill_n(mesh.clothTriangle.begin() + std::ptrdiff_t(first), count, uint8_t(1));
        mesh.parts.push_back(part);
    }
    return {};
}

Status readFrames(const fs::path& path, const Scan& scan, TrueMesh& mesh) {
    DPL_TRY(const json truth, readJson(path));
    std::map<std::string, const json*> byName;
    if (truth.contains("frames") && truth["frames"].is_array())
        for (const json& frame : truth["frames"])
            if (frame.is_object() && frame.contains("name") && frame["name"].is_string()) byName[frame["name"].get<std::string>()] = &frame;
    mesh.frames.resize(scan.frames.size());
    for (size_t f = 0; f < scan.frames.size(); ++f) {
        const auto found = byName.find(scan.frames[f].name);
        if (found == byName.end()) continue;
        const json& entry = *found->second;
        TrueFrame& frame = mesh.frames[f];
        const std::string where = path.string() + ": frame '" + scan.frames[f].name + "'";
        if (!entry.contains("rotations") || !entry["rotations"].is_array() || entry["rotations"].size() != mesh.joints.size())
            return fail(Code::CorruptData, "{} needs one rotation a joint", where);
        for (const json& rotation : entry["rotations"]) {
            DPL_TRY(const Vec3d w, triple(rotation, where));
            const double angle = glm::length(w);
            frame.rotations.push_back(angle > 1e-12 ? glm::angleAxis(angle, w / angle) : Quatd(1, 0, 0, 0));
        }
        DPL_TRY(frame.translation, triple(entry.value("translation", json()), where));
        if (entry.contains("posed") && entry["posed"].is_string()) {
            const fs::path file = fs::path(entry["posed"].get<std::string>());
            if (file != fs::path("posed") / (scan.frames[f].name + ".bin"))
                return fail(Code::CorruptData, "{}: its posed file must be posed/{}.bin", where, scan.frames[f].name);
            frame.posed = scan.root / file;
        }
        frame.known = true;
    }
    return {};
}

}  // namespace

Result<std::optional<TrueMesh>> readTrueMesh(const Scan& scan) {
    const fs::path truth = scan.root / "truth.json", folder = scan.root / "geometry", manifestPath = scan.root / "scan.json";
    std::error_code error;
    for (const fs::path& file : {truth, folder / "template.ply", folder / "weights.bin", manifestPath})
        if (!fs::is_regular_file(file, error)) return std::optional<TrueMesh>();
    DPL_TRY(const json manifest, readJson(manifestPath));
    TrueMesh mesh;
    DPL_RETURN_IF_ERROR(readSkeleton(manifestPath, manifest, mesh));
    DPL_RETURN_IF_ERROR(readTemplate(folder / "template.ply", mesh));
    DPL_RETURN_IF_ERROR(readWeights(folder / "weights.bin", mesh));
    DPL_RETURN_IF_ERROR(readParts(manifestPath, manifest.value("geometry", json::object()), mesh));
    DPL_RETURN_IF_ERROR(readFrames(truth, scan, mesh));
    return std::optional<TrueMesh>(std::move(mesh));
}

std::vector<Vec3f> skinnedTruth(const TrueMesh& mesh, const TrueFrame& frame) {
    std::vector<Mat3d> turned(mesh.joints.size());
    std::vector<Vec3d> moved(mesh.joints.size());
    for (size_t j = 0; j < mesh.joints.size(); ++j) {
        const Mat3d own = glm::mat3_cast(frame.rotations[j]);
        const Vec3d place = mesh.joints[j] - own * mesh.joints[j];
        const int32_t parent = mesh.parents[j];
        turned[j] = parent < 0 ? own : turned[size_t(parent)] * own;
        moved[j] = parent < 0 ? place + frame.translation : turned[size_t(parent)] * place + moved[size_t(parent)];
    }
    std::vector<Vec3f> positions(mesh.restPositions.size());
    for (size_t v = 0; v < positions.size(); ++v) {
        const Vec3d rest(mesh.restPositions[v]);
        Vec3d sum(0);
        for (size_t k = v * mesh.influences; k < (v + 1) * mesh.influences; ++k)
            if (mesh.weights[k] > 0) {
                const size_t j = size_t(mesh.weightJoints[k]);
                sum += double(mesh.weights[k]) * (turned[j] * rest + moved[j]);
            }
        positions[v] = Vec3f(sum);
    }
    return positions;
}

Result<std::optional<std::vector<Vec3f>>> trueSurface(const TrueMesh& mesh, const TrueFrame& frame, FrameKind kind) {
    using Positions = std::optional<std::vector<Vec3f>>;
    if (!frame.known) return Positions();
    if (kind != FrameKind::Dynamic) return Positions(skinnedTruth(mesh, frame));
    if (frame.posed.empty()) return Positions();
    DPL_TRY(const auto bytes, readFile(frame.posed, kMaxTruthFileBytes));
    if (bytes.size() != mesh.restPositions.size() * 12)
        return fail(Code::CorruptData, "{}: {} bytes, {} vertices need {}; copy it again", frame.posed.string(), bytes.size(),
                    mesh.restPositions.size(), mesh.restPositions.size() * 12);
    std::vector<Vec3f> positions(mesh.restPositions.size());
    std::memcpy(positions.data(), bytes.data(), bytes.size());
    for (Vec3f& p : positions) {
        if (!std::isfinite(p.x) || !std::isfinite(p.y) || !std::isfinite(p.z))
            return fail(Code::CorruptData, "{}: a vertex is not finite", frame.posed.string());
        p = upright(p);
    }
    return Positions(std::move(positions));
}

Status checkTruth(const Scan& scan) {
    DPL_TRY(const auto mesh, readTrueMesh(scan));
    if (!mesh) return {};
    for (size_t f = 0; f < scan.frames.size(); ++f)
        if (scan.frames[f].kind == FrameKind::Dynamic) DPL_RETURN_IF_ERROR(trueSurface(*mesh, mesh->frames[f], FrameKind::Dynamic));
    return {};
}

}  // namespace dpl
