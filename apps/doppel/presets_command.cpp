// SPDX-License-Identifier: Apache-2.0
#include <cstdio>

#include "apps/doppel/commands.h"
#include "apps/shared/checks.h"
#include "reconstruction/run/presets.h"
#include "sdk/core/files.h"
#include "sdk/core/numbers.h"

namespace dpl {

void addPresetsCommand(CLI::App& app, CommandRun& run) {
    auto name = std::make_shared<std::string>();
    auto out = std::make_shared<std::filesystem::path>();
    CLI::App* command = app.add_subcommand("presets", "List the presets of doppel reconstruct, or write one as a file to change");
    command->add_option("preset", *name, "One of them, or a file of your own; default: all");
    command->add_option("-o,--out", *out, "The file to write (.json)")->check(isOutputFile({".json"}));
    command->footer(
        "Examples:\n"
        "  doppel presets\n"
        "  doppel presets high -o mine.json                     (change its numbers; what you delete is that of \"like\", or of standard)\n"
        "  doppel presets mine.json\n"
        "  doppel reconstruct scan -o ada --preset mine.json");
    command->callback([name, out, &run] {
        if (!out->empty() && name->empty()) throw CLI::RequiresError("--out", "preset");
        refuseInputAsOutput(*out, {*name});
        run = [name, out] {
            if (name->empty()) {
                std::printf("%s\n", presetTable(namedPresets()).c_str());
                return int(kExitOk);
            }
            const auto preset = findPreset(*name);
            if (!preset) return reportError(preset.error());
            if (out->empty()) {
                std::printf("%s\n", presetTable({&*preset, 1}).c_str());
                return int(kExitOk);
            }
            const auto written = writeFileAtomically(*out, std::string_view(presetText(*preset)));
            if (!written) return reportError(written.error());
            std::printf("%s: the numbers of %s\n", out->c_str(), preset->name.c_str());
            return int(kExitOk);
        };
    });
}

}  // namespace dpl
