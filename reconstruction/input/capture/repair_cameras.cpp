// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/input/capture/repair_cameras.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "reconstruction/input/cameras/align_cameras.h"
#include "reconstruction/input/cameras/still_model.h"
#include "reconstruction/input/capture/focal_check.h"
#include "reconstruction/input/capture/frame_picture.h"
#include "reconstruction/input/capture/priors.h"
#include "sdk/core/percentile.h"
#include "sdk/core/task.h"

namespace dpl {
namespace {

constexpr size_t kRepairFeatures = 1500;
constexpr uint32_t kRepairMaxSidePx = 1200;
constexpr double kRepairMargin = 0.008;  // the person's mask grows by this part of the diagonal
// Matches of doubtful cameras may miss by this part of the diagonal, those of adjusted ones by the second. A focal length a fifth off moves
// the corner of a picture by a tenth of the diagonal.
constexpr double kDoubtfulGate = 0.06, kAdjustedGate = 0.006;
constexpr size_t kFullViewsOfCloseup = 20;
constexpr size_t kFewestMatches = 40;    // per picture, in the median
constexpr double kGoodMiss = 0.0016;     // of the diagonal; matches of right cameras miss by about half of that
constexpr size_t kFewestKeypoints = 20;  // fewer tell nothing
constexpr double kImproved = 0.5;        // of the miss before: less is a repair

double diagonalPx(const Camerad& camera) {
    return std::hypot(double(camera.widthPx), double(camera.heightPx));
}

bool isStillTraining(const ScanFrame& frame) {
    return frame.kind != FrameKind::Dynamic && frame.split == Split::Train;
}

/** Features of the background, or of the whole picture where there is no mask. In stored pixels. */
Result<Features> backgroundFeatures(const ScanFrame& frame) {
    ScanFrame stored = frame;
    stored.lens = {};
    DPL_TRY(ImageRgb8 image, readFrameImage(stored));
    cv::Mat rgb(int(image.heightPx), int(image.widthPx), CV_8UC3, image.pixels.data()), grey, background;
    cv::cvtColor(rgb, grey, cv::COLOR_RGB2GRAY);
    if (!frame.maskPath.empty()) {
        DPL_TRY(ImageGrey8 mask, readFrameMask(stored));
        cv::Mat person(int(mask.heightPx), int(mask.widthPx), CV_8UC1, mask.pixels.data());
        const int reach = 1 + int(kRepairMargin * diagonalPx(frame.camera));
        cv::threshold(person, person, 63, 255, cv::THRESH_BINARY);
        cv::dilate(person, person, cv::getStructuringElement(cv::MORPH_ELLIPSE, {2 * reach + 1, 2 * reach + 1}));
        cv::bitwise_not(person, background);
    }
    const auto view = [](const cv::Mat& m) -> GreyView { return {uint32_t(m.cols), uint32_t(m.rows), {m.ptr(), m.total()}}; };
    return findFeatures(view(grey), background.empty() ? GreyView{} : view(background), kRepairFeatures, kRepairMaxSidePx);
}

class Repair {
public:
    Repair(Scan& scan, Jobs& jobs) : scan_(scan), jobs_(jobs) {}

    Result<CameraRepair> run() {
        for (size_t f = 0; f < scan_.frames.size(); ++f)
            if (isStillTraining(scan_.frames[f])) stills_.push_back(f);
        if (stills_.size() < 3) return said("too few still pictures to check the cameras by");
        const Camerad& first = scan_.frames[stills_[0]].camera;
        for (const size_t f : stills_)
            if (const LensDistortion& a = scan_.frames[f].lens, &b = scan_.frames[stills_[0]].lens;
                a.p1 != 0 || a.p2 != 0 || a.k1 != b.k1 || a.k2 != b.k2)
                return said("cameras with several lenses or tangential distortion are taken as they are");
        DPL_RETURN_IF_ERROR(findAllFeatures());
        TrackSettings tracking = trackSettings(kDoubtfulGate * diagonalPx(first));
        DPL_TRY(Tracks tracks, findTracks(pictures_, scan_.frames[stills_[0]].lens, tracking));
        if (percentile(tracks.matchesOfPicture, 0.5) < kFewestMatches)
            return said("the pictures have too few matches to check the cameras by");
        DPL_TRY(const bool solved, adjust(tracks.scene, 1, kDoubtfulGate / 2 * diagonalPx(first)));
        if (!solved) return said("the pictures have too few matches to check the cameras by");
        out_.missBeforePx = end_.missBeforePx;
        out_.focalFactor = end_.focalFactor;
        for (size_t i = 0; i < stills_.size(); ++i) pictures_[i].camera = tracks.scene.cameras[i];
        tracking = trackSettings(kAdjustedGate * diagonalPx(first));
        const LensDistortion lens = tracks.scene.lens;
        DPL_TRY(tracks, findTracks(pictures_, lens, tracking));
        DPL_TRY(const bool again,
                adjust(tracks.scene, priors::kAdjustedMatchMiss * diagonalPx(first), priors::kAdjustedMatchOutlier * diagonalPx(first)));
        if (!again) return said("the adjusted cameras have too few matches, so they were not taken");
        out_.missAfterPx = end_.missAfterPx;
        out_.focalFactor *= end_.focalFactor;
        const bool was = out_.missBeforePx > kGoodMiss * diagonalPx(first);
        if (!was || out_.missAfterPx > kImproved * out_.missBeforePx)
            return said(formatText("matches of the pictures agree with the cameras: they miss by {} px, and by {} px after an adjustment",
                                   rounded(out_.missBeforePx), rounded(out_.missAfterPx)));
        return take(std::move(tracks));
    }

private:
    Scan& scan_;
    Jobs& jobs_;
    std::vector<size_t> stills_;          // frames
    std::vector<StillPicture> pictures_;  // of stills_
    BundleEnd end_;
    CameraRepair out_;

    static double rounded(double px) { return std::round(100 * px) / 100; }
    CameraRepair said(std::string sentence) {
        out_.sentence = std::move(sentence);
        return out_;
    }

    /** Close-ups see little of the background, and their neighbours see the same little: each is matched with many full views as well. */
    std::vector<std::pair<uint32_t, uint32_t>> closeupPairs() const {
        std::vector<Camerad> full;
        std::vector<uint32_t> which;
        for (size_t i = 0; i < stills_.size(); ++i)
            if (scan_.frames[stills_[i]].kind == FrameKind::StaticFull) full.push_back(pictures_[i].camera), which.push_back(uint32_t(i));
        std::vector<std::pair<uint32_t, uint32_t>> pairs;
        for (size_t i = 0; i < stills_.size(); ++i) {
            if (scan_.frames[stills_[i]].kind != FrameKind::StaticCloseup) continue;
            for (const size_t j : nearestTo(pictures_[i].camera, full, kFullViewsOfCloseup))
                pairs.emplace_back(std::min(uint32_t(i), which[j]), std::max(uint32_t(i), which[j]));
        }
        return pairs;
    }

    TrackSettings trackSettings(double gatePx) const {
        TrackSettings settings;
        settings.epipolarPx = gatePx;
        settings.missPx = 3 * gatePx;
        settings.morePairs = closeupPairs();
        return settings;
    }

    Status findAllFeatures() {
        std::vector<Status> results(stills_.size());
        pictures_.resize(stills_.size());
        std::atomic<bool> stopped{false};
        jobs_.forBlocks(stills_.size(), [&](size_t i, uint32_t worker) {
            if (worker == 0 && !taskAt(0)) stopped = true;
            if (stopped) return;
            auto found = backgroundFeatures(scan_.frames[stills_[i]]);
            if (found)
                pictures_[i] = {scan_.frames[stills_[i]].camera, std::move(*found)};
            else
                results[i] = found.error();
        });
        for (const Status& result : results) DPL_RETURN_IF_ERROR(result);
        return taskAt(0.3, "matching pictures");
    }

    /** False: the scene says too little. */
    Result<bool> adjust(BundleScene& scene, double lossPx, double outlierPx) {
        BundleSettings settings;
        settings.findFocal = settings.findLens = true;
        settings.lossPx = lossPx, settings.outlierPx = outlierPx;
        auto end = adjustBundle(scene, settings);
        if (end) end_ = std::move(*end);
        if (!end && end.error().code == Code::Cancelled) return end.error();
        return bool(end);
    }

    /** Puts the adjusted cameras into the scan and places all other frames. */
    Result<CameraRepair> take(Tracks tracks) {
        std::vector<Camerad> given, adjusted = tracks.scene.cameras;
        for (const size_t f : stills_) given.push_back(scan_.frames[f].camera);
        const auto align = alignCameras(adjusted, given);
        if (!align) return said("the adjusted cameras lie at one place, so they were not taken");
        for (size_t i = 0; i < stills_.size(); ++i) {
            adjusted[i] = moved(adjusted[i], *align);
            scan_.frames[stills_[i]].camera = tracks.scene.cameras[i] = pictures_[i].camera = adjusted[i];
        }
        for (Vec3d& point : tracks.scene.points) point = (*align)(point);
        out_.moved = stills_.size();
        const LensDistortion lens = tracks.scene.lens;
        for (size_t f = 0; f < scan_.frames.size(); ++f) {
            ScanFrame& frame = scan_.frames[f];
            DPL_RETURN_IF_ERROR(taskAt(0.6 + 0.4 * double(f) / double(scan_.frames.size()), "placing the other pictures"));
            if (!isStillTraining(frame)) {
                Camerad camera = frame.camera;
                camera.fx *= out_.focalFactor, camera.fy *= out_.focalFactor;
                DPL_TRY(const Features features, backgroundFeatures(frame));
                const auto placed = placePicture(features, camera, tracks, &camera);
                ++(placed ? out_.moved : out_.kept);
                frame.camera = placed ? placed->camera : camera;
            }
            frame.lens = lens;
        }
        out_.repaired = true;
        return said(formatText(
            "the cameras were repaired: matches of the still pictures missed by {} px and now miss by {} px; the focal length "
            "was multiplied by {}; {} frames were placed again, {} keep their place because their pictures have too few "
            "matches",
            rounded(out_.missBeforePx), rounded(out_.missAfterPx), std::round(1000 * out_.focalFactor) / 1000, out_.moved, out_.kept));
    }
};

}  // namespace

bool keypointsDoubtCameras(const Scan& scan) {
    std::vector<KeypointTrack> full(scan.keypointNames.size()), still(scan.keypointNames.size());
    std::vector<double> heights;
    for (const ScanFrame& frame : scan.frames) {
        if (!isStillTraining(frame)) continue;
        const auto keypoints = readKeypoints(scan, frame);
        if (!keypoints) continue;
        double low = INFINITY, high = -INFINITY;
        for (size_t k = 0; k < keypoints->size(); ++k) {
            const Keypoint& seen = (*keypoints)[k];
            if (seen.confidence > 0.3) low = std::min(low, seen.px.y), high = std::max(high, seen.px.y);
            if (seen.confidence < 0.5) continue;
            still[k].push_back({frame.camera, seen.px, seen.confidence});
            if (frame.kind == FrameKind::StaticFull) full[k].push_back(still[k].back());
        }
        if (high > low && frame.kind == FrameKind::StaticFull) heights.push_back(high - low);
    }
    const std::vector<double> misses = missesPx(full, 1);
    if (misses.size() < kFewestKeypoints || heights.empty()) return false;
    if (percentile(misses, 0.5) > priors::kCameraDoubt * percentile(heights, 0.5)) return true;
    const auto focal = estimateFocalFactor(still);  // close-ups tell it
    return focal && std::abs(std::log(focal->factor)) > std::log(1 + priors::kFocalWarn) &&
           focal->missAsGivenPx > priors::kFocalMissRatio * focal->missPx;
}

Result<CameraRepair> repairCameras(Scan& scan, Jobs& jobs) {
    return Repair(scan, jobs).run();
}

}  // namespace dpl
