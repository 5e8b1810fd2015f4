// SPDX-License-Identifier: Apache-2.0
// Training on without a part: what remains makes up for it, and the part does not come back.
#include "reconstruction/training/trainer/retrain.h"

#include <gtest/gtest.h>

#include "reconstruction/judging/evidence/evidence_file.h"
#include "reconstruction/judging/report/score.h"
#include "reconstruction/run/resumed_training.h"
#include "reconstruction/run/stage_body_map.h"
#include "reconstruction/run/stage_evidence.h"
#include "reconstruction/run/stage_package.h"
#include "sdk/avatar/cloth_bounds.h"
#include "tests/unit/heard_task.h"
#include "tests/unit/recon_run/toy_reconstruction.h"

namespace dpl::test {
namespace {

constexpr RetrainParts kNoLight{.correctiveOffsets = true, .correctiveLight = false};

std::vector<TrainFrame> framesOfToy(ToyReconstruction& toy) {
    return toy.table.frames(Split::Train, toy.metric.cameras, toy.truth).frames;
}

double scoreOf(const AvatarData& avatar, const std::vector<TrainFrame>& frames) {
    AvatarView view = must(AvatarView::open(bytesOf(avatar), 2));
    double sum = 0;
    for (const TrainFrame& frame : frames) {
        const auto picture = must(frame.picture.get());
        sum += scorePicture(must(view.draw(frame.pose, frame.camera)), picture->image, picture->mask).maskedPsnrDb;
    }
    return sum / double(frames.size());
}

TEST(Retrain, colourMakesUpForLightThatWasTakenAway) {
    ToyReconstruction toy;
    // The mode is 0 in still poses, so light alone could not explain that the truth is brighter everywhere.
    toy.avatar.correctives = ballCorrectives(toy.avatar.mesh, {0, 0, 0, 0.2f}, {0, 0, 0, 0.2f});
    AvatarData brighter = toy.avatar;
    for (size_t i = 0; i < brighter.splats.count(); ++i)
        for (size_t c = 0; c < 3; ++c) brighter.splats.sh[i * (brighter.splats.sh.size() / brighter.splats.count()) + c] += 0.3f;
    toy.takePictures(brighter);
    const auto frames = framesOfToy(toy);
    AvatarData without = toy.avatar;
    removePart(without, AvatarPart::CorrectiveLight);
    const CoOptimiseSettings settings = retrainSettings(settingsOf({}).training, kNoLight, 60, without.splats.shDegree);
    const AvatarData after = must(retrain(without, {}, frames, settings, toy.jobs));
    EXPECT_GT(scoreOf(after, frames), scoreOf(without, frames) + 1.0);
    EXPECT_EQ(after.splats.count(), without.splats.count());
    EXPECT_NE(after.mesh.restPositions, without.mesh.restPositions);
    EXPECT_FALSE(hasPart(after, AvatarPart::CorrectiveLight)) << "light was learned again";
    EXPECT_TRUE(hasPart(after, AvatarPart::CorrectiveOffsets)) << "offsets may be learned";
}

TEST(Retrain, doesNotDependOnTheNumberOfThreads) {
    ToyReconstruction toy;
    toy.takePictures(toy.avatar);
    const auto frames = framesOfToy(toy);
    const CoOptimiseSettings settings = retrainSettings(settingsOf({}).training, {}, 12, toy.avatar.splats.shDegree);
    Jobs one(1), three(3);
    EXPECT_EQ(bytesOf(must(retrain(toy.avatar, {}, frames, settings, one))),
              bytesOf(must(retrain(toy.avatar, {}, frames, settings, three))));
}

TEST(Retrain, aStoppedOneGoesOnFromItsCheckpointToTheSameBytes) {
    ToyReconstruction toy;
    toy.takePictures(toy.avatar);
    const auto frames = framesOfToy(toy);
    const CoOptimiseSettings settings = retrainSettings(settingsOf({}).training, {}, 24, toy.avatar.splats.shDegree);
    const auto checkpoint = toy.folder / "checkpoint";
    std::vector<uint32_t> starts;
    const auto go = [&] {
        return retrain(toy.avatar, {}, frames, settings, toy.jobs, [&](CoOptimiser& trainer) {
            const Status ran = trainFromCheckpoint(trainer, checkpoint, 1e9, toy.progress);
            starts.push_back(trainer.step());
            return ran;
        });
    };
    HeardTask stopped(9);
    {
        const TaskScope scope(&stopped);
        const auto cut = go();
        ASSERT_FALSE(cut);
        EXPECT_EQ(cut.error().code, Code::Cancelled);
    }
    EXPECT_TRUE(std::filesystem::exists(checkpoint));
    EXPECT_GT(starts[0], 0u);
    EXPECT_LT(starts[0], 24u);
    HeardTask heard;
    const TaskScope scope(&heard);
    const AvatarData continued = must(go());
    ASSERT_FALSE(heard.heard.empty());
    EXPECT_NEAR(heard.heard.front().first, starts[0] / 24.0, 1e-9) << "the second run did not begin where the first ended";
    EXPECT_EQ(bytesOf(continued), bytesOf(must(retrain(toy.avatar, {}, frames, settings, toy.jobs))));
}

/** The avatar that the package stage ships when the evidence keeps or drops the light. */
AvatarData packaged(ToyReconstruction& toy, const AssembledAvatar& assembled, bool keepsLight) {
    dpl::Run run(toy.chain, toy.jobs, toy.progress);
    run.put(toy.layers, "layers");
    run.put(SettingsAfterTraining{toy.settings}, "settings");
    run.put(toy.chosen, "chosen");
    run.put(MappedBody(), "map");
    run.put(assembled, "assembled");
    run.put(MeasuredParts{{{AvatarPart::CorrectiveLight, {"light", keepsLight, 0.0f, 0, "for the test"}}}},
            keepsLight ? "kept" : "dropped");
    return must(readAvatar(must(run.get<Package>())->bytes));
}

TEST(Retrain, whatShipsHasMadeUpForAPartThatDidNotPay) {
    ToyReconstruction toy;
    toy.settings.training.steps = 750, toy.settings.polishSteps = 2;
    toy.avatar.correctives = ballCorrectives(toy.avatar.mesh, {0, 0, 0, 0.2f}, {0, 0, 0, 0.2f});
    AvatarData brighter = toy.avatar;
    for (size_t i = 0; i < brighter.splats.count(); ++i)
        for (size_t c = 0; c < 3; ++c) brighter.splats.sh[i * (brighter.splats.sh.size() / brighter.splats.count()) + c] += 0.3f;
    toy.takePictures(brighter);
    const AssembledAvatar assembled{toy.avatar, framesOfToy(toy), {}};
    const AvatarData kept = packaged(toy, assembled, true), dropped = packaged(toy, assembled, false);
    EXPECT_TRUE(hasPart(kept, AvatarPart::CorrectiveLight));
    EXPECT_FALSE(hasPart(dropped, AvatarPart::CorrectiveLight));
    EXPECT_GT(scoreOf(dropped, assembled.frames), scoreOf(kept, assembled.frames) + 1.0) << "nothing was taken, so nothing was made up for";
}

TEST(Retrain, whatShipsAfterItLoadsAsItIsWritten) {
    ToyReconstruction toy;
    toy.settings.training.steps = 250, toy.settings.polishSteps = 2;
    AvatarData& avatar = toy.avatar;
    avatar.joints[0].humanoidBone = "hips";
    avatar.joints.resize(2);
    const JointData thigh = avatar.joints[1];
    for (const auto& [bone, parent, downM] :
         {std::tuple("rightUpperLeg", 0, 0.0f), std::tuple("leftLowerLeg", 1, 0.4f), std::tuple("rightLowerLeg", 2, 0.4f)}) {
        avatar.joints.push_back({bone, parent, thigh.restPosition - Vec3f(0, downM, 0), bone});
    }
    avatar.joints[1].humanoidBone = "leftUpperLeg";
    for (Pose& pose : toy.truth) pose.localRotations.resize(avatar.joints.size(), Quatf(1, 0, 0, 0));
    MeshData& mesh = avatar.mesh;
    mesh.layers = {{"skirt", "garment", 0, uint32_t(mesh.restPositions.size()), 0, uint32_t(mesh.triangles.size())}};
    for (size_t v = 0; v < mesh.restPositions.size(); ++v)  // torn between the legs, as training may leave it
        mesh.jointIndices[v] = {mesh.restPositions[v].x > 0 ? 1 : 2, 0, 0, 0}, mesh.jointWeights[v] = {255, 0, 0, 0};
    avatar.correctives = ballCorrectives(mesh, {0, 0, 0, 0.2f}, {0, 0, 0, 0.2f});
    toy.takePictures(avatar);
    const AssembledAvatar assembled{avatar, framesOfToy(toy), {}};
    ASSERT_GT(boundGarments(avatar.joints, mesh).evened, 0u) << "nothing was torn";
    AvatarData shipped = packaged(toy, assembled, /*keepsLight=*/false);
    EXPECT_EQ(boundGarments(shipped.joints, shipped.mesh).evened, 0u) << "a reader would mend it";
}

TEST(Retrain, whatShipsHasTheExpressionsOfItsBody) {
    ToyReconstruction toy;
    toy.settings.polishSteps = 2;
    toy.takePictures(toy.avatar);
    const AssembledAvatar assembled{toy.avatar, framesOfToy(toy), {}};
    const AvatarData still = packaged(toy, assembled, true);
    EXPECT_TRUE(still.expressions.empty());
    EXPECT_NE(still.evidence.back().reason.find("brings no shapes"), std::string::npos);
    toy.chosen.body.name = "ball", toy.chosen.body.mesh = toy.avatar.mesh, toy.chosen.faceHash = "smile";
    toy.chosen.body.mesh.colours.clear();  // of one colour: it hides nothing
    toy.chosen.body.expressions = {{23, std::vector<Vec3f>(toy.avatar.mesh.restPositions.size(), Vec3f(0, 0.01f, 0))}};
    const AvatarData smiling = packaged(toy, assembled, true);
    EXPECT_EQ(smiling.expressions.shapes, std::vector<uint8_t>{23});
    EXPECT_NE(smiling.evidence.back().reason.find("face not filmed"), std::string::npos);
    EXPECT_EQ(smiling.mesh.restPositions, still.mesh.restPositions);
    EXPECT_EQ(smiling.splats.sh, still.splats.sh);
    EXPECT_EQ(smiling.splats.uv, still.splats.uv);
}

}  // namespace
}  // namespace dpl::test
