// SPDX-License-Identifier: Apache-2.0
// The first step of a reconstruction from anything but a scan: the import.
#pragma once

#include "reconstruction/run/reconstruct.h"

namespace dpl {

/** The scan to reconstruct. It is options.scan, or a folder in it, where readScan() takes that as it is. Else it is OUT/scan, imported now
 * or by an earlier run from the same files with the same settings; a scan of other files, or one that is damaged, is imported anew, and the
 * earlier one is kept beside it. InvalidArgument where OUT/scan is not an import's, or holds a file that would be read; nothing is moved
 * then. Prints what was imported. */
Result<std::filesystem::path> scanToReconstruct(const ReconstructOptions& options, Progress& progress);

}  // namespace dpl
