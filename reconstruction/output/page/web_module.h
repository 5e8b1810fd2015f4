// SPDX-License-Identifier: Apache-2.0
// The built web module (platform/web), as far as a page needs it that holds a person in itself.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "sdk/core/result.h"

namespace dpl {

struct WebModule {
    std::vector<uint8_t> packed;  // doppel.wasm as .lzma
    std::string script;           // one ES module without imports, which unpacks and shows
    std::string style;
};

/** How to get a module where there is none, for the end of a sentence. */
inline constexpr const char* kHowToGetModule =
    "install the package doppel-tools, or build it in the source tree with tools/prove-web --build";

/** Reads the module from a folder that tools/prove-web --build made, or that doppel-tools installed. NotFound: a file is missing; the
 *  sentence names it and says how to get it. CorruptData: a file is empty, or is none of ours. */
Result<WebModule> readWebModule(const std::filesystem::path& folder);

}  // namespace dpl
