// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/input/cameras/solve_cameras.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <opencv2/imgproc.hpp>

#include "reconstruction/base/image_codec.h"
#include "reconstruction/input/cameras/colmap_run.h"
#include "reconstruction/input/cameras/picture_pairs.h"
#include "reconstruction/input/cameras/priors.h"
#include "reconstruction/input/cameras/still_model.h"
#include "sdk/core/files.h"
#include "sdk/core/percentile.h"
#include "sdk/core/task.h"

namespace dpl {
namespace {

namespace fs = std::filesystem;

constexpr double kMaskMargin = 0.008;  // the person's mask grows by this part of the diagonal: features at its outline move with the person
constexpr size_t kMostFeatures = 2000;
constexpr uint32_t kMaxSidePx = 1600;
constexpr double kEnoughPlaced = 0.6;              // share of the stills below which another focal length is tried
constexpr double kFocalTries[] = {1, 1.35, 0.75};  // times the guess: zoomed or cropped videos, wide lenses
constexpr double kFarthest =
    20;  // from the middle of the stills, in median distances of a still: a picture beyond was placed by wrong matches
constexpr double kReadShare = 0.15, kColmapShare = 0.6, kTrackShare = 0.05;  // of the time

class Solver {
public:
    Solver(std::span<const SolvePicture> pictures, const SolveSettings& settings) : pictures_(pictures), settings_(settings) {}

    Result<SolvedCameras> run() {
        for (size_t i = 0; i < pictures_.size(); ++i)
            (pictures_[i].role == SolveRole::Still ? stills_ : pictures_[i].role == SolveRole::Closeup ? closeups_ : late_).push_back(i);
        if (stills_.empty()) return fail(Code::InvalidArgument, "no picture of the subject standing still; film a walk round it first");
        out_.pictures.resize(pictures_.size());
        features_.resize(pictures_.size());
        DPL_RETURN_IF_ERROR(prepareFolder());
        DPL_RETURN_IF_ERROR(solveStills());
        if (placedStills() < 2) return std::move(out_);  // the verdict says so
        DPL_RETURN_IF_ERROR(findBackground());
        DPL_RETURN_IF_ERROR(placeLate());
        DPL_RETURN_IF_ERROR(placeCloseupsByThePerson());
        return std::move(out_);
    }

private:
    std::span<const SolvePicture> pictures_;
    const SolveSettings& settings_;
    std::vector<size_t> stills_, closeups_, late_;
    std::vector<Features> features_;  // of the background, per picture
    SolvedCameras out_;
    std::vector<StillPicture> model_;  // placed stills and close-ups
    Tracks tracks_;                    // of model_
    Camerad intrinsics_;

    std::string imageName(size_t i) const { return pictures_[i].name + pictures_[i].image.extension().string(); }

    size_t placedStills() const {
        return size_t(std::count_if(stills_.begin(), stills_.end(), [&](size_t i) { return out_.pictures[i].camera.has_value(); }));
    }

    /** 255 where the picture shows the background; empty when the person is not known. */
    std::vector<uint8_t> backgroundOf(const SolvePixels& pixels) const {
        if (pixels.person.empty()) return {};
        cv::Mat person(int(settings_.heightPx), int(settings_.widthPx), CV_8UC1);
        std::copy(pixels.person.begin(), pixels.person.end(), person.begin<uint8_t>());
        cv::threshold(person, person, 63, 255, cv::THRESH_BINARY);
        const int reach = 1 + int(kMaskMargin * std::hypot(settings_.widthPx, settings_.heightPx));
        cv::dilate(person, person, cv::getStructuringElement(cv::MORPH_ELLIPSE, {2 * reach + 1, 2 * reach + 1}));
        cv::bitwise_not(person, person);
        return {person.begin<uint8_t>(), person.end<uint8_t>()};
    }

    Result<SolvePixels> load(size_t i) const {
        DPL_TRY(SolvePixels pixels, settings_.load(i));
        const size_t count = size_t(settings_.widthPx) * settings_.heightPx;
        if (pixels.grey.size() != count || (!pixels.person.empty() && pixels.person.size() != count))
            return fail(Code::InvalidArgument, "picture '{}' is not {} x {} pixels; all pictures of a scan must have one size",
                        pictures_[i].name, settings_.widthPx, settings_.heightPx);
        return pixels;
    }

    GreyView view(const std::vector<uint8_t>& pixels) const { return {settings_.widthPx, settings_.heightPx, pixels}; }

    /** Links the stills and close-ups into folder/images and writes COLMAP's masks (0: no feature). Measures all pictures. */
    Status prepareFolder() {
        std::error_code error;
        const fs::path images = settings_.folder / "images", masks = settings_.folder / "masks";
        for (const fs::path& folder : {images, masks}) {
            fs::remove_all(folder, error);
            fs::create_directories(folder, error);
            if (error) return fail(Code::Io, "cannot create {}: {}", folder.string(), error.message());
        }
        for (size_t i = 0; i < pictures_.size(); ++i) {
            DPL_RETURN_IF_ERROR(
                taskAt(kReadShare * double(i) / double(pictures_.size()), formatText("reading picture {} of {}", i + 1, pictures_.size())));
            DPL_TRY(const SolvePixels pixels, load(i));
            const std::vector<uint8_t> background = backgroundOf(pixels);
            features_[i] = findFeatures(view(pixels.grey), view(background), kMostFeatures, kMaxSidePx);
            out_.pictures[i].features = features_[i].size();
            cv::Mat grey(int(settings_.heightPx), int(settings_.widthPx), CV_8UC1, const_cast<uint8_t*>(pixels.grey.data())), laplacian;
            cv::Laplacian(grey, laplacian, CV_64F);
            cv::Scalar mean, deviation;
            cv::meanStdDev(laplacian, mean, deviation);
            out_.pictures[i].sharpness = deviation[0] * deviation[0];
            if (pictures_[i].role == SolveRole::Moving || pictures_[i].role == SolveRole::HeldOut) continue;
            fs::create_symlink(fs::absolute(pictures_[i].image), images / imageName(i), error);
            if (error) return fail(Code::Io, "cannot create {}: {}", (images / imageName(i)).string(), error.message());
            if (background.empty()) continue;
            DPL_TRY(const auto png, encodePng(background, settings_.widthPx, settings_.heightPx, 1));
            DPL_RETURN_IF_ERROR(writeFileAtomically(masks / (imageName(i) + ".png"), png));
        }
        return {};
    }

    Status solveStills() {
        ColmapRun run{.folder = settings_.folder, .images = {}, .pairs = pairsToMatch(stills_.size(), closeups_.size())};
        std::map<std::string, size_t> indexOf;
        for (const auto* group : {&stills_, &closeups_})
            for (const size_t i : *group) run.images.push_back(imageName(i)), indexOf[imageName(i)] = i;
        run.widthPx = settings_.widthPx, run.heightPx = settings_.heightPx;
        const TaskPart part(kReadShare, kReadShare + kColmapShare);
        const double diagonal = std::hypot(settings_.widthPx, settings_.heightPx);
        const double guess = settings_.focalGuessPx > 0 ? settings_.focalGuessPx : priors::kPhoneFocal * diagonal;
        std::vector<ColmapImage> best;
        for (const double factor : kFocalTries) {
            run.focalPx = factor * guess;
            DPL_TRY(auto images, runColmap(run));
            if (images.size() > best.size()) best = std::move(images);
            if (double(best.size()) >= kEnoughPlaced * double(run.images.size())) break;
        }
        for (const ColmapImage& image : best) {
            const auto found = indexOf.find(image.name);
            if (found == indexOf.end()) return fail(Code::CorruptData, "COLMAP returned a picture '{}' that it did not get", image.name);
            out_.pictures[found->second].camera = image.camera;
            intrinsics_ = image.camera;
            out_.lens = image.lens;
        }
        dropFarPictures();
        return {};
    }

    /** Forgets cameras that stand where nobody films. */
    void dropFarPictures() {
        std::vector<double> along[3], distances;
        const auto eachStill = [&](const auto& take) {
            for (const size_t i : stills_)
                if (out_.pictures[i].camera) take(out_.pictures[i].camera->eye());
        };
        eachStill([&](const Vec3d& eye) {
            for (int k = 0; k < 3; ++k) along[k].push_back(eye[k]);
        });
        if (along[0].size() < 3) return;
        const Vec3d middle(percentile(along[0], 0.5), percentile(along[1], 0.5), percentile(along[2], 0.5));
        eachStill([&](const Vec3d& eye) { distances.push_back(glm::distance(eye, middle)); });
        const double most = kFarthest * percentile(distances, 0.5);
        for (SolveOutcome& picture : out_.pictures)
            if (picture.camera && !(glm::distance(picture.camera->eye(), middle) <= most)) picture.camera.reset();
    }

    /** Triangulates the background from placed stills and close-ups. */
    Status findBackground() {
        model_.clear();
        std::vector<size_t> ids;
        for (const auto* group : {&stills_, &closeups_})
            for (const size_t i : *group)
                if (out_.pictures[i].camera) model_.push_back({*out_.pictures[i].camera, features_[i]}), ids.push_back(i);
        const TaskPart part(kReadShare + kColmapShare, kReadShare + kColmapShare + kTrackShare);
        DPL_TRY(tracks_, findTracks(model_, out_.lens, {}));
        std::vector<double> misses;
        std::vector<std::vector<double>> ofPicture(model_.size());
        for (const BundleObservation& o : tracks_.scene.observations) {
            const double miss = glm::length(storedPixel(model_[o.camera].camera, out_.lens, tracks_.scene.points[o.point]) - o.px);
            misses.push_back(miss), ofPicture[o.camera].push_back(miss);
        }
        for (size_t m = 0; m < ids.size(); ++m) {
            out_.pictures[ids[m]].matches = ofPicture[m].size();
            out_.pictures[ids[m]].missPx = percentile(ofPicture[m], 0.5);
        }
        out_.missPx = percentile(misses, 0.5);
        out_.points = tracks_.scene.points;
        return {};
    }

    void place(size_t i, const Features& features, const Tracks& tracks, const Camerad* near) {
        const auto placed = placePicture(features, intrinsics_, tracks, near);
        if (!placed) return;
        out_.pictures[i].camera = placed->camera;
        out_.pictures[i].matches = placed->inliers;
        out_.pictures[i].missPx = placed->missPx;
    }

    Status placeLate() {
        std::optional<Camerad> before;  // of the moving picture before: the next is probably near. Never of a held-out one
        for (size_t k = 0; k < late_.size(); ++k) {
            DPL_RETURN_IF_ERROR(taskAt(1 - (1 - kReadShare - kColmapShare - kTrackShare) * double(late_.size() - k) / double(late_.size()),
                                       formatText("moving pictures, {} of {}", k + 1, late_.size())));
            place(late_[k], features_[late_[k]], tracks_, before ? &*before : nullptr);
            if (pictures_[late_[k]].role == SolveRole::Moving && out_.pictures[late_[k]].camera) before = out_.pictures[late_[k]].camera;
        }
        return {};
    }

    /** A close-up may show little but the person, who stands still; so the person's features may place it. */
    Status placeCloseupsByThePerson() {
        std::vector<size_t> open;
        for (const size_t i : closeups_)
            if (!out_.pictures[i].camera) open.push_back(i);
        if (open.empty()) return {};
        std::vector<StillPicture> whole;
        for (const auto* group : {&stills_, &closeups_})
            for (const size_t i : *group) {
                if (!out_.pictures[i].camera) continue;
                DPL_RETURN_IF_ERROR(taskAt(1));
                DPL_TRY(const SolvePixels pixels, load(i));
                whole.push_back({*out_.pictures[i].camera, findFeatures(view(pixels.grey), {}, kMostFeatures, kMaxSidePx)});
            }
        const TaskPart part(1, 1);
        DPL_TRY(const Tracks tracks, findTracks(whole, out_.lens, {}));
        for (const size_t i : open) {
            DPL_RETURN_IF_ERROR(taskAt(1));
            DPL_TRY(const SolvePixels pixels, load(i));
            place(i, findFeatures(view(pixels.grey), {}, kMostFeatures, kMaxSidePx), tracks, nullptr);
            out_.pictures[i].unmasked = out_.pictures[i].camera.has_value();
        }
        return {};
    }
};

}  // namespace

Result<SolvedCameras> solveCameras(std::span<const SolvePicture> pictures, const SolveSettings& settings) {
    return Solver(pictures, settings).run();
}

}  // namespace dpl
