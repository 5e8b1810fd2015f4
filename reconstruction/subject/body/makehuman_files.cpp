// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/subject/body/makehuman_files.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <set>
#include <string_view>

#include "reconstruction/base/inflate.h"
#include "reconstruction/subject/body/body_tools.h"
#include "sdk/core/files.h"
#include "sdk/core/numbers.h"

namespace dpl {
namespace {

constexpr size_t kMaxSourceBytes = 64u << 20;
constexpr size_t kMaxVertices = 1u << 20;

/** Splits a text into lines and words without copying it. */
class Lines {
public:
    explicit Lines(std::string_view text) : rest_(text) {}
    bool next(std::string_view& line) {
        if (rest_.empty()) return false;
        const size_t end = rest_.find('\n');
        line = rest_.substr(0, end);
        rest_ = end == std::string_view::npos ? std::string_view{} : rest_.substr(end + 1);
        ++number;
        return true;
    }
    size_t number = 0;

private:
    std::string_view rest_;
};

std::string_view nextWord(std::string_view& line) {
    const size_t begin = line.find_first_not_of(" \t\r");
    if (begin == std::string_view::npos) return line = {}, std::string_view{};
    const size_t end = std::min(line.find_first_of(" \t\r", begin), line.size());
    const std::string_view word = line.substr(begin, end - begin);
    line = line.substr(end);
    return word;
}

template <class T>
bool parse(std::string_view word, T& value) {
    if (!word.empty() && word.front() == '+') word.remove_prefix(1);
    return readNumber(word, value);
}

bool parseVec3(std::string_view line, Vec3f& v) {
    for (int i = 0; i < 3; ++i)
        if (!parse(nextWord(line), v[i])) return false;
    return true;
}

std::string_view asText(const std::vector<uint8_t>& bytes) {
    return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

Result<nlohmann::json> readJson(const std::filesystem::path& path) {
    DPL_TRY(const auto bytes, readFile(path, kMaxSourceBytes));
    nlohmann::json json = nlohmann::json::parse(bytes.begin(), bytes.end(), nullptr, /*allow_exceptions=*/false);
    if (json.is_discarded() || !json.is_object()) return fail(Code::CorruptData, "{}: not a JSON object", path.string());
    return json;
}

Result<std::vector<uint32_t>> headVertices(const nlohmann::json& head, const MakeHumanMesh& mesh, const std::string& where) {
    std::vector<uint32_t> vertices;
    const std::string strategy = head.value("strategy", "");
    if (strategy == "CUBE") {
        const auto group = mesh.groups.find(head.value("cube_name", ""));
        if (group == mesh.groups.end())
            return fail(Code::CorruptData, "{}: joint cube '{}' is not in base.obj", where, head.value("cube_name", ""));
        return group->second;
    }
    const auto list = head.find("vertex_indices");
    if (strategy == "MEAN" && list != head.end() && list->is_array()) {
        for (const auto& i : *list)
            if (i.is_number_unsigned()) vertices.push_back(i.get<uint32_t>());
    } else if (strategy == "VERTEX" && head.contains("vertex_index") && head["vertex_index"].is_number_unsigned()) {
        vertices.push_back(head["vertex_index"].get<uint32_t>());
    }
    if (vertices.empty()) return fail(Code::Unsupported, "{}: placement '{}' is not one of CUBE, MEAN, VERTEX", where, strategy);
    for (uint32_t v : vertices)
        if (v >= mesh.positionsDm.size()) return fail(Code::CorruptData, "{}: vertex {} of {}", where, v, mesh.positionsDm.size());
    return vertices;
}

}  // namespace

Result<MakeHumanMesh> readMakeHumanObj(const std::filesystem::path& path) {
    DPL_TRY(const auto bytes, readFile(path, kMaxSourceBytes));
    MakeHumanMesh mesh;
    std::string group = "body";
    std::map<std::string, std::set<uint32_t>> groups;
    Lines lines(asText(bytes));
    for (std::string_view line; lines.next(line);) {
        const std::string_view kind = nextWord(line);
        if (kind == "v") {
            Vec3f p;
            if (!parseVec3(line, p)) return fail(Code::CorruptData, "{} line {}: not three numbers", path.string(), lines.number);
            if (mesh.positionsDm.size() == kMaxVertices)
                return fail(Code::Unsupported, "{}: more than {} vertices", path.string(), kMaxVertices);
            mesh.positionsDm.push_back(p);
        } else if (kind == "g") {
            group = std::string(nextWord(line));
        } else if (kind == "f") {
            std::vector<uint32_t> face;
            for (std::string_view word = nextWord(line); !word.empty(); word = nextWord(line)) {
                uint32_t index = 0;  // "vertex/uv"
                if (!parse(word.substr(0, word.find('/')), index) || index == 0 || index > mesh.positionsDm.size())
                    return fail(Code::CorruptData, "{} line {}: face corner '{}'", path.string(), lines.number, std::string(word));
                face.push_back(index - 1);
            }
            if (face.size() < 3 || face.size() > 4)
                return fail(Code::Unsupported, "{} line {}: a face has {} corners; only triangles and quads are read", path.string(),
                            lines.number, face.size());
            groups[group].insert(face.begin(), face.end());
            mesh.faces[group].push_back(std::move(face));
        }
    }
    for (auto& [name, set] : groups) mesh.groups[name].assign(set.begin(), set.end());
    if (!mesh.faces.contains("body"))
        return fail(Code::CorruptData, "{}: no faces in group 'body'; is this MakeHuman's base.obj?", path.string());
    return mesh;
}

Result<std::vector<TargetRow>> readMakeHumanTarget(const std::filesystem::path& path, size_t vertexCount) {
    DPL_TRY(auto bytes, readFile(path, kMaxSourceBytes));
    if (path.extension() == ".gz") {
        auto plain = inflateBytes(bytes, DeflateWrapper::Gzip, kMaxSourceBytes);
        if (!plain) return fail(plain.error().code, "{}: {}", path.string(), plain.error().message);
        bytes = std::move(*plain);
    }
    std::vector<TargetRow> rows;
    Lines lines(asText(bytes));
    for (std::string_view line; lines.next(line);) {
        const std::string_view first = nextWord(line);
        if (first.empty() || first.front() == '#') continue;
        TargetRow row;
        if (!parse(first, row.vertex) || row.vertex >= vertexCount || !parseVec3(line, row.offsetDm))
            return fail(Code::CorruptData, "{} line {}: not 'vertex dx dy dz' of a mesh of {} vertices", path.string(), lines.number,
                        vertexCount);
        if (rows.size() == vertexCount) return fail(Code::CorruptData, "{}: more rows than the mesh has vertices", path.string());
        rows.push_back(row);
    }
    return rows;
}

Result<MakeHumanRig> readMakeHumanRig(const std::filesystem::path& rigPath, const std::filesystem::path& weightsPath,
                                      const MakeHumanMesh& mesh) {
    DPL_TRY(const auto rigJson, readJson(rigPath));
    DPL_TRY(const auto weightsJson, readJson(weightsPath));
    const nlohmann::json& bonesJson = rigJson.contains("bones") ? rigJson["bones"] : rigJson;
    if (!bonesJson.is_object()) return fail(Code::CorruptData, "{}: no bones", rigPath.string());

    std::map<std::string, MakeHumanBone> byName;
    for (const auto& [name, json] : bonesJson.items()) {
        if (!json.is_object() || !json.contains("head") || !json["head"].is_object())
            return fail(Code::CorruptData, "{}: bone '{}' has no head", rigPath.string(), name);
        MakeHumanBone bone{name, json.contains("parent") && json["parent"].is_string() ? json["parent"].get<std::string>() : "", {}};
        DPL_TRY(bone.headVertices, headVertices(json["head"], mesh, rigPath.string() + " bone '" + name + "'"));
        byName[name] = std::move(bone);
    }
    MakeHumanRig rig;
    std::set<std::string> placed;
    while (rig.bones.size() < byName.size()) {  // parents first, alphabetic within a level: the same order on every machine
        const size_t before = rig.bones.size();
        std::vector<std::string> generation;
        for (const auto& [name, bone] : byName)
            if (!placed.count(name) && (bone.parent.empty() || placed.count(bone.parent))) generation.push_back(name);
        for (const auto& name : generation) placed.insert(name), rig.bones.push_back(byName[name]);
        if (rig.bones.size() == before)
            return fail(Code::CorruptData, "{}: the bones form a cycle or name a parent that is not there", rigPath.string());
    }

    const auto weights = weightsJson.find("weights");
    if (weights == weightsJson.end() || !weights->is_object()) return fail(Code::CorruptData, "{}: no skin weights", weightsPath.string());
    for (const auto& [bone, list] : weights->items()) {
        if (!byName.count(bone) || !list.is_array()) continue;
        auto& out = rig.weights[bone];
        for (const auto& pair : list) {
            if (!pair.is_array() || pair.size() != 2 || !pair[0].is_number_unsigned() || !pair[1].is_number())
                return fail(Code::CorruptData, "{}: weights of '{}' are not [vertex, weight] pairs", weightsPath.string(), bone);
            const uint64_t vertex = pair[0].get<uint64_t>();
            const float weight = pair[1].get<float>();
            if (vertex >= mesh.positionsDm.size() || !std::isfinite(weight))
                return fail(Code::CorruptData, "{}: weight of vertex {} of bone '{}'", weightsPath.string(), vertex, bone);
            out.emplace_back(uint32_t(vertex), weight);
        }
    }
    return rig;
}

Result<MakeHumanFaceRig> readMakeHumanFaceRig(const std::filesystem::path& folder, const MakeHumanMesh& mesh) {
    const std::filesystem::path rigPath = folder / "default.mhskel", weightsPath = folder / "default_weights.mhw";
    DPL_TRY(const auto rigJson, readJson(rigPath));
    DPL_TRY(const auto weightsJson, readJson(weightsPath));
    MakeHumanFaceRig rig;
    for (const auto& [joint, vertices] :
         {std::pair{"eye.L____head", &rig.leftEye}, {"eye.R____head", &rig.rightEye}, {"jaw____head", &rig.jaw}}) {
        const nlohmann::json::json_pointer place(std::string("/joints/") + joint);
        if (!rigJson.contains(place) || !rigJson.at(place).is_array() || rigJson.at(place).empty())
            return fail(Code::CorruptData, "{}: joint '{}' has no vertices", rigPath.string(), joint);
        for (const auto& i : rigJson.at(place)) {
            if (!i.is_number_unsigned() || i.get<uint64_t>() >= mesh.positionsDm.size())
                return fail(Code::CorruptData, "{}: joint '{}' lies at a vertex that base.obj lacks", rigPath.string(), joint);
            vertices->push_back(i.get<uint32_t>());
        }
    }
    const auto bones = rigJson.find("bones"), weights = weightsJson.find("weights");
    if (bones == rigJson.end() || !bones->is_object()) return fail(Code::CorruptData, "{}: no bones", rigPath.string());
    if (weights == weightsJson.end() || !weights->is_object()) return fail(Code::CorruptData, "{}: no skin weights", weightsPath.string());
    const auto hangsOnJaw = [&](std::string bone) {
        for (size_t up = 0; up <= bones->size(); ++up) {  // a cycle ends too
            if (bone == "jaw") return true;
            const auto at = bones->find(bone);
            if (at == bones->end() || !at->is_object() || !at->contains("parent") || !at->at("parent").is_string()) return false;
            bone = at->at("parent").get<std::string>();
        }
        return false;
    };
    std::map<uint32_t, std::pair<float, float>> jawAndAll;
    for (const auto& [bone, list] : weights->items()) {
        const bool jaw = hangsOnJaw(bone);
        for (const auto& pair : list) {
            if (!pair.is_array() || pair.size() != 2 || !pair[0].is_number_unsigned() || !pair[1].is_number() ||
                pair[0].get<uint64_t>() >= mesh.positionsDm.size() || !(pair[1].get<float>() >= 0 && pair[1].get<float>() <= 1))
                return fail(Code::CorruptData, "{}: weights of '{}' are not [vertex, weight] pairs of base.obj", weightsPath.string(),
                            bone);
            auto& [onJaw, all] = jawAndAll[pair[0].get<uint32_t>()];
            all += pair[1].get<float>();
            if (jaw) onJaw += pair[1].get<float>();
        }
    }
    for (const auto& [vertex, sums] : jawAndAll)
        if (sums.first > 0) rig.withJaw[vertex] = sums.first / sums.second;
    return rig;
}

}  // namespace dpl
