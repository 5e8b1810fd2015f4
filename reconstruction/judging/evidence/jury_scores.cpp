// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/judging/evidence/jury_scores.h"

#include "reconstruction/base/json_fields.h"
#include "sdk/core/files.h"

namespace dpl {
namespace {

/** Finite numbers only: JSON has no other. */
Result<JuryScore> scoreOf(const nlohmann::json& object, const std::string& where) {
    const JsonFields fields(object, where);
    JuryScore score;
    DPL_TRY(score.maskedPsnrDb, fields.number("masked_psnr_db"));
    DPL_TRY(score.detail, fields.number("detail"));
    DPL_TRY(score.faults.flickerLevels, fields.number("flicker_levels"));
    DPL_TRY(score.faults.penetration, fields.number("penetration"));
    return score;
}

}  // namespace

JuryScores::JuryScores(std::filesystem::path file) : file_(std::move(file)) {
    std::error_code ignored;
    if (!std::filesystem::exists(file_, ignored)) return;
    const auto object = readJsonObject(file_);
    if (!object) return;
    for (const auto& [name, entry] : object->items()) {
        const auto score = scoreOf(entry, name);
        if (score) scores_[name] = *score;
    }
}

std::optional<JuryScore> JuryScores::find(const std::string& name) const {
    const auto found = scores_.find(name);
    return found == scores_.end() ? std::nullopt : std::optional(found->second);
}

Status JuryScores::add(const std::string& name, const JuryScore& score) {
    scores_[name] = score;
    nlohmann::json object = nlohmann::json::object();
    for (const auto& [key, s] : scores_)
        object[key] = {{"masked_psnr_db", s.maskedPsnrDb},
                       {"detail", s.detail},
                       {"flicker_levels", s.faults.flickerLevels},
                       {"penetration", s.faults.penetration}};
    return writeFileAtomically(file_, object.dump(1));
}

}  // namespace dpl
