// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/output/package/inspect.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <nlohmann/json.hpp>

#include "sdk/core/files.h"
#include "sdk/format/avatar_file.h"
#include "tests/unit/render/tube_avatar.h"

namespace dpl {
namespace {

class Inspect : public testing::Test {
protected:
    void SetUp() override {
        path_ = std::filesystem::temp_directory_path() / ("doppel_inspect_" + std::to_string(::getpid()) + ".glb");
        AvatarData avatar = makeTube({.splatsPerTriangle = 6, .rings = 10});
        sortSplats(avatar);
        auto bytes = writeAvatar(avatar);
        ASSERT_TRUE(bytes) << bytes.error().message;
        bytes_ = std::move(*bytes);
    }
    void TearDown() override { std::filesystem::remove(path_); }
    Result<Inspection> asText() {
        const Status written = writeFileAtomically(path_, bytes_);
        return written ? inspectAsText(path_) : Result<Inspection>(written.error());
    }
    std::filesystem::path path_;
    std::vector<uint8_t> bytes_;
};

TEST_F(Inspect, aGoodFileIsIntact) {
    const auto found = asText();
    ASSERT_TRUE(found) << found.error().message;
    EXPECT_TRUE(found->intact);
    EXPECT_NE(found->text.find("(matches)"), std::string::npos);
}

TEST_F(Inspect, layersAreListedWithTheirSplats) {
    const auto found = asText();
    ASSERT_TRUE(found) << found.error().message;
    const AvatarInfo info = *inspectAvatar(bytes_);
    ASSERT_EQ(info.layerList.size(), info.layers);
    uint32_t splats = 0;
    for (const LayerInfo& layer : info.layerList) {
        splats += layer.splats;
        EXPECT_EQ(layer.splats, 6 * layer.triangles);
        EXPECT_NE(found->text.find(layer.name + " (" + layer.role), std::string::npos);
    }
    EXPECT_EQ(splats, info.splats);
}

TEST_F(Inspect, clipsAndJointsAreNamed) {
    AvatarData avatar = *readAvatar(bytes_);
    avatar.clips = {{.name = "walk", .timesS = {0.5f, 1, 3}, .channels = {}, .rootTranslations = std::vector<Vec3f>(3, Vec3f(0))}};
    bytes_ = *writeAvatar(avatar);
    const auto found = asText();
    ASSERT_TRUE(found) << found.error().message;
    EXPECT_NE(found->text.find("clips: walk (2.5 s)\n"), std::string::npos) << found->text;
    const auto shown = inspectAsJson(path_);
    ASSERT_TRUE(shown) << shown.error().message;
    const auto json = nlohmann::json::parse(shown->text);
    EXPECT_EQ(json["clip_list"], nlohmann::json::parse(R"([{"name": "walk", "duration_s": 2.5}])"));
    ASSERT_EQ(json["joint_names"].size(), avatar.joints.size());
    EXPECT_EQ(json["joint_names"][0], avatar.joints[0].name);
}

TEST_F(Inspect, aFlippedBitThatOnlyTheHashDetectsIsReportedInTextAndJson) {
    auto found = asText();
    for (size_t i = bytes_.size(); i-- > bytes_.size() / 2;) {  // the end of the file holds splat streams
        bytes_[i] ^= 1;
        found = asText();
        if (found) break;
        bytes_[i] ^= 1;
    }
    ASSERT_TRUE(found) << found.error().message;
    EXPECT_FALSE(found->intact);
    const auto json = inspectAsJson(path_);
    ASSERT_TRUE(json);
    EXPECT_FALSE(json->intact);
    EXPECT_FALSE(nlohmann::json::parse(json->text)["hash_matches"].get<bool>());
}

TEST_F(Inspect, aFileThatIsNoAvatarIsRefusedByItsFirstBytes) {
    bytes_.assign(5, 'x');
    const auto found = asText();
    ASSERT_FALSE(found);
    EXPECT_EQ(found.error().code, Code::Unsupported);
    EXPECT_NE(found.error().message.find(path_.filename().string()), std::string::npos);
}

}  // namespace
}  // namespace dpl
