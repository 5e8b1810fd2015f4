#include "reconstruction/pipeline/scale_figures.h"

#include <algorithm>
#include <optional>

#include "reconstruction/pipeline/train_frames.h"
#include "reconstruction/report/draw_view.h"
#include "reconstruction/report/score.h"

namespace dpl {
namespace {

constexpr double kScales[] = {0.5, 1, 2, 4};
constexpr double kMaxPixels = 16e6;  // larger pictures are left out: the figure would cost more than the avatar

struct Truth {
    std::vector<uint8_t> rgba;
    uint32_t widthPx = 0, heightPx = 0;
};

/** The frame at ×4, else ×2. None when the scan has neither, or they cannot be read or have another size. */
std::optional<Truth> fineTruth(const std::filesystem::path& scan, const TrainFrame& frame) {
    for (const uint32_t times : {4u, 2u}) {
        ScanFrame file;
        const std::filesystem::path folder = scan / "hires" / ("x" + std::to_string(times));
        file.name = frame.name;
        file.imagePath = folder / (frame.name + ".jpg"), file.maskPath = folder / (frame.name + ".mask.png");
        file.camera = frame.camera.scaled(times);
        std::error_code missing;
        if (!std::filesystem::exists(file.imagePath, missing) || !std::filesystem::exists(file.maskPath, missing)) continue;
        const auto image = readFrameImage(file);
        const auto mask = readFrameMask(file);
        if (image && mask) return Truth{cutOut(*image, *mask), file.camera.widthPx, file.camera.heightPx};
    }
    return std::nullopt;
}

struct Sums {
    double all = 0, inside = 0;
    size_t frames = 0;
};

}  // namespace

Status addScaleFigures(const SubjectData& subject, Progress& progress, const std::vector<uint8_t>& avatarBytes, const PosesFile& poses, ReportData& data) {
    DPL_TRY(auto view, AvatarView::open(avatarBytes, subject.options.threadCount));
    std::vector<size_t> indices;
    DPL_TRY(auto frames, loadTrainFrames(subject, Split::Test, &indices));
    for (const bool dynamic : {false, true}) {
        const auto isOfKind = [&](const TrainFrame& f) { return (f.kind == FrameKind::Dynamic) == dynamic; };
        bool fine = false;
        Sums sums[std::size(kScales)];
        for (size_t i = 0; i < frames.size(); ++i) {
            const TrainFrame& frame = frames[i];
            if (!isOfKind(frame)) continue;
            if (progress.cancelled()) return fail(Code::Cancelled, "stopped");
            auto truth = fineTruth(subject.options.scan, frame);
            if (truth && !fine) fine = true, std::fill(std::begin(sums), std::end(sums), Sums{});  // frames without one do not mix in
            if (!truth && fine) continue;
            if (!truth) truth = Truth{cutOut(frame.image, frame.mask), frame.camera.widthPx, frame.camera.heightPx};
            const FramePose& found = poses.frames[indices[i]];
            for (size_t s = 0; s < std::size(kScales); ++s) {
                const Camerad camera = frame.camera.scaled(kScales[s]), compared = frame.camera.scaled(std::min(1.0, kScales[s]));
                if (double(camera.widthPx) * camera.heightPx > kMaxPixels || camera.widthPx == 0 || camera.heightPx == 0) continue;
                DPL_TRY(auto picture, view.draw(found.fittedPose ? *found.fittedPose : found.pose, camera));
                const uint32_t w = compared.widthPx, h = compared.heightPx;
                if (w != camera.widthPx || h != camera.heightPx) picture = areaAveraged(picture, camera.widthPx, camera.heightPx, w, h);
                const auto expected = w == truth->widthPx && h == truth->heightPx ? truth->rgba : areaAveraged(truth->rgba, truth->widthPx, truth->heightPx, w, h);
                sums[s].all += scorePicture(picture, expected, w, h).maskedPsnrDb;
                sums[s].inside += scorePicture(picture, insideOutline(expected, w, h), w, h).maskedPsnrDb;
                ++sums[s].frames;
            }
        }
        for (size_t s = 0; s < std::size(kScales); ++s) {
            if (sums[s].frames == 0) continue;
            const double n = double(sums[s].frames);
            const std::string group = formatText("masked PSNR when drawn at another size, held-out {} ({})", dynamic ? "dynamic" : "static",
                                                 fine ? formatText("{} frames with a finer truth", sums[s].frames) : std::string("the mask is yes or no"));
            data.figures.push_back({group, formatText("x {}", kScales[s]), "dB", sums[s].all / n});
            data.figures.push_back({group, formatText("x {}, one pixel inside the outline", kScales[s]), "dB", sums[s].inside / n});
        }
    }
    return {};
}

}  // namespace dpl
