// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cstdio>

#include "reconstruction/output/package/avatar_bytes.h"
#include "reconstruction/output/package/exported_motion.h"
#include "reconstruction/output/package/posed_splats.h"
#include "reconstruction/output/package/splat_target.h"
#include "reconstruction/output/package/without_gate.h"
#include "sdk/avatar/cloth_bounds.h"
#include "sdk/core/files.h"
#include "sdk/format/avatar_file.h"
#include "sdk/format/splat_file.h"

namespace dpl {
namespace {

constexpr const char* kHalfTurned = "y-down";

/** Splats to write, and what of the source they do not hold. */
struct Source {
    StaticSplatData splats;
    std::vector<std::string> notes, lost;
};

/** The turn to y up from axes of this name. */
Mat3d uprightOf(const std::string& name) {
    Vec3d up(0);
    up[name.starts_with("z") ? 2 : 1] = name.ends_with("down") ? -1 : 1;
    return axesOfUp(up)->uprightFromFile;
}

Result<Source> sourceOf(const ExportOptions& options, std::span<const uint8_t> bytes) {
    Source source;
    if (splatFormatOf(bytes) != SplatFormat::None) {
        if (!options.clip.empty() || options.timeS > 0)
            return fail(Code::InvalidArgument, "{} does not apply to general splats, which have no joints to pose; leave it out",
                        options.clip.empty() ? "--time" : "--clip");
        DPL_TRY(SplatFile file, readSplats(bytes));
        source.notes = file.remarks.notes;
        if (!options.inputAxes.empty())
            turnSplats(file.splats, uprightOf(options.inputAxes) * glm::transpose(file.remarks.axes.uprightFromFile));
        else if (file.remarks.axes.stated.empty())
            source.notes.push_back("it states no axes, so it is taken as y up; if it stands on its head, add --input-axes y-down");
        if (file.remarks.shDegree > file.splats.shDegree)
            source.lost.push_back(formatText("SH bands above degree {}", file.splats.shDegree));
        source.splats = std::move(file.splats);
        return source;
    }
    if (!options.inputAxes.empty())
        return fail(Code::InvalidArgument, "--input-axes does not apply to avatars, which are y up; leave it out");
    DPL_TRY(AvatarData avatar, readAvatar(bytes));
    boundGarments(avatar.joints, avatar.mesh);  // as renderers load it
    ExportedMotion motion(avatar);
    DPL_RETURN_IF_ERROR(motion.open(options.clip, options.animation));
    const Pose poses[] = {motion.at(options.timeS)};
    DPL_RETURN_IF_ERROR(checkPose(avatar.joints, poses[0]));
    Jobs jobs(options.threadCount);
    DPL_TRY(const AvatarData ungated, withoutGate(avatar, poses, jobs));
    if (const uint32_t left = avatar.splats.count() - ungated.splats.count())
        source.notes.push_back(formatText("{} splats are left out: they only show from inside, which other viewers do not hide", left));
    DPL_TRY(source.splats, SplatPoser(ungated, kSunkM).in(poses[0], /*all=*/false));
    source.lost.push_back(formatText("motion ({} joints, {} clips)", avatar.joints.size(), avatar.clips.size()));
    if (avatar.correctives.followsPose()) source.lost.push_back("pose correctives beyond this pose");
    if (!avatar.expressions.empty()) source.lost.push_back(formatText("{} expressions", avatar.expressions.shapes.size()));
    return source;
}

}  // namespace

std::string wrongExport(const ExportOptions& options) {
    const std::string out = options.out.string();
    const bool clip = options.fps > 0;
    if (clip && options.clip.empty()) return "--fps writes a whole clip; name it by --clip";
    if (clip && options.timeS > 0) return "--time does not go with --fps, which writes all of the clip; leave it out";
    if (clip && splatTargetOf(options.out) != SplatTarget::None)
        return formatText("-o {}: with --fps it names a folder; choose the files in it by --format", out);
    if (!clip && !options.format.empty()) return "--format is of the files that --fps writes; the name of -o chooses that of one frame";
    const SplatTarget target = splatTargetOf(clip ? std::filesystem::path("x." + options.format) : options.out);
    if (target == SplatTarget::CompressedPly)
        return formatText("-o {}: compressed PLY is not written; name a .spz, which is as small, or a plain .ply without 'compressed'",
                          out);
    if (target == SplatTarget::None) return formatText("-o {}: the file must end in .glb, .spz or .ply", out);
    if (target != SplatTarget::Ply && options.axes == kHalfTurned)
        return formatText("-o {}: --axes {} is for .ply; this format is y up by its definition", out, kHalfTurned);
    if (target != SplatTarget::Spz && options.spzVersion != ExportOptions().spzVersion)
        return formatText("-o {}: --spz-version is for .spz", out);
    return {};
}

Result<std::string> exportPosedSplats(const ExportOptions& options) {
    if (const std::string wrong = wrongExport(options); !wrong.empty()) return fail(Code::InvalidArgument, "{}", wrong);
    DPL_TRY(auto bytes, readAvatarBytes(options.avatar));
    auto source = sourceOf(options, bytes);
    if (!source) return fail(source.error().code, "{}: {}", options.avatar.string(), source.error().message);
    const SplatTarget target = splatTargetOf(options.out);
    auto file = splatFileOf(source->splats, target, options, source->lost);
    if (!file) return fail(file.error().code, "{}: {}", options.out.string(), file.error().message);
    DPL_RETURN_IF_ERROR(writeFileAtomically(options.out, *file));
    std::string text;
    for (const std::string& note : source->notes) text += formatText("note: {}: {}\n", options.avatar.string(), note);
    for (const std::string& lost : source->lost) text += formatText("not in {}: {}\n", options.out.filename().string(), lost);
    char perSplat[32];
    std::snprintf(perSplat, sizeof perSplat, "%.1f", double(file->size()) / std::max(1u, source->splats.count()));
    text += formatText("{} splats, SH degree {}, {} bytes ({} a splat) in {}\n", source->splats.count(), source->splats.shDegree,
                       file->size(), perSplat, options.out.string());
    return text + viewersFor(target, options);
}

}  // namespace dpl
