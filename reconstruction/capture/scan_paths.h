// SPDX-License-Identifier: Apache-2.0
// Paths and JSON fields of a scan, checked: what the three scan readers share.
#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>

#include "reconstruction/capture/scan.h"

namespace dpl {

constexpr uintmax_t kMaxJsonBytes = 16u << 20;
constexpr size_t kMaxFrames = 20000;

/** Reads a JSON file of at most kMaxJsonBytes; the top level must be an object. Errors name the file and what to do. */
Result<nlohmann::json> readJsonObject(const std::filesystem::path& path);

/** root / relative, for a path taken from a file: relative, without "..", and an existing regular file. */
Result<std::filesystem::path> fileInside(const std::filesystem::path& root, const std::string& relative, std::string_view where);

/** Letters, digits, '.', '_' and '-' only, at most 128, no leading dot: stages name their files after frames. */
bool isSafeName(std::string_view name);
/** "images/left cam/IMG 1.jpg" -> "left_cam_IMG_1": a safe name for a frame whose source has none. */
std::string nameFromPath(std::string_view relativePath);

/** Fields of one JSON object with messages that say where they are. */
class JsonFields {
public:
    JsonFields(const nlohmann::json& object, std::string where) : object_(object), where_(std::move(where)) {}

    const std::string& where() const { return where_; }
    bool has(const char* key) const;               // present and not null
    Result<double> number(const char* key) const;  // finite
    Result<double> number(const char* key, double otherwise) const;
    Result<std::string> text(const char* key) const;
    Result<std::string> text(const char* key, const std::string& otherwise) const;
    Result<const nlohmann::json*> array(const char* key) const;
    Result<std::vector<double>> numbers(const char* key, size_t count) const;  // exactly `count`, all finite

private:
    const nlohmann::json& object_;
    std::string where_;
};

/** Names unique and safe, at least one frame, at most kMaxFrames; images exist and have the camera's size; default test split. */
Status finishScan(Scan& scan);

Result<Scan> readScanFolder(const std::filesystem::path& manifest);
Result<Scan> readNerfstudio(const std::filesystem::path& manifest);
Result<Scan> readColmapScan(const std::filesystem::path& root, const std::filesystem::path& model);

}  // namespace dpl
