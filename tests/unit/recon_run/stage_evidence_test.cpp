// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "reconstruction/judging/evidence/jury_scores.h"
#include "reconstruction/run/stage_assemble.h"
#include "reconstruction/run/stage_evidence.h"
#include "tests/unit/recon_run/toy_reconstruction.h"

namespace dpl::test {
namespace {

/** Runs the stage for `toy.avatar` with its training frames. */
Result<MeasuredParts> measure(ToyReconstruction& toy) {
    toy.settings.training.steps = 250;  // so an avatar is trained on for 20 steps
    toy.settings.poseFit.iterations = 30;
    dpl::Run run(toy.chain, toy.jobs, toy.progress);
    toy.giveTrained(run);
    DPL_TRY(const FrameTable* table, run.get<FrameTable>());
    FrameSet set = table->frames(Split::Train, toy.metric.cameras, toy.truth);
    run.put(AssembledAvatar{toy.avatar, std::move(set.frames), {}}, toy.trainingKey);
    DPL_TRY(const MeasuredParts* measured, run.get<MeasuredParts>());
    return *measured;
}

const EvidenceData& rowOf(const MeasuredParts& measured, AvatarPart part) {
    for (const PartEvidence& p : measured.parts)
        if (p.part == part) return p.row;
    throw std::runtime_error("no row for the part");
}

TEST(StageEvidence, keepsAPartThatHelpsAndDropsOneThatDoesNot) {
    ToyReconstruction toy;
    toy.avatar.correctives = ballCorrectives(toy.avatar.mesh, {0.04f, 0, 0, 0}, {0, 0, 0.04f, 0});
    for (const bool offsetsAreTrue : {true, false}) {
        AvatarData shown = toy.avatar;
        removePart(shown, offsetsAreTrue ? AvatarPart::ViewDependentColour : AvatarPart::CorrectiveOffsets);
        toy.takePictures(shown);
        toy.trainingKey = offsetsAreTrue ? "first" : "second";
        const auto measured = measure(toy);
        ASSERT_TRUE(measured) << measured.error().message;
        ASSERT_EQ(measured->parts.size(), 5u);
        const EvidenceData &offsets = rowOf(*measured, AvatarPart::CorrectiveOffsets),
                           &colour = rowOf(*measured, AvatarPart::ViewDependentColour);
        EXPECT_EQ(offsets.kept, offsetsAreTrue);
        EXPECT_EQ(colour.kept, !offsetsAreTrue);
        const EvidenceData &kept = offsetsAreTrue ? offsets : colour, &dropped = offsetsAreTrue ? colour : offsets;
        EXPECT_GT(kept.gainDb, 0.5f);
        EXPECT_LT(dropped.gainDb, -0.5f) << "the truth does not have this part";
        EXPECT_GT(kept.bytes, 0u);
        EXPECT_EQ(dropped.bytes, 0u);
    }
}

TEST(StageEvidence, keepsLightThatIsThereAndDropsOneThatIsNot) {
    for (const bool lightIsTrue : {true, false}) {
        ToyReconstruction toy;
        AvatarData shown = toy.avatar;
        toy.avatar.light.irradiance = {-0.9f, 0.3f, -0.5f, 0, 0, 0, 0, 0};
        if (lightIsTrue) shown.light = toy.avatar.light;
        toy.takePictures(shown);
        toy.trainingKey = lightIsTrue ? "first" : "second";
        const auto measured = measure(toy);
        ASSERT_TRUE(measured) << measured.error().message;
        const EvidenceData& light = rowOf(*measured, AvatarPart::SceneLight);
        EXPECT_EQ(light.kept, lightIsTrue) << light.gainDb;
        EXPECT_GT(lightIsTrue ? light.gainDb : -light.gainDb, 0.1f);
    }
}

TEST(StageEvidence, validationFramesDecideAgainstTrainingFrames) {
    for (const bool validationShowsIt : {true, false}) {
        ToyReconstruction toy;
        toy.avatar.correctives = ballCorrectives(toy.avatar.mesh, {0.04f, 0, 0, 0}, {0, 0, 0.04f, 0});
        AvatarData without = toy.avatar;
        removePart(without, AvatarPart::CorrectiveOffsets);
        toy.takePictures(validationShowsIt ? without : toy.avatar);
        toy.takePictures(validationShowsIt ? toy.avatar : without, ToyReconstruction::kTrained);
        for (size_t f = ToyReconstruction::kTrained; f < ToyReconstruction::kFrames; ++f)
            toy.table.scan.frames[f].split = Split::Validation;
        const auto measured = measure(toy);
        ASSERT_TRUE(measured) << measured.error().message;
        const EvidenceData& offsets = rowOf(*measured, AvatarPart::CorrectiveOffsets);
        EXPECT_EQ(offsets.kept, validationShowsIt) << offsets.gainDb << " dB";
        EXPECT_NE(offsets.reason.find("3 validation frames"), std::string::npos) << offsets.reason;
    }
}

TEST(StageEvidence, closeupsAreJudgedByTheirDetailAlone) {
    ToyReconstruction toy;
    toy.avatar.correctives = ballCorrectives(toy.avatar.mesh, {0.04f, 0, 0, 0}, {0, 0, 0.04f, 0});
    toy.takePictures(toy.avatar);
    for (size_t f = ToyReconstruction::kTrained; f < ToyReconstruction::kFrames; ++f) toy.table.scan.frames[f].split = Split::Validation;
    toy.table.scan.frames[ToyReconstruction::kTrained].kind = FrameKind::StaticCloseup;
    const auto measured = measure(toy);
    ASSERT_TRUE(measured) << measured.error().message;
    const std::string& reason = rowOf(*measured, AvatarPart::CorrectiveOffsets).reason;
    for (const char* part : {"2 validation frames", "on 1 close-ups", "flicker", "inside the body"})
        EXPECT_NE(reason.find(part), std::string::npos) << reason;
}

TEST(StageEvidence, aMannequinYieldsNoNetworkAndEvenLightNoLight) {
    for (const bool mannequin : {true, false}) {
        ToyReconstruction toy;
        toy.avatar.correctives = ballCorrectives(toy.avatar.mesh, {0.04f, 0, 0, 0.4f}, {0, 0, 0.04f, -0.4f});
        AvatarData shown = toy.avatar;
        removePart(shown, AvatarPart::CorrectiveLight);
        if (mannequin) removePart(shown, AvatarPart::CorrectiveOffsets), dropEmptyCorrectives(shown);
        toy.takePictures(shown);
        const auto measured = measure(toy);
        ASSERT_TRUE(measured) << measured.error().message;
        AvatarData left = toy.avatar;
        for (const PartEvidence& p : measured->parts)
            if (!p.row.kept) removePart(left, p.part);
        dropEmptyCorrectives(left);
        EXPECT_FALSE(rowOf(*measured, AvatarPart::CorrectiveLight).kept);
        EXPECT_EQ(left.correctives.empty(), mannequin);
    }
}

TEST(StageEvidence, heldOutFramesDecideNothing) {
    ToyReconstruction toy;
    toy.avatar.correctives = ballCorrectives(toy.avatar.mesh, {0.04f, 0, 0, 0}, {0, 0, 0.04f, 0});
    toy.takePictures(toy.avatar);
    for (size_t f = ToyReconstruction::kTrained; f < ToyReconstruction::kFrames; ++f)
        std::filesystem::remove(toy.table.scan.frames[f].imagePath);
    const auto measured = measure(toy);
    ASSERT_TRUE(measured) << measured.error().message;
    const EvidenceData& offsets = rowOf(*measured, AvatarPart::CorrectiveOffsets);
    EXPECT_TRUE(offsets.kept);
    EXPECT_NE(offsets.reason.find("5 training frames"), std::string::npos) << offsets.reason;
}

TEST(StageEvidence, aPartWithTooSmallAGainIsDropped) {
    ToyReconstruction toy;
    toy.avatar.correctives = ballCorrectives(toy.avatar.mesh, {1e-5f, 0, 0, 0}, {0, 0, 1e-5f, 0});
    toy.takePictures(toy.avatar);
    const auto measured = measure(toy);
    ASSERT_TRUE(measured) << measured.error().message;
    const EvidenceData& offsets = rowOf(*measured, AvatarPart::CorrectiveOffsets);
    EXPECT_FALSE(offsets.kept) << "10 µm are true, but nobody sees them";
    EXPECT_NEAR(offsets.gainDb, 0, 0.05);
    EXPECT_TRUE(rowOf(*measured, AvatarPart::ViewDependentColour).kept);
}

TEST(StageEvidence, aKilledOneKeepsTheScoresThatItHad) {
    ToyReconstruction toy;
    toy.avatar.correctives = ballCorrectives(toy.avatar.mesh, {0.04f, 0, 0, 0}, {0, 0, 0.04f, 0});
    toy.takePictures(toy.avatar);
    const auto whole = measure(toy);
    ASSERT_TRUE(whole) << whole.error().message;

    // As if the process had died while it judged the avatar without colour. The planted score shows whether anybody read it.
    const auto folder = toy.folder / "out" / "stages" / "evidence", work = std::filesystem::path(folder.string() + ".work");
    const std::string key = nlohmann::json::parse(must(readFile(folder / "manifest.json")))["key"];
    std::filesystem::rename(folder, work);
    std::filesystem::remove(work / "evidence.json");
    ASSERT_TRUE(
        writeFileAtomically(work / "manifest.json", nlohmann::json{{"stage", "evidence"}, {"key", key}, {"finished", false}}.dump()));
    JuryScores scores(work / "scores.json");
    JuryScore planted = scores.find("corrective-offsets").value();
    planted.maskedPsnrDb -= 7;
    ASSERT_TRUE(scores.add("corrective-offsets", planted));

    const auto again = measure(toy);
    ASSERT_TRUE(again) << again.error().message;
    EXPECT_NEAR(rowOf(*again, AvatarPart::CorrectiveOffsets).gainDb, rowOf(*whole, AvatarPart::CorrectiveOffsets).gainDb + 7, 1e-4);
    EXPECT_EQ(rowOf(*again, AvatarPart::ViewDependentColour).gainDb, rowOf(*whole, AvatarPart::ViewDependentColour).gainDb);
    for (const auto& file : std::filesystem::directory_iterator(folder)) EXPECT_NE(file.path().extension(), ".checkpoint") << file.path();
}

TEST(StageEvidence, saysWhatWasNotTrained) {
    ToyReconstruction toy;
    removePart(toy.avatar, AvatarPart::ViewDependentColour);
    toy.takePictures(toy.avatar);
    const auto measured = measure(toy);
    ASSERT_TRUE(measured) << measured.error().message;
    for (const PartEvidence& p : measured->parts) {
        EXPECT_FALSE(p.row.kept);
        EXPECT_TRUE(p.row.reason.starts_with(p.part == AvatarPart::SceneLight ? "not found" : "not trained")) << p.row.reason;
    }
}

}  // namespace
}  // namespace dpl::test
