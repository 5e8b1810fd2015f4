// SPDX-License-Identifier: Apache-2.0
// A reconstruction names all that it needs and this machine lacks at once, before it works for minutes.
#include <gtest/gtest.h>

#include "reconstruction/run/reconstruct.h"
#include "tests/unit/bare_machine.h"
#include "tests/unit/recon_import/made_captures.h"

namespace dpl::test {
namespace {

namespace fs = std::filesystem;

class NeededTools : public testing::Test {
protected:
    NeededTools() {
        for (int i = 0; i < 8; ++i) writeBytes(folder_.path / formatText("photos/{}.jpg", i), jpegOf(spotPicture(96, 128, kMadePixel)));
    }
    std::string refusal() const {
        ReconstructOptions options;
        options.scan = folder_.path / "photos", options.out = out_;
        Progress progress(Progress::Style::Quiet);
        const auto result = reconstruct(options, progress);
        return result ? "was reconstructed" : result.error().message;
    }
    const TemporaryFolder folder_;
    const BareMachine machine_{folder_.path};
    const fs::path out_ = folder_.path / "out";
};

TEST_F(NeededTools, areNamedInOrder) {
    const std::string text = refusal();
    EXPECT_TRUE(mentions(text, {"out/scan needs", "1. networks", "doppel setup", "2. COLMAP", "doppel setup",
                                "then run the same command again", "docs/formats/scan.md"}));
    std::ifstream verdict(out_ / "verdict.json");
    const auto json = nlohmann::json::parse(verdict, nullptr, false);
    ASSERT_TRUE(json.is_object());
    EXPECT_EQ(json["refused"]["reason"], text) << "programs are told the same";
}

TEST_F(NeededTools, colmapIsMissedBeforeNetworksLookAtEveryPicture) {
    machine_.addNetworks();
    const std::string text = refusal();
    EXPECT_TRUE(mentions(text, {"1. COLMAP"}));
    EXPECT_EQ(text.find("networks"), std::string::npos) << text;
    EXPECT_FALSE(fs::exists(out_ / "stages"));
}

TEST_F(NeededTools, colmapIsNotAskedForAgainOnceCamerasWereFound) {
    machine_.addNetworks();
    writeText(out_ / "stages/cameras/manifest.json", R"({"inputs": {}})");
    EXPECT_EQ(refusal().find("COLMAP"), std::string::npos) << "the file that plays a network is the next problem";
}

}  // namespace
}  // namespace dpl::test
