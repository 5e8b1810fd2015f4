// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/input/cameras/camera_verdict.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "sdk/core/percentile.h"

namespace dpl {
namespace {

constexpr size_t kFewFeatures = 150;    // on the background of a picture; scans that worked have several hundred
constexpr double kBlurredShare = 0.35;  // of the median sharpness of the placed stills

/** The side of the subject that a camera at `eye` films. */
const char* sideName(const Vec3d& eye, const Vec3d& centre, const Vec3d& up, const Vec3d& front) {
    const Vec3d d = eye - centre, left = glm::cross(up, front);
    const double angle = std::atan2(glm::dot(d, left), glm::dot(d, front)) * 4 / std::numbers::pi;  // in eighths of a turn
    return std::abs(angle) <= 1 ? "front" : std::abs(angle) >= 3 ? "back" : angle > 0 ? "left side" : "right side";
}

class Judge {
public:
    Judge(std::span<const SolvePicture> pictures, const SolvedCameras& solved, const Vec3d& up, const Vec3d& front)
        : pictures_(pictures), solved_(solved), up_(up), front_(front) {
        for (size_t i = 0; i < pictures.size(); ++i)
            if (solved.pictures[i].camera && pictures[i].role == SolveRole::Still) {
                sharpness_.push_back(solved.pictures[i].sharpness);
                centre_ += solved.pictures[i].camera->eye();
            }
        if (!sharpness_.empty()) centre_ /= double(sharpness_.size());  // of the walk: the subject stands in its middle
    }

    CameraVerdict run() {
        CameraVerdict verdict;
        const size_t stills = count(SolveRole::Still, false), placed = count(SolveRole::Still, true);
        verdict.refuses = placed < kFewestPlacedStills || placed * 2 < stills;
        verdict.sentences.push_back(
            formatText("cameras found for {} of {} still pictures, {} of {} close-ups, {} of {} moving and {} of {} held-out pictures{}",
                       placed, stills, count(SolveRole::Closeup, true), count(SolveRole::Closeup, false), count(SolveRole::Moving, true),
                       count(SolveRole::Moving, false), count(SolveRole::HeldOut, true), count(SolveRole::HeldOut, false), fit()));
        sayTexture(verdict);
        for (const SolveRole role : {SolveRole::Still, SolveRole::Closeup, SolveRole::Moving, SolveRole::HeldOut}) sayGaps(verdict, role);
        for (const CameraGap& gap : verdict.gaps) verdict.sentences.push_back(gap.sentence);
        return verdict;
    }

private:
    std::span<const SolvePicture> pictures_;
    const SolvedCameras& solved_;
    Vec3d up_, front_, centre_{0};
    std::vector<double> sharpness_;  // of placed stills

    size_t count(SolveRole role, bool placedOnly) const {
        size_t n = 0;
        for (size_t i = 0; i < pictures_.size(); ++i)
            n += pictures_[i].role == role && (!placedOnly || solved_.pictures[i].camera.has_value());
        return n;
    }

    /** What all found cameras share, in brackets; empty if none was found. */
    std::string fit() const {
        for (const SolveOutcome& picture : solved_.pictures)
            if (picture.camera)
                return formatText(" (focal length {} px, matches miss by {} px)", std::round(picture.camera->fx * 10) / 10,
                                  std::round(solved_.missPx * 100) / 100);
        return {};
    }

    void sayTexture(CameraVerdict& verdict) const {
        std::vector<size_t> features;
        for (size_t i = 0; i < pictures_.size(); ++i)
            if (pictures_[i].role == SolveRole::Still) features.push_back(solved_.pictures[i].features);
        if (percentile(features, 0.5) < kFewFeatures)
            verdict.gaps.push_back(
                {"the background",
                 formatText("the background has too little texture (half of the still pictures show fewer than {} features of it): film "
                            "where there are posters, shelves or a patterned floor, or lay newspapers round the subject",
                            percentile(features, 0.5) + 1),
                 {}});
    }

    /** Whether the pictures of a run are mostly blurred. */
    bool blurred(const std::vector<size_t>& run) const {
        const double limit = kBlurredShare * percentile(sharpness_, 0.5);
        return size_t(std::count_if(run.begin(), run.end(), [&](size_t i) { return solved_.pictures[i].sharpness < limit; })) * 2 >
               run.size();
    }

    /** Where the walk was: between the neighbours of the run that have cameras. */
    std::string sideOf(const std::vector<size_t>& run, const std::vector<size_t>& all) const {
        if (!(glm::length(front_) > 0)) return "that part";
        Vec3d eyes(0);
        size_t known = 0;
        const auto at = std::find(all.begin(), all.end(), run.front());
        for (auto before = at; before != all.begin();)
            if (const auto& camera = solved_.pictures[*--before].camera) {
                eyes += camera->eye(), ++known;
                break;
            }
        for (auto after = at + std::ptrdiff_t(run.size()); after != all.end(); ++after)
            if (const auto& camera = solved_.pictures[*after].camera) {
                eyes += camera->eye(), ++known;
                break;
            }
        return known == 0 ? "that part" : formatText("the {}", sideName(eyes / double(known), centre_, up_, front_));
    }

    void sayGaps(CameraVerdict& verdict, SolveRole role) const {
        std::vector<size_t> all;
        for (size_t i = 0; i < pictures_.size(); ++i)
            if (pictures_[i].role == role) all.push_back(i);
        std::vector<size_t> run;
        for (size_t k = 0; k <= all.size(); ++k) {
            if (k < all.size() && !solved_.pictures[all[k]].camera) {
                run.push_back(all[k]);
                continue;
            }
            if (run.empty()) continue;
            const std::string which = run.size() == 1 ? formatText("picture {}", pictures_[run[0]].name)
                                                      : formatText("{} pictures from {} to {}", run.size(), pictures_[run.front()].name,
                                                                   pictures_[run.back()].name);
            const std::string side = sideOf(run, all);
            const std::string why = blurred(run) ? formatText("too blurred; film {} again, slower and with more light", side)
                                    : role == SolveRole::Closeup
                                        ? std::string("too few matches with the walk; film the close-up again with some background in view")
                                        : formatText("too few matches with their neighbours; film {} again, slower", side);
            CameraGap gap{role == SolveRole::Closeup ? "the close-ups" : side,
                          formatText("{} {} left out: {}", which, run.size() == 1 ? "is" : "are", why),
                          {}};
            for (size_t i : run) gap.frames.push_back(pictures_[i].name);
            verdict.gaps.push_back(std::move(gap));
            run.clear();
        }
    }
};

}  // namespace

CameraVerdict judgeCameras(std::span<const SolvePicture> pictures, const SolvedCameras& solved, const Vec3d& up, const Vec3d& front) {
    return Judge(pictures, solved, up, front).run();
}

}  // namespace dpl
