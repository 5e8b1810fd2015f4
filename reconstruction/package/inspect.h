// SPDX-License-Identifier: Apache-2.0
// What is in an avatar file, or in a file of general splats, for people and for programs.
#pragma once

#include <filesystem>
#include <string>

#include "sdk/core/result.h"

namespace dpl {

struct Inspection {
    std::string text;
    bool intact = true;  // false: the content hash in an avatar file does not match its bytes; the file was damaged or edited
};

/** A table of counts, bytes by part and the evidence rows; of general splats their format, count, extent and sizes. Errors name the file.
 */
Result<Inspection> inspectAsText(const std::filesystem::path& file);
Result<Inspection> inspectAsJson(const std::filesystem::path& file);

}  // namespace dpl
