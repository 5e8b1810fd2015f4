// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/run/scale_figures.h"

#include <algorithm>

#include "reconstruction/judging/report/fine_truth.h"
#include "reconstruction/judging/report/score.h"
#include "sdk/core/task.h"

namespace dpl {
namespace {

constexpr double kScales[] = {0.5, 1, 2, 4}, kComparedAt[] = {1, 0.5};
constexpr double kMaxPixels = 16e6;  // larger pictures are skipped, because they take too long to draw

struct Sums {
    double all = 0, inside = 0;
    size_t frames = 0;
};

}  // namespace

Status addScaleFigures(const std::filesystem::path& scan, AvatarView& view, const FrameSet& heldOut, const PosesFile& poses,
                       ReportData& data) {
    for (const FrameKind kind : {FrameKind::StaticFull, FrameKind::Dynamic}) {  // close-ups count as static
        const auto isOfKind = [&](const TrainFrame& f) { return (f.kind == FrameKind::Dynamic) == (kind == FrameKind::Dynamic); };
        bool fine = false;
        Sums sums[std::size(kComparedAt)][std::size(kScales)] = {};
        for (size_t i = 0; i < heldOut.frames.size(); ++i) {
            const TrainFrame& frame = heldOut.frames[i];
            if (!isOfKind(frame)) continue;
            DPL_RETURN_IF_ERROR(taskAt(double(i) / double(heldOut.frames.size()), frame.name));
            auto truth = fineTruth(scan, frame.name, frame.camera);
            if (truth && !fine) {  // once one frame has a finer truth, only such frames are scored
                fine = true;
                for (auto& row : sums) std::fill(std::begin(row), std::end(row), Sums{});
            }
            if (!truth && fine) continue;
            if (!truth) {
                DPL_TRY(const auto picture, frame.picture.get());
                truth = FineTruth{cutOut(picture->image, picture->mask), frame.camera.widthPx, frame.camera.heightPx};
            }
            const FramePose& found = poses.frames[heldOut.rows[i]];
            for (size_t s = 0; s < std::size(kScales); ++s) {
                const Camerad camera = frame.camera.scaled(kScales[s]);
                if (double(camera.widthPx) * camera.heightPx > kMaxPixels || camera.widthPx == 0 || camera.heightPx == 0) continue;
                DPL_TRY(auto picture, view.draw(found.bestPose(), camera));
                for (size_t c = 0; c < std::size(kComparedAt); ++c) {
                    if (kScales[s] < kComparedAt[c]) continue;
                    const Camerad compared = frame.camera.scaled(kComparedAt[c]);
                    const uint32_t w = compared.widthPx, h = compared.heightPx;
                    if (w == 0 || h == 0) continue;
                    const auto averaged = [&](const std::vector<uint8_t>& rgba, uint32_t fromW, uint32_t fromH) {
                        return fromW == w && fromH == h ? rgba : areaAveraged(rgba, fromW, fromH, w, h);
                    };
                    const auto drawn = averaged(picture, camera.widthPx, camera.heightPx),
                               expected = averaged(truth->rgba, truth->widthPx, truth->heightPx);
                    sums[c][s].all += scorePicture(drawn, expected, w, h).maskedPsnrDb;
                    sums[c][s].inside += scorePicture(drawn, insideOutline(expected, w, h), w, h).maskedPsnrDb;
                    ++sums[c][s].frames;
                }
            }
        }
        for (size_t c = 0; c < std::size(kComparedAt); ++c)
            for (size_t s = 0; s < std::size(kScales); ++s) {
                const Sums& sum = sums[c][s];
                if (sum.frames == 0) continue;
                const double n = double(sum.frames);
                const std::string group = formatText(
                    "masked PSNR when drawn at another size, averaged to x {}, held-out {} ({})", kComparedAt[c], shortKindName(kind),
                    fine ? formatText("{} frames with a finer truth", sum.frames) : std::string("the mask is yes or no"));
                const std::string key = formatText("scale.{}.at_{}.drawn_{}", shortKindName(kind), kComparedAt[c], kScales[s]),
                                  name = formatText("drawn at x {}", kScales[s]);
                data.figures.push_back({key + ".all", group, name, "dB", sum.all / n, {}});
                data.figures.push_back({key + ".inside", group, name + ", one pixel inside the outline", "dB", sum.inside / n, {}});
            }
    }
    return {};
}

}  // namespace dpl
