// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/pipeline/stage_keys.h"

#include <gtest/gtest.h>

namespace dpl {
namespace {

ReconstructOptions draft(uint32_t steps = 0, double budgetMinutes = 0) {
    ReconstructOptions options;
    options.preset = Preset::Draft, options.steps = steps, options.timeBudgetMinutes = budgetMinutes;
    return options;
}

TEST(StageKeys, presetsWithEqualNumbersShareTheirWork) {
    const RunSettings byName = settingsOf(draft()), byNumbers = settingsOf(draft(byName.training.steps));
    EXPECT_EQ(trainingInputs(byName), trainingInputs(byNumbers));
    EXPECT_EQ(polishInputs(byName), polishInputs(byNumbers));
    EXPECT_EQ(fieldsJson(byName.poseFit), fieldsJson(byNumbers.poseFit));
    EXPECT_EQ(trainingInputs(byName).dump().find("draft"), std::string::npos);
}

TEST(StageKeys, everyNumberThatDecidesAResultIsInItsKey) {
    const RunSettings standard = settingsOf({});
    const auto differs = [&](auto&& change) {
        RunSettings other = standard;
        change(other);
        return trainingInputs(other) != trainingInputs(standard) || polishInputs(other) != polishInputs(standard) ||
               fieldsJson(other.poseFit) != fieldsJson(standard.poseFit);
    };
    EXPECT_FALSE(differs([](RunSettings&) {}));
    EXPECT_TRUE(differs([](RunSettings& s) { s.training.seed = 2; }));
    EXPECT_TRUE(differs([](RunSettings& s) { ++s.training.steps; }));
    EXPECT_TRUE(differs([](RunSettings& s) { ++s.training.maxSplats; }));
    EXPECT_TRUE(differs([](RunSettings& s) { ++s.training.init.splatCount; })) << "fields of nested settings count";
    EXPECT_TRUE(differs([](RunSettings& s) { s.training.loss.ssim += 0.1f; }));
    EXPECT_TRUE(differs([](RunSettings& s) { s.training.levelStarts.back() += 0.1f; }));
    EXPECT_TRUE(differs([](RunSettings& s) { ++s.polishSteps; }));
    EXPECT_TRUE(differs([](RunSettings& s) { ++s.poseFit.iterations; }));
    EXPECT_TRUE(differs([](RunSettings& s) { s.poseFit.loss.mask += 0.1f; }));
}

TEST(StageKeys, labelsCountByTheirNames) {
    const std::vector<ScanLabel> labels = {{"background", 0}, {"body", 7}, {"dress", 40}, {"hair", 2}, {"shoes", 3}};
    const InitSettings named = settingsOf({}, labels).training.init;
    EXPECT_EQ(named.clothLabels, std::vector<uint8_t>{40});
    EXPECT_EQ(named.openLabels, std::vector<uint8_t>{2});
}

TEST(StageKeys, withATimeBudgetTheStepsAreAResult) {
    RunSettings settings = settingsOf(draft(0, 5));
    const auto inputs = trainingInputs(settings);
    settings.training.steps = 12345;  // as a probe would set it
    EXPECT_EQ(trainingInputs(settings), inputs);
    EXPECT_NE(trainingInputs(settingsOf(draft(0, 6))), inputs);
    EXPECT_EQ(settingsOf(draft(700, 5)).timeBudgetMinutes, 0) << "a stated number of steps needs no budget";
}

TEST(StageKeys, whatFollowsTrainingShrinksWithItsSteps) {
    const RunSettings budget = settingsOf(draft(0, 5));
    const RunSettings after = withTrainingSteps(budget, 700);
    EXPECT_EQ(after.training.steps, 700u);
    EXPECT_EQ(after.polishSteps, 70u);
    EXPECT_EQ(after.timeBudgetMinutes, 5) << "training keeps its key";
    EXPECT_EQ(trainingInputs(after), trainingInputs(budget));
    EXPECT_EQ(polishInputs(withTrainingSteps(budget, budget.training.steps)), polishInputs(budget));
    EXPECT_EQ(polishInputs(withTrainingSteps(budget, 100000)), polishInputs(budget)) << "a longer training needs no longer polish";
}

TEST(StageKeys, fitsAreKeyedByTheirSettings) {
    BodyFitSettings body;
    SurfaceFitSettings surface;
    RegisterSettings registration;
    const auto bodyBefore = fieldsJson(body), surfaceBefore = fieldsJson(surface), registrationBefore = fieldsJson(registration);
    body.outlierSigmas += 1, surface.maxOffsetM += 0.1, registration.roundsPerBlur += 1;
    EXPECT_NE(fieldsJson(body), bodyBefore);
    EXPECT_NE(fieldsJson(surface), surfaceBefore);
    EXPECT_NE(fieldsJson(registration), registrationBefore);
}

}  // namespace
}  // namespace dpl
