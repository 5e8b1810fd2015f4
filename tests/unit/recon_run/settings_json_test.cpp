// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/run/settings_json.h"

#include <gtest/gtest.h>

#include <type_traits>
#include <utility>

namespace dpl {
namespace {

struct Anything {
    template <class T>
    operator T() const;
};

/** The number of members of an aggregate: as many as it can be initialised with. */
template <class Settings, class... Values>
constexpr size_t memberCount() {
    if constexpr (requires { Settings{std::declval<Values>()..., std::declval<Anything>()}; })
        return memberCount<Settings, Values..., Anything>();
    else
        return sizeof...(Values);
}

template <class T>
constexpr bool kHasFields = requires(const T& value) {
    visitFields(value, [](const char*, const auto&) {});
};

template <class T>
void change(T& value) {
    if constexpr (std::is_same_v<T, bool>)
        value = !value;
    else if constexpr (std::is_arithmetic_v<T>)
        value += T(1);
    else if (value.empty())
        value.emplace_back();
    else
        change(value.back());
}

/** Changes field `which`, counted through nested settings; its name, or null when there are no more. */
template <class Settings>
const char* changeField(Settings& settings, size_t& which) {
    const char* changed = nullptr;
    visitFields(settings, [&](const char* name, const auto& constant) {
        auto& field = const_cast<std::remove_cvref_t<decltype(constant)>&>(constant);
        if (changed) return;
        if constexpr (kHasFields<std::remove_cvref_t<decltype(field)>>)
            changed = changeField(field, which);
        else if (which-- == 0)
            change(field), changed = name;
    });
    return changed;
}

/** Every field of settings is in `keyOf(settings)`. */
template <class Settings, class Key>
void expectEveryFieldIn(const Settings& settings, Key&& keyOf) {
    EXPECT_EQ(fieldsJson(settings).size(), memberCount<Settings>()) << fieldsJson(settings);
    const auto key = keyOf(settings);
    size_t changes = 0;
    for (;; ++changes) {
        Settings other = settings;
        size_t which = changes;
        const char* name = changeField(other, which);
        if (!name) break;
        EXPECT_NE(keyOf(other), key) << name;
    }
    EXPECT_GE(changes, memberCount<Settings>());
}

ReconstructOptions draft(uint32_t steps = 0, double budgetMinutes = 0) {
    ReconstructOptions options;
    options.preset = *findPreset("draft"), options.steps = steps, options.timeBudgetMinutes = budgetMinutes;
    return options;
}

TEST(SettingsJson, presetsWithEqualNumbersShareTheirWork) {
    const RunSettings byName = settingsOf(draft()), byNumbers = settingsOf(draft(byName.training.steps));
    EXPECT_EQ(trainingInputs(byName), trainingInputs(byNumbers));
    EXPECT_EQ(polishInputs(byName), polishInputs(byNumbers));
    EXPECT_EQ(fieldsJson(byName.poseFit), fieldsJson(byNumbers.poseFit));
    EXPECT_EQ(trainingInputs(byName).dump().find("draft"), std::string::npos);
}

TEST(SettingsJson, everyNumberThatDecidesAResultIsInItsKey) {
    const RunSettings standard = settingsOf({});
    const auto fields = [](const auto& settings) { return fieldsJson(settings); };
    expectEveryFieldIn(standard.training, [&](const CoOptimiseSettings& training) {
        RunSettings other = standard;
        other.training = training;
        return trainingInputs(other);
    });
    expectEveryFieldIn(standard.training.init, fields);
    expectEveryFieldIn(standard.training.loss, fields);
    expectEveryFieldIn(standard.training.regularise, fields);
    expectEveryFieldIn(standard.poseFit, fields);
    expectEveryFieldIn(BodyFitSettings{}, fields);
    expectEveryFieldIn(SurfaceFitSettings{}, fields);
    expectEveryFieldIn(RegisterSettings{}, fields);
    RunSettings longer = standard;
    ++longer.polishSteps;
    EXPECT_NE(polishInputs(longer), polishInputs(standard));
}

TEST(SettingsJson, labelsCountByTheirNames) {
    const std::vector<ScanLabel> labels = {{"background", 0}, {"body", 7}, {"dress", 40}, {"hair", 2}, {"shoes", 3}};
    const InitSettings named = settingsOf({}, labels).training.init;
    EXPECT_EQ(named.clothLabels, std::vector<uint8_t>{40});
    EXPECT_EQ(named.openLabels, std::vector<uint8_t>{2});
}

TEST(SettingsJson, withATimeBudgetTheStepsAreAResult) {
    RunSettings settings = settingsOf(draft(0, 5));
    const auto inputs = trainingInputs(settings);
    settings.training.steps = 12345;  // as a probe would set it
    EXPECT_EQ(trainingInputs(settings), inputs);
    EXPECT_NE(trainingInputs(settingsOf(draft(0, 6))), inputs);
    EXPECT_EQ(settingsOf(draft(700, 5)).timeBudgetMinutes, 0) << "a stated number of steps needs no budget";
}

TEST(SettingsJson, whatFollowsTrainingShrinksWithItsSteps) {
    const RunSettings budget = settingsOf(draft(0, 5));
    const RunSettings after = withTrainingSteps(budget, 700);
    EXPECT_EQ(after.training.steps, 700u);
    EXPECT_EQ(after.polishSteps, 70u);
    EXPECT_EQ(after.timeBudgetMinutes, 5) << "training keeps its key";
    EXPECT_EQ(trainingInputs(after), trainingInputs(budget));
    EXPECT_EQ(polishInputs(withTrainingSteps(budget, budget.training.steps)), polishInputs(budget));
    EXPECT_EQ(polishInputs(withTrainingSteps(budget, 100000)), polishInputs(budget)) << "a longer training needs no longer polish";
}

}  // namespace
}  // namespace dpl
