// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdio>

#include "reconstruction/output/package/avatar_bytes.h"
#include "reconstruction/output/package/posed_splats.h"
#include "sdk/avatar/cloth_bounds.h"
#include "sdk/core/files.h"
#include "sdk/format/avatar_file.h"
#include "sdk/format/gltf_splats.h"
#include "sdk/format/ply.h"
#include "sdk/format/splat_file.h"
#include "sdk/format/spz.h"
#include "sdk/motion/clip.h"
#include "sdk/motion/motion_clip.h"

namespace dpl {
namespace {

Result<Pose> choosePose(const AvatarData& avatar, const ExportOptions& options) {
    if (options.clip.empty()) return Pose::rest(avatar.joints.size());
    const auto own =
        std::find_if(avatar.clips.begin(), avatar.clips.end(), [&](const ClipData& clip) { return clip.name == options.clip; });
    if (own != avatar.clips.end()) return samplePose(*own, avatar.joints, options.timeS);
    auto bytes = readFile(options.clip, uint64_t(512) << 20);
    if (!bytes) return fail(bytes.error().code, "--clip {} is neither a clip of the avatar nor a readable BVH or glTF file", options.clip);
    const auto clip = readClip(*bytes, std::filesystem::path(options.clip).stem().string(), {options.animation}, avatar.joints);
    if (!clip) return fail(clip.error().code, "--clip {}: {}", options.clip, clip.error().message);
    return samplePose(*clip, avatar.joints, options.timeS);
}

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
    DPL_TRY(const Pose pose, choosePose(avatar, options));
    DPL_TRY(source.splats, posedSplats(avatar, pose));
    source.lost.push_back(formatText("motion ({} joints, {} clips)", avatar.joints.size(), avatar.clips.size()));
    if (!avatar.correctives.empty()) source.lost.push_back("pose correctives beyond this pose");
    return source;
}

/** Splats with a number that SPZ clamps. */
size_t clampedBySpz(const StaticSplatData& s) {
    const size_t shFloats = s.sh.size() / std::max<size_t>(1, s.count());
    size_t clamped = 0;
    for (size_t i = 0; i < s.count(); ++i) {
        bool any = false;
        for (size_t k = 0; k < shFloats; ++k) any = any || std::abs(s.sh[i * shFloats + k]) > (k < 3 ? 0.5 / 0.15 : 1.0);
        clamped += any;
    }
    return clamped;
}

enum class Target { None, Glb, Spz, Ply, CompressedPly };

Target targetOf(const std::filesystem::path& out) {
    std::string name = out.filename().string();
    std::transform(name.begin(), name.end(), name.begin(), [](unsigned char c) { return char(std::tolower(c)); });
    if (name.ends_with(".compressed.ply")) return Target::CompressedPly;
    const std::string extension = out.extension().string();
    return extension == ".glb" ? Target::Glb : extension == ".spz" ? Target::Spz : extension == ".ply" ? Target::Ply : Target::None;
}

constexpr const char* kHalfTurned = "y-down";

Result<std::vector<uint8_t>> bytesOf(const ExportOptions& options, Target target, Source& source) {
    if (target == Target::Glb) {
        if (source.splats.compensated) source.lost.push_back("the antialiased mark (.ply and .spz hold it)");
        return writeGltfSplats(source.splats);
    }
    if (target == Target::Ply) return writePly(source.splats, {.axes = options.axes == "y-up" ? "RUB" : "LDB"});
    if (const size_t clamped = clampedBySpz(source.splats))
        source.lost.push_back(formatText("colours or SH of {} splats beyond the range of SPZ, which are clamped", clamped));
    return writeSpz(source.splats, options.spzVersion);
}

std::string viewersFor(const ExportOptions& options, Target target) {
    if (target == Target::Glb) return "upright (y up, by the glTF standard) in every viewer of KHR_gaussian_splatting";
    if (target == Target::Spz) return "upright (y up, SPZ's default) in every viewer of SPZ";
    if (options.axes == "y-up")
        return "y up, as stated: upright in three.js, Spark and the PlayCanvas engine; for SuperSplat and splat-transform leave out --axes";
    return "half a turn about z, as stated: upright in SuperSplat and splat-transform; for three.js, Spark and the PlayCanvas engine add "
           "--axes y-up";
}

}  // namespace

std::string wrongExport(const ExportOptions& options) {
    const std::string out = options.out.string();
    const Target target = targetOf(options.out);
    if (target == Target::CompressedPly)
        return formatText("-o {}: compressed PLY is not written; name a .spz, which is as small, or a plain .ply without 'compressed'",
                          out);
    if (target == Target::None) return formatText("-o {}: the file must end in .glb, .spz or .ply", out);
    if (target != Target::Ply && options.axes == kHalfTurned)
        return formatText("-o {}: --axes {} is for .ply; this format is y up by its definition", out, kHalfTurned);
    if (target != Target::Spz && options.spzVersion != ExportOptions().spzVersion)
        return formatText("-o {}: --spz-version is for .spz", out);
    return {};
}

Result<std::string> exportPosedSplats(const ExportOptions& options) {
    if (const std::string wrong = wrongExport(options); !wrong.empty()) return fail(Code::InvalidArgument, "{}", wrong);
    DPL_TRY(auto bytes, readAvatarBytes(options.avatar));
    auto source = sourceOf(options, bytes);
    if (!source) return fail(source.error().code, "{}: {}", options.avatar.string(), source.error().message);
    const Target target = targetOf(options.out);
    auto file = bytesOf(options, target, *source);
    if (!file) return fail(file.error().code, "{}: {}", options.out.string(), file.error().message);
    DPL_RETURN_IF_ERROR(writeFileAtomically(options.out, *file));
    std::string text;
    for (const std::string& note : source->notes) text += formatText("note: {}: {}\n", options.avatar.string(), note);
    for (const std::string& lost : source->lost) text += formatText("not in {}: {}\n", options.out.filename().string(), lost);
    char perSplat[32];
    std::snprintf(perSplat, sizeof perSplat, "%.1f", double(file->size()) / std::max(1u, source->splats.count()));
    text += formatText("{} splats, SH degree {}, {} bytes ({} a splat) in {}\n", source->splats.count(), source->splats.shDegree,
                       file->size(), perSplat, options.out.string());
    return text + viewersFor(options, target);
}

}  // namespace dpl
