// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "reconstruction/output/page/html_text.h"
#include "reconstruction/output/page/live_page.h"
#include "reconstruction/output/page/shown_avatar.h"
#include "sdk/format/avatar_file.h"
#include "tests/reference/random_avatar.h"
#include "tests/unit/must.h"
#include "tests/unit/recon_page/module_folder.h"

namespace dpl::test {
namespace {

ClipData nod(const char* name) {
    return {name, {0, 0.5f, 1}, {{1, {Quatf(1, 0, 0, 0), glm::normalize(Quatf(0.9f, 0.4f, 0, 0)), Quatf(1, 0, 0, 0)}}}, {}};
}

std::vector<uint8_t> bytesOf(const AvatarData& avatar, const WriteOptions& options = {}) {
    return must(writeAvatar(avatar, options));
}

AvatarData filmed() {
    AvatarData avatar = randomAvatar(3);
    avatar.name = "scan-of-tuesday";
    avatar.clips = {nod("scan-motion")};
    avatar.evidence = {{"light", false, 0.1f, 0, "9 frames of /home/ada/scan"}};
    return avatar;
}

TEST(HtmlText, base64PadsByTheStandard) {
    const auto of = [](std::string_view text) { return base64({reinterpret_cast<const uint8_t*>(text.data()), text.size()}); };
    EXPECT_EQ(of(""), "");  // the examples of RFC 4648
    EXPECT_EQ(of("f"), "Zg==");
    EXPECT_EQ(of("fo"), "Zm8=");
    EXPECT_EQ(of("foo"), "Zm9v");
    EXPECT_EQ(of("foobar"), "Zm9vYmFy");
}

TEST(ShownAvatar, isTheSameToLookAtInEveryCoding) {
    for (const WriteOptions& options : {WriteOptions{}, WriteOptions{.compact = true}}) {
        const std::vector<uint8_t> file = bytesOf(filmed(), options);
        const std::vector<uint8_t> shown = must(shownAvatar(file, {.moreClips = {}, .nameInstead = {}}));
        EXPECT_EQ(shown, file) << "nothing was asked for";
        const AvatarInfo before = must(inspectAvatar(file)),
                         after = must(inspectAvatar(
                             must(shownAvatar(file, {.moreClips = {nod("walk")}, .nameInstead = "Ada", .withoutEvidence = true}))));
        EXPECT_EQ(after.splatEncoding, before.splatEncoding);
        EXPECT_EQ(after.splatBytes, before.splatBytes);
        EXPECT_EQ(after.shBytes, before.shBytes);
        EXPECT_EQ(after.meshBytes, before.meshBytes);
    }
}

TEST(ShownAvatar, takesClipsAndANameAndLeavesOutWhatWasMeasured) {
    const std::vector<uint8_t> file = bytesOf(filmed());
    const AvatarData shown = must(readAvatar(
        must(shownAvatar(file, {.moreClips = {nod("walk"), nod("scan-motion")}, .nameInstead = "Ada", .withoutEvidence = true}))));
    EXPECT_EQ(shown.name, "Ada");
    EXPECT_TRUE(shown.evidence.empty());
    ASSERT_EQ(shown.clips.size(), 2u) << "a name that is there stays with its clip";
    EXPECT_EQ(shown.clips[0].name, "scan-motion");
    EXPECT_EQ(shown.clips[1].name, "walk");
}

TEST(ShownAvatar, damagedBytesAndClipsOfAnotherRigAreErrors) {
    std::vector<uint8_t> file = bytesOf(filmed());
    ClipData strange = nod("walk");
    strange.channels[0].joint = 99;
    EXPECT_EQ(shownAvatar(file, {.moreClips = {strange}, .nameInstead = {}}).error().code, Code::InvalidArgument);
    file.resize(file.size() / 2);
    EXPECT_FALSE(shownAvatar(file, {}));
}

TEST(WebModule, everyMissingPartIsNamedWithTheRemedy) {
    const ModuleFolder folder;
    ASSERT_TRUE(readWebModule(folder.path));
    for (const char* name : {"doppel.wasm.lzma", "live-bundle.js", "live.css"}) {
        const ModuleFolder lacking;
        lacking.remove(name);
        const auto module = readWebModule(lacking.path);
        ASSERT_FALSE(module) << name;
        EXPECT_EQ(module.error().code, Code::NotFound);
        EXPECT_NE(module.error().message.find(name), std::string::npos) << module.error().message;
        EXPECT_NE(module.error().message.find("tools/prove-web --build"), std::string::npos) << module.error().message;
        lacking.write(name, "");
        EXPECT_EQ(readWebModule(lacking.path).error().code, Code::CorruptData) << name;
    }
}

TEST(WebModule, whatWouldEndItsElementIsRefused) {
    const ModuleFolder folder;
    for (const auto& [name, text] :
         {std::pair{"live-bundle.js", "x = '</ScRipt>';"}, {"live-bundle.js", "<!-- "}, {"live.css", "</style>"}}) {
        const ModuleFolder odd;
        odd.write(name, text);
        EXPECT_EQ(readWebModule(odd.path).error().code, Code::CorruptData) << text;
    }
    folder.write("doppel.wasm.lzma", std::string(40, '\xff'));
    EXPECT_EQ(readWebModule(folder.path).error().code, Code::CorruptData);
}

TEST(SharePage, holdsAPictureTheBytesAndTheWordsAsText) {
    const ModuleFolder folder;
    const WebModule module = must(readWebModule(folder.path));
    const std::vector<uint8_t> avatar = {1, 2, 3, 4};
    const std::string page = sharePage({"Ada <script>alert(1)</script>\"", "CC0-1.0", {9, 9}, avatar}, module);
    EXPECT_EQ(page.find("<script>alert"), std::string::npos);
    EXPECT_NE(page.find("<title>Ada &lt;script&gt;alert(1)&lt;/script&gt;&quot;</title>"), std::string::npos);
    EXPECT_NE(page.find("<meta name=\"dcterms.license\" content=\"CC0-1.0\">"), std::string::npos);
    EXPECT_NE(page.find("id=dpl-avatar>" + base64(avatar) + "</script>"), std::string::npos);
    EXPECT_NE(page.find("id=dpl-module>" + base64(module.packed) + "</script>"), std::string::npos);
    EXPECT_NE(page.find("data:image/jpeg;base64,CQk="), std::string::npos);
    EXPECT_EQ(page.find("http"), std::string::npos) << "the page needs no network";
    EXPECT_NE(sharePage({"Ada", "", {}, avatar}, module).find("Licence: not stated"), std::string::npos);
}

}  // namespace
}  // namespace dpl::test
