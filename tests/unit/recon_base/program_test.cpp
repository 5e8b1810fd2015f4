// SPDX-License-Identifier: Apache-2.0
// Programs are started without a shell, their output is kept, and a cancel ends them and their children. Programs that must be ended would
// run for ten minutes and then write a file; tools/prove-resume measures how soon they end.
#include "reconstruction/base/program.h"

#include <gtest/gtest.h>
#include <signal.h>
#include <unistd.h>

#include <fstream>
#include <sstream>

#include "tests/unit/wait_until.h"

namespace dpl {
namespace {

namespace fs = std::filesystem;

struct LogFile {
    fs::path path;
    explicit LogFile(const std::string& name = "log")
        : path(fs::temp_directory_path() / ("dpl_program_" + std::to_string(::getpid()) + "." + name)) {
        fs::remove(path);
    }
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

TEST(Program, cancelEndsProgramAndChildren) {
    LogFile log, late("late");
    std::atomic<bool> cancel{false};
    pid_t grandchild = 0;
    // A program that ignores SIGTERM, and a child of it.
    ProgramRun run{.arguments = {"sh", "-c", "trap '' TERM; sleep 600 & echo $!; wait; sleep 600; echo >$LATE"},
                   .environment = {"LATE=" + late.path.string()},
                   .log = log.path,
                   .cancel = &cancel};
    run.line = [&](std::string_view line) {
        grandchild = pid_t(std::stoi(std::string(line)));
        cancel = true;
    };
    const Status ended = runProgram(run);
    ASSERT_FALSE(ended);
    EXPECT_EQ(ended.error().code, Code::Cancelled);
    EXPECT_FALSE(fs::exists(late.path)) << "it was killed";
    ASSERT_GT(grandchild, 0);
    EXPECT_TRUE(test::waitUntil([&] { return !runs(grandchild); }));
}

TEST(Program, timeoutsEndPrograms) {
    LogFile log, late("late");
    const Status ended = runProgram({.arguments = {"sh", "-c", "sleep 600; echo >$LATE"},
                                     .environment = {"LATE=" + late.path.string()},
                                     .log = log.path,
                                     .timeoutS = 0.2});
    ASSERT_FALSE(ended);
    EXPECT_EQ(ended.error().code, Code::Io);
    EXPECT_NE(ended.error().message.find("more than 0.2 s"), std::string::npos) << ended.error().message;
    EXPECT_FALSE(fs::exists(late.path)) << "it was killed";
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
    LogFile late("late");
    {
        auto fed = FedProgram::start({.arguments = {"sh", "-c", "sleep 600; echo >$LATE"}, .environment = {"LATE=" + late.path.string()}});
        ASSERT_TRUE(fed) << fed.error().message;
    }
    EXPECT_FALSE(fs::exists(late.path)) << "it was killed";
    EXPECT_EQ(FedProgram::start({.arguments = {"dpl-no-such-program"}}).error().code, Code::NotFound);
}

}  // namespace
}  // namespace dpl
