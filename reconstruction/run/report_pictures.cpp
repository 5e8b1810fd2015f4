// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/run/report_pictures.h"

#include <algorithm>
#include <cmath>

#include "reconstruction/base/image_codec.h"
#include "reconstruction/judging/coach/move_poses.h"
#include "reconstruction/judging/coach/shots.h"
#include "reconstruction/judging/report/score.h"
#include "reconstruction/run/film_memory.h"
#include "reconstruction/subject/surface/body_places.h"
#include "reconstruction/subject/surface/orbit_camera.h"
#include "sdk/core/evenly_spaced.h"
#include "sdk/core/task.h"

namespace dpl {
namespace {

constexpr double kClipHeightPx = 320, kCardPx = 312;  // of cards the longer side: three pixels for each of the page's
constexpr int kJpegQuality = 85;
constexpr size_t kFilmPictures = 32, kFewestFilmPictures = 8;
constexpr double kFilmPicturesPerS = 6;

Result<std::vector<uint8_t>> jpegOf(const std::vector<uint8_t>& rgb, const Camerad& camera) {
    return encodeJpeg(rgb, camera.widthPx, camera.heightPx, 3, kJpegQuality);
}

Camerad scaledToHeight(const Camerad& camera, double heightPx) {
    return camera.scaled(heightPx / camera.heightPx);
}

/** Two pictures of one size beside each other. */
std::vector<uint8_t> beside(const std::vector<uint8_t>& left, const std::vector<uint8_t>& right, size_t rowBytes) {
    std::vector<uint8_t> out;
    for (size_t at = 0; at < left.size(); at += rowBytes) {
        out.insert(out.end(), left.begin() + ptrdiff_t(at), left.begin() + ptrdiff_t(at + rowBytes));
        out.insert(out.end(), right.begin() + ptrdiff_t(at), right.begin() + ptrdiff_t(at + rowBytes));
    }
    return out;
}

/** Rows of moving pictures of one size with masks, in the order of the film, thinned out evenly. */
std::vector<size_t> filmRows(const FrameTable& table, std::span<const Camerad> cameras) {
    std::vector<size_t> rows;
    for (size_t row = 0; row < table.rows(); ++row) {
        const ScanFrame& frame = table.scan.frames[row];
        if (frame.kind != FrameKind::Dynamic || !table.usable[row] || frame.maskPath.empty()) continue;
        if (!rows.empty() && (cameras[row].widthPx != cameras[rows[0]].widthPx || cameras[row].heightPx != cameras[rows[0]].heightPx))
            continue;
        rows.push_back(row);
    }
    std::stable_sort(rows.begin(), rows.end(), [&](size_t a, size_t b) { return table.scan.frames[a].timeS < table.scan.frames[b].timeS; });
    return evenlySpaced(rows, kFilmPictures);
}

Result<ReportClip> filmClip(const FilmedAvatar& filmed, AvatarView& view, std::span<const size_t> rows) {
    ReportClip clip{"Left as it was filmed, right the avatar", double(rows.size()) / kFilmPicturesPerS, {}};
    for (size_t i = 0; i < rows.size(); ++i) {
        DPL_RETURN_IF_ERROR(taskAt(double(i) / double(rows.size()), "clips"));
        const Camerad& camera = filmed.cameras[rows[i]];
        const Camerad small = scaledToHeight(camera, kClipHeightPx);
        DPL_TRY(const auto picture, filmed.table.picture(rows[i]));
        const auto truth =
            overWhite(areaAveraged(cutOut(picture->image, picture->mask), camera.widthPx, camera.heightPx, small.widthPx, small.heightPx));
        DPL_TRY(const auto drawn, view.draw(filmed.poses.frames[rows[i]].bestPose(), small));
        Camerad both = small;
        both.widthPx *= 2;
        DPL_TRY(clip.jpegs.emplace_back(), jpegOf(beside(truth, overWhite(drawn), size_t(small.widthPx) * 3), both));
    }
    return clip;
}

/** Looks at the avatar at rest from its front left, with room for arms and steps. */
Camerad clipCamera(const MeshData& mesh) {
    Vec3f low(1e9f), high(-1e9f);
    for (const Vec3f& p : mesh.restPositions) low = glm::min(low, p), high = glm::max(high, p);
    const double tall = double(high.y - low.y), distance = 3 * tall;
    const double focalPx = kClipHeightPx * distance / (1.25 * tall);
    return orbitCamera(0.5 * Vec3d(low + high), distance, 0.6, 0.1, focalPx, uint32_t(0.75 * kClipHeightPx), uint32_t(kClipHeightPx));
}

}  // namespace

Result<std::vector<ReportClip>> drawClips(const FilmedAvatar& filmed, AvatarView& view) {
    std::vector<ReportClip> clips;
    if (const std::vector<size_t> rows = filmRows(filmed.table, filmed.cameras); rows.size() >= kFewestFilmPictures) {
        DPL_TRY(clips.emplace_back(), filmClip(filmed, view, rows));
    }
    const Camerad camera = clipCamera(filmed.avatar.mesh);
    for (const MoveClip& move : moveClips(filmed.avatar.joints)) {
        ReportClip clip{formatText("The avatar {}, which nobody filmed", move.name), move.seconds, {}};
        const std::vector<Pose> poses = posesInLoop(filmed.avatar.correctives.motion, move);
        for (size_t i = 0; i < poses.size(); ++i) {
            DPL_RETURN_IF_ERROR(taskAt(double(i) / double(poses.size()), "clips"));
            DPL_TRY(const auto drawn, view.draw(poses[i], camera));
            DPL_TRY(clip.jpegs.emplace_back(), jpegOf(overWhite(drawn), camera));
        }
        clips.push_back(std::move(clip));
    }
    return clips;
}

Result<std::vector<AdviceCard>> drawAdvice(const FilmedAvatar& filmed, AvatarView& view,
                                           std::span<const std::pair<std::string, std::string>> shots) {
    const AvatarData& avatar = filmed.avatar;
    std::vector<PosedPicture> stills;  // those of the stage body-map, so that the first full-body picture is the same
    for (size_t row = 0; row < filmed.table.rows(); ++row) {
        const FrameKind kind = filmed.table.scan.frames[row].kind;
        if (!filmed.table.trains(row) || kind == FrameKind::Dynamic) continue;
        stills.push_back({{}, filmed.cameras[row], filmed.poses.frames[row].bestPose(), kind == FrameKind::StaticCloseup});
    }
    const auto standing = std::find_if(stills.begin(), stills.end(), [](const PosedPicture& p) { return !p.closeUp; });
    const std::vector<BodyPlace> places = placesOf(avatar.joints, avatar.mesh);
    std::vector<AdviceCard> cards;
    for (const auto& [key, sentence] : shots) {
        AdviceCard card{sentence, {}};
        if (key == "moves") {
            const Camerad camera = clipCamera(avatar.mesh);
            DPL_TRY(const auto drawn, view.draw(poseOfMove(avatar.joints, sentence), camera));
            DPL_TRY(card.jpeg, jpegOf(overWhite(drawn), camera));
        } else if (const auto camera = cameraOfShot(key, avatar.mesh, avatar.joints, places, stills)) {
            const Camerad small = camera->scaled(kCardPx / std::max(camera->widthPx, camera->heightPx));
            DPL_TRY(const auto drawn, view.draw(standing->pose, small));
            DPL_TRY(card.jpeg, jpegOf(overWhite(drawn), small));
        }
        cards.push_back(std::move(card));
    }
    return cards;
}

}  // namespace dpl
