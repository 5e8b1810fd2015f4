// SPDX-License-Identifier: Apache-2.0
// Checked paths and JSON fields, shared by the readers of scans and captures. Private to reconstruction/capture and reconstruction/import.
#pragma once

#include <filesystem>
#include <functional>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>

#include "reconstruction/capture/image_file.h"
#include "reconstruction/capture/scan.h"

namespace dpl {

constexpr uintmax_t kMaxJsonBytes = 16u << 20;
constexpr size_t kMaxFrames = 20000;

/** Reads a JSON file of at most kMaxJsonBytes whose top level is an object. Errors name the file and the remedy. */
Result<nlohmann::json> readJsonObject(const std::filesystem::path& path);

/** The same for text that was read already. */
Result<nlohmann::json> parseJsonObject(std::string_view text, const std::string& where);

/** Returns root / relative. Refuses a path that is absolute, contains "..", or is not an existing regular file. */
Result<std::filesystem::path> fileInside(const std::filesystem::path& root, const std::string& relative, std::string_view where);

/** At most 128 letters, digits, '.', '_' and '-', without a leading dot. Frame names must be safe because stages use them as file names. */
bool isSafeName(std::string_view name);
/** A safe frame name from a picture's path: "images/left cam/IMG 1.jpg" -> "left_cam_IMG_1". */
std::string nameFromPath(std::string_view relativePath);

/** Typed access to the fields of one JSON object. Errors name the place, `where`. Keeps a reference to the object. */
class JsonFields {
public:
    JsonFields(const nlohmann::json& object, std::string where) : object_(object), where_(std::move(where)) {}

    const std::string& where() const { return where_; }
    bool has(const char* key) const;               // present and not null
    Result<double> number(const char* key) const;  // finite
    Result<double> number(const char* key, double otherwise) const;
    Result<std::string> text(const char* key) const;
    Result<std::string> text(const char* key, const std::string& otherwise) const;
    Result<bool> boolean(const char* key, bool otherwise) const;
    Result<const nlohmann::json*> array(const char* key) const;
    Result<std::vector<double>> numbers(const char* key, size_t count) const;  // exactly `count`, all finite

private:
    const nlohmann::json& object_;
    std::string where_;
};

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
