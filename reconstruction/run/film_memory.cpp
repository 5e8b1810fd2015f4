// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/run/film_memory.h"

#include <numeric>

#include "reconstruction/training/correctives/motion_model.h"

namespace dpl {

std::vector<double> movingTimesS(const Scan& scan, std::span<const size_t> rows) {
    std::vector<double> timesS;
    for (const size_t row : rows)
        if (scan.frames[row].kind == FrameKind::Dynamic) timesS.push_back(scan.frames[row].timeS);
    return timesS;
}

void rememberPoses(const Scan& scan, std::span<const size_t> rows, const MotionModeData& motion, std::span<Pose> poses) {
    if (motion.empty()) return;
    std::vector<Pose> film;
    for (size_t i = 0; i < rows.size(); ++i)
        if (scan.frames[rows[i]].kind == FrameKind::Dynamic) film.push_back(poses[i]);
    rememberFilm(motion, movingTimesS(scan, rows), film);
    for (size_t i = 0, next = 0; i < rows.size(); ++i)
        poses[i].before = scan.frames[rows[i]].kind == FrameKind::Dynamic ? film[next++].before : MotionMemory();
}

void rememberFrames(const Scan& scan, const MotionModeData& motion, FrameSet& set) {
    std::vector<Pose> poses;
    for (const TrainFrame& frame : set.frames) poses.push_back(frame.pose);
    rememberPoses(scan, set.rows, motion, poses);
    for (size_t i = 0; i < poses.size(); ++i) set.frames[i].pose.before = poses[i].before;
}

void rememberPoses(const Scan& scan, const MotionModeData& motion, std::span<Pose> poses) {
    std::vector<size_t> rows(poses.size());
    std::iota(rows.begin(), rows.end(), size_t(0));
    rememberPoses(scan, rows, motion, poses);
}

void rememberPoses(const Scan& scan, const MotionModeData& motion, PosesFile& file) {
    std::vector<Pose> poses = file.poses();
    rememberPoses(scan, motion, poses);
    for (size_t f = 0; f < poses.size(); ++f) {
        file.frames[f].pose.before = poses[f].before;
        if (file.frames[f].fittedPose) file.frames[f].fittedPose->before = poses[f].before;
    }
}

std::vector<Pose> posesInLoop(const MotionModeData& motion, const MoveClip& move) {
    if (motion.empty()) return move.poses;
    std::vector<Pose> rounds = move.poses;
    rounds.insert(rounds.end(), move.poses.begin(), move.poses.end());
    std::vector<double> timesS;
    for (size_t i = 0; i < rounds.size(); ++i) timesS.push_back(move.seconds * double(i) / double(move.poses.size()));
    rememberFilm(motion, timesS, rounds);
    return {rounds.begin() + ptrdiff_t(move.poses.size()), rounds.end()};
}

}  // namespace dpl
