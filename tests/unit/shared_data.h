// SPDX-License-Identifier: Apache-2.0
// Finds the source tree and the shared real data for tests that read them. Without the data such tests skip and print why.
#pragma once

#include <cstdlib>
#include <filesystem>
#include <optional>

namespace dpl {

/** The source tree: $DOPPEL_SOURCE_DIR (ctest sets it), otherwise the nearest folder above the current one that contains this file (build
 *  folders lie inside the tree). __FILE__ does not tell, because ccache shortens paths so that all checkouts share objects. */
inline std::filesystem::path sourceFolder() {
    namespace fs = std::filesystem;
    if (const char* stated = std::getenv("DOPPEL_SOURCE_DIR"); stated && *stated) return stated;
    std::error_code ignored;
    fs::path at = fs::current_path(ignored);
    while (at.has_relative_path() && !fs::exists(at / "tests/unit/shared_data.h", ignored)) at = at.parent_path();
    return at;
}

/** The folder of scan-a, real-orbit-biker, models and others: $DOPPEL_SHARED_DATA, otherwise shared/data beside the source tree or beside
 *  one of the folders above it. Nothing if there is none. */
inline std::optional<std::filesystem::path> sharedData() {
    namespace fs = std::filesystem;
    std::error_code ignored;
    if (const char* stated = std::getenv("DOPPEL_SHARED_DATA"); stated && *stated) {
        if (fs::is_directory(stated, ignored)) return fs::path(stated);
        return std::nullopt;  // a folder that the variable names and that does not exist is never replaced by another
    }
    for (fs::path at = sourceFolder(); at.has_relative_path(); at = at.parent_path()) {
        const fs::path candidate = at.parent_path() / "shared" / "data";
        if (fs::is_directory(candidate / "scan-a", ignored)) return candidate;
    }
    return std::nullopt;
}

/** One data set inside sharedData(), or nothing. */
inline std::optional<std::filesystem::path> sharedData(const std::filesystem::path& inside) {
    std::error_code ignored;
    auto root = sharedData();
    if (!root || !std::filesystem::exists(*root / inside, ignored)) return std::nullopt;
    return *root / inside;
}

}  // namespace dpl
