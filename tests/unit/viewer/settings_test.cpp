// SPDX-License-Identifier: Apache-2.0
#include "apps/viewer/settings.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <fstream>
#include <map>

namespace {

using namespace dpl;
namespace fs = std::filesystem;

TEST(ViewerSettings, liesWhereThePlatformKeepsSettings) {
    std::map<std::string, std::string> variables{{"HOME", "/home/ada"}, {"APPDATA", "/roaming"}};
    const auto file = [&](System system) {
        return settingsFile(system, [&](const char* name) { return variables[name]; }).generic_string();
    };
    EXPECT_EQ(file(System::Unix), "/home/ada/.config/doppel/viewer.json");
    EXPECT_EQ(file(System::Mac), "/home/ada/Library/Application Support/doppel/viewer.json");
    EXPECT_EQ(file(System::Windows), "/roaming/doppel/viewer.json");
    variables["XDG_CONFIG_HOME"] = "/etc/ada";
    EXPECT_EQ(file(System::Unix), "/etc/ada/doppel/viewer.json");
    variables["XDG_CONFIG_HOME"] = "relative";
    EXPECT_EQ(file(System::Unix), "/home/ada/.config/doppel/viewer.json");
    variables.clear();
    for (const System system : {System::Unix, System::Mac, System::Windows}) EXPECT_EQ(file(system), "");
}

TEST(ViewerSettings, theLastOpenedComesFirstAndOnce) {
    ViewerSettings settings;
    for (int i = 0; i < 30; ++i) settings.remember("/a/" + std::to_string(i) + ".glb");
    ASSERT_EQ(settings.recent.size(), ViewerSettings::kMostRecent);
    EXPECT_EQ(settings.recent[0], "/a/29.glb");
    settings.remember("/a/25.glb");
    EXPECT_EQ(settings.recent.size(), ViewerSettings::kMostRecent);
    EXPECT_EQ(settings.recent[0], "/a/25.glb");
    EXPECT_EQ(settings.recent[1], "/a/29.glb");
    settings.forget("/a/25.glb");
    EXPECT_EQ(settings.recent[0], "/a/29.glb");
    for (const std::string& path : {std::string(), std::string("relative.glb"), "/" + std::string(5000, 'x'), std::string("/a\0b", 4)})
        settings.remember(path);
    EXPECT_EQ(settings.recent[0], "/a/29.glb");
}

TEST(ViewerSettings, comeBackAsTheyWere) {
    const fs::path folder = fs::temp_directory_path() / ("doppel-settings-" + std::to_string(::getpid()));
    ViewerSettings settings;
    settings.remember("/a/\u00e4 \"b\".glb");
    settings.remember("/runs/out");
    settings.folder = "/a", settings.exports = "/e", settings.room = "bright";
    EXPECT_TRUE(readSettings(folder / "deep/viewer.json").recent.empty()) << "there is none yet";
    ASSERT_TRUE(writeSettings(folder / "deep/viewer.json", settings));
    EXPECT_EQ(readSettings(folder / "deep/viewer.json"), settings);
    std::ofstream(folder / "file") << "";
    EXPECT_FALSE(writeSettings(folder / "file/viewer.json", settings));
    fs::remove_all(folder);
}

TEST(ViewerSettings, whatIsDamagedIsLeftOut) {
    const ViewerSettings none;
    const std::string good = R"({"recent":["/a.glb","/b.glb"],"folder":"/a","room":"dark"})";
    for (size_t length = 0; length < good.size(); ++length) EXPECT_EQ(parseSettings(good.substr(0, length)), none) << length;
    EXPECT_EQ(parseSettings(std::string(100000, '{')), none);
    EXPECT_EQ(parseSettings(good + std::string(ViewerSettings::kMostBytes, ' ')), none);
    const ViewerSettings some = parseSettings(R"({"recent":[7,"/a.glb",null,"b.glb",["/c.glb"],"/a.glb"],"folder":7,"room":"pink"})");
    EXPECT_EQ(some.recent, std::vector<std::string>{"/a.glb"});
    EXPECT_TRUE(some.folder.empty() && some.room.empty());
    std::string many = R"({"recent":[)";
    for (int i = 0; i < 1000; ++i) many += "\"/" + std::to_string(i) + "\",";
    const ViewerSettings first = parseSettings(many + "\"/x\"]}");
    EXPECT_EQ(first.recent.size(), ViewerSettings::kMostRecent);
    EXPECT_EQ(first.recent[0], "/0");
}

}  // namespace
