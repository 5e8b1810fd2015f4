// SPDX-License-Identifier: Apache-2.0
#include "apps/doppel/beside_tool.h"

namespace dpl {

namespace fs = std::filesystem;

std::array<fs::path, 2> besideTool(const fs::path& inPrefix, const fs::path& inTree) {
    std::error_code ignored;
    const fs::path folder = fs::read_symlink("/proc/self/exe", ignored).parent_path();
    return {folder.parent_path() / inPrefix, folder.parent_path().parent_path().parent_path().parent_path() / inTree};
}

fs::path webFolder() {
    const auto candidates = besideTool(DOPPEL_WEB_FOLDER, "build/web/platform/web");
    std::error_code ignored;
    for (const fs::path& candidate : candidates)
        if (fs::is_directory(candidate, ignored)) return candidate;
    return candidates[0];
}

}  // namespace dpl
