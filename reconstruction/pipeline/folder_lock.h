// SPDX-License-Identifier: Apache-2.0
// Keeps two runs out of one output folder.
#pragma once

#include <filesystem>

#include "sdk/core/result.h"

namespace dpl {

/** Holds `folder` for one run, until the object or its process ends, however the process ends. The file run.lock in the folder stays; it
 *  says which process held it last and since when. Move-only. */
class FolderLock {
public:
    /** The folder must exist. Errors: Io, when another run holds it with its start and process. */
    static Result<FolderLock> take(const std::filesystem::path& folder);

    FolderLock(FolderLock&& other) noexcept;
    FolderLock& operator=(FolderLock&&) = delete;
    ~FolderLock();

private:
    explicit FolderLock(int descriptor) : descriptor_(descriptor) {}
    int descriptor_ = -1;
};

}  // namespace dpl
