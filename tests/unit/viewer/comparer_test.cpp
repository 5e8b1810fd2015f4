// SPDX-License-Identifier: Apache-2.0
#include "apps/viewer/comparer.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "apps/shared/pictures.h"
#include "sdk/core/files.h"
#include "sdk/format/avatar_file.h"
#include "tests/package/tiny_avatar.h"
#include "tests/unit/must.h"

namespace {

using namespace dpl;
namespace fs = std::filesystem;
using nlohmann::json;

constexpr uint32_t kColumns = 96, kRows = 128;

/** A run of the tiny avatar, whose one photograph is a picture of it in a dark room. */
class ComparerTest : public ::testing::Test {
protected:
    void SetUp() override {
        fs::create_directories(out_ / "scan");
        AvatarData data = test::tinyAvatar();
        sortSplats(data);
        write("avatar.glb", must(writeAvatar(data)));
        camera_.widthPx = kColumns, camera_.heightPx = kRows, camera_.fx = camera_.fy = 150, camera_.cx = 48, camera_.cy = 64;
        camera_.viewFromWorldRotation = Mat3d(1, 0, 0, 0, -1, 0, 0, 0, -1);
        camera_.viewFromWorldTranslation = {0, 1, 2.5};
        auto context = doppel::Context::create(DPL_RENDERER_SOFTWARE, 1);
        auto avatar = context->loadAvatar(must(readFile(out_ / "avatar.glb")));
        const float rotations[] = {0, 0, 0, 1, 0, 0, 0, 1}, root[] = {0, 0, 0};
        ASSERT_TRUE(avatar->setPose(rotations, root));
        const DplAvatar handle = avatar->handle();
        const Cameraf view = camera_.cast<float>();
        drawn_ = must(drawViews(*context, {&handle, 1}, {&view, 1}))[0];
        for (size_t i = 0; i < drawn_.size(); i += 4) {
            for (size_t c = 0; c < 3; ++c) photo_.push_back(uint8_t(drawn_[i + c] * drawn_[i + 3] / 255));
            mask_.push_back(drawn_[i + 3] >= 128 ? 255 : 0);
        }
        write("scan/a.png", must(encodePng(photo_, kColumns, kRows, 3)));
        write("scan/m.png", must(encodePng(mask_, kColumns, kRows, 1)));
        describe("m.png", {0, 0, 0});
    }
    void TearDown() override { fs::remove_all(out_); }
    void write(const std::string& name, std::span<const uint8_t> bytes) { ASSERT_TRUE(writeFileAtomically(out_ / name, bytes)); }
    void describe(const std::string& mask, const Vec3d& root) {
        json camera = {camera_.fx, camera_.fy, camera_.cx, camera_.cy};
        for (int c = 0; c < 3; ++c)
            for (int r = 0; r < 3; ++r) camera.push_back(camera_.viewFromWorldRotation[c][r]);
        for (int a = 0; a < 3; ++a) camera.push_back(camera_.viewFromWorldTranslation[a]);
        const json frames = {
            {"format", "doppel-frames"},
            {"version", 1},
            {"scan", "scan"},
            {"frames", {{{"name", "a"}, {"image", "a.png"}, {"mask", mask}, {"size", {kColumns, kRows}}, {"camera", camera}}}}};
        const json pose = {{"rotations_xyzw", {{0, 0, 0, 1}, {0, 0, 0, 1}}}, {"root_translation", {root.x, root.y, root.z}}};
        const json poses = {{"format", "doppel-poses"},
                            {"version", 1},
                            {"joints", joints_},
                            {"frames", {{{"name", "a"}, {"split", "train"}, {"pose", pose}}}}};
        ASSERT_TRUE(writeFileAtomically(out_ / "frames.json", frames.dump()));
        ASSERT_TRUE(writeFileAtomically(out_ / "poses.json", poses.dump()));
    }
    Result<ComparedPictures> compare() {
        DPL_TRY(Comparer comparer, Comparer::open(out_, out_ / "avatar.glb", {}));
        return comparer.compare(0);
    }

    const fs::path out_ = fs::temp_directory_path() / ("doppel-comparer-" + std::to_string(::getpid()));
    Camerad camera_;
    std::vector<uint8_t> drawn_, photo_, mask_;
    std::vector<std::string> joints_{"pelvis", "left_shoulder"};
};

TEST_F(ComparerTest, theAvatarIsDrawnWhereItsPhotographHasIt) {
    const ComparedPictures same = must(compare());
    EXPECT_TRUE(same.masked);
    EXPECT_EQ(same.photo.heightPx, kRows);
    EXPECT_GT(same.db, 45) << "both are rounded to whole levels";
    const auto redAt = [&](const Picture& picture, uint32_t x, uint32_t y) { return int(picture.pixels[(y * kColumns + x) * 4]); };
    EXPECT_GT(redAt(same.avatar, 48, 64), 200);
    EXPECT_LT(redAt(same.avatar, 2, 2), 80) << "grey around it";
    EXPECT_LT(redAt(same.error, 48, 64), 20);
    describe("m.png", {0.3, 0, 0});
    const ComparedPictures moved = must(compare());
    EXPECT_LT(moved.db, same.db - 10);
    EXPECT_GT(redAt(moved.error, 18, 64), 200) << "the left edge is uncovered";
}

TEST_F(ComparerTest, withoutAMaskOnlyPixelsOfTheAvatarCount) {
    describe("", {0, 0, 0});
    const ComparedPictures pictures = must(compare());
    EXPECT_FALSE(pictures.masked);
    EXPECT_GT(pictures.db, 45);
}

TEST_F(ComparerTest, saysWhatIsWrong) {
    write("scan/a.png", must(encodePng(photo_, kRows, kColumns, 3)));
    EXPECT_NE(compare().error().message.find("another picture"), std::string::npos);
    fs::remove(out_ / "scan/a.png");
    EXPECT_NE(compare().error().message.find("a.png"), std::string::npos);
    joints_[1] = "tail";
    describe("m.png", {0, 0, 0});
    EXPECT_NE(compare().error().message.find("another skeleton"), std::string::npos);
    fs::remove_all(out_ / "scan");
    EXPECT_NE(compare().error().message.find("drop its folder on the window"), std::string::npos);
}

TEST(PinholePicture, averagesAndStraightens) {
    ComparedFrame frame;
    frame.camera.fx = frame.camera.fy = 4, frame.camera.cx = frame.camera.cy = 4;
    Picture stored{8, 8, 1, {}};
    for (int i = 0; i < 64; ++i) stored.pixels.push_back(uint8_t(8 * (i % 8)));  // a ramp to the right
    const Picture half = pinholePicture(stored, frame, 2);
    EXPECT_EQ(half.widthPx, 4u);
    EXPECT_EQ(int(half.pixels[1]), 20);  // columns 2 and 3
    frame.k1 = 0.1;
    const Picture straight = pinholePicture(stored, frame, 1);
    // Pixel (6, 3): x = 0.625, y = -0.125, r² = 0.40625, so it is stored at 4 + 4 · 0.625 · 1.040625 = 6.6016, 0.1016 of a column farther.
    EXPECT_NEAR(straight.pixels[3 * 8 + 6], 8 * 6.1016, 0.51);
}

}  // namespace
