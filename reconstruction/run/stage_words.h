// SPDX-License-Identifier: Apache-2.0
// What a stage does, in the words of who filmed. Folders, verdict.json and --verbose keep the technical names.
#pragma once

#include <cstddef>
#include <string_view>

namespace dpl {

/** "painting" for "co-optimise"; a name that is not known is its own words. */
std::string_view wordsOfStage(std::string_view name);

/** Which of the kStagesOfAll stages that every run has it is, from 1; 0: it is one of those before them, which only some runs need. */
size_t placeOfStage(std::string_view name);
inline constexpr size_t kStagesOfAll = 11;
/** The stage at a place, 1 to kStagesOfAll. */
std::string_view stageAt(size_t place);

}  // namespace dpl
