// SPDX-License-Identifier: Apache-2.0
// OUT/verdict.json: what to film again, for programs. A run writes it after the stage body-map, or when the scan is refused before.
//
//   scan         hash of its pictures, as in poses.json; null where it could not be read
//   avatar       content hash of the avatar that was made of it; null until then
//   refused      null, or {stage, reason}: the stage that refuses and its sentences for people
//   film_again   of a good scan: [{shot, sentence, gain}]; of a refused one: [{topic, sentence, frames}], and `part` where one is known
//   places       figures of each place of the body; empty where the scan is refused
//   scan_check   findings and figures of the scan check; null where the run did not come to it
#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>

#include "sdk/core/result.h"

namespace dpl {

struct Refusal {
    std::string stage;
    nlohmann::ordered_json filmAgain = nlohmann::ordered_json::array();
    nlohmann::ordered_json scanCheck;
};

/** Writes the verdict of a refused scan into `out`, and returns `reason` for the caller to return in turn, with Unsupported for
 * InvalidArgument: no argument is wrong. An error that says nothing about the scan (cancelled, disk full, out of memory) leaves the file as
 * it is. */
Error refuse(const std::filesystem::path& out, const Refusal& refusal, Error reason);

/** The verdict of a scan that can be used. */
struct Verdict {
    std::string scanHash;
    std::string avatarHash;          // empty: none yet
    nlohmann::ordered_json figures;  // film_again and places of the stage body-map
    std::string scanCheck;           // the result of the scan check as a JSON object
};

Status writeVerdict(const std::filesystem::path& out, const Verdict& verdict);

}  // namespace dpl
