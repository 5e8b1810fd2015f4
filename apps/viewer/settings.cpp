// SPDX-License-Identifier: Apache-2.0
#include "apps/viewer/settings.h"

#include <algorithm>

#include "reconstruction/base/json_fields.h"
#include "sdk/core/files.h"

namespace dpl {
namespace {

namespace fs = std::filesystem;
using nlohmann::ordered_json;

bool isPath(const std::string& text) {
    return !text.empty() && text.size() <= ViewerSettings::kMostPathBytes && text.find('\0') == text.npos && fs::path(text).is_absolute();
}

}  // namespace

void ViewerSettings::remember(const std::string& path) {
    if (!isPath(path)) return;
    forget(path);
    recent.insert(recent.begin(), path);
    if (recent.size() > kMostRecent) recent.resize(kMostRecent);
}

void ViewerSettings::forget(const std::string& path) {
    std::erase(recent, path);
}

System thisSystem() {
#if defined(_WIN32)
    return System::Windows;
#elif defined(__APPLE__)
    return System::Mac;
#else
    return System::Unix;
#endif
}

fs::path settingsFile(System system, const std::function<std::string(const char*)>& environment) {
    const auto below = [&](const char* variable, const fs::path& path) {
        const std::string folder = environment(variable);
        return folder.empty() ? fs::path() : folder / path / "doppel" / "viewer.json";
    };
    if (system == System::Windows) return below("APPDATA", {});
    if (system == System::Mac) return below("HOME", "Library/Application Support");
    const fs::path own = below("XDG_CONFIG_HOME", {});
    return own.is_absolute() ? own : below("HOME", ".config");  // the specification ignores relative ones
}

ViewerSettings parseSettings(std::string_view text) {
    ViewerSettings settings;
    const auto file =
        text.size() <= ViewerSettings::kMostBytes ? parseJsonObject(text, "viewer.json") : fail(Code::Unsupported, "too long");
    if (!file) return settings;
    const JsonFields fields(*file, "viewer.json");
    if (const auto recent = fields.array("recent"))
        for (auto path = (*recent)->rbegin(); path != (*recent)->rend(); ++path)
            if (path->is_string()) settings.remember(path->get<std::string>());
    if (const auto folder = fields.text("folder"); folder && isPath(*folder)) settings.folder = *folder;
    if (const auto exports = fields.text("exports"); exports && isPath(*exports)) settings.exports = *exports;
    if (const auto room = fields.text("room"); room && (*room == "dark" || *room == "bright" || *room == "none")) settings.room = *room;
    return settings;
}

std::string settingsToJson(const ViewerSettings& settings) {
    const ordered_json file = {{"format", "doppel-viewer-settings"}, {"version", 1},
                               {"recent", settings.recent},          {"folder", settings.folder},
                               {"exports", settings.exports},        {"room", settings.room}};
    return file.dump(1, ' ', false, ordered_json::error_handler_t::replace) + "\n";
}

ViewerSettings readSettings(const fs::path& file) {
    const auto bytes = readFile(file, ViewerSettings::kMostBytes);
    return bytes ? parseSettings({reinterpret_cast<const char*>(bytes->data()), bytes->size()}) : ViewerSettings();
}

Status writeSettings(const fs::path& file, const ViewerSettings& settings) {
    std::error_code error;
    fs::create_directories(file.parent_path(), error);
    if (error) return fail(Code::Io, "cannot create {}: {}", file.parent_path().string(), error.message());
    return writeFileAtomically(file, settingsToJson(settings));
}

}  // namespace dpl
