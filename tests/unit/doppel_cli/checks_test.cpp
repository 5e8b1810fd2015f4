// SPDX-License-Identifier: Apache-2.0
#include "apps/shared/checks.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>

namespace {

using namespace dpl;

bool accepts(const CLI::Validator& check, std::string text) {
    return check(text).empty();
}

TEST(InRange, takesFiniteNumbersBetweenItsEndsOnly) {
    const CLI::Validator check = inRange(0.5, 240);
    for (const char* good : {"0.5", "1", "24e0", "240"}) EXPECT_TRUE(accepts(check, good)) << good;
    for (const char* bad : {"nan", "NaN", "-nan", "inf", "-inf", "0.4", "240.001", "1e999", "", " 1", "1x", "0x10"})
        EXPECT_FALSE(accepts(check, bad)) << bad;
}

TEST(WholeNumber, takesDigitsUpToItsEndOnly) {
    for (const char* good : {"0", "7", "18446744073709551615"}) EXPECT_TRUE(accepts(isWholeNumber(), good)) << good;
    for (const char* bad : {"-1", "18446744073709551616", "1.5", "1e3", "+1", "0x10", ""})
        EXPECT_FALSE(accepts(isWholeNumber(), bad)) << bad;
    EXPECT_TRUE(accepts(isWholeNumber(UINT32_MAX), "4294967295"));
    EXPECT_FALSE(accepts(isWholeNumber(UINT32_MAX), "4294967296"));
}

TEST(PictureSize, isTwoWholeNumbersWithAnXBetween) {
    const auto size = parsePictureSize("720x1280");
    ASSERT_TRUE(size);
    EXPECT_EQ(size->widthPx, 720u);
    EXPECT_EQ(size->heightPx, 1280u);
    for (const char* bad : {"", "x", "720", "720x", "x720", "0x5", "5x0", "8193x1", "1x8193", "-1x5", "7.5x5", "5x5x5", "99999999999x1"})
        EXPECT_FALSE(parsePictureSize(bad)) << bad;
}

TEST(OutputFile, isRefusedBeforeTheWorkWhenItCouldNotBeWritten) {
    const auto folder = std::filesystem::temp_directory_path() / ("doppel_checks_" + std::to_string(::getpid()));
    std::filesystem::create_directories(folder);
    const auto in = [&](const char* name) { return (folder / name).string(); };
    const CLI::Validator glb = isOutputFile({".glb"});
    EXPECT_TRUE(accepts(glb, in("a.glb")));
    EXPECT_FALSE(accepts(glb, in("a.png"))) << "another ending";
    EXPECT_FALSE(accepts(glb, in("nowhere/a.glb"))) << "no such folder";
    EXPECT_FALSE(accepts(isOutputFile(), folder.string())) << "a folder is no file";
    EXPECT_TRUE(accepts(isOutputFile(), "/dev/stdout"));
    const CLI::Validator picture = isOutputFile({".png"}, /*orFolder=*/true);
    EXPECT_TRUE(accepts(picture, in("frames"))) << "a folder that does not exist yet";
    EXPECT_FALSE(accepts(picture, in("a.jpg")));
    std::filesystem::remove_all(folder);
}

TEST(InputAsOutput, isRefusedAlsoThroughLinks) {
    const auto folder = std::filesystem::temp_directory_path() / ("doppel_inputs_" + std::to_string(::getpid()));
    std::filesystem::create_directories(folder / "scan");
    const auto in = [&](const char* name) { return folder / name; };
    for (const char* name : {"a.glb", "b.glb"}) std::ofstream(in(name)) << name;
    std::filesystem::create_symlink("b.glb", in("link.glb"));
    std::filesystem::create_symlink("scan", in("scan-link"));
    EXPECT_NO_THROW(refuseInputAsOutput(in("a.glb"), {in("b.glb"), in("link.glb"), "", in("nowhere.glb")}));
    EXPECT_NO_THROW(refuseInputAsOutput(in("new.glb"), {in("a.glb"), ""}));
    EXPECT_THROW(refuseInputAsOutput(in("scan/../scan-link"), {in("scan")}), CLI::ValidationError);
    try {
        refuseInputAsOutput(in("link.glb"), {in("a.glb"), in("b.glb")});
        ADD_FAILURE() << "the input would be overwritten";
    } catch (const CLI::ValidationError& error) {
        EXPECT_EQ(error.what(),
                  "--out: " + in("link.glb").string() + " is the input " + in("b.glb").string() + " itself; choose another -o");
    }
    std::filesystem::remove_all(folder);
}

std::string unknownIn(std::vector<const char*> words) {
    CLI::App app;
    app.add_subcommand("render", "");
    CLI::App* body = app.add_subcommand("body", "");
    body->add_subcommand("import", "");
    CLI::App* bench = app.add_subcommand("bench", "");
    std::string avatar;
    bench->add_option("avatar", avatar);
    bench->add_subcommand("training", "");
    words.insert(words.begin(), "doppel");
    return unknownCommand(app, int(words.size()), words.data());
}

TEST(UnknownCommand, namesTheWordAndTheNearestCommand) {
    EXPECT_EQ(unknownIn({"render", "frobnicate"}), "") << "arguments of a command are its own";
    EXPECT_EQ(unknownIn({"body", "import", "x"}), "");
    EXPECT_EQ(unknownIn({"bench", "ada.glb"}), "") << "it may be the avatar";
    EXPECT_EQ(unknownIn({"--version"}), "");
    EXPECT_EQ(unknownIn({}), "");
    EXPECT_NE(unknownIn({"rendr"}).find("'rendr' (did you mean 'render'?)"), std::string::npos);
    EXPECT_NE(unknownIn({"body", "imprt"}).find("did you mean 'import'"), std::string::npos);
    const std::string far = unknownIn({"frobnicate"});
    EXPECT_NE(far.find("unknown command 'frobnicate'; the commands are"), std::string::npos) << far;
}

}  // namespace
