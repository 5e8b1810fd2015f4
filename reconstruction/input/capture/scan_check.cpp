// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/input/capture/scan_check.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <functional>
#include <map>
#include <numbers>
#include <opencv2/core.hpp>

#include "reconstruction/base/models_folder.h"
#include "reconstruction/input/capture/focal_check.h"
#include "reconstruction/input/capture/frame_measures.h"
#include "reconstruction/input/capture/priors.h"
#include "reconstruction/input/capture/silhouettes.h"
#include "sdk/core/percentile.h"
#include "sdk/core/task.h"

namespace dpl {
namespace {

constexpr size_t kFewestStill = 8;
constexpr size_t kFewestMoving = 20;  // of a scan without a still part; NeuMan trains on 30 and more

size_t listed(const Scan& scan, FrameKind kind) {
    return size_t(std::count_if(scan.frames.begin(), scan.frames.end(), [=](const ScanFrame& f) { return f.kind == kind; }));
}

class Checker {
public:
    Checker(const Scan& scan, Jobs& jobs)
        : scan_(scan), jobs_(jobs), measures_(scan.frames.size()), azimuthRad_(scan.frames.size(), 0), elevation_(scan.frames.size(), 0) {}

    Result<ScanCheck> run() {
        std::atomic<bool> cancelled{false};
        std::atomic<size_t> done{0};
        jobs_.forBlocks(scan_.frames.size(), [&](size_t i, uint32_t worker) {
            if (cancelled) return;
            measures_[i] = measureFrame(scan_, scan_.frames[i]);
            const size_t count = ++done;
            if (worker == 0 && !taskAt(double(count) / double(scan_.frames.size()), "reading the pictures")) cancelled = true;
        });
        if (cancelled) return fail(Code::Cancelled, "stopped after {} of {} pictures", done.load(), scan_.frames.size());
        checkFiles();
        checkMasks();
        checkBlur();
        checkAzimuth();
        checkExposure();
        checkSilhouettes();
        checkKeypoints();
        checkMoments();
        checkPoses();
        for (auto& m : measures_) out_.frames.push_back(std::move(m.check));
        for (const auto& finding : out_.findings)
            out_.verdict = std::max(out_.verdict, finding.refuses ? ScanVerdict::Refuse : ScanVerdict::Usable);
        return std::move(out_);
    }

private:
    const Scan& scan_;
    Jobs& jobs_;
    std::vector<FrameMeasures> measures_;
    ScanCheck out_;
    std::vector<double> azimuthRad_, elevation_;  // per frame, about the subject; elevation_ is a sine

    void find(bool refuses, const char* topic, std::string sentence, std::vector<std::string> frames = {}) {
        out_.findings.push_back({refuses, topic, std::move(sentence), std::move(frames)});
    }
    using Test = std::function<bool(const ScanFrame&, const FrameMeasures&)>;
    std::vector<size_t> select(const Test& test) const {
        std::vector<size_t> chosen;
        for (size_t i = 0; i < measures_.size(); ++i)
            if (measures_[i].check.measured && test(scan_.frames[i], measures_[i])) chosen.push_back(i);
        return chosen;
    }
    std::vector<size_t> ofKind(FrameKind kind) const {
        return select([=](const ScanFrame& f, const FrameMeasures& m) { return f.kind == kind && m.check.usable; });
    }
    std::vector<std::string> names(const std::vector<size_t>& indices) const {
        std::vector<std::string> out;
        for (size_t i : indices) out.push_back(scan_.frames[i].name);
        return out;
    }

    void checkFiles() {
        std::vector<std::string> bad;
        std::string first;
        for (const auto& m : measures_)
            if (!m.check.error.empty()) {
                if (first.empty()) first = m.check.error;
                bad.push_back(m.check.name);
            }
        if (!bad.empty())
            find(true, "files", formatText("{} of {} frames cannot be read; the first: {}", bad.size(), measures_.size(), first), bad);
        if (std::string lack = missingStillPart(scan_); !lack.empty())
            find(true, "files", std::move(lack));
        else if (listed(scan_, FrameKind::StaticFull) == 0)
            find(false, "files", "the subject never stands still, so its shape and one layer of splats come from moving frames alone");
        const auto held =
            std::count_if(scan_.frames.begin(), scan_.frames.end(), [](const ScanFrame& f) { return f.split == Split::Test; });
        if (held == 0) find(false, "files", "no picture is held out, so the report cannot judge the result on unseen views");
        const auto mixed = select([](const ScanFrame&, const FrameMeasures& m) { return m.labelAgreement >= 0 && m.labelAgreement < 0.7; });
        if (!mixed.empty())
            find(mixed.size() * 3 > measures_.size(), "files",
                 formatText("{} label pictures do not fit their masks; were the files mixed up?", mixed.size()), names(mixed));
    }

    void checkMasks() {
        const auto train = select([](const ScanFrame&, const FrameMeasures&) { return true; });
        const auto without = select([](const ScanFrame&, const FrameMeasures& m) { return m.check.maskShare < 0; });
        const auto empty = select(
            [](const ScanFrame&, const FrameMeasures& m) { return m.check.maskShare >= 0 && m.check.maskShare < priors::kEmptyMaskShare; });
        for (size_t i : empty) measures_[i].check.usable = false;
        if (!without.empty() && without.size() == train.size())
            find(false, "masks", formatText("the scan has no masks; add masks/, or let networks find the person: {}", howToGetNetworks()));
        else if (!without.empty()) {
            for (size_t i : without) measures_[i].check.usable = false;
            find(false, "masks", formatText("{} frames have no mask and are left out; add their masks", without.size()), names(without));
        }
        std::vector<std::string> notScored;
        for (const ScanFrame& frame : scan_.frames)
            if (frame.split == Split::Test && frame.maskPath.empty()) notScored.push_back(frame.name);
        if (!notScored.empty() && without.size() < train.size())
            find(false, "masks", formatText("{} held-out pictures have no mask and are not scored; add their masks", notScored.size()),
                 notScored);
        const bool found = std::all_of(empty.begin(), empty.end(), [&](size_t i) { return scan_.frames[i].maskFound; });
        if (!empty.empty())
            find(
                empty.size() * 3 >= train.size(), "masks",
                formatText(found ? "nobody was found in {} of {} pictures; keep the person in view, upright and well lit (those frames are "
                                   "left out)"
                                 : "{} of {} masks are empty; make them again (those frames are left out)",
                           empty.size(), train.size()),
                names(empty));
        const auto cut = select([](const ScanFrame& f, const FrameMeasures& m) {
            return f.kind != FrameKind::StaticCloseup && m.check.usable && m.check.borderShare > priors::kBorderShare;
        });
        const auto full = select([](const ScanFrame& f, const FrameMeasures&) { return f.kind != FrameKind::StaticCloseup; });
        if (!cut.empty())
            find(cut.size() * 2 > full.size(), "border",
                 formatText("the subject is cut by the picture's edge in {} of {} full-body frames; step back or turn the phone upright",
                            cut.size(), full.size()),
                 names(cut));
    }

    void checkBlur() {
        std::vector<double> indices;
        for (const FrameKind kind : {FrameKind::StaticFull, FrameKind::StaticCloseup, FrameKind::Dynamic}) {
            const auto frames = ofKind(kind);
            std::vector<double> sharp;
            for (size_t i : frames) sharp.push_back(measures_[i].check.sharpness);
            const double middle = percentile(sharp, 0.5);
            for (size_t i : frames) {
                FrameCheck& check = measures_[i].check;
                if (middle > 0) check.relativeSharpness = check.sharpness / middle;
                if (kind != FrameKind::StaticCloseup) indices.push_back(check.blurIndex);
            }
        }
        out_.medianBlurIndex = percentile(indices, 0.5);
        const auto blurred = select([](const ScanFrame&, const FrameMeasures& m) {
            return m.check.usable && m.check.relativeSharpness < priors::kBlurredRelative;
        });
        if (out_.medianBlurIndex > priors::kBlurredIndex)
            find(true, "blur",
                 formatText("all pictures are blurred (median blur index {}, up to {} is sharp enough); clean the lens, lock the focus, "
                            "use more light",
                            std::round(out_.medianBlurIndex * 100) / 100, priors::kBlurredIndex));
        if (!blurred.empty()) {
            for (size_t i : blurred) measures_[i].check.usable = false;
            find(false, "blur", formatText("{} frames are far blurrier than the others and are left out; move more slowly", blurred.size()),
                 names(blurred));
        }
    }

    void checkExposure() {
        const auto frames = ofKind(FrameKind::StaticFull);
        std::vector<double> all;
        std::vector<size_t> used;
        for (size_t i : frames)
            if (measures_[i].check.brightness > 0) used.push_back(i), all.push_back(std::log2(measures_[i].check.brightness));
        if (used.size() < 16) return;
        out_.exposureSpreadStops = percentile(all, 0.95) - percentile(all, 0.05);
        // A lit side or dark trousers change the brightness without an exposure drift. Subtract the part that azimuth and camera height
        // explain, and look for jumps in the remainder.
        cv::Mat basis(int(used.size()), 6, CV_64F), value(int(used.size()), 1, CV_64F), weights;
        for (size_t r = 0; r < used.size(); ++r) {
            const double a = azimuthRad_[used[r]];
            const double row[6] = {1, std::cos(a), std::sin(a), std::cos(2 * a), std::sin(2 * a), elevation_[used[r]]};
            for (int k = 0; k < 6; ++k) basis.at<double>(int(r), k) = row[k];
            value.at<double>(int(r), 0) = all[r];
        }
        cv::solve(basis, value, weights, cv::DECOMP_SVD);
        const cv::Mat rest = value - basis * weights;
        const std::vector<double> stops(rest.begin<double>(), rest.end<double>());
        constexpr size_t kWindow = 3;
        for (size_t i = kWindow; i + kWindow <= stops.size(); ++i) {
            const double before = percentile(std::vector<double>(stops.begin() + long(i - kWindow), stops.begin() + long(i)), 0.5);
            const double after = percentile(std::vector<double>(stops.begin() + long(i), stops.begin() + long(i + kWindow)), 0.5);
            out_.exposureJumpStops = std::max(out_.exposureJumpStops, std::abs(after - before));
        }
        if (out_.exposureJumpStops > priors::kExposureStops)
            find(false, "exposure",
                 formatText("brightness jumps by {} stops between neighbouring pictures; lock exposure and white balance",
                            std::round(out_.exposureJumpStops * 100) / 100));
    }

    std::vector<SilhouetteView> staticViews() const {
        std::vector<SilhouetteView> views;
        for (size_t i : ofKind(FrameKind::StaticFull))
            if (!measures_[i].mask.pixels.empty()) views.push_back({scan_.frames[i].camera, measures_[i].mask});
        return views;
    }

    void checkAzimuth() {
        const auto frames = ofKind(FrameKind::StaticFull);
        if (frames.empty()) return;
        const auto views = staticViews();
        std::optional<Vec3d> centre = subjectCentre(views);
        Vec3d up(0, 1, 0);
        if (!scan_.metricWorld) {  // arbitrary world: take the up direction from the cameras
            up = Vec3d(0);
            for (size_t i : frames) up -= glm::transpose(scan_.frames[i].camera.viewFromWorldRotation) * Vec3d(0, 1, 0);
            if (!(glm::length(up) > 1e-6)) return;
            up = glm::normalize(up);
        }
        if (!centre) {  // no masks: the point nearest to the optical axes
            std::vector<Ray> axes;
            for (size_t i : frames)
                axes.push_back(pixelRay(scan_.frames[i].camera, {scan_.frames[i].camera.cx, scan_.frames[i].camera.cy}));
            centre = pointNearRays(axes, std::vector<double>(axes.size(), 1.0), 0);
        }
        if (!centre) return find(true, "azimuth", "all cameras look the same way; walk around the subject");
        const Vec3d side = std::abs(up.z) < 0.9 ? Vec3d(0, 0, 1) : Vec3d(1, 0, 0);
        const Vec3d front = glm::normalize(side - glm::dot(side, up) * up), left = glm::cross(up, front);
        std::vector<double> angles;
        for (size_t i : frames) {
            const Vec3d d = scan_.frames[i].camera.eye() - *centre;
            double angle = std::atan2(glm::dot(d, left), glm::dot(d, front)) * 180 / std::numbers::pi;
            if (angle < 0) angle += 360;
            azimuthRad_[i] = angle * std::numbers::pi / 180;
            elevation_[i] = glm::dot(glm::normalize(d), up);
            angles.push_back(angle);
            ++out_.azimuth[std::min<size_t>(kAzimuthBins - 1, size_t(angle / (360.0 / kAzimuthBins)))];
        }
        std::sort(angles.begin(), angles.end());
        out_.largestGapDeg = angles.empty() ? 360 : 360 - angles.back() + angles.front();
        for (size_t i = 1; i < angles.size(); ++i) out_.largestGapDeg = std::max(out_.largestGapDeg, angles[i] - angles[i - 1]);
        if (out_.largestGapDeg > priors::kGapWarnDeg)
            find(out_.largestGapDeg > priors::kGapRefuseDeg, "azimuth",
                 formatText("no sharp picture over {} degrees of the walk around; add some there", std::round(out_.largestGapDeg)));
    }

    void checkSilhouettes() {
        const auto views = staticViews();
        if (views.size() < 4) return;
        out_.silhouetteCoherence = silhouetteCoherence(views, jobs_);
        if (out_.silhouetteCoherence < priors::kCoherenceWarn)
            find(out_.silhouetteCoherence < priors::kCoherenceRefuse, "cameras",
                 formatText("seen together the masks explain only {} % of themselves: cameras, intrinsics or masks do not belong together, "
                            "or the subject moved; "
                            "register the cameras again",
                            std::round(100 * out_.silhouetteCoherence)));
    }

    /** A track for each keypoint that these frames show with confidence. */
    std::vector<KeypointTrack> keypointTracks(const std::vector<size_t>& frames) const {
        std::vector<KeypointTrack> tracks(scan_.keypointNames.size());
        for (size_t i : frames)
            for (size_t k = 0; k < measures_[i].keypoints.size(); ++k)
                if (const Keypoint& seen = measures_[i].keypoints[k]; seen.confidence >= 0.5)
                    tracks[k].push_back({scan_.frames[i].camera, seen.px, seen.confidence});
        return tracks;
    }

    void checkKeypoints() {
        const auto frames = ofKind(FrameKind::StaticFull);
        std::vector<double> heights;
        for (size_t i : frames) {
            double low = 1e30, high = -1e30;
            for (const auto& k : measures_[i].keypoints)
                if (k.confidence > 0.3) low = std::min(low, k.px.y), high = std::max(high, k.px.y);
            if (high > low) heights.push_back(high - low);
        }
        const std::vector<double> errors = missesPx(keypointTracks(frames), 1);
        if (errors.size() < 20) return;
        out_.keypointErrorPx = percentile(errors, 0.5);
        out_.keypointErrorShare = out_.keypointErrorPx / std::max(1.0, percentile(heights, 0.5));
        if (out_.keypointErrorShare > priors::kKeypointWarn)
            find(out_.keypointErrorShare > priors::kKeypointRefuse, "cameras",
                 formatText("keypoints of the still pictures miss each other by {} px ({} % of the subject's height): wrong intrinsics, "
                            "wrong cameras or a subject "
                            "that moved; register the cameras again",
                            std::round(out_.keypointErrorPx * 10) / 10, std::round(1000 * out_.keypointErrorShare) / 10));
        checkFocalLength();
        const auto off = select([](const ScanFrame&, const FrameMeasures& m) {
            return m.check.usable && m.check.keypointsOnPerson >= 0 && m.check.keypointsOnPerson < 0.5;
        });
        if (!off.empty())
            find(off.size() * 3 > measures_.size(), "keypoints",
                 formatText("in {} frames the keypoints lie beside the person; were the files mixed up?", off.size()), names(off));
    }

    /** Whether synchronised cameras see a moving subject in one place. */
    void checkMoments() {
        std::map<double, std::vector<size_t>> moments;
        for (size_t i : ofKind(FrameKind::Dynamic)) moments[scan_.frames[i].timeS].push_back(i);
        if (moments.size() < 2) return;  // the scan states no times
        std::vector<double> errors;
        for (const auto& [timeS, frames] : moments) {
            const std::vector<double> misses = missesPx(keypointTracks(frames), 1);
            errors.insert(errors.end(), misses.begin(), misses.end());
            out_.moments += !misses.empty();
        }
        if (out_.moments > 0) out_.momentErrorPx = percentile(errors, 0.5);
    }

    void checkFocalLength() {
        const auto still =
            select([](const ScanFrame& f, const FrameMeasures& m) { return f.kind != FrameKind::Dynamic && m.check.usable; });
        const auto tracks = keypointTracks(still);
        const auto estimate = estimateFocalFactor(tracks);
        constexpr double kAgreedPx = 0.5;  // no detector is better
        if (!estimate || estimate->missAsGivenPx < kAgreedPx) return;
        out_.focalFactor = estimate->factor;
        const double off = std::max(estimate->factor, 1 / estimate->factor) - 1;
        if (off < priors::kFocalWarn || estimate->missAsGivenPx < priors::kFocalMissRatio * estimate->missPx) return;
        const auto percent = [](double share) { return std::round(100 * share); };
        find(
            off > priors::kFocalRefuse, "cameras",
            formatText("the focal length looks {} % too {}: keypoints of the still pictures miss each other by {} px as given and by {} px "
                       "with focal lengths multiplied by {}; was the camera calibrated at another picture size or zoom? Correct fx and fy, "
                       "or register the cameras again",
                       percent(estimate->factor > 1 ? 1 - 1 / estimate->factor : 1 / estimate->factor - 1),
                       estimate->factor > 1 ? "short" : "long", std::round(estimate->missAsGivenPx * 10) / 10,
                       std::round(estimate->missPx * 10) / 10, std::round(estimate->factor * 100) / 100));
    }

    void checkPoses() {
        std::map<std::string, size_t> order;
        for (size_t k = 0; k < scan_.keypointNames.size(); ++k) order[scan_.keypointNames[k]] = k;
        const auto frames = ofKind(FrameKind::Dynamic);
        if (listed(scan_, FrameKind::Dynamic) == 0)
            return find(false, "poses",
                        "no dynamic pictures: how clothes follow the pose cannot be learned; film arm and leg raises if you can");
        size_t still = 0, known = 0;
        for (const char* side : {"_l", "_r"})
            for (const auto& [joint, chain] : {std::pair{"shoulder", std::array{"hip", "shoulder", "elbow"}},
                                               {"elbow", std::array{"shoulder", "elbow", "wrist"}},
                                               {"hip", std::array{"shoulder", "hip", "knee"}},
                                               {"knee", std::array{"hip", "knee", "ankle"}}}) {
                std::array<size_t, 3> at{};
                bool named = true;
                for (int i = 0; i < 3; ++i) {
                    const auto found = order.find(std::string(chain[size_t(i)]) + side);
                    named = named && found != order.end();
                    if (named) at[size_t(i)] = found->second;
                }
                if (!named) continue;
                std::vector<double> angles;
                for (size_t f : frames) {
                    const auto& k = measures_[f].keypoints;
                    if (k.empty() || std::min({k[at[0]].confidence, k[at[1]].confidence, k[at[2]].confidence}) < 0.3) continue;
                    const Vec2d a = k[at[0]].px - k[at[1]].px, b = k[at[2]].px - k[at[1]].px;
                    angles.push_back(std::abs(std::atan2(a.x * b.y - a.y * b.x, glm::dot(a, b))) * 180 / std::numbers::pi);
                }
                if (angles.size() < 5) continue;
                out_.joints.push_back(
                    {std::string(joint) + side, uint32_t(angles.size()), percentile(angles, 0.05), percentile(angles, 0.95)});
                ++known;
                still += out_.joints.back().highDeg - out_.joints.back().lowDeg < priors::kPoseRangeDeg;
            }
        if (known >= 4 && still * 2 > known)
            find(false, "poses",
                 formatText("{} of {} joints hardly move in the dynamic pictures; raise arms and legs and bend elbows", still, known));
    }
};

}  // namespace

std::string missingStillPart(const Scan& scan) {
    const size_t full = listed(scan, FrameKind::StaticFull);
    const auto teaches = [](const ScanFrame& f) { return f.kind == FrameKind::Dynamic && f.split == Split::Train; };
    const auto moving = size_t(std::count_if(scan.frames.begin(), scan.frames.end(), teaches));
    if (full == 0 && moving >= kFewestMoving && !scan.protocol.empty()) return {};  // published data sets have no still part
    if (full >= kFewestStill) return {};
    return formatText("only {} full-body pictures of the still subject, at least {} are needed and 40 or more are better; walk once around",
                      full, kFewestStill);
}

Result<ScanCheck> checkScan(const Scan& scan, Jobs& jobs) {
    if (scan.frames.empty()) return fail(Code::InvalidArgument, "{}: the scan has no frame to check", scan.root.string());
    return Checker(scan, jobs).run();
}

}  // namespace dpl
