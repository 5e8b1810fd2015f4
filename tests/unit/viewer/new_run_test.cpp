// SPDX-License-Identifier: Apache-2.0
#include "apps/viewer/new_run.h"

#include "tests/unit/must.h"
#include "tests/unit/viewer/stand_in.h"

namespace {

using namespace dpl;
namespace fs = std::filesystem;
using Words = std::vector<std::string>;
using Role = NewRun::Role;

class NewRunTest : public test::FolderTest {
protected:
    void write(const fs::path& file, std::string_view text = "{}") const {
        fs::create_directories((folder_ / file).parent_path());
        EXPECT_TRUE(writeFileAtomically(folder_ / file, text));
    }
};

TEST_F(NewRunTest, aScanFolderGetsAFolderBeside) {
    const NewRun run = newRunOf({folder_ / "ada"});
    EXPECT_EQ(run.scan, folder_ / "ada");
    EXPECT_EQ(run.out, folder_ / "ada-avatar");
    write("ada-avatar/notes.txt");
    EXPECT_EQ(newRunOf({folder_ / "ada"}).out, folder_ / "ada-avatar-2") << "what is no run is left alone";
    write("ada-avatar/run.json");
    EXPECT_EQ(newRunOf({folder_ / "ada"}).out, folder_ / "ada-avatar") << "an earlier run goes on";
}

TEST_F(NewRunTest, videosGetTheirPartsByTheirNames) {
    EXPECT_EQ(newRunOf({"/f/orbit.mp4"}).scan, "/f/orbit.mp4") << "one video holds everything";
    const NewRun run = newRunOf({"/f/orbit.mp4", "/f/Face.MOV", "/f/moves.mp4"});
    EXPECT_TRUE(run.scan.empty());
    EXPECT_EQ(run.videos,
              (std::vector<NewRun::Video>{{"/f/orbit.mp4", Role::Still}, {"/f/Face.MOV", Role::Closeup}, {"/f/moves.mp4", Role::Moving}}));
    EXPECT_EQ(reconstructArguments("/bin/doppel", run),
              (Words{"/bin/doppel", "reconstruct", "--static", "/f/orbit.mp4", "--closeup", "/f/Face.MOV", "--motion", "/f/moves.mp4", "-o",
                     "/f/orbit-avatar", "--preset", "standard"}));
}

TEST_F(NewRunTest, thePresetAndTheBudgetReachTheProgram) {
    NewRun run = newRunOf({"/f/scan"});
    EXPECT_EQ(checkArguments("doppel", run), (Words{"doppel", "check", "/f/scan", "-o", "/f/scan-avatar", "--json"}));
    run.preset = NewRun::Preset::Draft, run.minutes = 20;
    EXPECT_EQ(reconstructArguments("doppel", run),
              (Words{"doppel", "reconstruct", "/f/scan", "-o", "/f/scan-avatar", "--preset", "draft", "--time-budget", "20"}));
}

TEST_F(NewRunTest, knowsFilmsFromOtherFolders) {
    EXPECT_TRUE(isVideoName("a.MP4") && isVideoName("b.mov"));
    EXPECT_FALSE(isVideoName("mp4") || isVideoName("a.glb"));
    write("empty/a.txt"), write("scan/scan.json"), write("photos/IMG_1.JPG"), write("colmap/sparse/0/cameras.bin");
    EXPECT_FALSE(isCaptureFolder(folder_ / "empty"));
    EXPECT_FALSE(isCaptureFolder(folder_ / "none"));
    for (const char* film : {"scan", "photos", "colmap"}) EXPECT_TRUE(isCaptureFolder(folder_ / film)) << film;
}

TEST_F(NewRunTest, readsTheCoach) {
    const CoachWords words = must(parseCoachWords(
        {"  looking", R"({"advice":"Film the feet\nand hands","first_look":[{"fault":"dark","sentence":"It is dark."}]})"}));
    EXPECT_EQ(words.advice, "Film the feet\nand hands");
    EXPECT_EQ(words.faults, (Words{"It is dark."}));
    const auto refused = parseCoachWords({R"({"error":{"code":"unsupported","message":"No person is in view."}})"});
    ASSERT_FALSE(refused);
    EXPECT_EQ(refused.error().message, "No person is in view.");
    for (const char* damaged : {"", "{", "{}", R"({"advice":1,"first_look":[]})", R"({"advice":"a","first_look":[{}]})"})
        EXPECT_FALSE(parseCoachWords({damaged})) << damaged;
}

TEST_F(NewRunTest, aLaterStartGoesOnWithTheSameRun) {
    NewRun run = newRunOf({"/f/orbit.mp4", "/f/face.mov"});
    run.preset = NewRun::Preset::High, run.minutes = 90, run.out = folder_;
    write(kRunRequest, runRequestToJson(run));
    const auto read = readRunRequest(folder_);
    ASSERT_TRUE(read);
    EXPECT_EQ(*read, run);
    run = newRunOf({"/f/scan"});
    EXPECT_EQ(parseRunRequest(runRequestToJson(run), run.out), run);
}

TEST_F(NewRunTest, hostileRequestsAreRefused) {
    const std::string good = runRequestToJson(newRunOf({"/f/scan"}));
    ASSERT_TRUE(parseRunRequest(good, "/o"));
    for (size_t cut = 0; cut + 2 < good.size(); ++cut) EXPECT_FALSE(parseRunRequest(good.substr(0, cut), "/o")) << cut;
    for (const auto& [part, other] : {std::pair<std::string, std::string>{"doppel-viewer-run", "doppel-run"},
                                      {"/f/scan\"", "--replace\""},
                                      {"/f/scan\"", "\""},
                                      {"standard", "best"},
                                      {"\"minutes\": 0", "\"minutes\": -1"},
                                      {"\"minutes\": 0", "\"minutes\": 1e9"},
                                      {"[]", "[{\"file\":\"-x\",\"role\":\"static\"}]"},
                                      {"[]", "[{\"file\":\"/x\",\"role\":\"any\"}]"},
                                      {"[]", "[{\"file\":\"/x\",\"role\":\"static\"}]"}}) {
        std::string bad = good;
        ASSERT_NE(bad.find(part), bad.npos) << part;
        bad.replace(bad.find(part), part.size(), other);
        EXPECT_FALSE(parseRunRequest(bad, "/o")) << bad;
    }
    EXPECT_FALSE(readRunRequest(folder_ / "none"));
}

}  // namespace
