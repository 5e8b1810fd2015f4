// SPDX-License-Identifier: Apache-2.0
// Command line of the conformance kit: writes the kit, draws it with Doppel's renderers, scores any renderer's pictures.
#include <CLI/CLI.hpp>
#include <cstdio>
#include <map>

#include "tests/conformance/kit.h"

using namespace dpl;

int main(int argc, char** argv) {
    CLI::App app(
        "Is a renderer of Doppel avatars right? Writes tiny avatars with double-precision pictures, and scores the pictures that a "
        "renderer makes of them",
        "conformance");
    app.require_subcommand(1);
    app.footer(
        "Examples:\n"
        "  tools/conformance                                   our renderers, into ./conformance\n"
        "  tools/conformance write kit                         then draw the views that kit/kit.json lists, with any renderer\n"
        "  tools/conformance score kit pictures --sheet s.png  exit code 1 when a case fails");
    std::filesystem::path kit, pictures, sheet;
    DplRenderer renderer = DPL_RENDERER_AUTO;
    const std::map<std::string, DplRenderer> names = {
        {"auto", DPL_RENDERER_AUTO}, {"software", DPL_RENDERER_SOFTWARE}, {"vulkan", DPL_RENDERER_VULKAN}};
    CLI::App* write = app.add_subcommand("write", "Write the kit: avatars, kit.json, reference pictures");
    write->add_option("kit", kit, "Folder of the kit")->required();
    CLI::App* draw = app.add_subcommand("draw", "Draw the kit with one of Doppel's renderers");
    draw->add_option("kit", kit, "Folder of the kit")->required();
    draw->add_option("pictures", pictures, "Folder for the pictures")->required();
    draw->add_option("--renderer", renderer, "auto, software or vulkan")->transform(CLI::CheckedTransformer(names));
    DplFill fill = DPL_FILL_AUTO;
    const std::map<std::string, DplFill> fills = {{"auto", DPL_FILL_AUTO}, {"quads", DPL_FILL_QUADS}, {"tiles", DPL_FILL_TILES}};
    draw->add_option("--fill", fill, "How a GPU fills pixels: auto, quads or tiles")->transform(CLI::CheckedTransformer(fills));
    CLI::App* score = app.add_subcommand("score", "Compare pictures with the kit's references; exit code 1 when a case fails");
    score->add_option("kit", kit, "Folder of the kit")->required();
    score->add_option("pictures", pictures, "Folder of the pictures")->required();
    score->add_option("--sheet", sheet, "A PNG: reference, picture, eight times their difference");
    CLI::App* compare = app.add_subcommand("compare", "Compare two folders of pictures: at most one level apart, and at least 80 dB");
    compare->add_option("kit", kit, "Folder of the kit")->required();
    std::filesystem::path first;
    compare->add_option("first", first, "Folder of the pictures that the others are compared with")->required();
    compare->add_option("pictures", pictures, "Folder of the other pictures")->required();
    CLI11_PARSE(app, argc, argv);

    const auto report = [](const Error& error) {
        std::fprintf(stderr, "conformance: %s\n", error.message.c_str());
        return error.code == Code::Unsupported ? 77 : 2;
    };
    if (*write) {
        if (Status done = writeKit(kit); !done) return report(done.error());
        std::printf("wrote %s\n", (kit / "kit.json").c_str());
        return 0;
    }
    if (*draw) {
        auto name = drawKit(kit, pictures, renderer, fill);
        if (!name) return report(name.error());
        std::printf("%s: pictures in %s\n", name->c_str(), pictures.c_str());
        return 0;
    }
    const OtherReferences others{first, {.psnrDb = 80, .coveredPsnrDb = 0, .maxLevels = 1.001}};  // 1.001: levels are not exact in doubles
    auto scores = scoreKit(kit, pictures, sheet, *compare ? &others : nullptr);
    if (!scores) return report(scores.error());
    size_t failed = 0;
    for (const CaseScore& s : *scores) failed += !s.passed;
    std::printf("%s\n%zu of %zu cases pass\n", scoreTable(*scores).c_str(), scores->size() - failed, scores->size());
    return failed ? 1 : 0;
}
