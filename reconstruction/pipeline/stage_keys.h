// SPDX-License-Identifier: Apache-2.0
// Settings as the inputs of a stage: by value, so that two presets with equal numbers share their work.
#pragma once

#include <nlohmann/json.hpp>

#include "reconstruction/body/fit_body.h"
#include "reconstruction/pipeline/preset.h"
#include "reconstruction/splat/settings_fields.h"
#include "reconstruction/surface/fit_surface.h"

namespace dpl {

// As in settings_fields.h: a field that is not named here does not compile. Callbacks are no values.
template <class Visit>
void visitFields(const BodyFitSettings& settings, Visit&& visit) {
    const auto& [sigmaAtFullConfidence, outlierSigmas, useMasks, progress] = settings;
    visit("sigmaAtFullConfidence", sigmaAtFullConfidence), visit("outlierSigmas", outlierSigmas), visit("useMasks", useMasks);
}

template <class Visit>
void visitFields(const SurfaceFitSettings& settings, Visit&& visit) {
    const auto& [startSmoothingM, endSmoothingM, levels, roundsPerLevel, maxOffsetM, maxStepM, maxSwayM, progress] = settings;
    visit("startSmoothingM", startSmoothingM), visit("endSmoothingM", endSmoothingM);
    visit("levels", levels), visit("roundsPerLevel", roundsPerLevel);
    visit("maxOffsetM", maxOffsetM), visit("maxStepM", maxStepM), visit("maxSwayM", maxSwayM);
}

/** Every field of a settings struct, by name. */
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

/** All that decides how a run trains. With a time budget the number of steps is a result and no input. */
inline nlohmann::json trainingInputs(const RunSettings& settings) {
    nlohmann::json out = fieldsJson(settings.training);
    if (settings.timeBudgetMinutes > 0) {
        out.erase("steps");
        out["budgetMinutes"] = settings.timeBudgetMinutes;
    }
    return out;
}

/** All that decides how the trained avatar is polished. */
inline nlohmann::json polishInputs(const RunSettings& settings) {
    return fieldsJson(polishSettings(settings.polishSteps, settings.training.seed, settings.training.init.shDegree));
}

}  // namespace dpl
