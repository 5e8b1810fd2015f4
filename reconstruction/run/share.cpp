// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/run/share.h"

#include <algorithm>
#include <cmath>

#include "reconstruction/base/image_codec.h"
#include "reconstruction/judging/coach/move_poses.h"
#include "reconstruction/judging/report/draw_view.h"
#include "reconstruction/judging/report/score.h"
#include "reconstruction/output/package/avatar_bytes.h"
#include "reconstruction/output/page/live_page.h"
#include "reconstruction/output/page/shown_avatar.h"
#include "reconstruction/subject/surface/orbit_camera.h"
#include "sdk/core/files.h"
#include "sdk/format/avatar_file.h"

namespace dpl {
namespace {

constexpr uint32_t kStillHeightPx = 560, kStillWidthPx = 420;
constexpr int kStillQuality = 75;
// Where <doppel-avatar> begins, so that the picture and the person stand in one place (platform/web/doppel-avatar.js).
constexpr double kFovY = 0.6, kAzimuth = 0.35, kElevation = 0.05, kMargin = 1.15;

Result<std::filesystem::path> avatarOfRun(const std::filesystem::path& from) {
    std::error_code error;
    if (!std::filesystem::is_directory(from, error)) return from;
    const std::filesystem::path avatar = from / "avatar.glb";
    if (!std::filesystem::exists(avatar, error))
        return fail(Code::NotFound, "{} holds no avatar.glb; finish its run with doppel reconstruct, or name an avatar file",
                    from.string());
    return avatar;
}

Pose firstPose(const AvatarData& avatar) {
    Pose pose = Pose::rest(avatar.joints.size());
    if (avatar.clips.empty()) return pose;
    const ClipData& clip = avatar.clips.front();
    for (const ClipChannel& channel : clip.channels) pose.localRotations[channel.joint] = channel.rotations.front();
    if (!clip.rootTranslations.empty()) pose.rootTranslation = clip.rootTranslations.front();
    return pose;
}

Result<std::vector<uint8_t>> drawStill(std::span<const uint8_t> bytes, const AvatarData& avatar, uint32_t threadCount) {
    Vec3f low(1e9f), high(-1e9f);
    for (const Vec3f& p : avatar.mesh.restPositions) low = glm::min(low, p), high = glm::max(high, p);
    const Vec3d half = 0.5 * Vec3d(high - low);
    const double wide = std::clamp(half.x, 0.3 * half.y, half.y), tangent = std::tan(kFovY / 2);
    const double distance = kMargin * std::max(half.y, wide * kStillHeightPx / kStillWidthPx) / tangent;
    const Camerad camera =
        orbitCamera(0.5 * Vec3d(low + high), distance, kAzimuth, kElevation, kStillHeightPx / (2 * tangent), kStillWidthPx, kStillHeightPx);
    DPL_TRY(auto view, AvatarView::open(bytes, threadCount));
    DPL_TRY(const auto rgba, view.draw(firstPose(avatar), camera));
    return encodeJpeg(overWhite(rgba), kStillWidthPx, kStillHeightPx, 3, kStillQuality);
}

}  // namespace

Result<std::string> shareAvatar(const ShareOptions& options) {
    DPL_TRY(const std::filesystem::path file, avatarOfRun(options.from));
    DPL_TRY(const auto original, readAvatarBytes(file));
    DPL_TRY(const AvatarData read, avatarOf(file, original, "moves"));
    DPL_TRY(const WebModule module, readWebModule(options.web));
    SharedPerson person{options.name.empty() ? options.out.stem().string() : options.name, options.licence, {}, {}};
    DPL_TRY(person.avatar,
            shownAvatar(original, {.moreClips = walkClips(read.joints), .nameInstead = person.name, .withoutEvidence = true}));
    DPL_TRY(const AvatarData shown, readAvatar(person.avatar));
    DPL_TRY(person.still, drawStill(person.avatar, shown, options.threadCount));
    const std::string page = sharePage(person, module);
    DPL_RETURN_IF_ERROR(writeFileAtomically(options.out, page));
    return formatText("{}: {} bytes, of them {} for the avatar; open it in a browser, or send it", options.out.string(), page.size(),
                      (person.avatar.size() + 2) / 3 * 4);
}

}  // namespace dpl
