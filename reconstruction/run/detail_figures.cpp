// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/run/detail_figures.h"

#include <algorithm>
#include <functional>
#include <map>

#include "reconstruction/judging/report/bar_contrast.h"
#include "reconstruction/judging/report/detail.h"
#include "reconstruction/judging/report/fine_truth.h"
#include "reconstruction/judging/report/score.h"
#include "sdk/core/task.h"

namespace dpl {
namespace {

constexpr uint32_t kTimes = 2;

/** Pixels of the fine picture whose label in the frame's own size is `value`. */
std::vector<uint8_t> pixelsOf(const ImageGrey8& labels, uint8_t value) {
    const uint32_t w = labels.widthPx * kTimes, h = labels.heightPx * kTimes;
    std::vector<uint8_t> chosen(size_t(w) * h);
    for (uint32_t y = 0; y < h; ++y)
        for (uint32_t x = 0; x < w; ++x)
            chosen[size_t(y) * w + x] = labels.pixels[size_t(y / kTimes) * labels.widthPx + x / kTimes] == value;
    return chosen;
}

struct Mean {
    double sum = 0;
    size_t count = 0;
    void add(std::optional<double> value) {
        if (value) sum += *value, ++count;
    }
};

}  // namespace

Status addDetailFigures(const Scan& scan, AvatarView& view, const FrameSet& heldOut, const PosesFile& poses, ReportData& data) {
    for (const FrameKind kind : {FrameKind::StaticFull, FrameKind::Dynamic}) {  // close-ups count as static
        Mean all;
        std::vector<Mean> ofLabel(scan.labels.size());
        for (size_t i = 0; i < heldOut.frames.size(); ++i) {
            const TrainFrame& frame = heldOut.frames[i];
            if ((frame.kind == FrameKind::Dynamic) != (kind == FrameKind::Dynamic)) continue;
            DPL_RETURN_IF_ERROR(taskAt(double(i) / double(heldOut.frames.size()), frame.name));
            const auto truth = fineTruth(scan.root, frame.name, frame.camera);
            if (!truth) continue;
            const Camerad camera = frame.camera.scaled(kTimes);
            const auto expected = truth->widthPx == camera.widthPx && truth->heightPx == camera.heightPx
                                      ? truth->rgba
                                      : areaAveraged(truth->rgba, truth->widthPx, truth->heightPx, camera.widthPx, camera.heightPx);
            const FramePose& found = poses.frames[heldOut.rows[i]];
            DPL_TRY(const auto drawn, view.draw(found.bestPose(), camera));
            const auto score = [&](std::span<const uint8_t> chosen) {
                return detailCorrelation(drawn, expected, camera.widthPx, camera.heightPx, chosen);
            };
            all.add(score({}));
            DPL_TRY(const auto picture, frame.picture.get());
            const ImageGrey8& labels = picture->labels;
            if (labels.pixels.size() * kTimes * kTimes != size_t(camera.widthPx) * camera.heightPx) continue;
            for (size_t l = 0; l < scan.labels.size(); ++l)
                if (scan.labels[l].name != "background") ofLabel[l].add(score(pixelsOf(labels, scan.labels[l].value)));
        }
        if (all.count == 0) continue;
        const std::string group = formatText("correlation of fine detail when drawn at x {}, held-out {} ({} frames with a finer truth)",
                                             kTimes, shortKindName(kind), all.count);
        const std::string key = std::string("detail.") + shortKindName(kind);
        data.figures.push_back({key, group, "whole subject", "", all.sum / double(all.count), {}});
        for (size_t l = 0; l < scan.labels.size(); ++l)
            if (ofLabel[l].count > 0)
                data.figures.push_back(
                    {key + "." + scan.labels[l].name, group, scan.labels[l].name, "", ofLabel[l].sum / double(ofLabel[l].count), {}});
    }
    return {};
}

Status addBarFigures(const Scan& scan, AvatarView& view, const FrameSet& heldOut, const PosesFile& poses, ReportData& data) {
    DPL_TRY(const auto printed, readPrintedBars(scan.root));
    std::map<double, Mean, std::greater<>> ofWidth;
    for (size_t i = 0; i < heldOut.frames.size(); ++i) {
        const TrainFrame& frame = heldOut.frames[i];
        const auto fields = printed.find(frame.name);
        if (frame.kind != FrameKind::StaticCloseup || fields == printed.end()) continue;
        DPL_TRY(const auto picture, frame.picture.get());
        DPL_TRY(const auto drawn, view.draw(poses.frames[heldOut.rows[i]].bestPose(), frame.camera));
        const std::vector<uint8_t> photograph = cutOut(picture->image, picture->mask);
        for (const PrintedBars& bars : fields->second)
            ofWidth[bars.widthMm].add(barContrast(drawn, photograph, frame.camera.widthPx, frame.camera.heightPx, bars));
    }
    for (const auto& [widthMm, mean] : ofWidth)
        if (mean.count > 0)
            data.figures.push_back({formatText("bars.{}mm", widthMm),
                                    "contrast kept of printed bars, held-out close-ups",
                                    formatText("bars {} mm wide", widthMm),
                                    "",
                                    mean.sum / double(mean.count),
                                    {}});
    return {};
}

}  // namespace dpl
