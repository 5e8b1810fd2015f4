// SPDX-License-Identifier: Apache-2.0
// Masks of close-ups: right ones stay, wrong and empty ones give way to the visual hull where it is sure.
#include "reconstruction/input/observe/closeup_masks.h"

#include "reconstruction/input/capture/frame_picture.h"
#include "tests/unit/recon_capture/scan_builder.h"

namespace dpl {
namespace {

constexpr int kWide = ScanBuilder::kWidth, kTall = ScanBuilder::kHeight;

double iou(const ImageGrey8& a, const cv::Mat& b) {
    const cv::Mat own = cv::Mat(int(a.heightPx), int(a.widthPx), CV_8U, const_cast<uint8_t*>(a.pixels.data())) >= 128;
    return cv::countNonZero(own & b) / std::max(1.0, double(cv::countNonZero(own | b)));
}

/** The silhouette of a spheroid, 0.8 m wide and 2.2 m tall about (0, 0, 1), in a camera of the manifest. */
cv::Mat spheroid(const nlohmann::json& camera) {
    const auto r = camera["R"].get<std::vector<double>>(), t = camera["t"].get<std::vector<double>>();
    const Vec3d axes(0.4, 0.4, 1.1);
    const auto toWorld = [&](const Vec3d& v) {
        return Vec3d(r[0] * v.x + r[3] * v.y + r[6] * v.z, r[1] * v.x + r[4] * v.y + r[7] * v.z, r[2] * v.x + r[5] * v.y + r[8] * v.z);
    };
    const Vec3d eye = (-toWorld({t[0], t[1], t[2]}) - Vec3d(0, 0, 1)) / axes;
    cv::Mat mask = cv::Mat::zeros(kTall, kWide, CV_8U);
    for (int y = 0; y < kTall; ++y)
        for (int x = 0; x < kWide; ++x) {
            const Vec3d d = toWorld({(x + 0.5 - kWide / 2) / 100, (y + 0.5 - kTall / 2) / 100, 1}) / axes;
            const double b = glm::dot(eye, d);
            if (b * b >= glm::dot(d, d) * (glm::dot(eye, eye) - 1)) mask.at<uint8_t>(y, x) = 255;
        }
    return mask;
}

/** Twenty full-body pictures of the spheroid and two close-ups, from 1.6 m instead of 2.5 m and 0.2 m off to the side. */
struct CloseupScan {
    TemporaryFolder folder;
    ScanBuilder builder{folder.path};
    cv::Mat truth;  // of the close-ups

    CloseupScan() {
        for (const auto& frame : builder.manifest["frames"]) writeMask(frame["name"], spheroid(frame["camera"]));
        for (const int i : {0, 1}) {
            const std::string name = "close_" + std::to_string(i);
            builder.addFrame(name, "static_closeup", 0.3 + i);
            auto& frame = builder.manifest["frames"].back();
            frame["split"] = "train";
            auto& t = frame["camera"]["t"];
            t[0] = t[0].get<double>() - 0.2, t[2] = t[2].get<double>() - 0.9;
            truth = spheroid(frame["camera"]);
            cv::Mat image(kTall, kWide, CV_8UC3, cv::Scalar(110, 110, 110)), noise(kTall, kWide, CV_8UC3);
            cv::RNG rng(7);
            rng.fill(noise, cv::RNG::UNIFORM, 150, 250);
            noise.copyTo(image, truth);
            cv::imwrite((folder.path / "images" / (name + ".jpg")).string(), image);
            writeMask(name, truth);
        }
    }

    void writeMask(const std::string& name, const cv::Mat& mask) { cv::imwrite((folder.path / "masks" / (name + ".png")).string(), mask); }

    std::vector<CloseupMask> check(bool found = true) {
        auto scan = readScan(builder.write());
        EXPECT_TRUE(scan) << scan.error().message;
        Jobs jobs(2);
        auto checked = checkCloseupMasks(
            *scan, [&](const ScanFrame&) { return found; }, jobs);
        EXPECT_TRUE(checked) << checked.error().message;
        return *checked;
    }
};

TEST(CloseupMasks, rightOnesStayAndWrongOnesGiveWayToTheHull) {
    CloseupScan scan;
    cv::Mat wrong = cv::Mat::zeros(kTall, kWide, CV_8U);
    wrong(cv::Rect(0, 0, kWide, kTall / 3)) = 255;
    scan.writeMask("close_1", wrong);
    const auto checked = scan.check();
    ASSERT_EQ(checked.size(), 2u);
    EXPECT_FALSE(checked[0].contradicted);
    EXPECT_GT(checked[0].agreement, 0.85);
    EXPECT_TRUE(checked[0].mask.pixels.empty());
    EXPECT_TRUE(checked[1].contradicted);
    EXPECT_LT(checked[1].agreement, 0.5);
    ASSERT_FALSE(checked[1].mask.pixels.empty());
    EXPECT_GT(iou(checked[1].mask, scan.truth), 0.93);
}

TEST(CloseupMasks, anEmptyOneIsFilled) {
    CloseupScan scan;
    scan.writeMask("close_0", cv::Mat::zeros(kTall, kWide, CV_8U));
    const auto checked = scan.check();
    ASSERT_EQ(checked.size(), 2u);
    EXPECT_EQ(checked[0].agreement, 0);
    ASSERT_FALSE(checked[0].mask.pixels.empty());
    EXPECT_GT(iou(checked[0].mask, scan.truth), 0.93);
}

TEST(CloseupMasks, whereTheSubjectSwaysTheHullIsNoMask) {
    CloseupScan scan;
    cv::Mat aside = cv::Mat::zeros(kTall, kWide, CV_8U);
    cv::ellipse(aside, {kWide / 2 + 25, kTall / 2}, {17, 48}, 0, 0, 360, 255, -1);
    for (const char* name : {"full_101", "full_108", "full_112"}) scan.writeMask(name, aside);
    scan.writeMask("close_0", cv::Mat::zeros(kTall, kWide, CV_8U));
    const auto checked = scan.check();
    ASSERT_EQ(checked.size(), 2u);
    EXPECT_LT(checked[0].certainty, 0.8);
    EXPECT_TRUE(checked[0].mask.pixels.empty());
}

TEST(CloseupMasks, whatTheScanBringsIsNotJudgedNorWithoutAHull) {
    CloseupScan scan;
    scan.writeMask("close_0", cv::Mat::zeros(kTall, kWide, CV_8U));
    EXPECT_TRUE(scan.check(false).empty());
    auto& frames = scan.builder.manifest["frames"];
    frames.erase(frames.begin() + 6, frames.begin() + 20);  // six full-body pictures are left
    EXPECT_TRUE(scan.check().empty());
}

TEST(CloseupMasks, storedPixelsReadBackAsTheMask) {
    CloseupScan scan;
    scan.builder.manifest["camera_model"] = "radial", scan.builder.manifest["distortion"] = {-0.25, 0.05};
    auto read = readScan(scan.builder.write());
    ASSERT_TRUE(read) << read.error().message;
    const ScanFrame& frame = read->frames.back();
    ASSERT_TRUE(frame.lens.any());
    ImageGrey8 mask{uint32_t(kWide), uint32_t(kTall), std::vector<uint8_t>(size_t(kWide) * kTall, 0)};
    const cv::Rect inner(8, 10, 70, 100);
    cv::Mat view(kTall, kWide, CV_8U, mask.pixels.data());
    view(inner) = 255;
    const cv::Mat wanted = view.clone();
    const auto readBack = [&](const ImageGrey8& stored) {
        scan.writeMask("close_1", cv::Mat(kTall, kWide, CV_8U, const_cast<uint8_t*>(stored.pixels.data())));
        auto back = readFrameMask(frame);
        EXPECT_TRUE(back) << back.error().message;
        return iou(*back, wanted);
    };
    EXPECT_LT(readBack(mask), 0.95) << "the lens distorts enough to matter";
    EXPECT_GT(readBack(toStoredPixels(mask, frame)), 0.985);
}

}  // namespace
}  // namespace dpl
