// What is in an avatar file, for people and for programs.
#pragma once

#include <filesystem>
#include <string>

#include "sdk/core/result.h"

namespace dpl {

/** A table of counts, bytes by part and the evidence rows. Errors name the file. */
Result<std::string> inspectAsText(const std::filesystem::path& avatar);
Result<std::string> inspectAsJson(const std::filesystem::path& avatar);

}  // namespace dpl
