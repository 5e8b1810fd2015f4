// SPDX-License-Identifier: Apache-2.0
#include "apps/viewer/run_process.h"

#include <fcntl.h>
#include <spawn.h>
#include <sys/stat.h>
#include <sys/wait.h>

#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstring>
#include <fstream>
#include <optional>
#include <sstream>
#include <thread>

#include "reconstruction/base/folder_lock.h"
#include "reconstruction/base/program.h"
#include "sdk/core/files.h"
#include "sdk/core/numbers.h"

extern char** environ;

namespace dpl {
namespace {

namespace fs = std::filesystem;

constexpr auto kLookEvery = std::chrono::milliseconds(50);
constexpr size_t kMostSentence = 2000;

int spawnInOwnSession(const fs::path& program, std::vector<std::string> words, const fs::path& log, pid_t& child) {
    posix_spawn_file_actions_t actions;
    posix_spawnattr_t attributes;
    posix_spawn_file_actions_init(&actions);
    posix_spawnattr_init(&attributes);
    posix_spawn_file_actions_addopen(&actions, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
    posix_spawn_file_actions_addopen(&actions, STDOUT_FILENO, log.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0644);
    posix_spawn_file_actions_adddup2(&actions, STDOUT_FILENO, STDERR_FILENO);
    sigset_t defaults;
    sigemptyset(&defaults);
    for (int number : {SIGINT, SIGTERM, SIGHUP, SIGPIPE}) sigaddset(&defaults, number);
    posix_spawnattr_setsigdefault(&attributes, &defaults);
    posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETSID | POSIX_SPAWN_SETSIGDEF);
    std::vector<char*> pointers;
    for (std::string& word : words) pointers.push_back(word.data());
    pointers.push_back(nullptr);
    const int error = ::posix_spawn(&child, program.c_str(), &actions, &attributes, pointers.data(), environ);
    posix_spawn_file_actions_destroy(&actions);
    posix_spawnattr_destroy(&attributes);
    return error;
}

/** The end of the log, from the last line in which the program speaks of itself. */
std::string lastWords(const fs::path& log) {
    const auto bytes = readFile(log, uint64_t(64) << 20);
    std::string text = bytes ? std::string(bytes->begin(), bytes->end()) : "";
    constexpr std::string_view kName = "doppel: ";
    size_t at = text.rfind(kName);
    while (at != text.npos && at > 0 && text[at - 1] != '\n') at = text.rfind(kName, at - 1);
    text = at == text.npos ? "" : text.substr(at + kName.size(), kMostSentence);
    while (!text.empty() && text.back() == '\n') text.pop_back();
    return text;
}

std::optional<fs::file_time_type> timeOf(const fs::path& file) {
    std::error_code error;
    const auto time = fs::last_write_time(file, error);
    return error ? std::nullopt : std::optional(time);
}

}  // namespace

Status startRun(const std::vector<std::string>& arguments, const fs::path& out, const std::atomic<bool>& cancel) {
    const auto program = findProgram(arguments.front());
    if (!program) return fail(Code::NotFound, "the program '{}' is not installed", arguments.front());
    std::error_code error;
    fs::create_directories(out, error);
    if (error) return fail(Code::Io, "cannot create {}: {}; choose another folder", out.string(), error.message());
    const auto before = timeOf(out / "progress.json");
    pid_t child = -1;
    if (const int failed = spawnInOwnSession(*program, arguments, out / kRunLog, child); failed != 0)
        return fail(Code::Io, "cannot start '{}': {}", program->string(), std::strerror(failed));
    while (!cancel) {
        if (timeOf(out / "progress.json") != before) return {};
        int status = 0;
        const pid_t ended = ::waitpid(child, &status, WNOHANG);
        if (ended == child || (ended < 0 && errno != EINTR)) {
            if (timeOf(out / "progress.json") != before) return {};  // it has told how it ended
            const std::string words = lastWords(out / kRunLog);
            return fail(Code::Io, "{}",
                        words.empty() ? formatText("the run ended at once; {} has what it said", (out / kRunLog).string()) : words);
        }
        std::this_thread::sleep_for(kLookEvery);
    }
    return fail(Code::Cancelled, "the run in {} was not waited for", out.string());
}

Result<pid_t> processOfRun(const fs::path& out) {
    const fs::path file = out / FolderLock::kName;
    const auto none = [&] {
        return fail(Code::NotFound, "no run on this machine works in {}; stop it where it was started", out.string());
    };
    struct stat info {};
    const auto bytes = readFile(file, 4096);
    if (!bytes || ::stat(file.c_str(), &info) != 0) return none();
    const std::string text(bytes->begin(), bytes->end());
    constexpr std::string_view kBefore = "(process ";
    const size_t at = text.find(kBefore);
    pid_t process = 0;
    if (at == text.npos || !readNumber(text.substr(at + kBefore.size(), text.find(')', at) - at - kBefore.size()), process) || process <= 0)
        return none();
    // The kernel tells who holds it: a line such as "1: FLOCK  ADVISORY  WRITE 6915 fe:00:12345 0 EOF".
    std::ifstream locks("/proc/locks");
    for (std::string line; std::getline(locks, line);) {
        std::istringstream words(line);
        std::string number, kind, advisory, way, holder, place;
        words >> number >> kind >> advisory >> way >> holder >> place;
        if (kind == "FLOCK" && holder == std::to_string(process) && place.ends_with(":" + std::to_string(info.st_ino))) return process;
    }
    return none();
}

Status stopRun(const fs::path& out) {
    DPL_TRY(const pid_t process, processOfRun(out));
    if (::kill(process, SIGINT) != 0) return fail(Code::Io, "the run in {} cannot be stopped: {}", out.string(), std::strerror(errno));
    const auto until = std::chrono::steady_clock::now() + std::chrono::seconds(kStopPatienceS);
    while (std::chrono::steady_clock::now() < until) {
        const auto now = processOfRun(out);
        if (!now || *now != process) return {};
        std::this_thread::sleep_for(kLookEvery);
    }
    return fail(Code::Io, "the run in {} has been asked to stop, and goes on", out.string());
}

}  // namespace dpl
