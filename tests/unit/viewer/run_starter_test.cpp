// SPDX-License-Identifier: Apache-2.0
#include "apps/viewer/run_starter.h"

#include <sys/stat.h>

#include <csignal>
#include <thread>

#include "reconstruction/base/folder_lock.h"
#include "tests/unit/must.h"
#include "tests/unit/viewer/stand_in.h"
#include "tests/unit/wait_until.h"

namespace {

using namespace dpl;
namespace fs = std::filesystem;
using Step = RunStarter::Step;

/** Programs that stand in for doppel find the output folder after -o. */
class RunStarterTest : public test::FolderTest {
protected:
    fs::path doppel(const std::string& check, const std::string& reconstruct) const {
        return program("way=$1\nwhile [ \"$1\" != -o ]; do shift; done\nout=$2\ncase $way in\ncheck) " + check + ";;\nreconstruct) " +
                       reconstruct + ";;\nesac");
    }
    bool comesTo(RunStarter& starter, Step step) const {
        return test::waitUntil([&] { return starter.tick(), starter.step() == step; });
    }
    std::string text(const char* file) const {
        const auto bytes = readFile(out_ / file);
        return bytes ? std::string(bytes->begin(), bytes->end()) : "";
    }

    const fs::path out_ = folder_ / "scan-avatar";
};

constexpr const char* kGoodFilm = R"(echo '{"advice":"Film the feet","first_look":[]}')";
constexpr const char* kDarkFilm = R"(echo '{"advice":"","first_look":[{"fault":"dark","sentence":"It is dark."}]}')";
constexpr const char* kTells = "echo begun; echo '{}' >\"$out/progress.json\"";

TEST_F(RunStarterTest, aGoodFilmIsMadeIntoAnAvatarAtOnce) {
    RunStarter starter(newRunOf({folder_ / "scan"}));
    starter.look(doppel(kGoodFilm, kTells));
    EXPECT_EQ(starter.step(), Step::Looking);
    ASSERT_TRUE(comesTo(starter, Step::Started)) << starter.problem();
    EXPECT_EQ(starter.coach().advice, "Film the feet");
    EXPECT_EQ(text(kRunLog), "begun\n");
    EXPECT_EQ(must(parseCoachWords({"{\"advice\":\"\",\"first_look\":[]}"})).advice, "");
    EXPECT_EQ(readRunRequest(out_), starter.run);
}

TEST_F(RunStarterTest, theUserDecidesOnAFilmWithFaults) {
    const fs::path program = doppel(kDarkFilm, kTells);
    RunStarter starter(newRunOf({folder_ / "scan"}));
    starter.look(program);
    ASSERT_TRUE(comesTo(starter, Step::Advised)) << starter.problem();
    EXPECT_EQ(starter.coach().faults, std::vector<std::string>{"It is dark."});
    EXPECT_FALSE(fs::exists(out_)) << "nothing was begun";
    starter.begin(program);
    EXPECT_TRUE(comesTo(starter, Step::Started)) << starter.problem();
}

TEST_F(RunStarterTest, aRefusedFilmIsASentence) {
    RunStarter starter(newRunOf({folder_ / "scan"}));
    starter.look(
        doppel("echo 'doppel: No person is in view.' >&2; echo '{\"error\":{\"message\":\"No person is in view.\"}}'; exit 1", kTells));
    ASSERT_TRUE(comesTo(starter, Step::Choosing));
    EXPECT_EQ(starter.problem(), "No person is in view.");
    starter.look(folder_ / "none");
    ASSERT_TRUE(comesTo(starter, Step::Choosing));
    EXPECT_NE(starter.problem().find("is not installed"), std::string::npos) << starter.problem();
}

TEST_F(RunStarterTest, goingBackEndsTheLook) {
    RunStarter starter(newRunOf({folder_ / "scan"}));
    starter.look(doppel("exec cat /dev/zero >/dev/null", kTells));
    starter.back();
    EXPECT_EQ(starter.step(), Step::Choosing);
    EXPECT_EQ(starter.problem(), "");
}

TEST_F(RunStarterTest, aRunThatEndsAtOnceSaysWhy) {
    RunStarter starter(newRunOf({folder_ / "scan"}));
    starter.begin(doppel("", "echo doppel: install COLMAP >&2; echo 'and ffmpeg'; exit 1"));
    ASSERT_TRUE(comesTo(starter, Step::Choosing));
    EXPECT_EQ(starter.problem(), "install COLMAP\nand ffmpeg");
    EXPECT_TRUE(writeFileAtomically(folder_ / "file", std::string_view("")));
    starter.run.out = folder_ / "file" / "out";
    starter.begin(doppel("", kTells));
    ASSERT_TRUE(comesTo(starter, Step::Choosing));
    EXPECT_NE(starter.problem().find("cannot create"), std::string::npos) << starter.problem();
}

TEST_F(RunStarterTest, theRunHasASessionOfItsOwnAndOutlivesTheViewer) {
    const fs::path fifo = folder_ / "go";
    ASSERT_EQ(::mkfifo(fifo.c_str(), 0600), 0);
    {
        RunStarter starter(newRunOf({folder_ / "scan"}));
        starter.begin(doppel("", "cut -d' ' -f6 /proc/$$/stat >\"$out/session\"; echo '{}' >\"$out/progress.json\"; read word <" +
                                     fifo.string() + "; echo $word >\"$out/end\""));
        ASSERT_TRUE(comesTo(starter, Step::Started)) << starter.problem();
    }  // as when the viewer is closed
    EXPECT_NE(text("session"), std::to_string(::getsid(0)) + "\n");
    EXPECT_TRUE(writeFileAtomically(fifo, std::string_view("on\n")));
    EXPECT_TRUE(test::waitUntil([&] { return text("end") == "on\n"; }));
}

TEST_F(RunStarterTest, closingTheViewerWaitsForNoRunThatTellsNothing) {
    const fs::path fifo = folder_ / "go";
    ASSERT_EQ(::mkfifo(fifo.c_str(), 0600), 0);
    {
        RunStarter starter(newRunOf({folder_ / "scan"}));
        starter.begin(doppel("", "echo begun; read word <" + fifo.string()));
        ASSERT_TRUE(test::waitUntil([&] { return text(kRunLog) == "begun\n"; }));
    }
    EXPECT_TRUE(writeFileAtomically(fifo, std::string_view("end\n")));
}

TEST_F(RunStarterTest, stopReachesTheProcessThatHoldsTheFolder) {
    fs::create_directories(out_);
    EXPECT_FALSE(processOfRun(out_));
    static volatile sig_atomic_t interrupted = 0;
    const auto before = std::signal(SIGINT, [](int) { interrupted = 1; });
    {
        auto lock = std::make_unique<FolderLock>(must(FolderLock::take(out_)));
        EXPECT_EQ(must(processOfRun(out_)), ::getpid());
        std::thread run([&lock] {  // ends when it is interrupted
            EXPECT_TRUE(test::waitUntil([] { return interrupted == 1; }));
            lock.reset();
        });
        EXPECT_TRUE(stopRun(out_));
        run.join();
        EXPECT_EQ(interrupted, 1);
        EXPECT_TRUE(writeFileAtomically(folder_ / "run.lock", std::string_view("since 2026 (process 1)\n")));
        EXPECT_FALSE(processOfRun(folder_)) << "a file alone names nobody";
    }
    std::signal(SIGINT, before);
    EXPECT_FALSE(processOfRun(out_)) << "nobody holds it any more";
    const Status stopped = stopRun(out_);
    ASSERT_FALSE(stopped);
    EXPECT_NE(stopped.error().message.find("scan-avatar"), std::string::npos) << stopped.error().message;
}

}  // namespace
