// SPDX-License-Identifier: Apache-2.0
#include "apps/viewer/exports.h"

#include "sdk/format/avatar_file.h"
#include "sdk/format/ply.h"
#include "tests/package/tiny_avatar.h"
#include "tests/unit/must.h"
#include "tests/unit/viewer/stand_in.h"
#include "tests/unit/wait_until.h"

namespace {

using namespace dpl;
using test::waitUntil;
namespace fs = std::filesystem;
using Words = std::vector<std::string>;

class ExportsTest : public test::FolderTest {
protected:
    ViewedSubject avatar() {
        AvatarData data = test::tinyAvatar();
        sortSplats(data);
        return subject(must(writeAvatar(data)), "ada.glb");
    }
    ViewedSubject subject(const std::vector<uint8_t>& bytes, const std::string& file) {
        auto avatar = context_->loadAvatar(bytes);
        EXPECT_TRUE(avatar) << avatar.error().message;
        ViewedSubject made = must(ViewedSubject::of(std::move(*avatar), file));
        made.path = "/runs/" + file;
        return made;
    }
    /** The end of an export. */
    static Status endOf(FileExport& made) {
        std::optional<Status> end;
        EXPECT_TRUE(waitUntil([&] { return (end = made.finished()).has_value(); }));
        return end ? *end : fail(Code::Internal, "it goes on");
    }
    size_t entries() const { return size_t(std::distance(fs::directory_iterator(folder_ / "out"), fs::directory_iterator())); }
    std::unique_ptr<FileExport> begin(const std::string& script) {
        const fs::path doppel = program(script);
        return must(FileExport::begin(folder_ / "out" / "ada-1.ply", [&](const fs::path& out) {
            return Words{doppel.string(), out.string()};
        }));
    }

    doppel::Result<doppel::Context> context_ = doppel::Context::create(DPL_RENDERER_SOFTWARE, 1);
};

TEST_F(ExportsTest, everyKindHasItsWords) {
    for (size_t i = 0; i < kExportKinds.size(); ++i) EXPECT_EQ(size_t(kExportKinds[i].kind), i);
}

TEST_F(ExportsTest, saysWhatIsMissing) {
    EXPECT_EQ(whyNotExport(ExportKind::Picture, nullptr, nullptr), "");
    for (const ExportKindWords& words : kExportKinds) {
        const bool drawn = words.kind == ExportKind::Picture;
        EXPECT_EQ(whyNotExport(words.kind, nullptr, nullptr).empty(), drawn) << words.name;
    }
    ViewedSubject ada = avatar();
    for (const ExportKindWords& words : kExportKinds) EXPECT_EQ(whyNotExport(words.kind, &ada, &ada), "") << words.name;
    ada.clip.reset();
    EXPECT_NE(whyNotExport(ExportKind::Clip, &ada, nullptr), "");
    ViewedSubject walker = avatar();
    EXPECT_EQ(whyNotExport(ExportKind::Clip, &ada, &walker), "") << "another one plays a clip, as beside splats";
    ada.path.clear();
    EXPECT_NE(whyNotExport(ExportKind::SplatsPly, &ada, &ada), "");
    EXPECT_EQ(whyNotExport(ExportKind::Turntable, &ada, &ada), "");
}

TEST_F(ExportsTest, namesTheNextFreeFileAfterTheSubject) {
    const ViewedSubject ada = avatar();
    EXPECT_EQ(exportFile(ExportKind::SplatsSpz, &ada, folder_), folder_ / "ada-1.spz");
    ASSERT_TRUE(writeFileAtomically(folder_ / "ada-1.spz", std::string_view("x")));
    EXPECT_EQ(exportFile(ExportKind::SplatsSpz, &ada, folder_), folder_ / "ada-2.spz");
    EXPECT_EQ(exportFile(ExportKind::Picture, nullptr, folder_), folder_ / "doppel-1.png");
}

TEST_F(ExportsTest, theProgramIsAskedForThePoseThatIsShown) {
    ViewedSubject ada = avatar();
    const std::string name = ada.clips[0].name;
    const Playback clock{.timeS = 2.25};  // of a clip that repeats each second
    EXPECT_EQ(exportArguments("/bin/doppel", ExportKind::SplatsGlb, ada, clock, "/x/a.glb"),
              (Words{"/bin/doppel", "export", "/runs/ada.glb", "-o", "/x/a.glb", "--clip=" + name, "--time=0.25"}));
    EXPECT_EQ(exportArguments("/bin/doppel", ExportKind::Mesh, ada, clock, "/x/a.glb"),
              (Words{"/bin/doppel", "export", "/runs/ada.glb", "-o", "/x/a.glb", "--mesh"}));
    ada.clips[0].from = "/motions/walk.bvh";
    EXPECT_EQ(exportArguments("/bin/doppel", ExportKind::Mesh, ada, clock, "/x/a.glb"),
              (Words{"/bin/doppel", "export", "/runs/ada.glb", "-o", "/x/a.glb", "--mesh", "--clip=/motions/walk.bvh"}));
    ada.clip.reset();
    EXPECT_EQ(exportArguments("/bin/doppel", ExportKind::SplatsPly, ada, clock, "/x/a.ply"),
              (Words{"/bin/doppel", "export", "/runs/ada.glb", "-o", "/x/a.ply"}));
}

TEST_F(ExportsTest, theFileAppearsWhenItIsComplete) {
    const auto made = begin("echo '  export              [############............]  50 %  1 s left  half' >&2; echo splats >\"$1\"");
    const Status end = endOf(*made);
    EXPECT_TRUE(end) << end.error().message;
    ASSERT_TRUE(made->job().progress());
    EXPECT_DOUBLE_EQ(made->job().progress()->share, 0.5);
    EXPECT_EQ(must(readFile(folder_ / "out" / "ada-1.ply")).size(), 7u);
}

TEST_F(ExportsTest, aFullDiskIsTheProgramsSentenceAndLeavesNothing) {
    auto made = begin("echo half >\"$1\"; echo hello; echo 'doppel: cannot write ada.ply: No space left on device' >&2; exit 1");
    const Status end = endOf(*made);
    ASSERT_FALSE(end);
    EXPECT_EQ(end.error().message, "cannot write ada.ply: No space left on device");
    made.reset();
    EXPECT_EQ(entries(), 0u);
}

TEST_F(ExportsTest, cancellingEndsTheProgramAndLeavesNothing) {
    auto made = begin("echo half >\"$1\"; echo begun; exec cat /dev/zero >/dev/null");
    ASSERT_TRUE(waitUntil([&] { return !made->job().lines().empty(); }));
    made->cancel();
    const Status end = endOf(*made);
    ASSERT_FALSE(end);
    EXPECT_EQ(end.error().code, Code::Cancelled);
    made.reset();
    EXPECT_EQ(entries(), 0u);
}

TEST_F(ExportsTest, closingTheViewerEndsTheProgramToo) {
    auto made = begin("echo half >\"$1\"; echo begun; exec cat /dev/zero >/dev/null");
    ASSERT_TRUE(waitUntil([&] { return !made->job().lines().empty(); }));
    made.reset();
    EXPECT_EQ(entries(), 0u);
}

TEST_F(ExportsTest, aMissingProgramIsASentence) {
    const auto made = must(FileExport::begin(folder_ / "out" / "a.ply", [](const fs::path&) { return Words{"/nowhere/doppel"}; }));
    const Status end = endOf(*made);
    ASSERT_FALSE(end);
    EXPECT_NE(end.error().message.find("'/nowhere/doppel' is not installed"), std::string::npos) << end.error().message;
}

TEST_F(ExportsTest, whatIsThereIsKept) {
    ASSERT_TRUE(writeFileAtomically(folder_ / "a.ply", std::string_view("mine")));
    const auto made = FileExport::begin(folder_ / "a.ply", [](const fs::path&) { return Words{"true"}; });
    ASSERT_FALSE(made);
    EXPECT_EQ(must(readFile(folder_ / "a.ply")).size(), 4u);
}

}  // namespace
