// SPDX-License-Identifier: Apache-2.0
// The start-up self-test on fake renderers whose fills are wrong, slow or failing.
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <utility>

#include "sdk/core/files.h"
#include "sdk/core/log.h"
#include "sdk/render/fill_memory.h"

namespace dpl {
namespace {

namespace fs = std::filesystem;

constexpr size_t kBytes = 157 * 219 * 4;

/** The correct picture of the test scene for these renderers. */
std::vector<uint8_t> truth() {
    std::vector<uint8_t> pixels(kBytes);
    for (size_t i = 0; i < kBytes; ++i) pixels[i] = uint8_t(i * 7 % 251);
    return pixels;
}

struct Behaviour {
    double milliseconds = 1;    // in pictures that are larger than the compared one
    bool oneWrongTile = false;  // 8 x 8 pixels are wrong
    int levelsOff = 0;          // added to every byte
    bool fails = false;
    bool outOfMemory = false, loses = false;  // this once; the device
};

/** A renderer whose fills behave as given. */
class FakeRenderer final : public Renderer {
public:
    FakeRenderer(Behaviour quads, Behaviour tiles, std::string identity = "fake")
        : behaviour_{quads, tiles}, identity_(std::move(identity)) {}
    std::string name() const override { return "fake"; }
    void setFill(Fill fill) override { this->fill = fill; }
    std::string identity() const override { return identity_; }
    Result<std::unique_ptr<PreparedSubject>> prepareAvatar(std::shared_ptr<const AvatarData>, CodedSplats) const override {
        return fail(Code::Unsupported, "no avatars");
    }
    Result<std::unique_ptr<PreparedSubject>> prepareSplats(const StaticSplatData&) const override {
        return std::make_unique<PreparedSubject>();
    }
    Result<RenderAvatarId> begin(std::unique_ptr<PreparedSubject>) override { return ++live, RenderAvatarId(1); }
    void removeAvatar(RenderAvatarId) override { --live; }
    Status drawTogether(std::span<const Drawn>, std::span<const Cameraf> cameras, const FrameWants&) override {
        ++draws;
        widthPx_ = cameras[0].widthPx;
        Behaviour& behaviour = behaviour_[size_t(fill)];
        if (behaviour.fails) return fail(Code::Device, "lost");
        if (std::exchange(behaviour.outOfMemory, false)) return fail(Code::OutOfMemory, "full");
        if (std::exchange(behaviour.loses, false)) lost_ = true;
        if (lost_) return fail(Code::Device, "the device is gone");
        return {};
    }
    Result<std::span<const PixelView>> read(RenderAvatarId) override {
        const Behaviour& b = behaviour_[size_t(fill)];
        pixels_ = truth();
        for (uint8_t& byte : pixels_) byte = uint8_t(std::clamp(int(byte) + b.levelsOff, 0, 255));
        if (b.oneWrongTile)
            for (size_t y = 80; y < 88; ++y)
                for (size_t x = 64; x < 72; ++x)
                    for (size_t c = 0; c < 4; ++c) pixels_[(y * 157 + x) * 4 + c] = 0;
        view_ = {157, 219, pixels_, {}, {}};
        return std::span<const PixelView>(&view_, 1);
    }
    Result<FrameStats> stats(RenderAvatarId) override {
        FrameStats stats;
        const double smallMs = fill == Fill::Tiles ? 3 : 1;  // small pictures mislead
        stats.passes = {{"draw", widthPx_ == 157 ? smallMs : behaviour_[size_t(fill)].milliseconds}, {"readback", 100}};
        return stats;
    }

    Fill fill = Fill::Quads;
    int live = 0, draws = 0;
    bool lost() const override { return lost_; }

private:
    bool lost_ = false;
    Behaviour behaviour_[2];
    std::string identity_;
    std::vector<uint8_t> pixels_;
    PixelView view_;
    uint32_t widthPx_ = 0;
};

Result<Fill> choose(FakeRenderer& renderer, std::string& reason) {
    auto chosen = chooseFill(renderer, fillTestScene(), truth(), reason);
    EXPECT_EQ(renderer.live, 0) << "the scene is left behind";
    return chosen;
}

void expectChoice(Behaviour quads, Behaviour tiles, Fill want, const std::string& inReason = {}) {
    FakeRenderer renderer(quads, tiles);
    std::string reason;
    const auto chosen = choose(renderer, reason);
    ASSERT_TRUE(chosen) << chosen.error().message;
    EXPECT_EQ(*chosen, want) << reason;
    EXPECT_EQ(renderer.fill, want) << "the choice is left set";
    EXPECT_NE(reason.find(inReason), std::string::npos) << reason;
}

TEST(ChooseFill, theFasterOfTwoRightOnes) {
    expectChoice({.milliseconds = 2}, {.milliseconds = 1}, Fill::Tiles, "quads: 2 ms; tiles: 1 ms");
    expectChoice({.milliseconds = 1}, {.milliseconds = 2}, Fill::Quads);
    expectChoice({.milliseconds = 1, .levelsOff = 1}, {.milliseconds = 2, .levelsOff = -1}, Fill::Quads, "quads: 1 ms");
}

TEST(ChooseFill, theRightOneHoweverSlow) {
    expectChoice({.milliseconds = 1, .oneWrongTile = true}, {.milliseconds = 50}, Fill::Tiles, "quads: wrong pixels");
    expectChoice({.milliseconds = 50}, {.milliseconds = 1, .oneWrongTile = true}, Fill::Quads, "tiles: wrong pixels");
    expectChoice({.milliseconds = 50}, {.milliseconds = 1, .levelsOff = 4}, Fill::Quads, "tiles: wrong pixels");
    expectChoice({.fails = true}, {}, Fill::Tiles, "quads: lost");
}

TEST(ChooseFill, aFillThatCouldNotBeTriedIsNotJudged) {
    std::string reason;
    FakeRenderer full({}, {.outOfMemory = true}), gone({.loses = true}, {});
    const auto noMemory = choose(full, reason), noDevice = choose(gone, reason);
    ASSERT_FALSE(noMemory);
    EXPECT_EQ(noMemory.error().code, Code::OutOfMemory);
    ASSERT_FALSE(noDevice);
    EXPECT_EQ(noDevice.error().message, "the device is gone");
}

TEST(ChooseFill, noneOfTwoWrongOnesAndSaysHowWrong) {
    FakeRenderer renderer({.oneWrongTile = true}, {.levelsOff = 30});
    std::string reason;
    const auto chosen = choose(renderer, reason);
    ASSERT_FALSE(chosen);
    EXPECT_EQ(chosen.error().code, Code::Device);
    for (const char* word : {"quads: wrong pixels", "tiles: wrong pixels", "dB", "levels"})
        EXPECT_NE(chosen.error().message.find(word), std::string::npos) << chosen.error().message;
}

const auto trusted = [](const FillScene&) -> Result<std::vector<uint8_t>> { return truth(); };

struct Folder {
    fs::path path;
    Folder() {
        std::string pattern = (fs::temp_directory_path() / "doppel-fill-test-XXXXXX").string();
        path = mkdtemp(pattern.data());
    }
    ~Folder() { fs::remove_all(path); }
    fs::path file(const std::string& identity) const { return path / ("doppel-fill-" + identity + ".txt"); }
    std::string text(const std::string& identity) const {
        const auto bytes = readFile(file(identity));
        return bytes ? std::string(bytes->begin(), bytes->end()) : "no file";
    }
};

TEST(FillMemory, errorsThatMayPassAreNotRemembered) {
    FakeRenderer full({.outOfMemory = true}, {}, "passing"), gone({}, {.loses = true}, "passing"), well({}, {.milliseconds = 2}, "passing");
    ASSERT_FALSE(setBestFill(full, "", trusted));
    ASSERT_FALSE(setBestFill(gone, "", trusted));
    const Status third = setBestFill(well, "", trusted);
    ASSERT_TRUE(third) << third.error().message;
    EXPECT_EQ(well.fill, Fill::Quads);
}

TEST(FillMemory, oneTestADeviceAndProcess) {
    FakeRenderer first({.milliseconds = 2}, {}, "a"), again({.milliseconds = 2}, {}, "a"), otherDriver({}, {.milliseconds = 2}, "b");
    ASSERT_TRUE(setBestFill(first, "", trusted));
    EXPECT_GT(first.draws, 0);
    EXPECT_EQ(first.fill, Fill::Tiles);
    ASSERT_TRUE(setBestFill(again, "", trusted));
    EXPECT_EQ(again.draws, 0);
    EXPECT_EQ(again.fill, Fill::Tiles);
    ASSERT_TRUE(setBestFill(otherDriver, "", trusted));
    EXPECT_GT(otherDriver.draws, 0);
    EXPECT_EQ(otherDriver.fill, Fill::Quads);
}

TEST(FillMemory, aFolderKeepsTheChoiceForTheNextProcess) {
    const Folder folder;
    FakeRenderer first({.milliseconds = 2}, {}, "c");
    ASSERT_TRUE(setBestFill(first, folder.path.string(), trusted));
    EXPECT_EQ(folder.text("c"), "tiles\n");
    ASSERT_TRUE(writeFileAtomically(folder.file("d"), "quads\n"));  // as if another process had tested device "d", which this one has not
    FakeRenderer kept({.milliseconds = 2}, {}, "d");
    ASSERT_TRUE(setBestFill(kept, folder.path.string(), trusted));
    EXPECT_EQ(kept.draws, 0);
    EXPECT_EQ(kept.fill, Fill::Quads);
}

TEST(FillMemory, aDamagedFileIsReplacedAndAMissingFolderIsNoError) {
    const Folder folder;
    int device = 0;
    for (const std::string& damaged :
         {std::string(), std::string("tiles"), std::string("tiles\nquads\n"), std::string("\0\xff", 2), std::string(100000, 't')}) {
        const std::string identity = "damaged" + std::to_string(device++);
        ASSERT_TRUE(writeFileAtomically(folder.file(identity), damaged));
        FakeRenderer renderer({.milliseconds = 2}, {}, identity);
        ASSERT_TRUE(setBestFill(renderer, folder.path.string(), trusted));
        EXPECT_GT(renderer.draws, 0);
        EXPECT_EQ(folder.text(identity), "tiles\n");
    }
    int warnings = 0;
    setLogSink([&](LogLevel level, std::string_view) { warnings += level == LogLevel::Warning; });
    FakeRenderer renderer({}, {}, "nowhere");
    EXPECT_TRUE(setBestFill(renderer, (folder.path / "missing").string(), trusted));
    EXPECT_EQ(warnings, 1);
    setLogSink({});
}

TEST(FillMemory, wrongPixelsAreLoggedAndNoneRightIsAnErrorThatNoFileKeeps) {
    const Folder folder;
    std::string logged;
    setLogSink([&](LogLevel level, std::string_view text) {
        if (level == LogLevel::Warning) logged += text;
    });
    FakeRenderer half({.oneWrongTile = true}, {.milliseconds = 9}, "half"), broken({.oneWrongTile = true}, {.fails = true}, "broken"),
        again({}, {}, "broken");
    EXPECT_TRUE(setBestFill(half, folder.path.string(), trusted));
    EXPECT_NE(logged.find("quads: wrong pixels"), std::string::npos) << logged;
    EXPECT_EQ(setBestFill(broken, folder.path.string(), trusted).error().code, Code::Device);
    EXPECT_EQ(setBestFill(again, folder.path.string(), trusted).error().code, Code::Device) << "remembered in the process";
    EXPECT_EQ(folder.text("broken"), "no file");
    setLogSink({});
}

}  // namespace
}  // namespace dpl
