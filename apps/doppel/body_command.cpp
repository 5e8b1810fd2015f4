// SPDX-License-Identifier: Apache-2.0
#include <cstdio>

#include "apps/doppel/commands.h"
#include "apps/shared/checks.h"
#include "reconstruction/subject/body/body_io.h"
#include "reconstruction/subject/body/body_tools.h"
#include "reconstruction/subject/body/makehuman.h"
#include "reconstruction/subject/body/smplx.h"
#include "reconstruction/subject/face/makehuman_face.h"
#include "reconstruction/subject/sample/builtin_body.h"

namespace dpl {
namespace {

struct BodyOptions {
    std::filesystem::path source, out;
};

/** A folder is MakeHuman data, .npz is SMPL-X, .glb is a rigged glTF, "builtin" the built-in body. */
Result<BodyModel> importBody(const std::filesystem::path& source) {
    if (source == "builtin") return withBoneMorphs(makeBuiltinBody());
    if (std::filesystem::is_directory(source)) {
        DPL_TRY(BodyModel body, importMakeHuman(source));
        DPL_TRY(body.expressions, makeHumanExpressions(source, body));
        return body;
    }
    const std::string extension = source.extension().string();
    if (extension == ".npz") return importSmplx(source);
    if (extension == ".glb") return readBody(source);
    if (!std::filesystem::exists(source)) return fail(Code::NotFound, "{} does not exist", source.string());
    return fail(
        Code::Unsupported,
        "{}: bodies come from a MakeHuman/MPFB2 folder, a SMPL-X .npz or a rigged .glb (convert other formats to .glb with Blender)",
        source.string());
}

std::string describe(const BodyModel& body) {
    std::string text = formatText("{}: {} vertices, {} triangles, {} joints, {} keypoints\n", body.name, body.mesh.restPositions.size(),
                                  body.mesh.triangles.size(), body.joints.size(), body.keypoints.size());
    size_t bones = 0;
    for (const JointData& joint : body.joints) bones += !joint.humanoidBone.empty();
    text += formatText("{} joints have humanoid bone names\nshape morphs:", bones);
    for (const ShapeMorph& morph : body.morphs) text += formatText(" {} [{}, {}]", morph.name, morph.minValue, morph.maxValue);
    if (!body.expressions.empty()) text += formatText("\nexpressions: {}", body.expressions.size());
    return text;
}

}  // namespace

void addBodyCommand(CLI::App& app, CommandRun& run) {
    CLI::App* command = app.add_subcommand("body", "Import parametric bodies, and show what they contain");
    command->require_subcommand(1);
    auto options = std::make_shared<BodyOptions>();

    command->footer("Examples:\n  doppel body import body-makehuman -o makehuman.glb\n  doppel body show makehuman.glb");
    CLI::App* importCommand = command->add_subcommand("import", "Make a glTF body from MakeHuman/MPFB2 data, SMPL-X .npz or a rigged .glb");
    importCommand->add_option("source", options->source, "MakeHuman/MPFB2 folder, SMPL-X .npz (your own copy), rigged .glb, or 'builtin'")
        ->required();
    importCommand->add_option("-o,--out", options->out, "The body to write (.glb)")->required()->check(isOutputFile({".glb"}));
    importCommand->footer(
        "Examples:\n  doppel body import body-makehuman -o makehuman.glb\n  doppel body import SMPLX_NEUTRAL.npz -o smplx.glb");
    importCommand->callback([options, &run] {
        run = [options] {
            auto body = importBody(options->source);
            if (!body) return reportError(body.error());
            if (Status written = writeBody(*body, options->out); !written) return reportError(written.error());
            std::printf("%s\nwritten to %s\n", describe(*body).c_str(), options->out.string().c_str());
            return int(kExitOk);
        };
    });

    CLI::App* showCommand = command->add_subcommand("show", "Show the size, joints and shape morphs of a body");
    showCommand->add_option("source", options->source, "MakeHuman/MPFB2 folder, SMPL-X .npz, rigged .glb, or 'builtin'")->required();
    showCommand->footer("Examples:\n  doppel body show builtin\n  doppel body show makehuman.glb");
    showCommand->callback([options, &run] {
        run = [options] {
            auto body = importBody(options->source);
            if (!body) return reportError(body.error());
            std::printf("%s\n", describe(*body).c_str());
            return int(kExitOk);
        };
    });
}

}  // namespace dpl
