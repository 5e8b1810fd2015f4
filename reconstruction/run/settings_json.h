// SPDX-License-Identifier: Apache-2.0
// Settings as inputs of a stage. They are listed by value, so two presets with equal numbers share finished stages.
#pragma once

#include <nlohmann/json.hpp>

#include "reconstruction/run/preset.h"
#include "reconstruction/subject/body/fit_body.h"
#include "reconstruction/subject/registration/register_frames.h"
#include "reconstruction/subject/surface/fit_surface.h"
#include "reconstruction/training/trainer/settings_fields.h"

namespace dpl {

// As in settings_fields.h, the code does not compile when a field is missing here.
template <class Visit>
void visitFields(const BodyFitSettings& settings, Visit&& visit) {
    const auto& [outlierSigmas, useMasks] = settings;
    visit("outlierSigmas", outlierSigmas), visit("useMasks", useMasks);
}

template <class Visit>
void visitFields(const SurfaceFitSettings& settings, Visit&& visit) {
    const auto& [startSmoothingM, endSmoothingM, levels, roundsPerLevel, maxOffsetM, maxStepM, maxSwayM] = settings;
    visit("startSmoothingM", startSmoothingM), visit("endSmoothingM", endSmoothingM);
    visit("levels", levels), visit("roundsPerLevel", roundsPerLevel);
    visit("maxOffsetM", maxOffsetM), visit("maxStepM", maxStepM), visit("maxSwayM", maxSwayM);
}

template <class Visit>
void visitFields(const RegisterSettings& settings, Visit&& visit) {
    const auto& [surfacePoints, blursPx, roundsPerBlur, stepsPerRound] = settings;
    visit("surfacePoints", surfacePoints), visit("blursPx", blursPx);
    visit("roundsPerBlur", roundsPerBlur), visit("stepsPerRound", stepsPerRound);
}

/** All fields of a settings struct as JSON, by name. */
template <class Settings>
nlohmann::json fieldsJson(const Settings& settings) {
    nlohmann::json out;
    const auto add = [&out](const char* name, const auto& field) {
        if constexpr (requires { visitFields(field, [](const char*, const auto&) {}); })
            out[name] = fieldsJson(field);
        else
            out[name] = field;
    };
    visitFields(settings, add);
    return out;
}

/** The inputs of training. With a time budget the number of steps is a result, so the budget takes its place. */
inline nlohmann::json trainingInputs(const RunSettings& settings) {
    nlohmann::json out = fieldsJson(settings.training);
    if (settings.timeBudgetMinutes > 0) {
        out.erase("steps");
        out["budgetMinutes"] = settings.timeBudgetMinutes;
    }
    return out;
}

/** The inputs of the polish. */
inline nlohmann::json polishInputs(const RunSettings& settings) {
    return fieldsJson(polishSettings(settings.polishSteps, settings.training.seed, settings.training.init.shDegree));
}

}  // namespace dpl
