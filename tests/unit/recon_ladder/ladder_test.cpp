// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/judging/ladder/ladder.h"

#include <gtest/gtest.h>

#include <cmath>

#include "reconstruction/base/image_codec.h"
#include "reconstruction/judging/report/score.h"
#include "sdk/avatar/posed_mesh.h"
#include "tests/unit/recon_ladder/toy_truth.h"

namespace dpl::test {
namespace {

class LadderTest : public testing::Test {
protected:
    LadderTest() {
        toy_.takePictures(toy_.avatar);
        writeTruth(toy_);
        for (size_t f = 0; f < ToyReconstruction::kFrames; ++f) {
            const ScanFrame& frame = toy_.table.scan.frames[f];
            poses_.frames.push_back({frame.name, frame.kind, frame.split, toy_.truth[f], std::nullopt});
        }
        bend(poses_.frames[kMoving].pose, 0.25f);
    }
    static void bend(Pose& pose, float angleRad) {
        pose.localRotations[1] = pose.localRotations[1] * glm::angleAxis(angleRad, Vec3f(0, 0, 1));
    }
    /** The cell of a rung and a group. */
    LadderCell cell(const std::string& rung, FrameKind kind, Split split) {
        auto ladder = measureLadder({toy_.table.scan, toy_.metric.cameras, toy_.avatar, poses_}, toy_.jobs);
        if (!ladder) throw std::runtime_error(ladder.error().message);
        for (const LadderRung& r : (*ladder)->rungs)
            for (size_t g = 0; g < (*ladder)->groups.size(); ++g)
                if (r.key == rung && (*ladder)->groups[g].kind == kind && (*ladder)->groups[g].split == split) return r.cells[g];
        throw std::runtime_error("no such cell");
    }

    /** Masked PSNR of the moving held-out frame, drawn by the public renderer in a pose. */
    double shownDb(const Pose& pose) {
        AvatarView view = must(AvatarView::open(toy_.package.bytes, 2));
        const FramePicture picture = must(readFramePicture(toy_.table.scan.frames[kMoving]));
        return scorePicture(must(view.draw(pose, toy_.metric.cameras[kMoving])), picture.image, picture.mask).maskedPsnrDb;
    }

    static constexpr size_t kMoving = 7;  // held out
    ToyReconstruction toy_;
    PosesFile poses_;
};

TEST_F(LadderTest, aWrongPoseCostsWhatTheTruePoseBringsBack) {
    const LadderCell wrong = cell("as_is", FrameKind::Dynamic, Split::Test), truth = cell("true_poses", FrameKind::Dynamic, Split::Test),
                     surface = cell("true_surface", FrameKind::Dynamic, Split::Test);
    EXPECT_EQ(wrong.frames, 1u);
    EXPECT_GT(*wrong.surfaceMm, 20);
    EXPECT_LT(*truth.surfaceMm, 2) << "half of the ball is seen by no still frame, and there the true surface is only near";
    EXPECT_GT(truth.maskedPsnrDb, wrong.maskedPsnrDb + 5);
    EXPECT_GT(surface.maskedPsnrDb, wrong.maskedPsnrDb + 5);
    EXPECT_NEAR(truth.maskedPsnrDb, shownDb(toy_.truth[kMoving]), 0.1) << "the avatar is the truth, so nothing else is lost";
}

TEST_F(LadderTest, asItIsAgreesWithThePublicRenderer) {
    EXPECT_NEAR(cell("as_is", FrameKind::Dynamic, Split::Test).maskedPsnrDb, shownDb(poses_.frames[kMoving].pose), 0.05);
}

TEST_F(LadderTest, theLightOfTheSceneIsDrawnToo) {
    const double unlitDb = shownDb(poses_.frames[kMoving].pose);
    toy_.avatar.light.irradiance = {0.9f, 0.3f, 0.9f};
    toy_.package.bytes = must(writeAvatar(toy_.avatar));
    const double litDb = shownDb(poses_.frames[kMoving].pose);
    EXPECT_GT(std::abs(litDb - unlitDb), 0.5);
    EXPECT_NEAR(cell("as_is", FrameKind::Dynamic, Split::Test).maskedPsnrDb, litDb, 0.05);
}

TEST_F(LadderTest, aShapeThatTheRigCannotMakeShowsInTheSurfaceAlone) {
    // The true surface of the moving frame is taller than any pose of the rig, as cloth may be, and its picture shows it.
    AvatarData tall = toy_.avatar;
    for (Vec3f& p : tall.mesh.restPositions) p.y = 0.7f + 1.15f * (p.y - 0.7f);
    toy_.takePictures(tall);
    for (size_t f : {size_t(3), size_t(4), kMoving})
        mustWrite(toy_.table.scan.root / "posed" / (toy_.table.scan.frames[f].name + ".bin"),
                  floatsOf(ballIn(tall, toy_.truth[f], toy_.jobs)));
    const LadderCell poses = cell("true_poses", FrameKind::Dynamic, Split::Test),
                     surface = cell("true_surface", FrameKind::Dynamic, Split::Test);
    EXPECT_GT(*poses.surfaceMm, 5);
    EXPECT_GT(surface.maskedPsnrDb, poses.maskedPsnrDb + 3);
}

TEST_F(LadderTest, garmentsAreComparedWithAndWithoutPoseCorrectives) {
    // The true ball is the avatar with correctives; a half of it counts as a simulated garment.
    AvatarData& avatar = toy_.avatar;
    const MeshData& mesh = avatar.mesh;
    const auto half = uint32_t(mesh.triangles.size() / 2), rest = uint32_t(mesh.triangles.size()) - half;
    writeTruth(toy_, half);
    avatar.mesh.layers = {{"body", "body", 0, uint32_t(mesh.restPositions.size()), 0, half}, {"top", "garment", 0, 0, half, rest}};
    avatar.correctives = ballCorrectives(mesh, Vec4f(0), Vec4f(0, 0.05f, 0, 0));
    poses_.frames[kMoving].pose = toy_.truth[kMoving];
    PosedMesh posed;
    posed.pose({avatar.joints, mesh, avatar.correctives, restTriangles(mesh)}, toy_.truth[kMoving], toy_.jobs);
    mustWrite(toy_.table.scan.root / "posed" / (toy_.table.scan.frames[kMoving].name + ".bin"),
              floatsOf({posed.positions().begin(), posed.positions().end()}));
    const auto ladder = must(measureLadder({toy_.table.scan, toy_.metric.cameras, avatar, poses_}, toy_.jobs));
    ASSERT_TRUE(ladder);
    ASSERT_EQ(ladder->garments.size(), 2u);
    const GarmentRow& row = ladder->garments[0];
    EXPECT_EQ(row.garment, "top");
    EXPECT_EQ(row.poses, GarmentPoses::Fitted);
    const GarmentCell& cell = row.cells.back();  // dynamic, test
    EXPECT_EQ(cell.frames, 1u);
    EXPECT_NEAR(cell.correctedMm, 0, 0.01);
    EXPECT_GT(cell.plainMm, 1);
    EXPECT_GT(cell.pointPlainMm, cell.pointCorrectedMm + 1);
    EXPECT_GE(cell.pointPlainMm, cell.plainMm) << "the nearest place is the nearest";
}

TEST_F(LadderTest, aFinerTruthIsTheFloorOfNoise) {
    // The finer truth differs from the picture by 10 levels everywhere, as noise would.
    const ScanFrame& frame = toy_.table.scan.frames[kMoving];
    const FramePicture picture = must(readFramePicture(frame));
    const uint32_t w = 2 * picture.image.widthPx, h = 2 * picture.image.heightPx;
    std::vector<uint8_t> rgb, mask;
    for (uint32_t y = 0; y < h; ++y)
        for (uint32_t x = 0; x < w; ++x) {
            const size_t i = size_t(y / 2) * picture.image.widthPx + x / 2;
            mask.push_back(picture.mask.pixels[i]);
            for (size_t c = 0; c < 3; ++c) {
                const uint8_t value = picture.image.pixels[3 * i + c];
                rgb.push_back(uint8_t(value > 128 ? value - 10 : value + 10));
            }
        }
    const std::filesystem::path file = toy_.table.scan.root / "hires/x2" / frame.name;
    mustWrite(file.string() + ".jpg", must(encodePng(rgb, w, h, 3)));
    mustWrite(file.string() + ".mask.png", must(encodePng(mask, w, h, 1)));
    const double expectedDb = 20 * std::log10(255.0 / 10);
    for (const char* rung : {"noise_floor", "noise_floor_inside"}) {
        EXPECT_NEAR(cell(rung, FrameKind::Dynamic, Split::Test).maskedPsnrDb, expectedDb, 1e-3) << rung;
        EXPECT_EQ(cell(rung, FrameKind::StaticFull, Split::Train).frames, 0u) << "these frames have none";
    }
}

TEST_F(LadderTest, withoutAFinerTruthNothingIsSaidOfNoise) {
    const auto ladder = must(measureLadder({toy_.table.scan, toy_.metric.cameras, toy_.avatar, poses_}, toy_.jobs));
    for (const LadderRung& rung : ladder->rungs) EXPECT_FALSE(rung.key.starts_with("noise")) << rung.key;
}

TEST_F(LadderTest, aNarrowWindowOfLightGainsMoreAndStillFramesAreScoredWithIt) {
    for (const FrameKind kind : {FrameKind::Dynamic, FrameKind::StaticFull}) {
        const double wide = cell("true_surface_light", kind, Split::Test).maskedPsnrDb;
        const double fine = cell("true_surface_light_fine", kind, Split::Test).maskedPsnrDb;
        EXPECT_GT(fine, wide);
        EXPECT_GT(cell("true_surface_light_finest", kind, Split::Test).maskedPsnrDb, fine);
    }
}

TEST_F(LadderTest, aRungThatDoesNotApplyIsEmpty) {
    EXPECT_EQ(cell("pose_fit", FrameKind::Dynamic, Split::Test).frames, 0u) << "no fitted pose is known";
    EXPECT_EQ(cell("as_is", FrameKind::StaticFull, Split::Validation).frames, 0u);
    EXPECT_EQ(cell("as_is", FrameKind::StaticFull, Split::Train).frames, 3u);
}

TEST_F(LadderTest, aScanWithoutTruthHasNone) {
    std::filesystem::remove_all(toy_.table.scan.root / "geometry");
    const auto ladder = measureLadder({toy_.table.scan, toy_.metric.cameras, toy_.avatar, poses_}, toy_.jobs);
    ASSERT_TRUE(ladder) << ladder.error().message;
    EXPECT_FALSE(*ladder);
}

TEST_F(LadderTest, posesOfAnotherScanAreRefused) {
    poses_.frames.pop_back();
    EXPECT_FALSE(measureLadder({toy_.table.scan, toy_.metric.cameras, toy_.avatar, poses_}, toy_.jobs));
}

}  // namespace
}  // namespace dpl::test
