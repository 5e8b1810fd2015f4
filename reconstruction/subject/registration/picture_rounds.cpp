// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/subject/registration/picture_rounds.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>

#include "reconstruction/subject/body/priors.h"
#include "reconstruction/subject/registration/priors.h"
#include "reconstruction/subject/surface/contours.h"
#include "sdk/core/percentile.h"

namespace dpl {
namespace {

constexpr uint32_t kOutlineSidePx = 512;  // distance transforms are at most this large
constexpr double kOutlineSpacingPx = 8;   // outline pixels this far apart count as independent
constexpr double kSameDirection = 0.5;    // least cosine between the drawn outline's normal and the picture's outward direction
constexpr float kSameDepthM = 0.02f;      // a label's outline against a part nearer than this is the outline of that part

double medianDepth(const MeshRaster& raster) {
    std::vector<float> depths;
    for (const float depth : raster.depthM)
        if (std::isfinite(depth)) depths.push_back(depth);
    return depths.empty() ? 1.0 : double(percentile(std::move(depths), 0.5));
}

/** Variance of a channel's difference. A point may slip on the body, which matters where the picture changes fast. */
double contrastVariance(const PointContrast& contrast, const Vec3d& dx, const Vec3d& dy, bool rigid, double pxPerM) {
    const double slipPx = pxPerM * (rigid ? priors::kRigidSlipM : priors::kClothSlipM);
    const double slope2 = (glm::dot(dx, dx) + glm::dot(dy, dy)) / 3;
    return priors::kContrastNoise * priors::kContrastNoise + contrast.spread * contrast.spread + slope2 * slipPx * slipPx / 2;
}

/** Points that count, of one with this area: those within one blur count as one. */
double independentShare(double areaPx, double blurPx) {
    return std::min(1.0, areaPx / (4 * std::numbers::pi * blurPx * blurPx));
}

}  // namespace

PictureRounds::PictureRounds(const RegisterInput& input, const RegisterSettings& settings, Jobs& jobs)
    : input_(input), jobs_(jobs), points_(spreadPoints(*input.surface, settings.surfacePoints)) {
    for (const MeshPoint& p : points_) carried_.emplace_back(input.body->joints, *input.surface, p);
    for (size_t f = 0; f < input.frames.size(); ++f) {
        if (!input.frames[f].picture) continue;
        if (input.frames[f].kind == FrameKind::StaticFull) stills_.push_back(shown_.size());
        shown_.push_back(f);
    }
    if (stills_.empty()) {  // the subject never stands still
        stills_.resize(shown_.size());
        std::iota(stills_.begin(), stills_.end(), size_t(0));
    }
    outlines_.resize(shown_.size());
    jobs.forBlocks(shown_.size(), [&](size_t i, uint32_t) {
        outlines_[i] = frameOutlines(**input.frames[shown_[i]].picture.get(), input.outlineLabels, kOutlineSidePx);
    });
    pxPerM_.resize(shown_.size()), blurPx_.resize(shown_.size());
    views_.resize(shown_.size()), images_.resize(shown_.size());
}

void PictureRounds::start(const FramePoses& poses, double blurPx) {
    std::vector<size_t> all(shown_.size());
    std::iota(all.begin(), all.end(), size_t(0));
    const std::vector<DrawnMesh> drawn = draw(poses, all);
    for (const size_t i : all) pxPerM_[i] = input_.frames[shown_[i]].camera.fx / medianDepth(drawn[i].raster);
    const double usual = percentile(pxPerM_, 0.5);
    jobs_.forBlocks(all.size(), [&](size_t i, uint32_t) {
        blurPx_[i] = blurPx * std::clamp(pxPerM_[i] / usual, 0.25, 8.0);
        views_[i] = viewOf(i, drawn[i]);
        images_[i] = contrastImage(**input_.frames[shown_[i]].picture.get(), blurPx_[i]);
    });
    std::vector<StillContrast> observed;
    for (const size_t i : stills_) observed.push_back({views_[i].seen, &images_[i]});
    contrast_ = gatherContrast(points_.size(), observed);
    ofTriangle_.clear();
}

void PictureRounds::look(const FramePoses& poses, std::span<const size_t> frames) {
    const std::vector<size_t> which = withPicture(frames);
    const std::vector<DrawnMesh> drawn = draw(poses, which);
    jobs_.forBlocks(which.size(), [&](size_t k, uint32_t) { views_[which[k]] = viewOf(which[k], drawn[k]); });
}

void PictureRounds::addTerms(ceres::Problem& problem, FramePoses& poses, std::span<const size_t> frames) const {
    for (const size_t i : withPicture(frames)) {
        std::vector<OutlineTerm> outline = views_[i].outline;
        for (OutlineTerm& term : outline) term.weight *= input_.pictureWeight * priors::kOutlineTrust;
        poses.addPicture(problem, shown_[i],
                         new PictureCost(poses.chain(), input_.frames[shown_[i]].camera, poses.reference(shown_[i]), &images_[i],
                                         contrastTerms(i), std::move(outline), poses.held(shown_[i])));
    }
}

double PictureRounds::misfit(const FramePoses& poses, std::span<const size_t> frames) {
    const std::vector<size_t> which = withPicture(frames);
    if (which.empty()) return 0;
    if (ofTriangle_.empty()) findTriangleContrast();
    const std::vector<DrawnMesh> drawn = draw(poses, which);
    std::vector<double> costs(which.size());
    jobs_.forBlocks(which.size(), [&](size_t k, uint32_t) { costs[k] = misfit(which[k], drawn[k]); });
    return std::accumulate(costs.begin(), costs.end(), 0.0);
}

std::vector<size_t> PictureRounds::withPicture(std::span<const size_t> frames) const {
    std::vector<size_t> which;
    for (const size_t f : frames)
        if (const auto at = std::lower_bound(shown_.begin(), shown_.end(), f); at != shown_.end() && *at == f)
            which.push_back(size_t(at - shown_.begin()));
    return which;
}

std::vector<DrawnMesh> PictureRounds::draw(const FramePoses& poses, std::span<const size_t> which) const {
    std::vector<Pose> now;
    std::vector<Camerad> cameras;
    for (const size_t i : which) now.push_back(poses.pose(shown_[i])), cameras.push_back(input_.frames[shown_[i]].camera);
    return drawMesh(input_.body->joints, *input_.surface, now, cameras, jobs_);
}

/** Terms for the drawn outline of what `inside` marks, against the same outline of the picture. */
void PictureRounds::addOutline(size_t i, const DrawnMesh& drawn, const std::vector<uint8_t>& inside, const MaskDistance& outline,
                               bool silhouette, std::vector<OutlineTerm>& terms) const {
    const MeshRaster& raster = drawn.raster;
    const Camerad& camera = input_.frames[shown_[i]].camera;
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
        const bool rigid = input_.rigidTriangle[triangle] != 0;
        terms.push_back({CarriedPoint(input_.body->joints, *input_.surface, {triangle, raster.barycentric[p.inside]}), &outline,
                         rigid ? priors::kRigidOutlineM : priors::kClothOutlineM, 1 / kOutlineSpacingPx});
    }
}

PictureRounds::FrameView PictureRounds::viewOf(size_t i, const DrawnMesh& drawn) const {
    FrameView view;
    view.seen = seenPoints(*input_.surface, points_, drawn, input_.frames[shown_[i]].camera);
    const MeshRaster& raster = drawn.raster;
    std::vector<uint8_t> inside(raster.triangle.size());
    for (const auto& [label, outline] : outlines_[i].byLabel) {
        for (size_t at = 0; at < inside.size(); ++at) {
            const uint32_t t = raster.triangle[at];
            inside[at] = t != kNoTriangle && (label == 0 || input_.triangleLabel[t] == label);
        }
        addOutline(i, drawn, inside, outline, label == 0, view.outline);
    }
    return view;
}

/** Terms of the points that a frame shows. */
std::vector<ContrastTerm> PictureRounds::contrastTerms(size_t i) const {
    const ContrastImage& image = images_[i];
    std::vector<ContrastTerm> terms;
    for (const SeenPoint& seen : views_[i].seen) {
        Vec3d value, dx, dy;
        const PointContrast& contrast = contrast_[seen.point];
        if (!contrast.known || !image.isInside(seen.px) || !image.sample(seen.px, value, dx, dy)) continue;
        const bool rigid = input_.rigidTriangle[points_[seen.point].triangle] != 0;
        terms.push_back({carried_[seen.point], contrast.median, std::sqrt(contrastVariance(contrast, dx, dy, rigid, pxPerM_[i])), 1.0});
    }
    size_t person = 0;
    for (const uint8_t inside : image.inside) person += inside;
    const double areaPx = double(person) / double(std::max<size_t>(1, terms.size()));
    const double weight = input_.pictureWeight * priors::kContrastTrust * independentShare(areaPx, blurPx_[i]);
    for (ContrastTerm& term : terms) term.weight = weight;
    return terms;
}

/** Each triangle looks like the known point that is nearest to it at rest. */
void PictureRounds::findTriangleContrast() {
    const MeshData& mesh = *input_.surface;
    const auto at = [&](uint32_t triangle, const Vec2f& uv) {
        const Triangle& t = mesh.triangles[triangle];
        return (1 - uv.x - uv.y) * mesh.restPositions[t.x] + uv.x * mesh.restPositions[t.y] + uv.y * mesh.restPositions[t.z];
    };
    std::vector<Vec3f> places;
    std::vector<size_t> known;
    for (size_t i = 0; i < points_.size(); ++i)
        if (contrast_[i].known) places.push_back(at(points_[i].triangle, points_[i].uv)), known.push_back(i);
    ofTriangle_.assign(mesh.triangles.size(), {});
    jobs_.forBlocks(known.empty() ? 0 : ofTriangle_.size(), [&](size_t t, uint32_t) {
        const Vec3f middle = at(uint32_t(t), Vec2f(1.0f / 3));
        const auto nearest = std::min_element(places.begin(), places.end(), [&](const Vec3f& a, const Vec3f& b) {
            return glm::dot(a - middle, a - middle) < glm::dot(b - middle, b - middle);
        });
        ofTriangle_[t] = contrast_[known[size_t(nearest - places.begin())]];
    });
}

double PictureRounds::misfit(size_t i, const DrawnMesh& drawn) const {
    const MeshRaster& raster = drawn.raster;
    const ContrastImage& image = images_[i];
    constexpr double kOutlier = priors::kContrastOutlierSigmas * priors::kContrastOutlierSigmas;
    double sum = 0;
    for (uint32_t y = 0; y < raster.heightPx; ++y)
        for (uint32_t x = 0; x < raster.widthPx; ++x) {
            const size_t at = size_t(y) * raster.widthPx + x;
            const uint32_t t = raster.triangle[at];
            if ((t != kNoTriangle) != (image.inside[at] != 0)) {
                sum += kOutlier;
                continue;
            }
            Vec3d value, dx, dy;
            if (t == kNoTriangle || !ofTriangle_[t].known || !image.sample(Vec2d(x + 0.5, y + 0.5), value, dx, dy)) continue;
            const double pxPerM = input_.frames[shown_[i]].camera.fx / raster.depthM[at];
            const Vec3d r = value - ofTriangle_[t].median;
            const double s = glm::dot(r, r) / contrastVariance(ofTriangle_[t], dx, dy, input_.rigidTriangle[t] != 0, pxPerM);
            sum += kOutlier * s / (s + kOutlier);
        }
    return input_.pictureWeight * priors::kContrastTrust * independentShare(1, blurPx_[i]) * sum;
}

}  // namespace dpl
