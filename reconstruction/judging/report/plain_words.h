// SPDX-License-Identifier: Apache-2.0
// What a report says to somebody who filmed a person, and has no use for decibels.
#pragma once

#include <string>
#include <vector>

#include "reconstruction/judging/report/report.h"

namespace dpl {

/** What a run is worth, in a word. */
enum class Worth : uint8_t { Good, Usable, FilmAgain };

/** By kWorthRule. */
Worth worthOf(const ReportData& data);
/** "Good", "Usable", "Film again". */
const char* wordOf(Worth worth);
/** The rule by which worthOf() decides, in sentences. */
extern const char* const kWorthRule;

/** How the avatar looks beside the pictures that it was not made from, in one sentence. */
std::string verdictSentence(const ReportData& data);

/** That the avatar is a draft, and what makes a finer one. Empty when it was trained as long as the preset standard trains. */
std::string draftSentence(const ReportData& data);

/** Parts that the avatar does not have and why, one sentence each. */
std::vector<std::string> leftOut(const std::vector<EvidenceData>& evidence);

}  // namespace dpl
