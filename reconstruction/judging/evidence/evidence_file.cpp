// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/judging/evidence/evidence_file.h"

#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>

#include "sdk/core/files.h"
#include "sdk/format/motion_modes.h"
#include "sdk/math/sh.h"

namespace dpl {
namespace {

constexpr std::array<const char*, 5> kPartNames{"corrective-offsets", "corrective-light", "motion", "scene-light", "view-dependent-colour"};

}  // namespace

const char* nameOf(AvatarPart part) {
    return kPartNames[size_t(part)];
}

bool hasPart(const AvatarData& avatar, AvatarPart part) {
    if (part == AvatarPart::ViewDependentColour) return avatar.splats.shDegree > 0;
    if (part == AvatarPart::MotionModes) return !avatar.correctives.motion.empty();
    if (part == AvatarPart::SceneLight) return !avatar.light.empty();
    const auto& nodes = avatar.correctives.nodes;
    return std::any_of(nodes.begin(), nodes.end(),
                       [&](const Vec4f& n) { return part == AvatarPart::CorrectiveLight ? n.w != 0 : Vec3f(n) != Vec3f(0); });
}

void removePart(AvatarData& avatar, AvatarPart part) {
    if (part == AvatarPart::ViewDependentColour) {
        SplatData& s = avatar.splats;
        const size_t stride = 3 * shCoefficientCount(s.shDegree);
        std::vector<float> dc;
        for (size_t i = 0; i < s.count(); ++i) dc.insert(dc.end(), s.sh.begin() + long(i * stride), s.sh.begin() + long(i * stride + 3));
        s.sh = std::move(dc), s.shDegree = 0;
        return;
    }
    if (part == AvatarPart::MotionModes) return dropMotionModes(avatar.correctives);
    if (part == AvatarPart::SceneLight) {
        avatar.light = {};
        return;
    }
    for (Vec4f& node : avatar.correctives.nodes) {
        if (part == AvatarPart::CorrectiveLight)
            node.w = 0;
        else
            node = Vec4f(0, 0, 0, node.w);
    }
}

void dropEmptyCorrectives(AvatarData& avatar) {
    const auto& nodes = avatar.correctives.nodes;
    if (std::all_of(nodes.begin(), nodes.end(), [](const Vec4f& n) { return n == Vec4f(0); })) avatar.correctives = {};
}

Status writeEvidence(const std::vector<PartEvidence>& parts, const std::filesystem::path& path) {
    nlohmann::json list = nlohmann::json::array();
    for (const PartEvidence& p : parts)
        list.push_back({{"id", nameOf(p.part)},
                        {"part", p.row.part},
                        {"kept", p.row.kept},
                        {"gain_db", p.row.gainDb},
                        {"bytes", p.row.bytes},
                        {"reason", p.row.reason}});
    return writeFileAtomically(path, list.dump(1));
}

Result<std::vector<PartEvidence>> readEvidence(const std::filesystem::path& path) {
    DPL_TRY(auto bytes, readFile(path));
    const auto damaged = [&] { return fail(Code::CorruptData, "{} is damaged; delete it and run again", path.string()); };
    const nlohmann::json list = nlohmann::json::parse(bytes.begin(), bytes.end(), nullptr, false);
    if (!list.is_array()) return damaged();
    std::vector<PartEvidence> parts;
    try {
        for (const auto& entry : list) {
            const auto name = std::find(kPartNames.begin(), kPartNames.end(), entry.at("id").get<std::string>());
            if (name == kPartNames.end()) return damaged();
            parts.push_back({AvatarPart(name - kPartNames.begin()),
                             {entry.at("part"), entry.at("kept"), entry.at("gain_db"), entry.at("bytes"), entry.at("reason")}});
        }
    } catch (const nlohmann::json::exception&) {
        return damaged();
    }
    return parts;
}

}  // namespace dpl
