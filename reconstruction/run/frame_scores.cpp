// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/run/frame_scores.h"

#include <cstdio>

#include "reconstruction/base/image_codec.h"
#include "reconstruction/judging/report/error_map.h"
#include "sdk/avatar/posed_mesh.h"
#include "sdk/core/task.h"

namespace dpl {

Result<LabelColours> gatherLabelColours(const FrameTable& table) {
    LabelColours colours;
    for (size_t row = 0; row < table.rows(); ++row) {
        if (!table.trains(row) || table.scan.frames[row].kind == FrameKind::StaticCloseup) continue;
        DPL_TRY(const auto picture, table.picture(row));
        colours.add(picture->image, picture->mask, picture->labels);
    }
    return colours;
}

Result<std::vector<HeldOutFrame>> scoreFrames(const LabelColours& labelColours, const FrameSet& set, const AvatarData& avatar,
                                              AvatarView& view, const PosesFile& poses, bool withPictures, Jobs& jobs) {
    const std::vector<RestTriangle<float>> bind = restTriangles(avatar.mesh);
    const ClothLimits cloth(avatar.joints, avatar.mesh, avatar.correctives);
    PosedMesh posed;
    std::vector<HeldOutFrame> scored;
    for (size_t i = 0; i < set.frames.size(); ++i) {
        const TrainFrame& frame = set.frames[i];
        DPL_RETURN_IF_ERROR(taskAt(double(i) / double(set.frames.size()), frame.name));
        DPL_TRY(const auto picture, frame.picture.get());
        const ImageRgb8& image = picture->image;
        const ImageGrey8 &mask = picture->mask, &labels = picture->labels;
        const FramePose& found = poses.frames[set.rows[i]];
        const Pose& fitted = found.bestPose();
        HeldOutFrame out;
        out.name = frame.name;
        out.kind = frame.kind;
        DPL_TRY(auto plain, view.draw(found.pose, frame.camera));
        DPL_TRY(auto best, view.draw(fitted, frame.camera));
        out.withoutPoseFit = scorePicture(plain, image, mask);
        out.withPoseFit = scorePicture(best, image, mask);
        out.labelFloor = scorePicture(labelColours.paint(mask, labels), image, mask);
        posed.pose({avatar.joints, avatar.mesh, avatar.correctives, {bind}, nullptr, {}, &cloth}, fitted, jobs);
        out.meshFloor = scorePicture(paintMesh(posed.positions(), avatar.mesh.triangles, avatar.mesh.colours, frame.camera), image, mask);
        if (withPictures) {
            const auto truth = overWhite(cutOut(image, mask)), shown = overWhite(best);
            const uint32_t w = frame.camera.widthPx, h = frame.camera.heightPx;
            DPL_TRY(out.truthPng, encodePng(truth, w, h, 3));
            DPL_TRY(out.renderPng, encodePng(shown, w, h, 3));
            DPL_TRY(out.differencePng, encodePng(differenceTimesFour(shown, truth), w, h, 3));
            out.onSurface = differenceOnSurface(posed.positions(), avatar.mesh.triangles, frame.camera, shown, truth, mask);
        }
        scored.push_back(std::move(out));
    }
    return scored;
}

std::string scoreLines(const std::vector<HeldOutFrame>& frames, const char* what) {
    std::string text;
    for (const FrameKind kind : {FrameKind::StaticFull, FrameKind::StaticCloseup, FrameKind::Dynamic})
        if (auto mean = meanScore(frames, kind, &HeldOutFrame::withPoseFit)) {
            char line[320];
            std::snprintf(line, sizeof line,
                          "\n%s %-8s  masked PSNR %.2f dB, alpha IoU %.4f, SSIM %.4f (pose fitted; without: %.2f dB)\n"
                          "  with what is drawn outside: PSNR %.2f dB, SSIM %.4f; uncovered %.2f %%, drawn outside %.2f %% of the mask, "
                          "%.1f px of lone specks",
                          what, shortKindName(kind), mean->maskedPsnrDb, mean->alphaIou, mean->maskedSsim,
                          meanScore(frames, kind, &HeldOutFrame::withoutPoseFit)->maskedPsnrDb, mean->unionPsnrDb, mean->unionSsim,
                          100 * mean->uncovered, 100 * mean->drawnOutside, mean->lonePx);
            text += line;
        }
    return text;
}

}  // namespace dpl
