// SPDX-License-Identifier: Apache-2.0
// The readers of the kinds of scan folder, and what they share. Private to reconstruction/input.
#pragma once

#include <filesystem>
#include <functional>
#include <nlohmann/json.hpp>
#include <string>

#include "reconstruction/base/image_file.h"
#include "reconstruction/base/json_fields.h"
#include "reconstruction/input/capture/scan.h"

namespace dpl {

constexpr size_t kMaxFrames = 20000;

/** Checks that there are 1 … kMaxFrames frames with unique, safe names and images of the camera's size. Chooses test frames when the source
 *  states no split. */
Status finishScan(Scan& scan);

Result<Scan> readScanFolder(const std::filesystem::path& manifest);
/** `up`: 'y' or 'z', of a file that does not state it. */
Result<Scan> readNerfstudio(const std::filesystem::path& manifest, char up = 'y');
/** How parseNerfstudio looks at files: the checked path of a name in the manifest, and the size of a picture. */
struct NerfstudioFiles {
    std::function<Result<std::filesystem::path>(const std::string&relative, const std::string&where)> picture, mask;
    std::function<Result<ImageHeader>(const std::filesystem::path&)> header;
};
/** Frames and cameras of a manifest, before finishScan(). */
Result<Scan> parseNerfstudio(const nlohmann::json& manifest, const std::filesystem::path& path, const NerfstudioFiles& files,
                             char up = 'y');
/** The folder of a COLMAP model's pictures when `folder` is it, its sparse or its sparse/0; `folder` itself when neither images/ nor input/
 * is near; empty when there is no model. */
std::filesystem::path colmapRoot(const std::filesystem::path& folder);
Result<Scan> readColmapScan(const std::filesystem::path& root, const std::filesystem::path& model);

}  // namespace dpl
