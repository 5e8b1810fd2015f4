// SPDX-License-Identifier: Apache-2.0
// What the page shows to who filmed: the person, a word, what to film again, and the avatar in motion. Private to
// reconstruction/judging/report.
#pragma once

#include <string>
#include <vector>

#include "reconstruction/judging/report/report.h"

namespace dpl {

/** The person, the word and its sentence, and links to the avatar. The picture comes first, so that no text can push it off. */
void addTop(std::string& html, const ReportData& data);

/** Stands early, because it is what the reader can change. Nothing where there is neither advice nor a warning. */
void addAdvice(std::string& html, const FilmAgainSection& section);

/** Clips that play in a loop, and stand still where the reader's system asks for less motion. Needs no script. */
void addClips(std::string& html, const std::vector<ReportClip>& clips);

}  // namespace dpl
