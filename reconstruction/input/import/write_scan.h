// SPDX-License-Identifier: Apache-2.0
// Writes a capture as a scan folder (docs/formats/scan.md).
#pragma once

#include "reconstruction/input/import/capture.h"

namespace dpl {

/** Writes scan.json, images/ and masks/ into `folder`, which exists and is empty. Pictures are copied as they are, unless they must be
 * turned upright, carry their mask in an alpha channel or are not sRGB. Without cameras all pictures must have one size: those of other
 * sizes than most are left out. So are pictures that cannot be read or are damaged, unless the capture has a protocol. `capture` keeps what
 * was written, and a note of each kind of change. Errors name the picture and the remedy. */
Status writeScan(Capture& capture, const std::string& name, double heightM, const std::filesystem::path& folder,
                 const ImportProgress& progress);

}  // namespace dpl
