// SPDX-License-Identifier: Apache-2.0
#include <algorithm>

#include "reconstruction/output/package/avatar_bytes.h"
#include "reconstruction/output/package/posed_splats.h"
#include "sdk/core/files.h"
#include "sdk/format/avatar_file.h"
#include "sdk/format/gltf_splats.h"
#include "sdk/format/ply.h"
#include "sdk/format/splat_file.h"
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
    const auto clip = readClip(*bytes, std::filesystem::path(options.clip).filename().string(), {options.animation}, avatar.joints);
    if (!clip) return fail(clip.error().code, "--clip {}: {}", options.clip, clip.error().message);
    return samplePose(*clip, avatar.joints, options.timeS);
}

Result<StaticSplatData> splatsOf(const ExportOptions& options, std::span<const uint8_t> bytes) {
    if (splatFormatOf(bytes) != SplatFormat::None) {
        if (!options.clip.empty() || options.timeS > 0)
            return fail(Code::InvalidArgument, "{} does not apply to general splats, which have no joints to pose; leave it out",
                        options.clip.empty() ? "--time" : "--clip");
        DPL_TRY(SplatFile file, readSplats(bytes));
        return std::move(file.splats);
    }
    DPL_TRY(const AvatarData avatar, readAvatar(bytes));
    DPL_TRY(const Pose pose, choosePose(avatar, options));
    return posedSplats(avatar, pose);
}

}  // namespace

Result<std::string> exportPosedSplats(const ExportOptions& options) {
    const std::string extension = options.out.extension().string();
    if (extension != ".ply" && extension != ".glb")
        return fail(Code::InvalidArgument, "-o {}: the file must end in .ply or .glb", options.out.string());
    DPL_TRY(auto bytes, readAvatarBytes(options.avatar));
    auto splats = splatsOf(options, bytes);
    if (!splats) return fail(splats.error().code, "{}: {}", options.avatar.string(), splats.error().message);
    DPL_TRY(auto file, extension == ".ply" ? writePly(*splats) : writeGltfSplats(*splats));
    DPL_RETURN_IF_ERROR(writeFileAtomically(options.out, file));
    return formatText("{} splats, SH degree {}, {} bytes in {}", splats->count(), splats->shDegree, file.size(), options.out.string());
}

}  // namespace dpl
