// SPDX-License-Identifier: Apache-2.0
// What a stage does, in the words of who filmed. Folders, verdict.json and --verbose keep the technical names.
#pragma once

#include <string_view>

namespace dpl {

/** "painting" for "co-optimise"; a name that is not known is its own words. */
std::string_view wordsOfStage(std::string_view name);

}  // namespace dpl
