// SPDX-License-Identifier: Apache-2.0
// Presets: the numbers by which a user trades quality for time. Three have a name; others are JSON files.
#pragma once

#include <array>
#include <filesystem>
#include <span>
#include <string>

#include "sdk/core/result.h"

namespace dpl {

struct Preset {
    std::string name;            // of a file: its name without extension
    uint32_t steps = 0;          // of training
    uint32_t startSplats = 0;    // before density control
    uint32_t maxSplats = 0;      // after it
    uint32_t shDegree = 0;       // view-dependent colour: 0 none, to 3
    uint32_t polishSteps = 0;    // of colour, opacity and size, on the finished file
    uint32_t poseFitRounds = 0;  // for each held-out picture, before it is scored
};

/** draft, standard and high. */
std::span<const Preset> namedPresets();

/** The preset of a name, or of a JSON file: {"like": "standard", "steps": 20000}. "like" names the preset whose numbers hold where the file
 *  has none; otherwise it is standard. Errors: no such name or file; a key that is unknown; a number out of its range. */
Result<Preset> findPreset(const std::string& nameOrFile);

/** A preset as the text of such a file. */
std::string presetText(const Preset& preset);

/** A table of presets, for people. */
std::string presetTable(std::span<const Preset> presets);

}  // namespace dpl
