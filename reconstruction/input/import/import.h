// SPDX-License-Identifier: Apache-2.0
// From what lies on disk to a scan folder: `doppel import`, and the first step of `doppel reconstruct` for anything but a scan.
#pragma once

#include <atomic>

#include "reconstruction/input/import/capture.h"
#include "reconstruction/input/import/video_capture.h"

namespace dpl {

struct ImportOptions {
    std::filesystem::path source;  // folder or file; empty when videos are named by what they show
    VideoSources videos;           // `undivided` is set from `source`
    std::filesystem::path out;     // scan folder to make: new, or empty
    FrameCounts counts;
    uint32_t longSidePx = 1920;  // of frames from videos and photos, at most
    double heightM = 0;          // of the subject, kept in the scan; 0: unknown
};

/** Lines for the terminal, without a line break at the end. */
struct ImportReport {
    std::string summary;   // what was recognised, taken and left out
    std::string nextStep;  // the next command as the last line; before it what it needs and this machine lacks. Or why none works yet
};

/** Recognises the source, reads it and writes `out`, completely or not at all: files are written to OUT.partial, which is renamed at the
 * end and removed after an error. A symbolic link is kept and its target is written. Io: another import writes `out` now. The result is
 * read back as a check. */
Result<ImportReport> importCapture(const ImportOptions& options, const std::atomic<bool>* cancel, const ImportProgress& progress);

}  // namespace dpl
