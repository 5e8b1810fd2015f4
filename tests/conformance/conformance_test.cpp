// SPDX-License-Identifier: Apache-2.0
// Both of Doppel's renderers must pass the kit, and pictures of a wrong renderer must fail it.
#include "tests/conformance/kit.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <functional>

#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "sdk/core/files.h"

namespace dpl {
namespace {

namespace fs = std::filesystem;

class Conformance : public testing::Test {
protected:
    static void SetUpTestSuite() {
        root_ = fs::temp_directory_path() / ("doppel-conformance-" + std::to_string(getpid()));
        const Status written = writeKit(root_ / "kit");
        ASSERT_TRUE(written) << written.error().message;
        const auto drawn = drawKit(root_ / "kit", root_ / "software", DPL_RENDERER_SOFTWARE);
        ASSERT_TRUE(drawn) << drawn.error().message;
    }
    static void TearDownTestSuite() { fs::remove_all(root_); }

    static std::vector<CaseScore> score(const std::string& pictures) {
        auto scores = scoreKit(root_ / "kit", root_ / pictures);
        EXPECT_TRUE(scores) << scores.error().message;
        return scores ? *scores : std::vector<CaseScore>();
    }
    static CaseScore scoreOf(const char* pictures, const std::string& name) {
        for (const CaseScore& s : score(pictures))
            if (s.name == name) return s;
        ADD_FAILURE() << name << " is not in the kit";
        return {};
    }
    static void copyPictures(const char* folder) {
        fs::create_directories(root_ / folder);
        fs::copy(root_ / "software", root_ / folder, fs::copy_options::overwrite_existing | fs::copy_options::recursive);
    }
    /** Copies the software renderer's pictures into `folder` and changes one of them. */
    static void spoil(const char* folder, const std::string& picture, const std::function<void(cv::Mat&)>& change) {
        copyPictures(folder);
        cv::Mat image = cv::imread((root_ / folder / picture).string(), cv::IMREAD_UNCHANGED);
        ASSERT_FALSE(image.empty());
        change(image);
        ASSERT_TRUE(cv::imwrite((root_ / folder / picture).string(), image));
    }
    static inline fs::path root_;
};

TEST_F(Conformance, everyCaseDrawsSomethingUnlessItMayBeBlank) {
    const auto cases = readKit(root_ / "kit");
    ASSERT_TRUE(cases) << cases.error().message;
    EXPECT_GE(cases->size(), 20u);
    const auto scores = score("software");
    ASSERT_EQ(scores.size(), cases->size());
    for (size_t i = 0; i < scores.size(); ++i) {
        if ((*cases)[i].mayBeBlank)
            EXPECT_EQ(scores[i].coverage, 0) << scores[i].name;
        else
            EXPECT_GT(scores[i].coverage, 0.002) << scores[i].name;
    }
}

TEST_F(Conformance, theSoftwareRendererPasses) {
    const auto scores = score("software");
    std::printf("%s", scoreTable(scores).c_str());
    for (const CaseScore& s : scores) EXPECT_TRUE(s.passed) << s.name << ": " << s.trouble;
}

TEST_F(Conformance, theVulkanRendererPassesWithBothFills) {
    for (const DplFill fill : {DPL_FILL_QUADS, DPL_FILL_TILES}) {
        const std::string folder = fill == DPL_FILL_TILES ? "vulkan-tiles" : "vulkan-quads";
        const auto drawn = drawKit(root_ / "kit", root_ / folder, DPL_RENDERER_VULKAN, fill);
        if (!drawn && drawn.error().code == Code::Unsupported) GTEST_SKIP() << drawn.error().message;
        ASSERT_TRUE(drawn) << drawn.error().message;
        const auto scores = score(folder);
        std::printf("%s: \n%s", drawn->c_str(), scoreTable(scores).c_str());
        for (const CaseScore& s : scores) EXPECT_TRUE(s.passed) << *drawn << ", " << s.name << ": " << s.trouble;
    }
}

TEST_F(Conformance, halfAPixelOffIsNoticed) {
    spoil("shifted", "needles.png",
          [](cv::Mat& image) { cv::warpAffine(image.clone(), image, cv::Mat(cv::Matx23d(1, 0, 0.5, 0, 1, 0)), image.size()); });
    EXPECT_FALSE(scoreOf("shifted", "needles").passed);
    EXPECT_TRUE(scoreOf("shifted", "one-splat").passed);
}

TEST_F(Conformance, straightAlphaIsNoticed) {
    spoil("straight", "one-splat.png", [](cv::Mat& image) {
        for (auto p = image.begin<cv::Vec4b>(); p != image.end<cv::Vec4b>(); ++p)
            for (int c = 0; c < 3; ++c) (*p)[c] = cv::saturate_cast<uint8_t>(255.0 * (*p)[c] / std::max<int>(1, (*p)[3]));
    });
    EXPECT_FALSE(scoreOf("straight", "one-splat").passed);
}

TEST_F(Conformance, swappedEyesAreNoticed) {
    copyPictures("swapped");
    fs::rename(root_ / "swapped/stereo-parallel.left.png", root_ / "swapped/eye.png");
    fs::rename(root_ / "swapped/stereo-parallel.right.png", root_ / "swapped/stereo-parallel.left.png");
    fs::rename(root_ / "swapped/eye.png", root_ / "swapped/stereo-parallel.right.png");
    EXPECT_FALSE(scoreOf("swapped", "stereo-parallel").passed);
}

TEST_F(Conformance, clothesThatForgetAreNoticed) {
    copyPictures("forgotten");
    fs::copy(root_ / "forgotten/clothes-in-a-pose.png", root_ / "forgotten/clothes-that-remember.png",
             fs::copy_options::overwrite_existing);
    EXPECT_TRUE(scoreOf("forgotten", "clothes-in-a-pose").passed);
    EXPECT_FALSE(scoreOf("forgotten", "clothes-that-remember").passed);
}

TEST_F(Conformance, missingDamagedAndMisshapenPicturesFailTheirCase) {
    copyPictures("broken");
    fs::remove(root_ / "broken/off-axis.png");
    fs::resize_file(root_ / "broken/edge-on.png", 40);
    spoil("misshapen", "far-away.png", [](cv::Mat& image) { image = image.colRange(0, image.cols - 1).clone(); });
    for (const char* name : {"off-axis", "edge-on"}) {
        const CaseScore s = scoreOf("broken", name);
        EXPECT_FALSE(s.passed) << name;
        EXPECT_NE(s.trouble.find(std::string(name) + ".png"), std::string::npos) << s.trouble;
    }
    EXPECT_FALSE(scoreOf("misshapen", "far-away").passed);
    EXPECT_TRUE(scoreOf("broken", "needles").passed);
}

TEST_F(Conformance, aDamagedKitIsAnErrorThatNamesTheFile) {
    fs::create_directories(root_ / "bad");
    ASSERT_TRUE(writeFileAtomically(root_ / "bad/kit.json",
                                    std::string_view("{\"format\": \"doppel-conformance\", \"version\": 1, \"cases\": [{}]}")));
    const auto cases = readKit(root_ / "bad");
    ASSERT_FALSE(cases);
    EXPECT_NE(cases.error().message.find("kit.json"), std::string::npos);
}

}  // namespace
}  // namespace dpl
