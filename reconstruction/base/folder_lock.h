// SPDX-License-Identifier: Apache-2.0
// Keeps two runs out of one output folder.
#pragma once

#include <filesystem>

#include "sdk/core/result.h"

namespace dpl {

/** Holds `folder` for one run, until the object or its process ends, however the process ends. The file kName in the folder stays; it
 *  says which process held it last and since when. Move-only. */
class FolderLock {
public:
    static constexpr const char* kName = "run.lock";

    /** The folder must exist. Errors: Io, when another run holds it with its start and process. `output` is the folder that errors name,
     *  where it is another one; empty: `folder`. */
    static Result<FolderLock> take(const std::filesystem::path& folder, const std::filesystem::path& output = {});

    FolderLock(FolderLock&& other) noexcept;
    FolderLock& operator=(FolderLock&&) = delete;
    ~FolderLock();

private:
    explicit FolderLock(int descriptor) : descriptor_(descriptor) {}
    int descriptor_ = -1;
};

}  // namespace dpl
