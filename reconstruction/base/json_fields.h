// SPDX-License-Identifier: Apache-2.0
// Checked JSON fields and the paths in them, for every reader of a manifest from outside.
#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "sdk/core/result.h"

namespace dpl {

constexpr uintmax_t kMaxJsonBytes = 16u << 20;

/** Reads a JSON file of at most kMaxJsonBytes whose top level is an object. Errors name the file and the remedy. */
Result<nlohmann::json> readJsonObject(const std::filesystem::path& path);

/** The same for text that was read already. */
Result<nlohmann::json> parseJsonObject(std::string_view text, const std::string& where);

/** Returns root / relative. Refuses a path that is absolute, contains "..", or is not an existing regular file. */
Result<std::filesystem::path> fileInside(const std::filesystem::path& root, const std::string& relative, std::string_view where);

/** At most 128 bytes: letters and signs of any script in UTF-8, and of ASCII letters, digits, '.', '_' and '-', without a leading dot.
 * Frame names must be safe because stages use them as file names. */
bool isSafeName(std::string_view name);
/** A safe frame name from a picture's path: "images/left cam/IMG 1.jpg" -> "left_cam_IMG_1". */
std::string nameFromPath(std::string_view relativePath);
/** The name with "_2" behind it, cut so that it stays safe: for a second picture of one name. */
std::string numberedName(const std::string& name, size_t number);
/** A path with '/' where programs on Windows wrote a backslash. */
std::string withSlashes(std::string path);

/** Typed access to the fields of one JSON object. Errors name the place, `where`. Keeps a reference to the object. */
class JsonFields {
public:
    JsonFields(const nlohmann::json& object, std::string where) : object_(object), where_(std::move(where)) {}

    const std::string& where() const { return where_; }
    bool has(const char* key) const;                                 // present and not null
    bool states(const char* key) const;                              // present, and neither null nor false nor 0 nor a text that says so
    Result<double> number(const char* key) const;                    // finite; null is an error
    Result<double> number(const char* key, double otherwise) const;  // `otherwise` where the key is absent
    Result<std::string> text(const char* key) const;
    Result<std::string> text(const char* key, const std::string& otherwise) const;
    Result<bool> boolean(const char* key, bool otherwise) const;
    Result<const nlohmann::json*> array(const char* key) const;
    Result<std::vector<double>> numbers(const char* key, size_t count) const;  // exactly `count`, all finite

private:
    const nlohmann::json& object_;
    std::string where_;
};

}  // namespace dpl
