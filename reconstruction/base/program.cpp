// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/base/program.h"

#include <fcntl.h>
#include <poll.h>
#include <spawn.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cctype>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <thread>
#include <utility>

#include "sdk/core/task.h"

extern char** environ;

namespace dpl {
namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;

constexpr int kPollMs = 100;                             // how late a cancel may be noticed
constexpr auto kGrace = std::chrono::milliseconds(300);  // from SIGTERM to SIGKILL
constexpr size_t kMaxLineBytes = 64 << 10;               // a longer line is handed on in pieces

/** Closes a file descriptor when it goes out of scope. */
struct Descriptor {
    int fd = -1;
    explicit Descriptor(int given = -1) : fd(given) {}
    Descriptor(const Descriptor&) = delete;
    Descriptor& operator=(const Descriptor&) = delete;
    ~Descriptor() { close(); }
    void close() {
        if (fd >= 0) ::close(fd);
        fd = -1;
    }
};

std::vector<std::string> mergedEnvironment(const std::vector<std::string>& added) {
    std::vector<std::string> merged = added;
    for (char** entry = environ; *entry; ++entry) {
        const std::string_view whole(*entry), name = whole.substr(0, whole.find('=') + 1);
        bool replaced = false;
        for (const std::string& other : added) replaced |= std::string_view(other).substr(0, name.size()) == name;
        if (!replaced) merged.emplace_back(whole);
    }
    return merged;
}

std::vector<char*> pointersTo(std::vector<std::string>& texts) {
    std::vector<char*> pointers;
    for (std::string& text : texts) pointers.push_back(text.data());
    pointers.push_back(nullptr);
    return pointers;
}

/** Starts the program with both outputs in `output`. Returns errno. */
int start(const ProgramRun& run, const fs::path& program, int output, pid_t& child) {
    posix_spawn_file_actions_t actions;
    posix_spawnattr_t attributes;
    posix_spawn_file_actions_init(&actions);
    posix_spawnattr_init(&attributes);
    if (run.input >= 0)
        posix_spawn_file_actions_adddup2(&actions, run.input, STDIN_FILENO);
    else
        posix_spawn_file_actions_addopen(&actions, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
    posix_spawn_file_actions_adddup2(&actions, output, STDOUT_FILENO);
    posix_spawn_file_actions_adddup2(&actions, output, STDERR_FILENO);
    sigset_t defaults;
    sigemptyset(&defaults);
    for (int number : {SIGINT, SIGTERM, SIGPIPE}) sigaddset(&defaults, number);
    posix_spawnattr_setsigdefault(&attributes, &defaults);
    posix_spawnattr_setpgroup(&attributes, 0);
    posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETPGROUP | POSIX_SPAWN_SETSIGDEF);
    std::vector<std::string> arguments = run.arguments, environment = mergedEnvironment(run.environment);
    const int error =
        ::posix_spawn(&child, program.c_str(), &actions, &attributes, pointersTo(arguments).data(), pointersTo(environment).data());
    posix_spawn_file_actions_destroy(&actions);
    posix_spawnattr_destroy(&attributes);
    return error;
}

/** Splits output into lines. Carriage returns, with which programs rewrite a progress line, end a line too. */
class LineSplitter {
public:
    explicit LineSplitter(const std::function<void(std::string_view)>& line) : line_(line) {}
    void add(std::string_view bytes) {
        for (char c : bytes) {
            if (c == '\n' || c == '\r' || open_.size() >= kMaxLineBytes) end();
            if (c != '\n' && c != '\r') open_.push_back(c);
        }
    }
    void end() {
        if (open_.empty()) return;
        last_ = open_;
        if (line_) line_(open_);
        open_.clear();
    }
    const std::string& last() const { return last_; }

private:
    const std::function<void(std::string_view)>& line_;
    std::string open_, last_;
};

/** Ends the whole group: politely, then by force. */
void endGroup(pid_t child) {
    ::kill(-child, SIGTERM);
    int status = 0;
    for (const auto until = Clock::now() + kGrace; Clock::now() < until;) {
        if (::waitpid(child, &status, WNOHANG) == child) {
            ::kill(-child, SIGKILL);  // children that outlive their parent
            return;
        }
        std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
    ::kill(-child, SIGKILL);
    while (::waitpid(child, &status, 0) < 0 && errno == EINTR) {
    }
}

}  // namespace

std::string shellWord(const fs::path& path) {
    const std::string text = path.string();
    const bool plain = !text.empty() && std::all_of(text.begin(), text.end(), [](unsigned char c) {
        return std::isalnum(c) || c >= 0x80 || std::string_view("/._-+:,@%=").find(char(c)) != std::string_view::npos;
    });
    if (plain) return text;
    std::string word = "'";
    for (const char c : text) word += c == '\'' ? std::string("'\\''") : std::string(1, c);
    return word + "'";
}

std::optional<fs::path> findProgram(const std::string& name) {
    const auto runnable = [](const fs::path& path) {
        std::error_code error;
        return fs::is_regular_file(path, error) && ::access(path.c_str(), X_OK) == 0;
    };
    if (name.empty()) return std::nullopt;
    if (name.find('/') != std::string::npos) return runnable(name) ? std::optional<fs::path>(name) : std::nullopt;
    const char* path = std::getenv("PATH");
    for (std::string_view rest = path ? path : "/usr/local/bin:/usr/bin:/bin"; !rest.empty();) {
        const size_t end = std::min(rest.find(':'), rest.size());
        const fs::path candidate = fs::path(end == 0 ? "." : std::string(rest.substr(0, end))) / name;
        if (runnable(candidate)) return candidate;
        rest.remove_prefix(std::min(end + 1, rest.size()));
    }
    return std::nullopt;
}

Status runProgram(const ProgramRun& run) {
    const std::string name = run.arguments.empty() ? "" : run.arguments.front();
    const auto program = findProgram(name);
    if (!program) return fail(Code::NotFound, "the program '{}' is not installed", name);
    Descriptor readEnd, writeEnd;
    if (int ends[2]; ::pipe2(ends, O_CLOEXEC) == 0)
        readEnd.fd = ends[0], writeEnd.fd = ends[1];
    else
        return fail(Code::Io, "cannot start '{}': {}", name, std::strerror(errno));
    std::ofstream log;
    if (!run.log.empty()) log.open(run.log, std::ios::app | std::ios::binary);
    if (!log) return fail(Code::Io, "cannot write {}; choose another output folder", run.log.string());
    pid_t child = -1;
    if (const int error = start(run, *program, writeEnd.fd, child); error != 0)
        return fail(Code::Io, "cannot start '{}': {}", program->string(), std::strerror(error));
    writeEnd.close();

    const std::string whereOutput = run.log.empty() ? "" : "; all of its output: " + run.log.string();
    LineSplitter lines(run.line);
    const auto cancelled = [&] { return (run.cancel && run.cancel->load()) || !taskAt(0); };
    const auto started = Clock::now();
    const auto late = [&] { return run.timeoutS > 0 && std::chrono::duration<double>(Clock::now() - started).count() > run.timeoutS; };
    const auto stop = [&]() -> Status {
        endGroup(child);
        if (cancelled()) return fail(Code::Cancelled, "'{}' was stopped", name);
        return fail(Code::Io, "'{}' took more than {} s and was stopped{}", name, run.timeoutS, whereOutput);
    };
    for (bool open = true; open;) {
        if (cancelled() || late()) return stop();
        pollfd waiting{readEnd.fd, POLLIN, 0};
        if (::poll(&waiting, 1, kPollMs) <= 0) continue;
        char bytes[4096];
        const ssize_t count = ::read(readEnd.fd, bytes, sizeof bytes);
        if (count < 0 && errno == EINTR) continue;
        open = count > 0;
        if (!open) break;
        if (log.is_open()) log.write(bytes, count).flush();
        lines.add({bytes, size_t(count)});
    }
    lines.end();
    int status = 0;
    for (;;) {  // the outputs are closed, so it ends at once or has to be ended
        const pid_t ended = ::waitpid(child, &status, WNOHANG);
        if (ended == child || (ended < 0 && errno != EINTR)) break;
        if (cancelled() || late()) return stop();
        std::this_thread::sleep_for(std::chrono::milliseconds(5));
    }
    if (WIFEXITED(status) && WEXITSTATUS(status) == 0) return {};
    const std::string how = WIFSIGNALED(status) ? formatText("was ended by signal {}", WTERMSIG(status))
                                                : formatText("ended with exit status {}", WEXITSTATUS(status));
    return fail(Code::Io, "'{}' {}; its last line: \"{}\"{}", name, how, lines.last().substr(0, 300), whereOutput);
}

Result<std::unique_ptr<FedProgram>> FedProgram::start(ProgramRun run) {
    const std::string name = run.arguments.empty() ? "" : run.arguments.front();
    if (!findProgram(name)) return fail(Code::NotFound, "the program '{}' is not installed", name);
    // A socket, because writing to a pipe that nobody reads raises SIGPIPE.
    int ends[2];
    if (::socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends) != 0)
        return fail(Code::Io, "cannot start '{}': {}", name, std::strerror(errno));
    std::unique_ptr<FedProgram> fed(new FedProgram);
    fed->input_ = ends[0];
    run.input = ends[1], run.cancel = &fed->cancel_;
    fed->thread_ = std::thread([fed = fed.get(), run = std::move(run)] {
        const Descriptor readEnd(run.input);  // kept until the program has ended, then a writer learns that nobody reads
        fed->end_ = runProgram(run);
    });
    return fed;
}

FedProgram::~FedProgram() {
    cancel_ = true;
    if (input_ >= 0) ::close(input_);
    if (thread_.joinable()) thread_.join();
}

Status FedProgram::write(std::span<const uint8_t> bytes) {
    while (!bytes.empty()) {
        const ssize_t count = ::send(input_, bytes.data(), bytes.size(), MSG_NOSIGNAL);
        if (count < 0 && errno == EINTR) continue;
        if (count <= 0) return fail(Code::Io, "the program stopped reading");
        bytes = bytes.subspan(size_t(count));
    }
    return {};
}

Status FedProgram::finish() {
    ::shutdown(input_, SHUT_WR);
    thread_.join();
    ::close(std::exchange(input_, -1));
    return std::move(end_);
}

}  // namespace dpl
