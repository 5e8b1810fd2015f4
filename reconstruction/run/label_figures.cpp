// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/run/label_figures.h"

#include "reconstruction/judging/report/label_score.h"
#include "reconstruction/judging/report/score.h"
#include "sdk/core/task.h"

namespace dpl {
namespace {

struct LabelSum {
    double psnrDb = 0, iou = 0;
    size_t frames = 0;
};

}  // namespace

Status addLabelFigures(const Scan& scan, AvatarView& view, const FrameSet& heldOut, const PosesFile& poses, ReportData& data) {
    for (const FrameKind kind : {FrameKind::StaticFull, FrameKind::Dynamic}) {
        std::vector<LabelSum> sums(scan.labels.size());
        for (size_t i = 0; i < heldOut.frames.size(); ++i) {
            const TrainFrame& frame = heldOut.frames[i];
            if (frame.kind != kind) continue;
            DPL_RETURN_IF_ERROR(taskAt(double(i) / double(heldOut.frames.size()), frame.name));
            DPL_TRY(const auto picture, frame.picture.get());
            if (picture->labels.pixels.empty()) continue;
            DPL_TRY(const auto drawn, view.draw(poses.frames[heldOut.rows[i]].bestPose(), frame.camera));
            const std::vector<uint8_t> truth = cutOut(picture->image, picture->mask);
            for (size_t l = 0; l < sums.size(); ++l) {
                if (scan.labels[l].name == "background") continue;
                if (const auto score = scoreLabel(drawn, truth, picture->labels, scan.labels[l].value))
                    sums[l].psnrDb += score->maskedPsnrDb, sums[l].iou += score->outlineIou, ++sums[l].frames;
            }
        }
        const std::string group = formatText("each label, held-out {}, pose fitted", shortKindName(kind));
        for (size_t l = 0; l < sums.size(); ++l) {
            const auto& [psnrDb, iou, frames] = sums[l];
            if (frames == 0) continue;
            const std::string &name = scan.labels[l].name, key = formatText("label.{}.{}", shortKindName(kind), name);
            data.figures.push_back({key + ".psnr", group, name + ", masked PSNR", "dB", psnrDb / double(frames), {}});
            data.figures.push_back({key + ".iou", group, name + ", overlap of the outlines beside it", "", iou / double(frames), {}});
        }
    }
    return {};
}

}  // namespace dpl
