// SPDX-License-Identifier: Apache-2.0
// What the viewer asks of `doppel check` and `doppel reconstruct`: a film, where its avatar goes, and how much work it is worth.
#pragma once

#include <array>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "sdk/core/result.h"

namespace dpl {

struct NewRun {
    enum class Role : uint8_t { Still, Closeup, Moving };  // as in --static, --closeup, --motion
    enum class Preset : uint8_t { Draft, Standard, High };
    struct Video {
        std::filesystem::path file;
        Role role = Role::Still;
        bool operator==(const Video&) const = default;
    };
    static constexpr size_t kMostVideos = 32;
    static constexpr int kMostMinutes = 100000;

    std::filesystem::path scan;  // a folder or one video, absolute; empty: `videos`
    std::vector<Video> videos;
    std::filesystem::path out;
    Preset preset = Preset::Standard;
    int minutes = 0;  // for training; 0: what the preset takes
    bool operator==(const NewRun&) const = default;
};

constexpr std::array<const char*, 3> kRoleNames{"static", "closeup", "motion"};  // options of doppel, without dashes
constexpr std::array<const char*, 3> kPresetNames{"draft", "standard", "high"};

bool isVideoName(const std::string& name);
/** Whether a folder holds what `doppel import` may read: a scan, cameras, photos or videos. Looks at its first entries alone. */
bool isCaptureFolder(const std::filesystem::path& folder);

/** A run of a scan folder, or of one or more videos: `dropped` are absolute paths, at least one. Several videos get their parts by their
 *  names. The output is a folder beside, NAME-avatar: that of an earlier run, which goes on, or one that is not there. */
NewRun newRunOf(const std::vector<std::filesystem::path>& dropped);

/** Command lines. */
std::vector<std::string> checkArguments(const std::filesystem::path& program, const NewRun& run);
std::vector<std::string> reconstructArguments(const std::filesystem::path& program, const NewRun& run);

/** What the coach says of a film. */
struct CoachWords {
    std::vector<std::string> faults;  // of the film: worth filming again before an avatar is made of it
    std::string advice;               // lines for people
};
/** From the line of JSON that `doppel check --json` prints. CorruptData: none of the lines is that. The error of a refused film is its
 *  sentence, with Unsupported. */
Result<CoachWords> parseCoachWords(const std::vector<std::string>& lines);

/** The file in an output folder by which a later start of the viewer goes on with the run. */
constexpr const char* kRunRequest = "viewer-run.json";
std::string runRequestToJson(const NewRun& run);
/** out: the folder that the file lies in. Nothing: damaged, or with anything but absolute paths and numbers within their bounds. */
std::optional<NewRun> parseRunRequest(std::string_view text, const std::filesystem::path& out);
std::optional<NewRun> readRunRequest(const std::filesystem::path& out);

}  // namespace dpl
