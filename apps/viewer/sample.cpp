// SPDX-License-Identifier: Apache-2.0
#include "apps/viewer/sample.h"

#include "reconstruction/base/program.h"

namespace dpl {

namespace fs = std::filesystem;

Result<fs::path> doppelProgram() {
    std::error_code ignored;
    const fs::path folder = fs::read_symlink("/proc/self/exe", ignored).parent_path();
    for (const fs::path& path : {folder / "doppel", folder.parent_path() / "doppel" / "doppel"})
        if (fs::is_regular_file(path, ignored)) return path;
    if (auto found = findProgram("doppel")) return *found;
    return fail(Code::NotFound, "the program doppel is not here; install the package doppel-tools");
}

Result<fs::path> sampleAvatar(const fs::path& program, const fs::path& folder, const std::atomic<bool>& cancel) {
    const fs::path file = folder / "sample-" DOPPEL_VERSION ".glb";
    std::error_code ignored;
    if (fs::is_regular_file(file, ignored)) return file;
    ProgramRun run;
    run.arguments = {program.string(), "sample-avatar", "-o", file.string()};
    run.cancel = &cancel;
    run.timeoutS = 600;
    DPL_RETURN_IF_ERROR(runProgram(run));
    return file;
}

}  // namespace dpl
