// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/subject/registration/limb_search.h"

#include <ceres/problem.h>

#include <algorithm>
#include <utility>

#include "sdk/core/task.h"

namespace dpl {
namespace {

constexpr size_t kCandidates = 4;
constexpr size_t kNeighbours = 4;       // frames before and after a run that are solved with it
constexpr int kRounds = 3, kSteps = 8;  // of solving a trial; a round looks anew at what pictures show

/** Keypoints, priors and motion of the split, and the pictures of `frames`; σ². */
double costOf(FramePoses& poses, Split split, PictureRounds& pictures, std::span<const size_t> frames) {
    ceres::Problem problem;
    poses.addTerms(problem, split);
    double half = 0;
    problem.Evaluate({}, &half, nullptr, nullptr, nullptr);
    return 2 * half + pictures.misfit(poses, frames);
}

/** The run and its neighbours in time. */
std::span<const size_t> windowOf(std::span<const size_t> inTime, const std::vector<size_t>& run) {
    const auto at = [&](size_t frame) { return size_t(std::find(inTime.begin(), inTime.end(), frame) - inTime.begin()); };
    const size_t runStart = at(run.front()), first = runStart - std::min(runStart, kNeighbours),
                 end = std::min(inTime.size(), at(run.back()) + kNeighbours + 1);
    return inTime.subspan(first, end - first);
}

Result<SolveEnd> solveWindow(FramePoses& poses, Split split, PictureRounds& pictures, std::span<const size_t> window,
                             const std::function<Status()>& goOn) {
    SolveEnd end;
    for (int round = 0; round < kRounds; ++round) {
        DPL_RETURN_IF_ERROR(goOn());
        pictures.look(poses, window);
        ceres::Problem problem;
        poses.addTerms(problem, split);
        pictures.addTerms(problem, poses, window);
        poses.holdAllBut(problem, window);
        DPL_TRY(end, poses.solve(problem, "limbs at another depth", kSteps));
    }
    return end;
}

}  // namespace

Result<std::vector<SolveEnd>> searchLimbs(FramePoses& poses, Split split, PictureRounds& pictures) {
    std::vector<SolveEnd> solves;
    const std::vector<size_t> inTime = poses.movingInTime(split);
    for (size_t limb = 0; limb < kLimbCount; ++limb) {
        const std::vector<std::vector<size_t>> runs = poses.doubtedRuns(limb, split);
        for (size_t r = 0; r < runs.size(); ++r) {
            const auto goOn = [&] {
                return taskAt((double(limb) + double(r) / double(runs.size())) / kLimbCount, "limbs at other depths");
            };
            const std::span<const size_t> window = windowOf(inTime, runs[r]);
            const std::vector<double> start = poses.parameters();
            std::vector<double> best = start;
            double least = costOf(poses, split, pictures, window);
            std::optional<SolveEnd> kept;
            for (size_t candidate = 0; candidate < kCandidates; ++candidate) {
                poses.setParameters(start);
                poses.bendLimb(limb, runs[r], candidate);
                DPL_TRY(SolveEnd end, solveWindow(poses, split, pictures, window, goOn));
                const double cost = costOf(poses, split, pictures, window);
                if (cost < least) least = cost, best = poses.parameters(), kept = std::move(end);
            }
            poses.setParameters(best);
            if (kept) solves.push_back(std::move(*kept));
        }
    }
    return solves;
}

}  // namespace dpl
