// SPDX-License-Identifier: Apache-2.0
// frames.json: pictures and cameras of a run for programs that show them beside the avatar; docs/formats/poses.md lists the fields.
#pragma once

#include <filesystem>
#include <span>
#include <string>

#include "reconstruction/input/capture/scan.h"

namespace dpl {

/** cameras: of the scan's frames, in metres. out: the run's folder; a scan inside it is named by its path from there. */
std::string framesToJson(const Scan& scan, std::span<const Camerad> cameras, const std::filesystem::path& out);

}  // namespace dpl
