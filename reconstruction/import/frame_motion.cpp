// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/import/frame_motion.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>
#include <opencv2/video/tracking.hpp>

namespace dpl {
namespace {

constexpr int kMaxTracks = 300;
constexpr double kTrackErrorPx = 0.5;   // forward and backward tracking must agree to this
constexpr double kEpipolarPx = 1.0;     // a static point lies this near to its epipolar line
constexpr double kRestPx = 0.7;         // below this median motion the camera rests, and epipolar lines mean nothing
constexpr size_t kFewestTracks = 16;    // the epipolar fit needs 8
constexpr double kMovingPose = 0.0003;  // mean pose change a frame, shares of the diagonal: between swaying and gestures
constexpr double kClearChange = 2.5;    // ratio of pose change between the moving and the still part
constexpr double kShortestPartS = 2;
constexpr double kOffCentrePenalty = 0.3;

struct Tracks {
    std::vector<cv::Point2f> from, to;
};

Tracks track(const cv::Mat& before, const cv::Mat& now) {
    std::vector<cv::Point2f> from, to, back;
    cv::goodFeaturesToTrack(before, from, kMaxTracks, 0.01, 5);
    if (from.empty()) return {};
    std::vector<uint8_t> found, foundBack;
    std::vector<float> error;
    cv::calcOpticalFlowPyrLK(before, now, from, to, found, error);
    cv::calcOpticalFlowPyrLK(now, before, to, back, foundBack, error);
    Tracks tracks;
    for (size_t i = 0; i < from.size(); ++i)
        if (found[i] && foundBack[i] && cv::norm(back[i] - from[i]) < kTrackErrorPx) {
            tracks.from.push_back(from[i]);
            tracks.to.push_back(to[i]);
        }
    return tracks;
}

double medianOf(std::vector<double> values) {
    const auto middle = values.begin() + ptrdiff_t(values.size() / 2);
    std::nth_element(values.begin(), middle, values.end());
    return *middle;
}

/** Pixels by which each track differs from the motion of a static scene. */
std::vector<double> unexplained(const Tracks& tracks, double medianPx, cv::Point2f median) {
    std::vector<double> residual(tracks.from.size());
    cv::Mat f;
    if (medianPx >= kRestPx) {
        cv::setRNGSeed(1);  // RANSAC of the same frames gives the same answer
        f = cv::findFundamentalMat(tracks.from, tracks.to, cv::FM_RANSAC, kEpipolarPx, 0.99);
    }
    for (size_t i = 0; i < residual.size(); ++i) {
        const cv::Point2f a = tracks.from[i], b = tracks.to[i];
        if (f.rows != 3 || f.cols != 3) {
            residual[i] = cv::norm(b - a - median);
            continue;
        }
        const cv::Vec3d line = cv::Matx33d(f) * cv::Vec3d(a.x, a.y, 1);
        residual[i] = std::abs(line.dot(cv::Vec3d(b.x, b.y, 1))) / std::max(std::hypot(line[0], line[1]), 1e-12);
    }
    return residual;
}

/** Mean pose change before each index: prefix[i] is the sum over frames [0, i). */
std::vector<double> prefixOfPose(std::span<const FrameMotion> frames) {
    std::vector<double> prefix(frames.size() + 1, 0);
    for (size_t i = 0; i < frames.size(); ++i) prefix[i + 1] = prefix[i] + frames[i].poseChange;
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
    if (!previous_.empty()) {
        const cv::Mat before(int(heightPx_), int(widthPx_), CV_8U, previous_.data());
        const Tracks tracks = track(before, now);
        if (tracks.from.size() >= kFewestTracks) {
            const double diagonal = std::hypot(double(widthPx_), double(heightPx_));
            std::vector<double> dx, dy, length;
            for (size_t i = 0; i < tracks.from.size(); ++i) {
                const cv::Point2f d = tracks.to[i] - tracks.from[i];
                dx.push_back(d.x), dy.push_back(d.y), length.push_back(cv::norm(d));
            }
            const double medianPx = medianOf(length);
            const cv::Point2f median(float(medianOf(dx)), float(medianOf(dy)));
            double sum = 0;
            for (double residual : unexplained(tracks, medianPx, median))
                if (residual > kEpipolarPx) sum += std::min(residual, 0.1 * diagonal);
            motion.cameraMotion = medianPx / diagonal;
            motion.poseChange = sum / double(tracks.from.size()) / diagonal;
        }
    }
    previous_.assign(grey.begin(), grey.end());
    return motion;
}

StillAndMoving splitByMotion(std::span<const FrameMotion> frames) {
    const size_t count = frames.size();
    const FrameSpan all{0, count};
    const std::vector<double> prefix = prefixOfPose(frames);
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
    if (best > 0) {
        const double first = meanOf(0, best), second = meanOf(best, count);
        if (second > kClearChange * first && second > kMovingPose) return {{0, best}, {best, count}};
        if (first > kClearChange * second && first > kMovingPose) return {{best, count}, {0, best}};
    }
    return meanOf(0, count) > kMovingPose ? StillAndMoving{{}, all} : StillAndMoving{all, {}};
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
