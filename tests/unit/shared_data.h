// Where the shared real data lies on this machine, for tests that read it; they GTEST_SKIP with the reason when it is absent.
#pragma once

#include <cstdlib>
#include <filesystem>
#include <optional>

namespace dpl {

/** The folder of scan-a, real-orbit-biker, models ...: $DOPPEL_SHARED_DATA, else <source>/../shared/data, else nothing. */
inline std::optional<std::filesystem::path> sharedData() {
    namespace fs = std::filesystem;
    std::error_code ignored;
    if (const char* stated = std::getenv("DOPPEL_SHARED_DATA"); stated && *stated) {
        if (fs::is_directory(stated, ignored)) return fs::path(stated);
        return std::nullopt;  // a stated folder that is not there is not silently replaced by another
    }
    for (fs::path at = fs::path(__FILE__).parent_path(); at.has_relative_path(); at = at.parent_path()) {
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
