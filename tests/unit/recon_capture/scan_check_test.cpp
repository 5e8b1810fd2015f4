// SPDX-License-Identifier: Apache-2.0
// The ingest check: good scans pass, each kind of damage has its finding, and unusable scans are refused.
#include "reconstruction/input/capture/scan_check.h"

#include <algorithm>
#include <functional>

#include "reconstruction/input/capture/silhouettes.h"
#include "tests/unit/heard_task.h"
#include "tests/unit/recon_capture/scan_builder.h"
#include "tests/unit/shared_data.h"

namespace dpl {
namespace {

ScanCheck check(const std::filesystem::path& root, const std::function<void(Scan&)>& change = {}) {
    auto scan = readScan(root);
    EXPECT_TRUE(scan) << scan.error().message;
    if (change) change(*scan);
    Jobs jobs(2);
    auto result = checkScan(*scan, jobs);
    EXPECT_TRUE(result) << result.error().message;
    return *result;
}

const ScanFinding* finding(const ScanCheck& c, const std::string& topic, bool refuses) {
    for (const auto& f : c.findings)
        if (f.topic == topic && f.refuses == refuses) return &f;
    return nullptr;
}

/** A scan whose 20 static and 8 dynamic pictures can be changed on disk before the check. */
struct Spoiled {
    TemporaryFolder folder;
    ScanBuilder builder;
    explicit Spoiled(int staticFrames = 20) : builder(folder.path, staticFrames, 8) {}
    void eachImage(const std::function<cv::Mat(const cv::Mat&, size_t)>& change, const char* kind = "image", int flags = cv::IMREAD_COLOR) {
        for (size_t i = 0; i < builder.manifest["frames"].size(); ++i) {
            const auto path = (folder.path / builder.manifest["frames"][i][kind].get<std::string>()).string();
            cv::imwrite(path, change(cv::imread(path, flags), i));
        }
    }
};

TEST(ScanCheck, aGoodScanPasses) {
    Spoiled s;
    const auto c = check(s.builder.write());
    EXPECT_EQ(c.verdict, ScanVerdict::Pass) << c.findings.front().sentence;
    EXPECT_NEAR(c.largestGapDeg, 36, 1e-6) << "20 views at 18°, two neighbours of the held-out ones at 36°";
    EXPECT_GT(c.silhouetteCoherence, 0.96);
}

TEST(ScanCheck, oneImageIsRefused) {
    TemporaryFolder folder;
    ScanBuilder builder(folder.path, 1);
    const auto c = check(builder.write());
    EXPECT_EQ(c.verdict, ScanVerdict::Refuse);
    const auto* why = finding(c, "files", true);
    ASSERT_TRUE(why);
    EXPECT_TRUE(mentions(why->sentence, {"only 1", "walk"}));
}

TEST(ScanCheck, onlyScansOfAProtocolMayLackAStillPart) {
    TemporaryFolder folder;
    ScanBuilder builder(folder.path, 0, 25);  // 3 of them are held out
    EXPECT_EQ(check(builder.write()).verdict, ScanVerdict::Refuse);
    EXPECT_FALSE(finding(check(folder.path), "azimuth", true)) << "nobody walked around, and one sentence says so";
    builder.manifest["protocol"] = "neuman";
    const auto c = check(builder.write());
    EXPECT_FALSE(finding(c, "files", true));
    ASSERT_TRUE(finding(c, "files", false));
    EXPECT_TRUE(mentions(finding(c, "files", false)->sentence, {"never stands still"}));
    builder.manifest["frames"].erase(builder.manifest["frames"].begin(), builder.manifest["frames"].begin() + 4);
    EXPECT_TRUE(finding(check(builder.write()), "files", true)) << "19 frames are too few";
}

TEST(ScanCheck, allBlurredIsRefusedAlthoughNoneIsBlurrierThanTheRest) {
    Spoiled s;
    s.eachImage([](const cv::Mat& image, size_t) {
        cv::Mat out;
        cv::GaussianBlur(image, out, {0, 0}, 4);
        return out;
    });
    const auto c = check(s.builder.write());
    EXPECT_EQ(c.verdict, ScanVerdict::Refuse);
    EXPECT_TRUE(finding(c, "blur", true)) << c.medianBlurIndex;
}

TEST(ScanCheck, aFewBlurredAreLeftOut) {
    Spoiled s;
    s.eachImage([](const cv::Mat& image, size_t i) {
        cv::Mat out = image;
        if (i == 3 || i == 7) cv::GaussianBlur(image, out, {0, 0}, 4);
        return out;
    });
    const auto c = check(s.builder.write());
    EXPECT_EQ(c.verdict, ScanVerdict::Usable);
    const auto* why = finding(c, "blur", false);
    ASSERT_TRUE(why);
    EXPECT_EQ(why->frames, (std::vector<std::string>{"full_103", "full_107"}));
    EXPECT_FALSE(c.frames[3].usable);
    EXPECT_TRUE(c.frames[4].usable);
}

TEST(ScanCheck, halfTheMasksEmptyIsRefusedOneIsLeftOut) {
    for (const size_t step : {2, 28}) {
        Spoiled s;
        s.eachImage([&](const cv::Mat& mask, size_t i) { return i % step == 1 ? cv::Mat(cv::Mat::zeros(mask.size(), CV_8U)) : mask; },
                    "mask", cv::IMREAD_GRAYSCALE);
        const auto c = check(s.builder.write());
        EXPECT_EQ(c.verdict, step == 2 ? ScanVerdict::Refuse : ScanVerdict::Usable);
        const auto* why = finding(c, "masks", step == 2);
        ASSERT_TRUE(why);
        EXPECT_TRUE(mentions(why->sentence, {"empty", "make them again"}));
        EXPECT_FALSE(c.frames[1].usable);
        const auto found = check(s.folder.path, [](Scan& scan) {
            for (ScanFrame& frame : scan.frames) frame.maskFound = true;
        });
        ASSERT_TRUE(finding(found, "masks", step == 2));
        EXPECT_TRUE(mentions(finding(found, "masks", step == 2)->sentence, {"nobody was found", "keep the person in view"}));
    }
}

TEST(ScanCheck, aSubjectOutOfFrameIsRefused) {
    Spoiled s;
    const auto shift = [](const cv::Mat& image, size_t) {
        cv::Mat out;
        cv::warpAffine(image, out, cv::Matx23d(1, 0, 0, 0, 1, 60), image.size(), cv::INTER_NEAREST, cv::BORDER_CONSTANT);
        return out;
    };
    s.eachImage(shift, "mask", cv::IMREAD_GRAYSCALE);
    s.eachImage(shift);
    const auto c = check(s.builder.write());
    EXPECT_EQ(c.verdict, ScanVerdict::Refuse);
    const auto* why = finding(c, "border", true);
    ASSERT_TRUE(why);
    EXPECT_TRUE(mentions(why->sentence, {"edge", "step back"}));
}

TEST(ScanCheck, missingMasksAreFlaggedNotRefused) {
    Spoiled s;
    for (auto& frame : s.builder.manifest["frames"]) frame.erase("mask");
    const auto c = check(s.builder.write());
    EXPECT_EQ(c.verdict, ScanVerdict::Usable);
    EXPECT_TRUE(finding(c, "masks", false));
}

TEST(ScanCheck, framesWithoutAMaskAreLeftOutWhereOthersHaveOne) {
    Spoiled s;
    size_t heldOut = SIZE_MAX;
    for (size_t i = 0; i < s.builder.manifest["frames"].size(); ++i) {
        auto& frame = s.builder.manifest["frames"][i];
        if (frame["split"] == "test") heldOut = i;
    }
    ASSERT_NE(heldOut, SIZE_MAX);
    for (const size_t i : {size_t(1), heldOut}) s.builder.manifest["frames"][i].erase("mask");
    const auto c = check(s.builder.write());
    EXPECT_EQ(c.verdict, ScanVerdict::Usable);
    EXPECT_FALSE(c.frames[1].usable);
    EXPECT_TRUE(c.frames[2].usable);
    ASSERT_TRUE(finding(c, "masks", false));
    EXPECT_TRUE(mentions(describeScanCheck(*readScan(s.folder.path), c),
                         {"1 frames have no mask and are left out", "1 held-out pictures have no mask"}));
}

TEST(ScanCheck, aTruncatedImageIsNamed) {
    Spoiled s;
    s.builder.write();
    std::filesystem::resize_file(s.folder.path / "images/full_104.jpg",
                                 std::filesystem::file_size(s.folder.path / "images/full_104.jpg") / 2);
    const auto c = check(s.folder.path);
    EXPECT_EQ(c.verdict, ScanVerdict::Refuse);
    const auto* why = finding(c, "files", true);
    ASSERT_TRUE(why);
    EXPECT_TRUE(mentions(why->sentence, {"full_104.jpg", "truncated"}));
}

TEST(ScanCheck, anExposureJumpIsSeenALitSideIsNot) {
    for (const bool jump : {true, false}) {
        Spoiled s(40);
        s.eachImage([&](const cv::Mat& image, size_t i) {
            const double stops = jump ? (i >= 17 ? -1.0 : 0) : 0.4 * std::cos(6.2831853 * double(i) / 40);
            return cv::Mat(image * std::exp2(stops));
        });
        const auto c = check(s.builder.write());
        EXPECT_EQ(finding(c, "exposure", false) != nullptr, jump) << c.exposureJumpStops;
    }
}

TEST(ScanCheck, heldOutPicturesHaveNoSay) {
    Spoiled a, b;
    a.eachImage([](const cv::Mat& image, size_t) { return image; });  // encoded again, as those of b
    b.eachImage([&](const cv::Mat& image, size_t i) {
        cv::Mat noise = image;
        if (b.builder.manifest["frames"][i]["split"] == "test") cv::RNG(7).fill(noise, cv::RNG::UNIFORM, 0, 255);
        return noise;
    });
    b.eachImage(
        [&](const cv::Mat& mask, size_t i) {
            return b.builder.manifest["frames"][i]["split"] == "test" ? cv::Mat(cv::Mat::zeros(mask.size(), CV_8U)) : mask;
        },
        "mask", cv::IMREAD_GRAYSCALE);
    const auto scanA = readScan(a.builder.write()), scanB = readScan(b.builder.write());
    ASSERT_TRUE(scanA && scanB);
    ASSERT_NE(scanA->root, scanB->root);
    Jobs one(1), three(3);
    const auto first = checkScan(*scanA, one), second = checkScan(*scanB, three);
    ASSERT_TRUE(first && second);
    EXPECT_EQ(scanCheckJson(*scanA, *first), scanCheckJson(*scanB, *second));
}

TEST(ScanCheck, stopsAtThePictureAtWhichItIsCancelled) {
    Spoiled a;
    const auto scan = readScan(a.builder.write());
    ASSERT_TRUE(scan);
    Jobs jobs(1);
    test::HeardTask stopping(3), whole;
    {
        const TaskScope scope(&stopping);
        const auto stopped = checkScan(*scan, jobs);
        ASSERT_FALSE(stopped);
        EXPECT_EQ(stopped.error().code, Code::Cancelled);
    }
    EXPECT_EQ(stopping.heard.size(), 3u) << "of " << scan->frames.size() << " pictures";
    const TaskScope scope(&whole);
    ASSERT_TRUE(checkScan(*scan, jobs));
    EXPECT_EQ(whole.heard.back().first, 1.0);
}

TEST(ScanCheck, camerasThatBelongToOtherPicturesAreRefused) {
    const auto data = sharedData("scan-tiny");
    if (!data) GTEST_SKIP() << "shared data (scan-tiny) is not on this machine";
    // Each picture gets the camera of another frame.
    const auto c = check(*data, [](Scan& scan) {
        std::vector<ScanFrame*> full;
        for (auto& f : scan.frames)
            if (f.kind == FrameKind::StaticFull) full.push_back(&f);
        for (size_t i = 0; i + 5 < full.size(); ++i) std::swap(full[i]->camera, full[i + 5]->camera);
    });
    EXPECT_EQ(c.verdict, ScanVerdict::Refuse) << c.silhouetteCoherence << " " << c.keypointErrorShare;
    EXPECT_TRUE(finding(c, "cameras", true));
}

TEST(ScanCheck, aFocalLengthOfHalfTheTruthIsFlagged) {
    const auto data = sharedData("scan-tiny");
    if (!data) GTEST_SKIP() << "shared data (scan-tiny) is not on this machine";
    const auto c = check(*data, [](Scan& scan) {
        for (auto& f : scan.frames) f.camera.fx *= 0.5, f.camera.fy *= 0.5;
    });
    EXPECT_NE(c.verdict, ScanVerdict::Pass);
    EXPECT_TRUE(finding(c, "cameras", false) || finding(c, "cameras", true)) << c.silhouetteCoherence << " " << c.keypointErrorShare;
}

TEST(ScanCheck, aFocalLengthThatIsAFifthOffIsRefusedAndTheRightOneIsNamed) {
    const auto data = sharedData("scan-tiny");
    if (!data) GTEST_SKIP() << "shared data (scan-tiny) is not on this machine";
    for (const double factor : {0.8, 1.2}) {
        const auto c = check(*data, [=](Scan& scan) {
            for (auto& f : scan.frames) f.camera.fx *= factor, f.camera.fy *= factor;
        });
        const auto* why = finding(c, "cameras", true);
        ASSERT_TRUE(why) << factor << ": " << c.focalFactor;
        EXPECT_NEAR(c.focalFactor * factor, 1, 0.03);
        EXPECT_TRUE(mentions(why->sentence, {"focal length", factor < 1 ? "short" : "long", "fx"})) << why->sentence;
    }
    EXPECT_NEAR(check(*data).focalFactor, 1, 0.03);
}

TEST(ScanCheck, synchronisedCamerasAreHeldAgainstEachOther) {
    TemporaryFolder folder;
    ScanBuilder builder(folder.path, 20, 12);
    const auto stamped = [&](auto timeOf) {
        for (int i = 0; i < 12; ++i) builder.manifest["frames"][20 + size_t(i)]["time"] = timeOf(i);
        return check(builder.write());
    };
    const auto fourAtOnce = [](int i) { return double(i / 4); };
    EXPECT_EQ(stamped([](int) { return 0.0; }).moments, 0u) << "no times are stated";
    EXPECT_EQ(stamped([](int i) { return 0.1 * i; }).moments, 0u) << "one camera";
    const auto agreeing = stamped(fourAtOnce);
    EXPECT_EQ(agreeing.moments, 2u) << "one frame of the second moment is held out";
    EXPECT_LT(agreeing.momentErrorPx, 0.1);
    for (const char* frame : {"dyn_100", "dyn_101", "dyn_102", "dyn_108", "dyn_109", "dyn_110"}) {
        const auto path = folder.path / "keypoints" / (std::string(frame) + ".json");
        nlohmann::json moved = nlohmann::json::parse(std::ifstream(path));
        for (auto& at : moved["detections"])
            if (!at.is_null()) at[0] = at[0].get<double>() + 40;
        writeText(path, moved.dump());
    }
    const auto apart = stamped(fourAtOnce);
    EXPECT_GT(apart.momentErrorPx, 5) << "three cameras of each moment see the keypoints 40 px beside";
    EXPECT_TRUE(mentions(describeScanCheck(*readScan(folder.path), apart), {"moments     2 seen by four cameras or more at once"}));
}

TEST(ScanCheck, sharedScansAreUsable) {
    const auto data = sharedData("scan-tiny");
    if (!data) GTEST_SKIP() << "shared data (scan-tiny) is not on this machine";
    const auto c = check(*data);
    EXPECT_NE(c.verdict, ScanVerdict::Refuse);
    EXPECT_GT(c.silhouetteCoherence, 0.97);
    EXPECT_LT(c.keypointErrorShare, 0.02);
    EXPECT_EQ(c.joints.size(), 8u);
    auto scan = readScan(*data);
    const std::string text = describeScanCheck(*scan, c);
    EXPECT_TRUE(mentions(text, {"scan-tiny", "18 full-body", "azimuth", "USABLE"}));
}

}  // namespace
}  // namespace dpl
