// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/run/presets.h"

#include <algorithm>
#include <vector>

#include "reconstruction/base/json_fields.h"
#include "sdk/core/edit_distance.h"
#include "sdk/core/numbers.h"
#include "sdk/math/sh.h"

namespace dpl {
namespace {

const std::array<Preset, 3> kPresets = {{
    {.name = "draft", .steps = 3000, .startSplats = 40000, .maxSplats = 50000, .shDegree = 0, .polishSteps = 200, .poseFitRounds = 40},
    {.name = "standard", .steps = 10000, .startSplats = 60000, .maxSplats = 80000, .shDegree = 0, .polishSteps = 600, .poseFitRounds = 80},
    {.name = "high", .steps = 60000, .startSplats = 120000, .maxSplats = 300000, .shDegree = 2, .polishSteps = 2000, .poseFitRounds = 120},
}};

struct Field {
    const char* key;
    uint32_t Preset::*number;
    uint32_t least, most;
    const char* words;
};
constexpr uint32_t kMostSplats = 2'000'000;
constexpr Field kFields[] = {
    {"steps", &Preset::steps, 1, 10'000'000, "steps of training"},
    {"startSplats", &Preset::startSplats, 1000, kMostSplats, "splats at its start"},
    {"maxSplats", &Preset::maxSplats, 1000, kMostSplats, "most splats"},
    {"shDegree", &Preset::shDegree, 0, kMaxShDegree, "degree of view-dependent colour"},
    {"polishSteps", &Preset::polishSteps, 0, 1'000'000, "steps of the polish of the finished file"},
    {"poseFitRounds", &Preset::poseFitRounds, 0, 10'000, "rounds of the pose fit before a held-out picture is scored"},
};
constexpr const char* kLike = "like";

const Preset* named(const std::string& name) {
    const auto found = std::find_if(kPresets.begin(), kPresets.end(), [&](const Preset& preset) { return preset.name == name; });
    return found == kPresets.end() ? nullptr : &*found;
}

Result<Preset> readPreset(const std::filesystem::path& path) {
    const auto object = readJsonObject(path);
    if (!object) return object.error();
    std::vector<std::string> keys = {kLike};
    for (const Field& field : kFields) keys.push_back(field.key);
    for (const auto& [key, value] : object->items()) {
        if (std::find(keys.begin(), keys.end(), key) != keys.end()) continue;
        std::string known;
        for (const std::string& name : keys) known += (known.empty() ? "" : ", ") + name;
        return fail(Code::InvalidArgument, "{}: a preset has no '{}'{}; it has {}", path.string(), key, didYouMean(key, keys), known);
    }
    const JsonFields fields(*object, path.string());
    const auto like = fields.text(kLike, "standard");
    if (!like) return like.error();
    const Preset* base = named(*like);
    if (!base) return fail(Code::InvalidArgument, "{}: 'like' is '{}'; it is draft, standard or high", path.string(), *like);
    Preset preset = *base;
    preset.name = path.stem().string();
    for (const Field& field : kFields) {
        const auto number = fields.number(field.key, preset.*field.number);
        if (!number) return number.error();
        if (*number < field.least || *number > field.most || *number != uint32_t(*number))
            return fail(Code::InvalidArgument, "{}: '{}' is {}; it is a whole number from {} to {}", path.string(), field.key, *number,
                        field.least, field.most);
        preset.*field.number = uint32_t(*number);
    }
    if (preset.startSplats > preset.maxSplats)
        return fail(Code::InvalidArgument, "{}: training starts with {} splats and may have {}; lower startSplats or raise maxSplats",
                    path.string(), preset.startSplats, preset.maxSplats);
    return preset;
}

}  // namespace

std::span<const Preset> namedPresets() {
    return kPresets;
}

Result<Preset> findPreset(const std::string& nameOrFile) {
    if (const Preset* preset = named(nameOrFile)) return *preset;
    std::error_code ignored;
    if (std::filesystem::exists(nameOrFile, ignored)) return readPreset(nameOrFile);
    std::vector<std::string> names;
    for (const Preset& preset : kPresets) names.push_back(preset.name);
    return fail(Code::NotFound, "there is no preset and no file '{}'{}; doppel presets lists presets, and says how to make a file",
                nameOrFile, didYouMean(nameOrFile, names));
}

std::string presetText(const Preset& preset) {
    nlohmann::ordered_json object;
    for (const Field& field : kFields) object[field.key] = preset.*field.number;
    return object.dump(2) + "\n";
}

std::string presetTable(std::span<const Preset> presets) {
    std::string text(16, ' ');
    const auto cell = [](const std::string& word, size_t width) { return std::string(width - std::min(width, word.size()), ' ') + word; };
    for (const Preset& preset : presets) text += cell(preset.name, 10);
    for (const Field& field : kFields) {
        text += formatText("\n  {}{}", field.key, std::string(14 - std::min<size_t>(14, std::string(field.key).size()), ' '));
        for (const Preset& preset : presets) text += cell(std::to_string(preset.*field.number), 10);
        text += formatText("   {}", field.words);
    }
    return text;
}

}  // namespace dpl
