// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/run/evaluate.h"
#include "reconstruction/run/scan_inputs.h"

#include <gtest/gtest.h>

#include <cstdio>

#include "reconstruction/input/import/write_scan.h"
#include "reconstruction/run/cameras_file.h"
#include "reconstruction/run/clothes_in_motion.h"
#include "reconstruction/run/run_scan.h"
#include "tests/unit/recon_report/naive_scores.h"
#include "tests/unit/recon_run/toy_reconstruction.h"

namespace dpl::test {
namespace {

/** The toy on disk as a scan of the NeuMan protocol, whose cameras count in units of 40 cm. */
class Evaluate : public testing::Test {
protected:
    static constexpr double kMetresPerUnit = 0.4;
    ToyReconstruction toy;
    EvaluateOptions options;
    Evaluate() {
        toy.takePictures(toy.avatar);
        options.scan = toy.folder / "disk", options.avatar = toy.folder / "avatar.glb", options.threadCount = 2;
        must_(writeFileAtomically(options.avatar, toy.package.bytes));
        PosesFile poses;
        for (const JointData& joint : toy.avatar.joints) poses.jointNames.push_back(joint.name);
        poses.metresPerUnit = kMetresPerUnit;
        for (size_t f = 0; f < ToyReconstruction::kFrames; ++f) {
            Pose pose = toy.truth[f];
            pose.localRotations[1] = pose.localRotations[1] * glm::angleAxis(0.15f, Vec3f(1, 0, 0));  // not quite the truth
            poses.frames.push_back(
                {toy.table.scan.frames[f].name, toy.table.scan.frames[f].kind, toy.table.scan.frames[f].split, pose, std::nullopt});
        }
        shown_ = poses;
        must_(writeFileAtomically(toy.folder / "poses.json", posesToJson(poses)));
        writeScanOf("neuman");
    }
    void writeScanOf(const std::string& protocol) {
        Capture capture;
        capture.what = "toy", capture.metricWorld = false, capture.splitStated = true, capture.protocol = protocol;
        for (const ScanFrame& frame : toy.table.scan.frames) {
            CapturePicture picture{frame.name, frame.kind, frame.split, frame.imagePath, frame.maskPath, frame.camera, {}, 0, {}};
            picture.camera->viewFromWorldTranslation /= kMetresPerUnit;
            capture.pictures.push_back(picture);
        }
        std::filesystem::remove_all(options.scan);
        std::filesystem::create_directories(options.scan);
        must_(writeScan(capture, "toy", 0, options.scan, {}));
    }
    static void must_(const Status& status) {
        if (!status) throw std::runtime_error(status.error().message);
    }
    PosesFile shown_;
};

TEST_F(Evaluate, refusesTheAvatarOrTheScanOfAnother) {
    const auto refusal = [&](const PosesFile& poses) {
        must_(writeFileAtomically(toy.folder / "poses.json", posesToJson(poses)));
        const auto summary = evaluateAvatar(options, toy.progress);
        return summary ? std::string() : summary.error().message;
    };
    const Scan onDisk = must(readScan(options.scan, ScanCameras::MayLack));
    PosesFile poses = shown_;
    poses.scanHash = hashOfScan(onDisk, hashFrames(onDisk));
    for (const JointData& joint : toy.avatar.joints) poses.restPositions.push_back(joint.restPosition);
    EXPECT_EQ(refusal(poses), "") << "its own";
    PosesFile other = poses;
    other.restPositions[1].y += 0.05f;
    EXPECT_NE(refusal(other).find("another person or scan"), std::string::npos) << refusal(other);
    other = poses;
    other.scanHash = "0123";
    EXPECT_NE(refusal(other).find("is not the scan that"), std::string::npos) << refusal(other);
}

TEST_F(Evaluate, refusesAFolderThatCannotBeMadeBeforeItScores) {
    options.out = options.avatar / "report";
    options.ladder = true;  // refused after the scoring, because the toy has no truth
    const auto summary = evaluateAvatar(options, toy.progress);
    ASSERT_FALSE(summary);
    EXPECT_EQ(summary.error().code, Code::Io) << summary.error().message;
    EXPECT_NE(summary.error().message.find(options.out.string()), std::string::npos) << summary.error().message;
}

TEST_F(Evaluate, givesThePublishedScoresOfTheHeldOutFrames) {
    const std::string summary = must(evaluateAvatar(options, toy.progress));
    AvatarView view = must(AvatarView::open(toy.package.bytes, 2));
    double psnr = 0, ssim = 0;
    for (size_t f = ToyReconstruction::kTrained; f < ToyReconstruction::kFrames; ++f) {
        const ScanFrame& frame = toy.table.scan.frames[f];
        const auto rgba = must(view.draw(shown_.frames[f].pose, frame.camera));
        const ImageRgb8 truth = must(readFrameImage(frame));
        const ImageGrey8 mask = must(readFrameMask(frame));
        const auto drawn = publishedPixel(rgba, mask), expected = publishedPixel(truth, mask);
        psnr += naivePsnrDb(drawn, expected, ToyReconstruction::kSizePx, ToyReconstruction::kSizePx) / 3;
        ssim += naiveSsim(drawn, expected, ToyReconstruction::kSizePx, ToyReconstruction::kSizePx) / 3;
    }
    EXPECT_GT(psnr, 15);
    EXPECT_LT(psnr, 40);
    const size_t line = summary.find("protocol neuman, 3 held-out frames: PSNR ");
    ASSERT_NE(line, std::string::npos) << summary;
    double printedPsnr = 0, printedSsim = 0;
    ASSERT_EQ(std::sscanf(summary.c_str() + line, "protocol neuman, 3 held-out frames: PSNR %lf dB, SSIM %lf,", &printedPsnr, &printedSsim),
              2);
    // Cameras that went through the file differ by 1e-15; the rest is the rounding of the line.
    EXPECT_NEAR(printedPsnr, psnr, 0.0051);
    EXPECT_NEAR(printedSsim, ssim, 0.000051);
    EXPECT_NE(summary.find("LPIPS needs weights"), std::string::npos);
    EXPECT_NE(summary.find("masked PSNR"), std::string::npos) << "our own figures are missing";
}

TEST_F(Evaluate, withoutAProtocolThereAreOnlyOurFigures) {
    writeScanOf("");
    const std::string summary = must(evaluateAvatar(options, toy.progress));
    EXPECT_EQ(summary.find("protocol"), std::string::npos);
    EXPECT_NE(summary.find("masked PSNR"), std::string::npos);
    options.lpips = "weights.npz";
    const auto refused = evaluateAvatar(options, toy.progress);
    ASSERT_FALSE(refused);
    EXPECT_NE(refused.error().message.find("leave --lpips out"), std::string::npos);
}

TEST_F(Evaluate, camerasThatTheRunRepairedStandInForTheScans) {
    const std::string right = must(evaluateAvatar(options, toy.progress));
    for (ScanFrame& frame : toy.table.scan.frames) frame.camera.cx += 30;  // what the scan on disk says is wrong from here on
    FoundCameras repaired = camerasOf(must(readScan(options.scan)));
    writeScanOf("neuman");
    EXPECT_NE(must(evaluateAvatar(options, toy.progress)), right);
    must_(writeFileAtomically(camerasBeside(toy.folder / "poses.json"), camerasToJson(repaired)));
    EXPECT_EQ(must(evaluateAvatar(options, toy.progress)), right);
}

TEST_F(Evaluate, anAvatarWithoutPosesBesideItIsAnsweredWithTheOption) {
    std::filesystem::remove(toy.folder / "poses.json");
    const auto refused = evaluateAvatar(options, toy.progress);
    ASSERT_FALSE(refused);
    EXPECT_NE(refused.error().message.find("poses.json: no such file"), std::string::npos) << refused.error().message;
    EXPECT_NE(refused.error().message.find("--poses"), std::string::npos);
}

TEST_F(Evaluate, generalSplatsAreRefusedByName) {
    options.avatar = toy.folder / "guitar.ply";
    must_(writeFileAtomically(options.avatar, "ply\nformat binary_little_endian 1.0\nelement vertex 0\nend_header\n"));
    const auto scored = evaluateAvatar(options, toy.progress);
    ASSERT_FALSE(scored);
    EXPECT_NE(scored.error().message.find("guitar.ply holds general splats, which have no poses"), std::string::npos)
        << scored.error().message;
    const auto worn = clothesInMotion(options.avatar, "walk.bvh", {}, false, toy.progress);
    ASSERT_FALSE(worn);
    EXPECT_NE(worn.error().message.find("guitar.ply holds general splats, which have no clothes"), std::string::npos)
        << worn.error().message;
}

TEST_F(Evaluate, posesOfOlderFilesWithoutAScaleAreRefused) {
    PosesFile old = shown_;
    old.metresPerUnit = 0;
    must_(writeFileAtomically(toy.folder / "poses.json", posesToJson(old)));
    const auto refused = evaluateAvatar(options, toy.progress);
    ASSERT_FALSE(refused);
    EXPECT_NE(refused.error().message.find("run doppel reconstruct again"), std::string::npos);
}

}  // namespace
}  // namespace dpl::test
