// SPDX-License-Identifier: Apache-2.0
// Presets by name and from files, and what is wrong with a file.
#include "reconstruction/run/presets.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include "reconstruction/run/preset.h"
#include "sdk/core/files.h"

namespace dpl {
namespace {

class Presets : public testing::Test {
protected:
    ~Presets() override { std::filesystem::remove(file_); }

    Result<Preset> read(std::string_view text) {
        EXPECT_TRUE(bool(writeFileAtomically(file_, text)));
        return findPreset(file_.string());
    }
    void refuses(std::string_view text, std::string_view sentence) {
        const auto preset = read(text);
        ASSERT_FALSE(preset) << text;
        EXPECT_NE(preset.error().message.find(sentence), std::string::npos) << preset.error().message;
        EXPECT_NE(preset.error().message.find(file_.string()), std::string::npos) << preset.error().message;
    }
    const std::filesystem::path file_ = std::filesystem::temp_directory_path() / ("doppel_preset_" + std::to_string(::getpid()) + ".json");
};

TEST_F(Presets, aFileOfANamedPresetIsThatPreset) {
    ASSERT_EQ(namedPresets().size(), 3u);
    for (const Preset& named : namedPresets()) {
        const auto again = read(presetText(named));
        ASSERT_TRUE(again) << again.error().message;
        EXPECT_EQ(presetText(*again), presetText(named));
        EXPECT_EQ(again->name, file_.stem());
    }
}

TEST_F(Presets, whatAFileLeavesOutIsThatOfTheOneItIsLike) {
    const auto high = read(R"({"like": "high", "steps": 20000})"), standard = read(R"({"maxSplats": 100000})");
    ASSERT_TRUE(high) << high.error().message;
    ASSERT_TRUE(standard) << standard.error().message;
    EXPECT_EQ(high->steps, 20000u);
    EXPECT_EQ(high->maxSplats, findPreset("high")->maxSplats);
    EXPECT_EQ(standard->maxSplats, 100000u);
    EXPECT_EQ(standard->steps, findPreset("standard")->steps);
}

TEST_F(Presets, everyNumberReachesTheRun) {
    const auto preset =
        read(R"({"steps": 1234, "startSplats": 2345, "maxSplats": 3456, "shDegree": 1, "polishSteps": 45, "poseFitRounds": 56})");
    ASSERT_TRUE(preset) << preset.error().message;
    ReconstructOptions options;
    options.preset = *preset;
    const RunSettings settings = settingsOf(options);
    EXPECT_EQ(settings.training.steps, 1234u);
    EXPECT_EQ(settings.training.init.splatCount, 2345u);
    EXPECT_EQ(settings.training.maxSplats, 3456u);
    EXPECT_EQ(settings.training.init.shDegree, 1u);
    EXPECT_EQ(settings.polishSteps, 45u);
    EXPECT_EQ(settings.poseFit.iterations, 56u);
}

TEST_F(Presets, aBadFileIsRefusedWithItsNameAndTheRemedy) {
    refuses(R"({"step": 100})", "a preset has no 'step' (did you mean 'steps'?); it has like, steps,");
    refuses(R"({"colour": 1})", "a preset has no 'colour'; it has");
    refuses(R"({"steps": 0})", "'steps' is 0; it is a whole number from 1 to 10000000");
    refuses(R"({"steps": 1.5})", "'steps' is 1.5; it is a whole number");
    refuses(R"({"steps": -1})", "'steps' is -1");
    refuses(R"({"steps": 1e300})", "it is a whole number");
    refuses(R"({"steps": "many"})", "'steps' is not a finite number");
    refuses(R"({"steps": null})", "'steps' is null");
    refuses(R"({"maxSplats": 999})", "'maxSplats' is 999; it is a whole number from 1000 to 2000000");
    refuses(R"({"maxSplats": 50000000})", "it is a whole number from 1000 to 2000000");
    refuses(R"({"shDegree": 4})", "'shDegree' is 4; it is a whole number from 0 to 3");
    refuses(R"({"like": "best"})", "'like' is 'best'; it is draft, standard or high");
    refuses(R"({"startSplats": 90000})", "training starts with 90000 splats and may have 80000");
    refuses("[1]", "");
    refuses("steps: 3", "");
}

TEST_F(Presets, anUnknownNameGuesses) {
    const auto preset = findPreset("standart");
    ASSERT_FALSE(preset);
    EXPECT_NE(preset.error().message.find("there is no preset and no file 'standart' (did you mean 'standard'?)"), std::string::npos)
        << preset.error().message;
}

TEST_F(Presets, theTableHasEveryNumber) {
    const std::string table = presetTable(namedPresets());
    for (const char* number : {"draft", "3000", "10000", "60000", "40000", "80000", "300000", "2000", "120"})
        EXPECT_NE(table.find(number), std::string::npos) << number << "\n" << table;
}

}  // namespace
}  // namespace dpl
