// SPDX-License-Identifier: Apache-2.0
// The page of doppel share, from a run's folder. tests/web opens one in a browser.
#include "reconstruction/run/share.h"

#include <gtest/gtest.h>

#include "reconstruction/run/live_person.h"
#include "tests/unit/recon_page/module_folder.h"
#include "tests/unit/recon_run/toy_reconstruction.h"

namespace dpl::test {
namespace {

namespace fs = std::filesystem;

std::vector<uint8_t> fromBase64(const std::string& text) {
    std::vector<uint8_t> bytes;
    uint32_t word = 0;
    int bits = 0;
    for (const char c : text) {
        const size_t value = std::string_view("ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/").find(c);
        if (value == std::string::npos) break;
        word = word << 6 | uint32_t(value);
        if ((bits += 6) >= 8) bytes.push_back(uint8_t(word >> (bits -= 8)));
    }
    return bytes;
}

class Share : public testing::Test {
protected:
    Share() {
        AvatarData avatar = toy_.avatar;
        avatar.name = "scan-of-tuesday";
        avatar.evidence = {{"light", false, 0.1f, 0, "xxh3:0123456789abcdef of /home/somebody/scan-of-tuesday"}};
        run_ = toy_.folder / "run";
        fs::create_directories(run_);
        file_ = must(writeAvatar(avatar, {.compact = true}));
        write(run_ / "avatar.glb", {file_.begin(), file_.end()});
        write(run_ / "report.html", "a photograph of scan-of-tuesday");
        options_ = {run_, toy_.folder / "ada.html", module_.path, "", "CC0-1.0", 2};
    }
    static void write(const fs::path& path, const std::string& text) {
        if (const Status done = writeFileAtomically(path, text); !done) throw std::runtime_error(done.error().message);
    }
    std::string page() const {
        const auto bytes = must(readFile(options_.out));
        return {bytes.begin(), bytes.end()};
    }
    static std::string block(const std::string& page, const std::string& id) {
        const size_t from = page.find("id=" + id + ">") + id.size() + 4;
        return page.substr(from, page.find('<', from) - from);
    }

    ToyReconstruction toy_;
    ModuleFolder module_;
    fs::path run_;
    std::vector<uint8_t> file_;
    ShareOptions options_;
};

TEST_F(Share, tellsNothingOfTheScan) {
    must(shareAvatar(options_));
    const std::string html = page();
    const std::vector<uint8_t> avatar = fromBase64(block(html, "dpl-avatar"));
    const std::string inside(avatar.begin(), avatar.end());
    for (const std::string& text : {html, inside})
        for (const char* word : {"tuesday", "xxh3:0123", "somebody", "/home", "/tmp", "doppel reconstruct"})
            EXPECT_EQ(text.find(word), std::string::npos) << word;
    size_t pictures = 0;
    for (size_t at = html.find("data:image"); at != std::string::npos; at = html.find("data:image", at + 1)) ++pictures;
    EXPECT_EQ(pictures, 1u) << "the drawn one";
    const AvatarData shown = must(readAvatar(avatar));
    EXPECT_EQ(shown.name, "ada") << "as the page is called";
    EXPECT_EQ(shown.splats.count(), toy_.avatar.splats.count());
}

TEST_F(Share, aFileGivesTheSamePageAsItsRun) {
    must(shareAvatar(options_));
    const std::string ofRun = page();
    options_.from = run_ / "avatar.glb";
    must(shareAvatar(options_));
    EXPECT_EQ(page(), ofRun);
    options_.name = "Ada", options_.licence.clear();
    must(shareAvatar(options_));
    EXPECT_NE(page().find("<title>Ada</title>"), std::string::npos);
    EXPECT_NE(page().find("Licence: not stated"), std::string::npos);
}

TEST_F(Share, errorsNameTheFileAndTheRemedy) {
    const auto sentence = [this] {
        const auto done = shareAvatar(options_);
        return done ? std::string("no error") : done.error().message;
    };
    module_.remove("live-bundle.js");
    EXPECT_NE(sentence().find("live-bundle.js, a part of the web module; install the package doppel-tools, or build"), std::string::npos);
    module_.write("live-bundle.js", "1;");
    fs::remove(run_ / "avatar.glb");
    EXPECT_NE(sentence().find("holds no avatar.glb; finish its run with doppel reconstruct"), std::string::npos) << sentence();
    options_.from = toy_.folder / "nobody.glb";
    EXPECT_NE(sentence().find("nobody.glb"), std::string::npos);
    options_.from = run_ / "cut.glb";
    write(options_.from, {file_.begin(), file_.begin() + ptrdiff_t(file_.size() / 2)});
    EXPECT_NE(sentence().find("cut.glb"), std::string::npos);
    EXPECT_FALSE(fs::exists(options_.out)) << "no page of an error";
}

TEST_F(Share, theReportMovesWithAModuleAndSaysSoWithout) {
    ReportData data;
    ASSERT_TRUE(bringToLife(module_.path, file_, toy_.avatar, data));
    ASSERT_TRUE(data.live);
    EXPECT_TRUE(data.whyStill.empty());
    EXPECT_EQ(must(readAvatar(data.live->avatar)).name, "scan-of-tuesday") << "the report is for who has the scan";
    const std::string key = livePageKey(module_.path);
    module_.write("live.css", "#person{margin:1px}");
    EXPECT_NE(livePageKey(module_.path), key) << "another module makes another report";
    module_.remove("doppel.wasm.lzma");
    ReportData still;
    ASSERT_TRUE(bringToLife(module_.path, file_, toy_.avatar, still));
    EXPECT_FALSE(still.live);
    EXPECT_NE(still.whyStill.find("tools/prove-web --build. Then run the same command again."), std::string::npos);
    ReportData unasked;
    ASSERT_TRUE(bringToLife({}, file_, toy_.avatar, unasked));
    EXPECT_TRUE(unasked.whyStill.empty() && !unasked.live);
}

}  // namespace
}  // namespace dpl::test
