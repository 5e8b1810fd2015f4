// SPDX-License-Identifier: Apache-2.0
// What a report says to somebody who filmed a person, and has no use for decibels.
#pragma once

#include <string>
#include <vector>

#include "reconstruction/judging/report/report.h"

namespace dpl {

/** How the avatar looks beside the pictures that it was not made from, in one sentence. */
std::string verdictSentence(const ReportData& data);

/** That the avatar is a draft, and what makes a finer one. Empty when it was trained as long as the preset standard trains. */
std::string draftSentence(const ReportData& data);

/** Parts that the avatar does not have and why, one sentence each. */
std::vector<std::string> leftOut(const std::vector<EvidenceData>& evidence);

}  // namespace dpl
