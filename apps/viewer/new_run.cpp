// SPDX-License-Identifier: Apache-2.0
#include "apps/viewer/new_run.h"

#include <algorithm>
#include <cctype>

#include "apps/viewer/run_reader.h"
#include "reconstruction/base/json_fields.h"
#include "sdk/core/files.h"

namespace dpl {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using nlohmann::ordered_json;

constexpr size_t kMostRequestBytes = size_t(1) << 20, kMostPath = 4096;

std::string lowered(std::string text) {
    std::transform(text.begin(), text.end(), text.begin(), [](unsigned char c) { return char(std::tolower(c)); });
    return text;
}

bool endsWithOneOf(const std::string& name, std::initializer_list<const char*> endings) {
    const std::string ending = lowered(fs::path(name).extension().string());
    return std::any_of(endings.begin(), endings.end(), [&](const char* one) { return ending == one; });
}

NewRun::Role roleByName(const fs::path& video) {
    const std::string name = lowered(video.stem().string());
    const auto has = [&](std::initializer_list<const char*> words) {
        return std::any_of(words.begin(), words.end(), [&](const char* word) { return name.find(word) != name.npos; });
    };
    if (has({"close", "face", "hand", "head", "detail"})) return NewRun::Role::Closeup;
    if (has({"mov", "motion", "dance", "dyn", "walk"})) return NewRun::Role::Moving;
    return NewRun::Role::Still;
}

std::vector<std::string> sourceWords(const NewRun& run) {
    if (!run.scan.empty()) return {run.scan.string()};
    std::vector<std::string> words;
    for (size_t role = 0; role < kRoleNames.size(); ++role)
        for (const NewRun::Video& video : run.videos)
            if (size_t(video.role) == role) words.insert(words.end(), {std::string("--") + kRoleNames[role], video.file.string()});
    return words;
}

bool isPath(const std::string& text) {
    return !text.empty() && text.size() <= kMostPath && text.find('\0') == text.npos && fs::path(text).is_absolute();
}

template <size_t N>
std::optional<size_t> indexOf(const std::array<const char*, N>& names, const std::string& name) {
    const auto at = std::find(names.begin(), names.end(), name);
    return at == names.end() ? std::nullopt : std::optional(size_t(at - names.begin()));
}

}  // namespace

bool isVideoName(const std::string& name) {
    return endsWithOneOf(name, {".mp4", ".mov", ".m4v", ".mkv", ".avi", ".webm"});
}

bool isCaptureFolder(const fs::path& folder) {
    constexpr int kEntries = 200;
    std::error_code error;
    int seen = 0;
    for (fs::directory_iterator at(folder, fs::directory_options::skip_permission_denied, error);
         !error && at != fs::directory_iterator() && seen < kEntries; at.increment(error), ++seen) {
        const std::string name = at->path().filename().string();
        for (const char* known : {"scan.json", "transforms.json", "cameras.bin", "cameras.txt", "sparse", "keyframes"})
            if (name == known) return true;
        if (isVideoName(name) || endsWithOneOf(name, {".jpg", ".jpeg", ".heic", ".r3d"})) return true;
    }
    return false;
}

NewRun newRunOf(const std::vector<fs::path>& dropped) {
    NewRun run;
    if (dropped.size() == 1)
        run.scan = dropped[0];
    else
        for (const fs::path& video : dropped)
            if (run.videos.size() < NewRun::kMostVideos) run.videos.push_back({video, roleByName(video)});
    std::error_code error;
    const fs::path base = dropped[0].parent_path() / dropped[0].stem();
    run.out = base.string() + "-avatar";
    for (int i = 2; fs::exists(run.out, error) && !isRunFolder(run.out); ++i) run.out = base.string() + "-avatar-" + std::to_string(i);
    return run;
}

std::vector<std::string> checkArguments(const fs::path& program, const NewRun& run) {
    std::vector<std::string> words = {program.string(), "check"};
    for (std::string& word : sourceWords(run)) words.push_back(std::move(word));
    words.insert(words.end(), {"-o", run.out.string(), "--json"});
    return words;
}

std::vector<std::string> reconstructArguments(const fs::path& program, const NewRun& run) {
    std::vector<std::string> words = {program.string(), "reconstruct"};
    for (std::string& word : sourceWords(run)) words.push_back(std::move(word));
    words.insert(words.end(), {"-o", run.out.string(), "--preset", kPresetNames[size_t(run.preset)]});
    if (run.minutes > 0) words.insert(words.end(), {"--time-budget", std::to_string(run.minutes)});
    return words;
}

Result<CoachWords> parseCoachWords(const std::vector<std::string>& lines) {
    for (auto line = lines.rbegin(); line != lines.rend(); ++line) {
        if (!line->starts_with('{')) continue;
        const auto object = parseJsonObject(*line, "doppel check");
        if (!object) continue;
        if (object->contains("error") && (*object)["error"].is_object()) {
            const JsonFields error((*object)["error"], "doppel check");
            DPL_TRY(const std::string message, error.text("message"));
            return fail(Code::Unsupported, "{}", message);
        }
        const JsonFields fields(*object, "doppel check");
        CoachWords words;
        DPL_TRY(words.advice, fields.text("advice"));
        DPL_TRY(const json* faults, fields.array("first_look"));
        for (const json& fault : *faults) {
            if (!fault.is_object()) continue;
            DPL_TRY(std::string sentence, JsonFields(fault, "doppel check").text("sentence"));
            words.faults.push_back(std::move(sentence));
        }
        return words;
    }
    return fail(Code::CorruptData, "doppel check has not said what it saw; run it in a terminal");
}

std::string runRequestToJson(const NewRun& run) {
    ordered_json videos = ordered_json::array();
    for (const NewRun::Video& video : run.videos)
        videos.push_back({{"file", video.file.string()}, {"role", kRoleNames[size_t(video.role)]}});
    const ordered_json file = {{"format", "doppel-viewer-run"},
                               {"version", 1},
                               {"scan", run.scan.string()},
                               {"videos", videos},
                               {"preset", kPresetNames[size_t(run.preset)]},
                               {"minutes", run.minutes}};
    return file.dump(1, ' ', false, ordered_json::error_handler_t::replace) + "\n";
}

std::optional<NewRun> parseRunRequest(std::string_view text, const fs::path& out) {
    const auto object = text.size() <= kMostRequestBytes ? parseJsonObject(text, kRunRequest) : fail(Code::Unsupported, "too long");
    if (!object) return std::nullopt;
    const JsonFields fields(*object, kRunRequest);
    const auto format = fields.text("format"), scan = fields.text("scan"), preset = fields.text("preset");
    const auto minutes = fields.number("minutes", 0);
    const auto videos = fields.array("videos");
    if (!format || *format != "doppel-viewer-run" || !scan || !preset || !minutes || !videos) return std::nullopt;
    NewRun run;
    run.out = out;
    const auto presetAt = indexOf(kPresetNames, *preset);
    if (!presetAt || !(*minutes >= 0 && *minutes <= NewRun::kMostMinutes) || (*videos)->size() > NewRun::kMostVideos) return std::nullopt;
    run.preset = NewRun::Preset(*presetAt), run.minutes = int(*minutes);
    for (const json& video : **videos) {
        if (!video.is_object()) return std::nullopt;
        const JsonFields of(video, kRunRequest);
        const auto file = of.text("file"), role = of.text("role");
        const auto roleAt = role ? indexOf(kRoleNames, *role) : std::nullopt;
        if (!file || !isPath(*file) || !roleAt) return std::nullopt;
        run.videos.push_back({*file, NewRun::Role(*roleAt)});
    }
    if (run.videos.empty() != isPath(*scan)) return std::nullopt;  // one of both
    run.scan = *scan;
    return run;
}

std::optional<NewRun> readRunRequest(const fs::path& out) {
    const auto bytes = readFile(out / kRunRequest, kMostRequestBytes);
    return bytes ? parseRunRequest({reinterpret_cast<const char*>(bytes->data()), bytes->size()}, out) : std::nullopt;
}

}  // namespace dpl
