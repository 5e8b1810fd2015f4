// SPDX-License-Identifier: Apache-2.0
// Files that are installed with `doppel`, or lie in the source tree that it was built in.
#pragma once

#include <array>
#include <filesystem>

namespace dpl {

/** Where something is looked for: below the prefix that the program is installed in, then below the source tree that it was built in
 *  (build/PRESET/apps/doppel/doppel). */
std::array<std::filesystem::path, 2> besideTool(const std::filesystem::path& inPrefix, const std::filesystem::path& inTree);

/** The folder of the web module (platform/web): PREFIX/share/doppel/web, else build/web/platform/web of the source tree. Where neither is
 *  there, it is the first, for the error that names it. */
std::filesystem::path webFolder();

}  // namespace dpl
