// SPDX-License-Identifier: Apache-2.0
// What a folder holds for the viewer. A slow disk makes it wait: it belongs on the loader's thread.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "sdk/core/result.h"

namespace dpl {

struct FolderEntry {
    enum class Kind : uint8_t { Folder, Run, Scan, File };
    std::string name;
    Kind kind = Kind::File;
    bool operator==(const FolderEntry&) const = default;
};

struct FolderList {
    static constexpr size_t kMostEntries = 2000;
    std::filesystem::path folder;      // absolute
    std::vector<FolderEntry> entries;  // folders first, each by name; neither hidden ones nor files of other kinds
    bool cut = false;                  // there are more
};

/** Whether the viewer opens files that are called so. */
bool isOpenable(const std::string& name);

/** Errors name the folder. */
Result<FolderList> listFolder(const std::filesystem::path& folder);

}  // namespace dpl
