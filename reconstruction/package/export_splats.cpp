#include <algorithm>

#include "reconstruction/package/posed_splats.h"
#include "sdk/avatar/clip.h"
#include "sdk/avatar/motion.h"
#include "sdk/avatar/retarget.h"
#include "sdk/core/files.h"
#include "sdk/format/avatar_file.h"
#include "sdk/format/gltf_splats.h"
#include "sdk/format/ply.h"

namespace dpl {
namespace {

Result<Pose> choosePose(const AvatarData& avatar, const ExportOptions& options) {
    if (options.clip.empty()) return Pose::rest(avatar.joints.size());
    const auto own = std::find_if(avatar.clips.begin(), avatar.clips.end(), [&](const ClipData& clip) { return clip.name == options.clip; });
    if (own != avatar.clips.end()) return samplePose(*own, avatar.joints, options.timeS);
    auto bytes = readFile(options.clip, uint64_t(512) << 20);
    if (!bytes) return fail(bytes.error().code, "--clip {} is neither a clip of the avatar nor a readable BVH or glTF file", options.clip);
    auto motion = readMotion(*bytes, options.clip);
    if (!motion) return fail(motion.error().code, "{}: {}", options.clip, motion.error().message);
    auto clip = retarget(*motion, avatar.joints);
    if (!clip) return fail(clip.error().code, "{}: {}", options.clip, clip.error().message);
    return samplePose(*clip, avatar.joints, options.timeS);
}

}  // namespace

Result<std::string> exportPosedSplats(const ExportOptions& options) {
    const std::string extension = options.out.extension().string();
    if (extension != ".ply" && extension != ".glb") return fail(Code::InvalidArgument, "-o {}: the file must end in .ply or .glb", options.out.string());
    DPL_TRY(auto bytes, readFile(options.avatar));
    auto avatar = readAvatar(bytes);
    if (!avatar) return fail(avatar.error().code, "{}: {}", options.avatar.string(), avatar.error().message);
    DPL_TRY(Pose pose, choosePose(*avatar, options));
    DPL_TRY(StaticSplatData splats, posedSplats(*avatar, pose));
    DPL_TRY(auto file, extension == ".ply" ? writePly(splats) : writeGltfSplats(splats));
    DPL_CHECK_OK(writeFileAtomically(options.out, file));
    return formatText("{} splats, SH degree {}, {} bytes in {}", splats.count(), splats.shDegree, file.size(), options.out.string());
}

}  // namespace dpl
