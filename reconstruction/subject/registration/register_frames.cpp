// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/subject/registration/register_frames.h"

#include <ceres/problem.h>

#include <algorithm>
#include <cmath>

#include "reconstruction/subject/registration/limb_search.h"
#include "sdk/core/task.h"

namespace dpl {
namespace {

constexpr uint32_t kPictureSidePx = 640;  // larger pictures are reduced: poses need no finer ones

/** A picture of the camera's size, reduced to kPictureSidePx. */
Result<std::shared_ptr<const FramePicture>> smallPicture(const LazyPicture& lazy, const Camerad& camera) {
    DPL_TRY(auto picture, lazy.get());
    if (picture->image.widthPx != camera.widthPx || picture->image.heightPx != camera.heightPx)
        return fail(Code::InvalidArgument, "a picture has not the size of its camera");
    if (std::max(camera.widthPx, camera.heightPx) <= kPictureSidePx) return picture;
    return std::make_shared<const FramePicture>(reducedPicture(*picture, kPictureSidePx));
}

/** The frames at the size at which they are registered, at most kPictureSidePx. Their pictures lie in memory, so get() has no error. */
class ReducedFrames {
public:
    Result<RegisterInput> reduce(RegisterInput input, Jobs& jobs) {
        std::vector<Status> read(input.frames.size());
        keypoints_.resize(input.frames.size());
        jobs.forBlocks(input.frames.size(), [&](size_t f, uint32_t) {
            RegisterFrame& frame = input.frames[f];
            if (frame.picture) {
                auto small = smallPicture(frame.picture, frame.camera);
                if (small)
                    frame.picture = LazyPicture(std::move(*small));
                else
                    read[f] = small.error();
            }
            const uint32_t side = std::max(frame.camera.widthPx, frame.camera.heightPx);
            if (side <= kPictureSidePx) return;
            const Camerad whole = frame.camera;
            frame.camera = whole.scaled(double(kPictureSidePx) / side);
            for (Keypoint k : frame.keypoints) {
                k.px *= Vec2d(frame.camera.fx / whole.fx, frame.camera.fy / whole.fy);
                keypoints_[f].push_back(k);
            }
            frame.keypoints = keypoints_[f];
        });
        for (const Status& status : read) DPL_RETURN_IF_ERROR(status);
        return input;
    }

private:
    std::vector<std::vector<Keypoint>> keypoints_;
};

Status checkInput(const RegisterInput& input) {
    const size_t triangles = input.surface->triangles.size();
    if (!input.triangleLabel.empty() && input.triangleLabel.size() != triangles)
        return fail(Code::InvalidArgument, "{} triangle labels for {} triangles", input.triangleLabel.size(), triangles);
    if (input.rigidTriangle.size() != triangles)
        return fail(Code::InvalidArgument, "{} marks of rigid triangles for {} triangles", input.rigidTriangle.size(), triangles);
    if (input.triangleLabel.empty() && !input.outlineLabels.empty())
        return fail(Code::InvalidArgument, "outlines of labels need triangle labels");
    for (const RegisterFrame& frame : input.frames) {
        if (frame.split != Split::Train && frame.picture)
            return fail(Code::InvalidArgument, "a validation or held-out frame must not bring its picture");
        if (!frame.keypoints.empty() && frame.keypoints.size() != input.keypointNames.size())
            return fail(Code::InvalidArgument, "a frame with {} keypoints, the scan names {}", frame.keypoints.size(),
                        input.keypointNames.size());
        DPL_RETURN_IF_ERROR(checkPose(input.body->joints, frame.pose));
    }
    return {};
}

}  // namespace

Result<Registration> registerFrames(const RegisterInput& given, const RegisterSettings& settings, Jobs& jobs) {
    DPL_RETURN_IF_ERROR(checkInput(given));
    ReducedFrames reduced;
    DPL_TRY(const RegisterInput input, reduced.reduce(given, jobs));
    FramePoses poses(input);
    Registration result;
    result.precisions.resize(input.frames.size());
    /** Of the frames of a split, after their last solve. */
    const auto keepPrecisions = [&](ceres::Problem& problem, Split split) {
        for (size_t f = 0; f < input.frames.size(); ++f) {
            if (input.frames[f].split != split) continue;
            result.precisions[f] = poses.precision(problem, f);
            for (double& value : result.precisions[f].matrix) value /= input.pictureWeight;
        }
    };
    PictureRounds pictures(input, settings, jobs);
    const std::vector<size_t>& shown = pictures.shown();
    const size_t rounds = shown.empty() ? 1 : settings.blursPx.size() * size_t(settings.roundsPerBlur);
    // At a fine blur a picture tells a limb's depth; the last level then settles what was found.
    const size_t searchLevel = std::max<size_t>(2, settings.blursPx.size()) - 2;
    const double searchRounds = input.searchLimbs ? double(rounds) : 0;  // the search takes about as long as all rounds
    const auto search = [&](Split split, double from, double to) -> Status {
        if (!input.searchLimbs) return {};
        const TaskPart part(from, to);
        DPL_TRY(const std::vector<SolveEnd> changed, searchLimbs(poses, split, pictures));
        result.solves.insert(result.solves.end(), changed.begin(), changed.end());
        return {};
    };
    size_t done = 0;
    double searched = 0;  // rounds
    /** Progress after this many rounds and the search so far. */
    const auto fraction = [&](double roundsDone) { return 0.9 * (roundsDone + searched) / (double(rounds) + searchRounds); };
    for (size_t level = 0; level < settings.blursPx.size() && !shown.empty(); ++level) {
        const double blurPx = settings.blursPx[level];
        for (int round = 0; round < settings.roundsPerBlur; ++round) {
            DPL_RETURN_IF_ERROR(taskAt(fraction(double(done++)), formatText("pictures at a blur of {} px", blurPx)));
            pictures.start(poses, blurPx);
            ceres::Problem problem;
            poses.addTerms(problem, Split::Train);
            pictures.addTerms(problem, poses, shown);
            DPL_TRY(SolveEnd end, poses.solve(problem, formatText("pictures, blur {} px", blurPx), settings.stepsPerRound));
            result.solves.push_back(std::move(end));
            if (done == rounds) keepPrecisions(problem, Split::Train);
        }
        if (level != searchLevel) continue;
        DPL_RETURN_IF_ERROR(search(Split::Train, fraction(double(done)), fraction(double(done) + searchRounds)));
        searched = searchRounds;
    }
    if (shown.empty()) {
        ceres::Problem problem;
        poses.addTerms(problem, Split::Train);
        DPL_TRY(SolveEnd end, poses.solve(problem, "moving frames: keypoints", 30));
        result.solves.push_back(std::move(end));
        keepPrecisions(problem, Split::Train);
    }
    DPL_RETURN_IF_ERROR(taskAt(0.9, "held-out frames"));
    for (const Split split : {Split::Validation, Split::Test}) {
        ceres::Problem problem;
        if (poses.hasMoving(split)) {
            poses.addTerms(problem, split);
            const char* what = split == Split::Test ? "held-out moving frames" : "validation moving frames";
            DPL_TRY(SolveEnd end, poses.solve(problem, what, 30));
            result.solves.push_back(std::move(end));
            DPL_RETURN_IF_ERROR(search(split, split == Split::Test ? 0.95 : 0.9, split == Split::Test ? 1.0 : 0.95));
        }
        keepPrecisions(problem, split);
    }
    for (size_t f = 0; f < input.frames.size(); ++f)
        result.poses.push_back(input.frames[f].kind == FrameKind::Dynamic || input.frames[f].picture ? poses.pose(f)
                                                                                                     : input.frames[f].pose);
    return result;
}

}  // namespace dpl
