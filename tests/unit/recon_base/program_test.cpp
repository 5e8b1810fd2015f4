// SPDX-License-Identifier: Apache-2.0
// Programs are started without a shell, their output is kept, and a cancel ends them and their children at once.
#include "reconstruction/base/program.h"

#include <gtest/gtest.h>
#include <signal.h>
#include <unistd.h>

#include <chrono>
#include <fstream>
#include <sstream>
#include <thread>

namespace dpl {
namespace {

namespace fs = std::filesystem;

struct LogFile {
    fs::path path = fs::temp_directory_path() / ("dpl_program_" + std::to_string(::getpid()) + ".log");
    LogFile() { fs::remove(path); }
    ~LogFile() { fs::remove(path); }
    std::string text() const {
        std::ostringstream all;
        all << std::ifstream(path).rdbuf();
        return all.str();
    }
};

TEST(Program, argumentsReachTheProgramAsTheyAre) {
    LogFile log;
    std::vector<std::string> lines;
    ProgramRun run{.arguments = {"printf", "%s\\n", "a b; $(exit 3) 'c'", "*"}, .environment = {}, .log = log.path, .line = {}};
    run.line = [&](std::string_view line) { lines.emplace_back(line); };
    const Status ended = runProgram(run);
    ASSERT_TRUE(ended) << ended.error().message;
    EXPECT_EQ(lines, (std::vector<std::string>{"a b; $(exit 3) 'c'", "*"}));
    EXPECT_EQ(log.text(), "a b; $(exit 3) 'c'\n*\n");
}

TEST(Program, environmentIsAddedAndReplaced) {
    LogFile log;
    ProgramRun run{.arguments = {"sh", "-c", "echo $HOME $DPL_ADDED"}, .environment = {"HOME=/nowhere", "DPL_ADDED=yes"}, .log = log.path};
    ASSERT_TRUE(runProgram(run));
    EXPECT_EQ(log.text(), "/nowhere yes\n");
}

TEST(Program, failureNamesStatusLastLineAndLog) {
    LogFile log;
    const Status ended = runProgram({.arguments = {"sh", "-c", "echo first; echo no space >&2; exit 7"}, .log = log.path});
    ASSERT_FALSE(ended);
    EXPECT_EQ(ended.error().code, Code::Io);
    for (const char* part : {"exit status 7", "no space", log.path.c_str()})
        EXPECT_NE(ended.error().message.find(part), std::string::npos) << ended.error().message;
    const Status killed = runProgram({.arguments = {"sh", "-c", "kill -9 $$"}, .log = log.path});
    ASSERT_FALSE(killed);
    EXPECT_NE(killed.error().message.find("signal 9"), std::string::npos) << killed.error().message;
}

TEST(Program, missingProgramIsNotFound) {
    LogFile log;
    for (const char* name : {"", "dpl-no-such-program", "/dpl/no/such/program", "/tmp"}) {
        const Status ended = runProgram({.arguments = {name}, .log = log.path});
        ASSERT_FALSE(ended) << name;
        EXPECT_EQ(ended.error().code, Code::NotFound) << name;
        EXPECT_FALSE(findProgram(name)) << name;
    }
    EXPECT_EQ(runProgram({.arguments = {}, .log = log.path}).error().code, Code::NotFound);
}

/** Whether the process is there and has not ended (a zombie has). */
bool runs(pid_t process) {
    std::ifstream stat("/proc/" + std::to_string(process) + "/stat");
    std::string id, name, state;
    return bool(stat >> id >> name >> state) && state != "Z";
}

TEST(Program, cancelEndsProgramAndChildrenWithinASecond) {
    LogFile log;
    std::atomic<bool> cancel{false};
    pid_t grandchild = 0;
    // A program that ignores SIGTERM, and a child of it.
    ProgramRun run{.arguments = {"sh", "-c", "trap '' TERM; sleep 60 & echo $!; wait; sleep 60"}, .log = log.path, .cancel = &cancel};
    std::chrono::steady_clock::time_point asked;
    run.line = [&](std::string_view line) {
        grandchild = pid_t(std::stoi(std::string(line)));
        asked = std::chrono::steady_clock::now();
        cancel = true;
    };
    const Status ended = runProgram(run);
    const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - asked).count();
    ASSERT_FALSE(ended);
    EXPECT_EQ(ended.error().code, Code::Cancelled);
    EXPECT_LT(seconds, 1.0);
    ASSERT_GT(grandchild, 0);
    for (int wait = 0; wait < 100 && runs(grandchild); ++wait) std::this_thread::sleep_for(std::chrono::milliseconds(10));
    EXPECT_FALSE(runs(grandchild));
}

TEST(Program, timeoutsEndPrograms) {
    LogFile log;
    const auto started = std::chrono::steady_clock::now();
    const Status ended = runProgram({.arguments = {"sleep", "30"}, .log = log.path, .timeoutS = 0.2});
    ASSERT_FALSE(ended);
    EXPECT_EQ(ended.error().code, Code::Io);
    EXPECT_NE(ended.error().message.find("more than 0.2 s"), std::string::npos) << ended.error().message;
    EXPECT_LT(std::chrono::steady_clock::now() - started, std::chrono::seconds(10));
}

TEST(Program, carriageReturnsEndLines) {
    LogFile log;
    std::vector<std::string> lines;
    ProgramRun run{.arguments = {"printf", "1 of 2\\r2 of 2\\rdone"}, .log = log.path};
    run.line = [&](std::string_view line) { lines.emplace_back(line); };
    ASSERT_TRUE(runProgram(run));
    EXPECT_EQ(lines, (std::vector<std::string>{"1 of 2", "2 of 2", "done"}));
}

std::vector<uint8_t> bytesOf(const std::string& text) {
    return {text.begin(), text.end()};
}

TEST(FedProgram, inputReachesTheProgram) {
    LogFile log;
    auto fed = FedProgram::start({.arguments = {"sh", "-c", "read line; echo \"got $line\"; wc -c"}, .log = log.path});
    ASSERT_TRUE(fed) << fed.error().message;
    ASSERT_TRUE((*fed)->write(bytesOf("$(exit 3)\n")));
    const std::vector<uint8_t> much(3 << 20, 'x');  // more than any socket holds
    ASSERT_TRUE((*fed)->write(much));
    const Status ended = (*fed)->finish();
    ASSERT_TRUE(ended) << ended.error().message;
    EXPECT_EQ(log.text(), "got $(exit 3)\n3145728\n");
}

TEST(FedProgram, aProgramThatStopsReadingIsAnErrorWithItsLastLine) {
    auto fed = FedProgram::start({.arguments = {"sh", "-c", "exec <&-; echo disk full; exit 4"}});
    ASSERT_TRUE(fed) << fed.error().message;
    const std::vector<uint8_t> much(1 << 20, 'x');
    Status written;
    while (written) written = (*fed)->write(much);  // without a SIGPIPE
    const Status ended = (*fed)->finish();
    ASSERT_FALSE(ended);
    for (const char* part : {"exit status 4", "disk full"})
        EXPECT_NE(ended.error().message.find(part), std::string::npos) << ended.error().message;
}

TEST(FedProgram, leavingItEndsTheProgram) {
    const auto started = std::chrono::steady_clock::now();
    {
        auto fed = FedProgram::start({.arguments = {"sleep", "60"}});
        ASSERT_TRUE(fed) << fed.error().message;
    }
    EXPECT_LT(std::chrono::steady_clock::now() - started, std::chrono::seconds(5));
    EXPECT_EQ(FedProgram::start({.arguments = {"dpl-no-such-program"}}).error().code, Code::NotFound);
}

}  // namespace
}  // namespace dpl
