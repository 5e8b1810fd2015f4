// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/input/import/frame_motion.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>
#include <opencv2/video/tracking.hpp>

namespace dpl {
namespace {

constexpr int kMaxTracks = 300;
constexpr double kTrackErrorPx = 0.5;  // forward and backward tracking must agree to this
constexpr size_t kStepFrames = 3;      // motion is measured over this many: it grows with them, the error of tracks does not
constexpr double kFewFollowed = 0.4;   // of the features: with fewer, frames lie too far apart
constexpr double kFarApart = 0.007;    // so do frames with more camera motion: a slow walk has a third of it
constexpr double kFitPx = 1.0;         // tracks this near to a homography or to their epipolar lines agree with it
constexpr double kMoverPx = 2.0;       // tracks farther off move by themselves
// So many tracks on one homography that moves by less than this part of the diagonal: the camera rests, and epipolar lines mean nothing.
constexpr double kRestShare = 0.75, kRestMotion = 0.003;
constexpr size_t kFewestTracks = 16;                          // the epipolar fit needs 8
constexpr size_t kBackFrames = 42;                            // 3.5 s: a slow walk turns the room by 20 degrees meanwhile
constexpr size_t kBackEvery = 4;                              // frames
constexpr double kStayShare = 0.15;                           // of the diagonal: features of a resting camera stay within this
constexpr double kStayFit = 0.01;                             // of the diagonal: sway of a hand bends the picture by less
constexpr double kRests = 0.5;                                // share of features that stay
constexpr double kTripod = 0.0001;                            // camera motion a frame; a hand sways by five times as much
constexpr double kMovingPose = 0.00033;                       // pose change a frame that counts as moving in full, shares of the diagonal
constexpr double kMovingWhole = 0.5;                          // liveliness of a video that moves as a whole
constexpr double kClearRatio = 1.7, kClearDifference = 0.25;  // of liveliness between the moving and the still part
constexpr double kShortestPartS = 2;
constexpr double kOffCentrePenalty = 0.3;

struct Tracks {
    std::vector<cv::Point2f> from, to;
    size_t tried = 0;  // features that were looked for
};

/** Follows corners of the first picture through the others, picture by picture, so that fast limbs are not lost. */
Tracks track(std::span<const cv::Mat> pictures) {
    std::vector<cv::Point2f> from, at, next, back;
    cv::goodFeaturesToTrack(pictures.front(), from, kMaxTracks, 0.01, 5);
    Tracks tracks;
    tracks.tried = from.size();
    at = from;
    std::vector<uint8_t> found, foundBack;
    std::vector<float> error;
    for (size_t p = 1; p < pictures.size() && !from.empty(); ++p) {
        cv::calcOpticalFlowPyrLK(pictures[p - 1], pictures[p], at, next, found, error);
        cv::calcOpticalFlowPyrLK(pictures[p], pictures[p - 1], next, back, foundBack, error);
        size_t kept = 0;
        for (size_t i = 0; i < from.size(); ++i)
            if (found[i] && foundBack[i] && cv::norm(back[i] - at[i]) < kTrackErrorPx) from[kept] = from[i], next[kept++] = next[i];
        from.resize(kept), next.resize(kept);
        at.swap(next);
    }
    tracks.from = std::move(from), tracks.to = std::move(at);
    return tracks;
}

double medianOf(std::vector<double> values) {
    const auto middle = values.begin() + ptrdiff_t(values.size() / 2);
    std::nth_element(values.begin(), middle, values.end());
    return *middle;
}

/** Pixels by which each track differs from the motion of a static scene. */
std::vector<double> unexplained(const Tracks& tracks, double medianPx, double diagonal) {
    cv::setRNGSeed(1);  // RANSAC of the same frames gives the same answer
    std::vector<uint8_t> onPlane;
    const cv::Mat flat = cv::findHomography(tracks.from, tracks.to, cv::RANSAC, kFitPx, onPlane);
    const bool rests =
        flat.rows == 3 && medianPx < kRestMotion * diagonal && double(cv::countNonZero(onPlane)) >= kRestShare * double(tracks.from.size());
    cv::Mat f;
    if (!rests) {
        cv::setRNGSeed(1);
        f = cv::findFundamentalMat(tracks.from, tracks.to, cv::FM_RANSAC, kFitPx, 0.999);
    }
    std::vector<double> residual(tracks.from.size(), 0);
    for (size_t i = 0; i < residual.size(); ++i) {
        const cv::Vec3d a(tracks.from[i].x, tracks.from[i].y, 1), b(tracks.to[i].x, tracks.to[i].y, 1);
        if (f.rows == 3 && f.cols == 3) {
            const cv::Vec3d line = cv::Matx33d(f) * a;
            residual[i] = std::abs(line.dot(b)) / std::max(std::hypot(line[0], line[1]), 1e-12);
        } else if (flat.rows == 3) {
            const cv::Vec3d p = cv::Matx33d(flat) * a;
            if (std::abs(p[2]) > 1e-12) residual[i] = std::hypot(p[0] / p[2] - b[0], p[1] / p[2] - b[1]);
        }
    }
    return residual;
}

/** Share of a frame's features that are found near their place in another frame, moved by one homography. */
double stayedShare(const cv::Mat& before, const cv::Mat& now) {
    const double diagonal = std::hypot(double(now.cols), double(now.rows));
    const cv::Mat both[] = {before, now};
    const Tracks tracks = track(both);
    if (tracks.from.size() < kFewestTracks) return 0;
    cv::setRNGSeed(1);
    std::vector<uint8_t> agrees;
    if (cv::findHomography(tracks.from, tracks.to, cv::RANSAC, kStayFit * diagonal, agrees).rows != 3) return 0;
    size_t stay = 0;
    for (size_t i = 0; i < tracks.from.size(); ++i) stay += agrees[i] && cv::norm(tracks.to[i] - tracks.from[i]) < kStayShare * diagonal;
    return double(stay) / double(tracks.tried);
}

/** The mean of the known ones takes the place of values that are not known. */
void fillUnknown(std::vector<double>& values) {
    double sum = 0, known = 0;
    for (double value : values)
        if (value >= 0) sum += value, ++known;
    for (double& value : values)
        if (value < 0) value = known > 0 ? sum / known : 0;
}

/** How much each frame looks like one of a moving part: 1 for a fast change of pose, 1 for a resting camera. */
std::vector<double> liveliness(std::span<const FrameMotion> frames) {
    std::vector<double> pose, rest;
    for (size_t i = 0; i < frames.size(); ++i) {
        pose.push_back(frames[i].followed ? std::min(1.0, frames[i].poseChange / kMovingPose) : -1);
        // What a frame shares with one long before says most about the moment between them.
        const size_t later = i + kBackFrames / 2;
        const double stayed = later < frames.size() ? frames[later].stayed : -1;
        rest.push_back(stayed < 0 ? -1 : stayed >= kRests ? 1 : 0);
    }
    fillUnknown(pose), fillUnknown(rest);
    for (size_t i = 0; i < frames.size(); ++i) pose[i] += rest[i];
    return pose;
}

std::vector<double> prefixSums(const std::vector<double>& values) {
    std::vector<double> prefix(values.size() + 1, 0);
    for (size_t i = 0; i < values.size(); ++i) prefix[i + 1] = prefix[i] + values[i];
    return prefix;
}

}  // namespace

FrameMotion MotionMeter::add(std::span<const uint8_t> grey, double timeS) {
    FrameMotion motion;
    motion.timeS = timeS;
    const cv::Mat now(int(heightPx_), int(widthPx_), CV_8U, const_cast<uint8_t*>(grey.data()));
    cv::Mat laplacian;
    cv::Laplacian(now, laplacian, CV_16S);
    cv::Scalar mean, deviation;
    cv::meanStdDev(laplacian, mean, deviation);
    motion.sharpness = deviation[0] * deviation[0];
    const auto back = [&](size_t frames) { return cv::Mat(int(heightPx_), int(widthPx_), CV_8U, before_[before_.size() - frames].data()); };
    if (!before_.empty()) {
        size_t step = std::min(kStepFrames, before_.size());
        std::vector<cv::Mat> pictures;
        for (size_t k = step; k > 0; --k) pictures.push_back(back(k));
        pictures.push_back(now);
        Tracks tracks = track(pictures);
        motion.followed = double(tracks.from.size()) >= kFewFollowed * double(tracks.tried) && tracks.from.size() >= kFewestTracks;
        if (!motion.followed && step > 1) {
            step = 1;
            tracks = track(std::span(pictures).last(2));
        }
        if (tracks.from.size() >= kFewestTracks) {
            const double diagonal = std::hypot(double(widthPx_), double(heightPx_)), unit = diagonal * double(step);
            std::vector<double> length;
            for (size_t i = 0; i < tracks.from.size(); ++i) length.push_back(cv::norm(tracks.to[i] - tracks.from[i]));
            const double medianPx = medianOf(length);
            double sum = 0;
            for (double residual : unexplained(tracks, medianPx, diagonal))
                if (residual > kMoverPx) sum += std::min(residual, 0.1 * diagonal);
            motion.cameraMotion = medianPx / unit;
            motion.followed = motion.followed && motion.cameraMotion < kFarApart;
            motion.poseChange = sum / double(tracks.from.size()) / unit;
        }
        if (before_.size() == kBackFrames && count_ % kBackEvery == 0) stayed_ = stayedShare(back(kBackFrames), now);
    }
    motion.stayed = stayed_;
    ++count_;
    before_.emplace_back(grey.begin(), grey.end());
    if (before_.size() > kBackFrames) before_.pop_front();
    return motion;
}

StillAndMoving splitByMotion(std::span<const FrameMotion> frames) {
    const size_t count = frames.size();
    const FrameSpan all{0, count};
    const auto share = [&](auto test) {
        return double(std::count_if(frames.begin(), frames.end(), test)) / double(std::max<size_t>(1, count));
    };
    if (share([](const FrameMotion& f) { return f.followed; }) < 0.5) return {all, {}, false, false};
    const bool stays = share([](const FrameMotion& f) { return f.stayed >= kRests; }) > 0 &&
                       share([](const FrameMotion& f) { return f.stayed >= 0 && f.stayed < kRests; }) == 0;
    if (stays || share([](const FrameMotion& f) { return f.cameraMotion < kTripod; }) > 0.8) return {{}, all, true};
    const std::vector<double> prefix = prefixSums(liveliness(frames));
    const auto meanOf = [&](size_t begin, size_t end) { return (prefix[end] - prefix[begin]) / double(std::max<size_t>(end - begin, 1)); };
    // The split that explains most variance: it maximises n1 n2 (mean1 − mean2)².
    size_t best = 0;
    double most = 0;
    for (size_t i = 1; i + 1 < count; ++i) {
        if (frames[i].timeS - frames[0].timeS < kShortestPartS || frames[count - 1].timeS - frames[i].timeS < kShortestPartS) continue;
        const double difference = meanOf(0, i) - meanOf(i, count);
        const double gain = double(i) * double(count - i) * difference * difference;
        if (gain > most) most = gain, best = i;
    }
    const auto isClear = [](double moving, double still) { return moving > kClearRatio * still && moving - still > kClearDifference; };
    if (best > 0) {
        const double first = meanOf(0, best), second = meanOf(best, count);
        if (isClear(second, first)) return {{0, best}, {best, count}};
        if (isClear(first, second)) return {{best, count}, {0, best}};
    }
    return meanOf(0, count) > kMovingWhole ? StillAndMoving{{}, all} : StillAndMoving{all, {}};
}

std::vector<size_t> chooseFrames(std::span<const FrameMotion> frames, FrameSpan span, size_t count, bool withPose) {
    const size_t have = span.end - span.begin;
    std::vector<size_t> chosen;
    if (have <= count) {
        chosen.resize(have);
        std::iota(chosen.begin(), chosen.end(), span.begin);
        return chosen;
    }
    // A small part of the path is time itself, so that a resting camera still gives a frame now and then.
    const auto step = [&](size_t i) { return frames[i].cameraMotion + (withPose ? 4 * frames[i].poseChange : 0.0); };
    double moved = 0;
    for (size_t i = span.begin + 1; i < span.end; ++i) moved += step(i);
    const double rest = moved > 0 ? 0.1 * moved / double(have - 1) : 1;
    const double total = moved + rest * double(have - 1);
    std::vector<double> bestScore(count, -1);
    std::vector<size_t> best(count, 0);
    double at = 0;
    for (size_t i = span.begin; i < span.end; ++i) {
        if (i > span.begin) at += step(i) + rest;
        const double place = at / total * double(count);
        const size_t slot = std::min(count - 1, size_t(place));
        const double offCentre = std::min(1.0, 2 * std::abs(place - double(slot) - 0.5));
        const double score = frames[i].sharpness * (1 - kOffCentrePenalty * offCentre);
        if (score > bestScore[slot]) bestScore[slot] = score, best[slot] = i;
    }
    for (size_t slot = 0; slot < count; ++slot)
        if (bestScore[slot] >= 0) chosen.push_back(best[slot]);
    return chosen;
}

}  // namespace dpl
