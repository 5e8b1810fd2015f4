// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/registration/register_frames.h"

#include <ceres/problem.h>
#include <ceres/solver.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "reconstruction/registration/appearance.h"
#include "reconstruction/registration/frame_poses.h"
#include "reconstruction/registration/picture_cost.h"
#include "reconstruction/surface/contours.h"
#include "sdk/core/percentile.h"

namespace dpl {
namespace {

constexpr uint32_t kPictureSidePx = 640;  // larger pictures are reduced: poses need no finer ones
constexpr uint32_t kOutlineSidePx = 512;  // distance transforms are at most this large
constexpr double kOutlineSpacingPx = 8;   // outline pixels this far apart count as independent
constexpr double kSameDirection = 0.5;    // least cosine between the drawn outline's normal and the picture's outward direction
constexpr float kSameDepthM = 0.02f;      // a label's outline against a part nearer than this is the outline of that part
constexpr double kPi = 3.14159265358979323846;

/** The points and outlines of one frame for the current poses. */
struct FrameView {
    std::vector<SeenPoint> seen;
    std::vector<OutlineTerm> outline;
};

/** Terms for the drawn outline of what `inside` marks, against the same outline of the picture. */
void addOutline(const RegisterInput& input, const DrawnMesh& drawn, const Camerad& camera, const std::vector<uint8_t>& inside,
                const MaskDistance& outline, bool silhouette, std::vector<OutlineTerm>& terms) {
    const MeshRaster& raster = drawn.raster;
    for (const ContourPoint& p : contourPoints(inside, raster.widthPx, raster.heightPx)) {
        const uint32_t triangle = raster.triangle[p.inside];
        const Vec2d beyond = p.px + p.normal;
        if (!(beyond.x >= 0 && beyond.y >= 0 && beyond.x < raster.widthPx && beyond.y < raster.heightPx)) continue;
        const size_t outside = size_t(beyond.y) * raster.widthPx + size_t(beyond.x);
        const float depth = raster.depthM[p.inside];
        if (!silhouette && (raster.triangle[outside] == kNoTriangle || depth > raster.depthM[outside] + kSameDepthM)) continue;
        Vec2d gradient;
        const double distanceM = outline.sample(p.px, gradient) * double(depth) / camera.fx;
        if (std::abs(distanceM) > priors::kOutlineReachM || glm::length(gradient) < 0.3) continue;
        if (glm::dot(glm::normalize(gradient), p.normal) < kSameDirection) continue;
        const bool rigid = input.rigidTriangle[triangle] != 0;
        terms.push_back({CarriedPoint(input.body->joints, *input.surface, {triangle, raster.barycentric[p.inside]}), &outline,
                         rigid ? priors::kRigidOutlineM : priors::kClothOutlineM, 1 / kOutlineSpacingPx});
    }
}

FrameView viewOf(const RegisterInput& input, std::span<const MeshPoint> points, const RegisterFrame& frame, const DrawnMesh& drawn,
                 const FrameOutlines& outlines) {
    FrameView view;
    view.seen = seenPoints(*input.surface, points, drawn, frame.camera);
    const MeshRaster& raster = drawn.raster;
    std::vector<uint8_t> inside(raster.triangle.size());
    for (const auto& [label, outline] : outlines.byLabel) {
        for (size_t i = 0; i < inside.size(); ++i) {
            const uint32_t t = raster.triangle[i];
            inside[i] = t != kNoTriangle && (label == 0 || input.triangleLabel[t] == label);
        }
        addOutline(input, drawn, frame.camera, inside, outline, label == 0, view.outline);
    }
    return view;
}

/** Terms of the points that a frame shows. A point counts less where the picture changes fast and the point may slip, and where several
 *  points lie within one blur. */
std::vector<ContrastTerm> contrastTerms(const RegisterInput& input, std::span<const MeshPoint> points,
                                        std::span<const CarriedPoint> carried, std::span<const PointContrast> contrast, double pxPerM,
                                        const FrameView& view, const ContrastImage& image, double blurPx) {
    std::vector<ContrastTerm> terms;
    for (const SeenPoint& seen : view.seen) {
        Vec3d value, dx, dy;
        if (!contrast[seen.point].known || !image.isInside(seen.px) || !image.sample(seen.px, value, dx, dy)) continue;
        const double slipPx = pxPerM * (input.rigidTriangle[points[seen.point].triangle] ? priors::kRigidSlipM : priors::kClothSlipM);
        const double slope2 = (glm::dot(dx, dx) + glm::dot(dy, dy)) / 3, spread = contrast[seen.point].spread;
        const double variance = priors::kContrastNoise * priors::kContrastNoise + spread * spread + slope2 * slipPx * slipPx / 2;
        terms.push_back({carried[seen.point], contrast[seen.point].median, std::sqrt(variance), 1.0});
    }
    size_t person = 0;
    for (const uint8_t i : image.inside) person += i;
    const double areaPx = double(person) / double(std::max<size_t>(1, terms.size()));
    const double weight = input.pictureWeight * priors::kContrastTrust * std::min(1.0, areaPx / (4 * kPi * blurPx * blurPx));
    for (ContrastTerm& term : terms) term.weight = weight;
    return terms;
}

double medianDepth(const MeshRaster& raster) {
    std::vector<float> depths;
    for (const float depth : raster.depthM)
        if (std::isfinite(depth)) depths.push_back(depth);
    return depths.empty() ? 1.0 : double(percentile(std::move(depths), 0.5));
}

/** Keeps the pictures and keypoints of frames that are reduced to kPictureSidePx. */
class ReducedFrames {
public:
    RegisterInput reduce(RegisterInput input, Jobs& jobs) {
        pictures_.resize(input.frames.size());
        keypoints_.resize(input.frames.size());
        jobs.forBlocks(input.frames.size(), [&](size_t f, uint32_t) {
            RegisterFrame& frame = input.frames[f];
            const uint32_t side = std::max(frame.camera.widthPx, frame.camera.heightPx);
            if (side <= kPictureSidePx) return;
            const Camerad whole = frame.camera;
            frame.camera = whole.scaled(double(kPictureSidePx) / side);
            for (Keypoint k : frame.keypoints) {
                k.px *= Vec2d(frame.camera.fx / whole.fx, frame.camera.fy / whole.fy);
                keypoints_[f].push_back(k);
            }
            frame.keypoints = keypoints_[f];
            if (!frame.picture) return;
            pictures_[f] = reducedPicture(*frame.picture, kPictureSidePx);
            frame.picture = &pictures_[f];
        });
        return input;
    }

private:
    std::vector<FramePicture> pictures_;
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
        if (frame.picture &&
            (frame.picture->image.widthPx != frame.camera.widthPx || frame.picture->image.heightPx != frame.camera.heightPx))
            return fail(Code::InvalidArgument, "a picture has not the size of its camera");
        DPL_CHECK_OK(checkPose(input.body->joints, frame.pose));
    }
    return {};
}

}  // namespace

Result<Registration> registerFrames(const RegisterInput& given, const RegisterSettings& settings, Jobs& jobs) {
    DPL_CHECK_OK(checkInput(given));
    ReducedFrames reduced;
    const RegisterInput input = reduced.reduce(given, jobs);
    FramePoses poses(input);
    Registration result;
    result.precisions.resize(input.frames.size());
    /** Of the frames of a split, after their last solve. */
    const auto keepPrecisions = [&](ceres::Problem& problem, Split split) {
        for (size_t f = 0; f < input.frames.size(); ++f)
            if (input.frames[f].split == split) result.precisions[f] = poses.precision(problem, f);
    };
    const auto tell = [&](double fraction, std::string_view what) -> Status {
        if (settings.progress && !settings.progress(fraction, what)) return fail(Code::Cancelled, "registration was cancelled");
        return {};
    };
    const std::vector<MeshPoint> points = spreadPoints(*input.surface, settings.surfacePoints);
    std::vector<CarriedPoint> carried;
    for (const MeshPoint& p : points) carried.emplace_back(input.body->joints, *input.surface, p);

    std::vector<size_t> stills, shown;  // frames with a picture: those that tell the contrast of points; all
    for (size_t f = 0; f < input.frames.size(); ++f) {
        if (!input.frames[f].picture) continue;
        if (input.frames[f].kind == FrameKind::StaticFull) stills.push_back(shown.size());
        shown.push_back(f);
    }
    if (stills.empty()) {  // the subject never stands still
        stills.resize(shown.size());
        std::iota(stills.begin(), stills.end(), size_t(0));
    }
    std::vector<Camerad> cameras;
    for (const size_t f : shown) cameras.push_back(input.frames[f].camera);
    std::vector<FrameOutlines> outlines(shown.size());
    jobs.forBlocks(shown.size(), [&](size_t i, uint32_t) {
        outlines[i] = frameOutlines(*input.frames[shown[i]].picture, input.outlineLabels, kOutlineSidePx);
    });

    const size_t rounds = shown.empty() ? 1 : settings.blursPx.size() * size_t(settings.roundsPerBlur);
    size_t done = 0;
    for (size_t level = 0; level < settings.blursPx.size() && !shown.empty(); ++level) {
        const double blurPx = settings.blursPx[level];
        for (int round = 0; round < settings.roundsPerBlur; ++round) {
            DPL_CHECK_OK(tell(0.9 * double(done++) / double(rounds), formatText("pictures at a blur of {} px", blurPx)));
            std::vector<Pose> now;
            for (const size_t f : shown) now.push_back(poses.pose(f));
            const auto drawn = drawMesh(input.body->joints, *input.surface, now, cameras, jobs);
            std::vector<double> pxPerM(shown.size());
            for (size_t i = 0; i < shown.size(); ++i) pxPerM[i] = cameras[i].fx / medianDepth(drawn[i].raster);
            const double usual = percentile(pxPerM, 0.5);
            std::vector<FrameView> views(shown.size());
            std::vector<ContrastImage> images(shown.size());
            jobs.forBlocks(shown.size(), [&](size_t i, uint32_t) {
                views[i] = viewOf(input, points, input.frames[shown[i]], drawn[i], outlines[i]);
                images[i] = contrastImage(*input.frames[shown[i]].picture, blurPx * std::clamp(pxPerM[i] / usual, 0.25, 8.0));
            });
            std::vector<StillContrast> observed;
            for (const size_t i : stills) observed.push_back({views[i].seen, &images[i]});
            const std::vector<PointContrast> contrast = gatherContrast(points.size(), observed);
            ceres::Problem problem;
            poses.addTerms(problem, Split::Train);
            for (size_t i = 0; i < shown.size(); ++i) {
                const RegisterFrame& frame = input.frames[shown[i]];
                for (OutlineTerm& term : views[i].outline) term.weight *= input.pictureWeight * priors::kOutlineTrust;
                const double framePx = blurPx * std::clamp(pxPerM[i] / usual, 0.25, 8.0);
                poses.addPicture(problem, shown[i],
                                 new PictureCost(poses.chain(), frame.camera, poses.reference(shown[i]), &images[i],
                                                 contrastTerms(input, points, carried, contrast, pxPerM[i], views[i], images[i], framePx),
                                                 std::move(views[i].outline)));
            }
            DPL_TRY(SolveEnd end, poses.solve(problem, formatText("pictures, blur {} px", blurPx), settings.stepsPerRound));
            result.solves.push_back(std::move(end));
            if (done == rounds) keepPrecisions(problem, Split::Train);
        }
    }
    if (shown.empty()) {
        ceres::Problem problem;
        poses.addTerms(problem, Split::Train);
        DPL_TRY(SolveEnd end, poses.solve(problem, "moving frames: keypoints", 30));
        result.solves.push_back(std::move(end));
        keepPrecisions(problem, Split::Train);
    }
    DPL_CHECK_OK(tell(0.9, "held-out frames"));
    for (const Split split : {Split::Validation, Split::Test}) {
        ceres::Problem problem;
        if (poses.hasMoving(split)) {
            poses.addTerms(problem, split);
            const char* what = split == Split::Test ? "held-out moving frames" : "validation moving frames";
            DPL_TRY(SolveEnd end, poses.solve(problem, what, 30));
            result.solves.push_back(std::move(end));
        }
        keepPrecisions(problem, split);
    }
    for (size_t f = 0; f < input.frames.size(); ++f)
        result.poses.push_back(input.frames[f].kind == FrameKind::Dynamic || input.frames[f].picture ? poses.pose(f)
                                                                                                     : input.frames[f].pose);
    return result;
}

}  // namespace dpl
