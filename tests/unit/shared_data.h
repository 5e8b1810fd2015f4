// SPDX-License-Identifier: Apache-2.0
// Where the source tree and the shared real data lie, for tests that read them; tests GTEST_SKIP with the reason when the data is absent.
#pragma once

#include <cstdlib>
#include <filesystem>
#include <optional>

namespace dpl {

/** The source tree: $DOPPEL_SOURCE_DIR (ctest sets it), else the folder above the current one that holds this file (a build folder lies
 * inside the tree). Not by __FILE__: ccache shortens paths so that every checkout finds the same object. */
inline std::filesystem::path sourceFolder() {
    namespace fs = std::filesystem;
    if (const char* stated = std::getenv("DOPPEL_SOURCE_DIR"); stated && *stated) return stated;
    std::error_code ignored;
    fs::path at = fs::current_path(ignored);
    while (at.has_relative_path() && !fs::exists(at / "tests/unit/shared_data.h", ignored)) at = at.parent_path();
    return at;
}

/** The folder of scan-a, real-orbit-biker, models ...: $DOPPEL_SHARED_DATA, else <source>/../shared/data or the same above it, else
 * nothing. */
inline std::optional<std::filesystem::path> sharedData() {
    namespace fs = std::filesystem;
    std::error_code ignored;
    if (const char* stated = std::getenv("DOPPEL_SHARED_DATA"); stated && *stated) {
        if (fs::is_directory(stated, ignored)) return fs::path(stated);
        return std::nullopt;  // a stated folder that is not there is not silently replaced by another
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
