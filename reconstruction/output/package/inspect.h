// SPDX-License-Identifier: Apache-2.0
// Describes the contents of an avatar file or of a file of general splats, as text or as JSON.
#pragma once

#include <filesystem>
#include <string>

#include "sdk/core/result.h"

namespace dpl {

struct Inspection {
    std::string text;
    bool intact = true;  // false: an avatar file's content hash does not match its bytes (damaged or edited)
};

/** Of avatars: counts, bytes per part and the evidence table. Of general splats: format, count, extent and sizes. Errors name the file. */
Result<Inspection> inspectAsText(const std::filesystem::path& file);
/** The same content as a JSON object. */
Result<Inspection> inspectAsJson(const std::filesystem::path& file);

}  // namespace dpl
