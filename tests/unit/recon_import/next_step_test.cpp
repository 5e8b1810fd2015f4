// SPDX-License-Identifier: Apache-2.0
// The last lines of an import: what an avatar of the capture needs and this machine lacks, in order, and then the command that works.
#include "reconstruction/input/import/import.h"
#include "tests/unit/bare_machine.h"
#include "tests/unit/must.h"
#include "tests/unit/recon_import/made_captures.h"

namespace dpl {
namespace {

namespace fs = std::filesystem;

class NextStep : public testing::Test {
protected:
    /** The last lines of an import, with SCAN in the place of its output. */
    std::string import(const char* source) {
        ImportOptions options;
        options.source = folder_.path / source, options.out = folder_.path / formatText("{}-scan-{}", source, imports_++);
        std::string text = must(importCapture(options, nullptr, {})).nextStep;
        for (size_t at = 0; (at = text.find(options.out.string(), at)) != std::string::npos;)
            text.replace(at, options.out.string().size(), "SCAN");
        return text;
    }
    void writePhotos(int count) const {
        for (int i = 0; i < count; ++i) writeBytes(folder_.path / formatText("photos/{}.jpg", i), jpegOf(spotPicture(96, 128, kMadePixel)));
    }
    void writePolycam() const {
        for (int i = 0; i < 8; ++i) {
            writeBytes(folder_.path / formatText("polycam/keyframes/images/{}.jpg", i), jpegOf(spotPicture(128, 96, kMadeSensorPixel)));
            writeText(folder_.path / formatText("polycam/keyframes/cameras/{}.json", i), polycamKeyframe().dump());
        }
    }
    const TemporaryFolder folder_;
    const BareMachine machine_{folder_.path};
    int imports_ = 0;
};

const char* const kReady = "wrote SCAN; next: doppel reconstruct SCAN -o OUT";
const char* const kNetworks =
    "networks, which find the person's keypoints and masks: run doppel setup, or name a folder of networks by --models\n";
const char* const kColmap = "COLMAP, which finds the cameras: run doppel setup, or apt-get install colmap\n";

std::string lacking(const std::string& lines, const std::string& names) {
    return "wrote SCAN. An avatar of it needs what is missing on this machine. Get it once, in this order:\n" + lines +
           "missing: " + names + "; next: doppel setup, then doppel reconstruct SCAN -o OUT";
}

TEST_F(NextStep, unknownCamerasNeedNetworksAndThenColmap) {
    writePhotos(8);
    EXPECT_EQ(import("photos"), lacking(formatText("  1. {}  2. {}", kNetworks, kColmap), "networks and COLMAP"));
    machine_.addNetworks();
    EXPECT_EQ(import("photos"), lacking(formatText("  1. {}", kColmap), "COLMAP"));
    machine_.addProgram("colmap");
    EXPECT_EQ(import("photos"), kReady);
}

TEST_F(NextStep, colmapWithoutNetworksIsNotEnough) {
    writePhotos(8);
    machine_.addProgram("colmap");
    EXPECT_EQ(import("photos"), lacking(formatText("  1. {}", kNetworks), "networks"));
}

TEST_F(NextStep, knownCamerasNeedNoColmap) {
    writePolycam();
    EXPECT_EQ(import("polycam"), lacking(formatText("  1. {}", kNetworks), "networks"));
    machine_.addNetworks();
    EXPECT_EQ(import("polycam"), kReady);
}

TEST_F(NextStep, masksThatTheCaptureBringsAreNotAskedFor) {
    for (int i = 0; i < 8; ++i) writeBytes(folder_.path / formatText("photos/{}.png", i), pngOf(spotPicture(96, 128, kMadePixel, 4)));
    machine_.addProgram("colmap");
    EXPECT_TRUE(mentions(import("photos"), {"1. networks, which find the person's keypoints: run"}));
}

TEST_F(NextStep, withoutHomeTheFolderOfNetworksMustBeNamed) {
    writePolycam();
    BareMachine::forgetHome();
    EXPECT_TRUE(mentions(import("polycam"), {"doppel setup", "--out DIR", "--models", "neither HOME nor XDG_DATA_HOME"}));
}

TEST_F(NextStep, aCaptureThatGivesNoAvatarNamesNoCommand) {
    writePhotos(7);
    const std::string text = import("photos");
    EXPECT_TRUE(mentions(text, {"only 7 full-body pictures", "at least 8", "together with these"}));
    EXPECT_EQ(text.find("doppel reconstruct"), std::string::npos) << text;
}

TEST_F(NextStep, withoutFfmpegAFilmIsRefusedWithAllThatItNeeds) {
    writeBytes(folder_.path / "walk.mp4", {0, 1, 2});
    writeBytes(folder_.path / "studio/cam01.mp4", {0, 1, 2});
    writeText(folder_.path / "studio/Calib.qca.txt", qualisysText());
    const auto refusal = [&](const char* source) {
        ImportOptions options;
        options.source = folder_.path / source, options.out = folder_.path / "scan";
        const auto done = importCapture(options, nullptr, {});
        return done ? "was imported" : done.error().message;
    };
    const std::string ffmpeg = "  1. ffmpeg, which reads videos: apt-get install ffmpeg\n";
    const std::string begin = "the film needs what is missing on this machine. Get it once, in this order:\n",
                      end = "then run the same command again";
    EXPECT_EQ(refusal("walk.mp4"), begin + ffmpeg + formatText("  2. {}  3. {}", kNetworks, kColmap) + end);
    EXPECT_EQ(refusal("studio"), begin + ffmpeg + formatText("  2. {}", kNetworks) + end);
    machine_.addNetworks();
    machine_.addProgram("colmap");
    EXPECT_EQ(refusal("walk.mp4"), begin + ffmpeg + end);
}

}  // namespace
}  // namespace dpl
