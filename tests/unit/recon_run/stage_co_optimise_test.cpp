// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <csignal>
#include <nlohmann/json.hpp>

#include "reconstruction/run/run_news.h"
#include "tests/unit/recon_run/toy_reconstruction.h"
#include "tests/unit/wait_until.h"

namespace dpl::test {
namespace {

namespace fs = std::filesystem;

/** The smallest budget gives the fewest steps, a hundred, on any machine. */
RunSettings withBudget() {
    RunSettings settings = settingsOf({});
    settings.training.init.splatCount = 300, settings.training.maxSplats = 400;
    settings.timeBudgetMinutes = 1e-9;
    return settings;
}

class StageCoOptimise : public testing::Test {
protected:
    StageCoOptimise() {
        toy_.takePictures(toy_.avatar);
        toy_.layers.clothed.mesh = toy_.avatar.mesh;
        toy_.settings = withBudget();
    }
    struct Trained : Training {
        std::string key;
    };
    Result<Trained> train() {
        dpl::Run run(toy_.chain, toy_.jobs, toy_.progress);
        toy_.give(run);
        DPL_TRY(const Training* training, run.get<Training>());
        DPL_TRY(const std::string key, run.keyOf<Training>());
        return Trained{*training, key};
    }

    /** Makes the finished stage look as if the process had died after the last file of the work folder, before the manifest. */
    void killBeforeTheManifest() {
        const std::string key = nlohmann::json::parse(must(readFile(folder_ / "manifest.json")))["key"];
        fs::rename(folder_, work_);
        const std::string manifest = nlohmann::json{{"stage", "co-optimise"}, {"key", key}, {"finished", false}}.dump();
        ASSERT_TRUE(writeFileAtomically(work_ / "manifest.json", manifest));
    }

    ToyReconstruction toy_;
    const fs::path folder_ = toy_.folder / "out" / "stages" / "co-optimise", work_ = folder_.string() + ".work";
};

TEST(SlowestSteps, haveFullSizeAndEverySplat) {
    const CoOptimiseSettings given = settingsOf({}).training, slowest = slowestSteps(given);
    ASSERT_LT(given.init.splatCount, given.maxSplats);
    EXPECT_EQ(slowest.init.splatCount, given.maxSplats);
    EXPECT_TRUE(slowest.fullResolutionOnly);
    EXPECT_EQ(slowest.steps, given.steps);
}

TEST_F(StageCoOptimise, aStopIsHeardInTheProbe) {
    GTEST_FLAG_SET(death_test_style, "threadsafe");  // a process of its own: the flag of Ctrl-C cannot be cleared
    const auto stopped = [&] {
        installSignalHandlers();
        std::raise(SIGINT);
        const auto training = train();
        const bool cancelled = !training && training.error().code == Code::Cancelled;
        const bool probed = fs::exists(work_ / "steps.txt");
        fs::remove_all(toy_.folder);
        std::_Exit(cancelled && !probed ? 0 : 1);
    };
    EXPECT_EXIT(stopped(), testing::ExitedWithCode(0), "");
}

TEST_F(StageCoOptimise, aStopInTrainingLeavesACheckpoint) {
    GTEST_FLAG_SET(death_test_style, "threadsafe");
    toy_.settings.training.learnLight = false;  // else the stop is heard before the first step, when there is nothing to keep
    const auto stopped = [&] {
        must(train());
        killBeforeTheManifest();  // leaves steps.txt, so there is no probe
        fs::remove(work_ / "trained.bin");
        installSignalHandlers();
        std::raise(SIGINT);
        const auto training = train();
        const bool cancelled = !training && training.error().code == Code::Cancelled;
        const bool kept = fs::exists(work_ / "checkpoint");
        fs::remove_all(toy_.folder);
        std::_Exit(cancelled && kept ? 0 : 1);
    };
    EXPECT_EXIT(stopped(), testing::ExitedWithCode(0), "");
}

TEST_F(StageCoOptimise, anotherRunGoesOnFromACheckpoint) {
    GTEST_FLAG_SET(death_test_style, "threadsafe");
    const fs::path kept = fs::path(testing::TempDir()) / "doppel_stage_from.checkpoint";
    const auto leave = [&] {  // a stopped run's checkpoint
        toy_.settings.timeBudgetMinutes = 0, toy_.settings.training.steps = 300;
        toy_.settings.training.learnLight = false;
        installSignalHandlers();
        std::raise(SIGINT);
        (void)train();
        std::error_code failed;
        fs::copy_file(work_ / "checkpoint", kept, fs::copy_options::overwrite_existing, failed);
        fs::remove_all(toy_.folder);
        std::_Exit(failed ? 1 : 0);
    };
    EXPECT_EXIT(leave(), testing::ExitedWithCode(0), "");
    toy_.settings.timeBudgetMinutes = 0, toy_.settings.training.steps = 120;
    toy_.settings.training.learnLight = false;
    const std::string alone = must(train()).key;
    toy_.settings.from = kept;
    const auto branched = train();
    ASSERT_TRUE(branched) << branched.error().message;
    EXPECT_NE(branched->key, alone) << "where it began is part of the key";
    EXPECT_EQ(branched->steps, 120u);
    toy_.settings.training.steps = 60, toy_.settings.training.init.shDegree = 3;
    const auto refused = train();
    ASSERT_FALSE(refused);
    EXPECT_NE(refused.error().message.find("keep init.shDegree"), std::string::npos) << refused.error().message;
    fs::remove(kept);
    EXPECT_FALSE(train()) << "the checkpoint is gone";
}

TEST_F(StageCoOptimise, theStepsThatABudgetAllowedArePartOfTheKeyOfLaterStages) {
    const Trained first = must(train());
    EXPECT_EQ(first.steps, 100u);
    EXPECT_EQ(must(train()).key, first.key) << "read back";
    killBeforeTheManifest();
    fs::remove(work_ / "trained.bin");
    ASSERT_TRUE(writeFileAtomically(work_ / "steps.txt", std::string("110")));  // as a faster machine allows
    const Trained second = must(train());
    EXPECT_EQ(second.steps, 110u);
    EXPECT_NE(second.key, first.key);
    EXPECT_EQ(must(train()).key, second.key) << "read back";
}

TEST_F(StageCoOptimise, whoWatchesChangesNothing) {
    const Trained alone = must(train());
    fs::remove_all(folder_);
    toy_.table.scan.frames.back().split = Split::Validation;
    RunNews news(toy_.folder / "out");
    const ToldNews told(toy_.progress, news);
    const Trained watched = must(train());
    EXPECT_EQ(watched.key, alone.key);
    EXPECT_EQ(watched.result.splats.sh, alone.result.splats.sh);
    EXPECT_EQ(watched.result.splats.scaleM, alone.result.splats.scaleM);
    EXPECT_EQ(watched.result.restPositions, alone.result.restPositions);
    const auto shown = [&](const char* file) { return fs::exists(toy_.folder / "out" / file); };
    EXPECT_TRUE(waitUntil([&] { return shown(RunNews::kAvatar) && shown(RunNews::kHeldBack); }));
}

TEST_F(StageCoOptimise, aKillBeforeTheManifestCostsNothing) {
    const Trained whole = must(train());
    const auto bytes = must(readFile(folder_ / "trained.bin"));
    killBeforeTheManifest();
    ASSERT_TRUE(writeFileAtomically(work_ / "checkpoint", std::string("the last one")));
    fs::remove_all(toy_.table.scan.root);  // training again would miss the pictures
    const auto again = train();
    ASSERT_TRUE(again) << again.error().message;
    EXPECT_EQ(must(readFile(folder_ / "trained.bin")), bytes);
    EXPECT_EQ(again->key, whole.key);
    EXPECT_FALSE(fs::exists(folder_ / "checkpoint"));
}

TEST_F(StageCoOptimise, aDamagedResultOfAKilledRunIsMadeAgain) {
    must(train());
    const auto bytes = must(readFile(folder_ / "trained.bin"));
    killBeforeTheManifest();
    fs::resize_file(work_ / "trained.bin", bytes.size() / 2);
    const auto again = train();
    ASSERT_TRUE(again) << again.error().message;
    EXPECT_EQ(must(readFile(folder_ / "trained.bin")).size(), bytes.size());
}

}  // namespace
}  // namespace dpl::test
