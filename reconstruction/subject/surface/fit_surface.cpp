// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/subject/surface/fit_surface.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "reconstruction/input/capture/frame_picture.h"
#include "reconstruction/subject/shape/large_steps.h"
#include "reconstruction/subject/shape/vertex_sets.h"
#include "reconstruction/subject/surface/contours.h"
#include "reconstruction/subject/surface/mesh_raster.h"
#include "reconstruction/subject/surface/priors.h"
#include "sdk/core/task.h"
#include "sdk/format/check_mesh.h"
#include "sdk/math/merge_vertices.h"
#include "sdk/math/skinning.h"

namespace dpl {
namespace {

constexpr double kTurnShare = 0.03;   // turnPx of matchContours(), as a share of the picture's height
constexpr double kReachShare = 0.25;  // reachPx of matchContours(), as a share of the picture's height; longer pulls are wrong matches
constexpr double kHiddenM = 0.03;     // a mark this far behind what the picture shows there is hidden
constexpr double kStep = 0.8;         // share of the smoothed pull by which a round moves the surface
/** Share of an offset's difference from its neighbours' mean that a round removes. A higher value pulls sleeves and hems inwards. */
constexpr double kRelax = 0.03;

/** A displacement that one outline point asks of one vertex, in the rest pose. */
struct Pull {
    uint32_t vertex;
    float weight;
    Vec3f weighted;  // weight × displacement, metres
};

Status checkInput(const MeshData& mesh, std::span<const JointData> joints, std::span<const Vec3f> offsets,
                  std::span<const SurfaceView> views) {
    const size_t count = mesh.restPositions.size();
    if (count == 0 || mesh.triangles.empty()) return fail(Code::InvalidArgument, "the mesh to fit is empty");
    DPL_RETURN_IF_ERROR(checkMesh(mesh, joints.size()));
    DPL_RETURN_IF_ERROR(checkFinite(mesh));
    if (!offsets.empty() && offsets.size() != count)
        return fail(Code::InvalidArgument, "{} offsets for {} vertices", offsets.size(), count);
    for (size_t i = 0; i < views.size(); ++i) {
        const auto& view = views[i];
        if (view.mask.widthPx != view.camera.widthPx || view.mask.heightPx != view.camera.heightPx ||
            view.mask.pixels.size() != size_t(view.mask.widthPx) * view.mask.heightPx)
            return fail(Code::InvalidArgument, "the mask of view {} is {} x {}, its camera {} x {}", i, view.mask.widthPx,
                        view.mask.heightPx, view.camera.widthPx, view.camera.heightPx);
        DPL_RETURN_IF_ERROR(checkPose(joints, view.pose));
        for (const SurfaceMark& mark : view.marks)
            for (const auto& [v, weight] : mark.vertices)
                if (v >= count) return fail(Code::InvalidArgument, "a mark of view {} lies on vertex {} of {}", i, v, count);
    }
    return {};
}

/** Blended rotation-and-scale part and position of every vertex in one view. */
struct PosedView {
    std::vector<Mat3f> linear;
    std::vector<Vec3f> positions;
};

PosedView poseVertices(const MeshData& mesh, std::span<const JointData> joints, std::span<const Vec3f> offsets, const Pose& pose) {
    std::vector<Mat3x4f> worldFromRest;
    jointTransforms(joints, pose, worldFromRest);
    PosedView out{std::vector<Mat3f>(mesh.restPositions.size()), std::vector<Vec3f>(mesh.restPositions.size())};
    for (size_t v = 0; v < mesh.restPositions.size(); ++v) {
        const Mat3x4f blended = blendedTransform(mesh.jointIndices[v], mesh.jointWeights[v], worldFromRest.data());
        const Vec3f rest = mesh.restPositions[v] + (offsets.empty() ? Vec3f(0) : offsets[v]);
        out.linear[v] = Mat3f(blended[0], blended[1], blended[2]);
        out.positions[v] = out.linear[v] * rest + blended[3];
    }
    return out;
}

std::vector<double> posedIou(const MeshData& mesh, std::span<const JointData> joints, std::span<const Vec3f> offsets,
                             std::span<const SurfaceView> views, std::span<const Pose> poses, Jobs& jobs) {
    std::vector<double> iou(views.size(), 0);
    jobs.forBlocks(views.size(), [&](size_t i, uint32_t) {
        const PosedView posed = poseVertices(mesh, joints, offsets, poses[i]);
        iou[i] = silhouetteIou(rasteriseMesh(posed.positions, mesh.triangles, views[i].camera), views[i].mask.pixels);
    });
    return iou;
}

/** Pulls of one view, and the translation parallel to its picture that fits its outline best. */
class ViewPulls {
public:
    ViewPulls(const MeshData& mesh, const SurfaceView& view, const PosedView& posed, std::span<const ContourPoint> target,
              std::span<const uint32_t> carrier)
        : mesh_(mesh), view_(view), posed_(posed), image_(rasteriseMesh(posed.positions, mesh.triangles, view.camera)) {
        const uint32_t width = view.camera.widthPx, height = view.camera.heightPx;
        std::vector<uint8_t> inside(image_.triangle.size());
        for (size_t i = 0; i < inside.size(); ++i) inside[i] = image_.triangle[i] != kNoTriangle;
        const auto outline = contourPoints(inside, width, height);
        const double reach = kReachShare * height, turn = kTurnShare * height;
        const auto toTarget = matchContours(outline, target, reach, turn), toMesh = matchContours(target, outline, reach, turn);
        for (size_t i = 0; i < outline.size(); ++i)
            if (toTarget[i] != UINT32_MAX) pull(outline[i], target[toTarget[i]].px - outline[i].px);
        for (size_t i = 0; i < target.size(); ++i)
            if (toMesh[i] != UINT32_MAX) pull(outline[toMesh[i]], target[i].px - outline[toMesh[i]].px);
        for (const SurfaceMark& mark : view.marks) pull(mark, carrier);
    }
    std::vector<Pull> take() { return std::move(pulls_); }
    /** Least squares over the outline: Σ n nᵀ t = Σ n (n·way), at the mean depth of the outline; world, metres. */
    Vec3f translation() const {
        const double determinant = nxx_ * nyy_ - nxy_ * nxy_;
        if (!(count_ > 0) || !(determinant > 1e-3 * count_ * count_)) return Vec3f(0);
        const double x = (nyy_ * rx_ - nxy_ * ry_) / determinant, y = (nxx_ * ry_ - nxy_ * rx_) / determinant, depth = depth_ / count_;
        const Camerad& c = view_.camera;
        return Vec3f(glm::transpose(c.viewFromWorldRotation) * Vec3d(x * depth / c.fx, y * depth / c.fy, 0));
    }

private:
    const MeshData& mesh_;
    const SurfaceView& view_;
    const PosedView& posed_;
    MeshRaster image_;
    std::vector<Pull> pulls_;
    double nxx_ = 0, nxy_ = 0, nyy_ = 0, rx_ = 0, ry_ = 0, depth_ = 0, count_ = 0;

    void pull(const ContourPoint& at, const Vec2d& wayPx) {
        const Vec2d along = glm::dot(wayPx, at.normal) * at.normal;
        const Vec2d way = along + priors::kTangentShare * (wayPx - along);
        const Camerad& c = view_.camera;
        const double depth = image_.depthM[at.inside];
        const double off = glm::dot(wayPx, at.normal);
        nxx_ += at.normal.x * at.normal.x, nxy_ += at.normal.x * at.normal.y, nyy_ += at.normal.y * at.normal.y;
        rx_ += at.normal.x * off, ry_ += at.normal.y * off, depth_ += depth, count_ += 1;
        const Triangle& t = mesh_.triangles[image_.triangle[at.inside]];
        for (int k = 0; k < 3; ++k) pullVertex(t[k], way, depth, 1);  // equal weights suffice: the smoothing is wider than a triangle
    }

    void pull(const SurfaceMark& mark, std::span<const uint32_t> carrier) {
        Vec3f place(0);
        for (const auto& [v, weight] : mark.vertices) place += weight * (posed_.positions[v] + posed_.linear[v] * mark.seenAtM);
        const Camerad& c = view_.camera;
        const Vec3d inView = c.toView(Vec3d(place));
        if (!(inView.z > kHiddenM)) return;
        const Vec2d at = c.pixelOf(inView);
        if (!(at.x >= 0 && at.y >= 0 && at.x < c.widthPx && at.y < c.heightPx)) return;
        const size_t pixel = size_t(at.y) * c.widthPx + size_t(at.x);
        if (image_.triangle[pixel] == kNoTriangle || inView.z > image_.depthM[pixel] + kHiddenM) return;
        const Vec2d way = mark.px - at;
        const double far = glm::length(way) * inView.z / (c.fx * priors::kMarkReachM), trust = 1 / ((1 + far * far) * (1 + far * far));
        for (const auto& [v, weight] : mark.vertices)
            pullVertex(carrier[v], way, inView.z, float(priors::kMarkWeight * trust) * mark.confidence * weight);
    }

    void pullVertex(uint32_t v, const Vec2d& wayPx, double depthM, float weight) {
        const Mat3f& linear = posed_.linear[v];
        if (!(std::abs(glm::determinant(linear)) > 0.05f)) return;  // opposing rotations cancel: not invertible
        const Camerad& c = view_.camera;
        const Vec3d inView(wayPx.x * depthM / c.fx, wayPx.y * depthM / c.fy, 0);
        pulls_.push_back({v, weight, weight * (glm::inverse(linear) * Vec3f(glm::transpose(c.viewFromWorldRotation) * inView))});
    }
};

/** For each vertex the vertex whose offset it takes. In a small separate part that is the nearest vertex of the largest part, otherwise
 *  the vertex itself. */
std::vector<uint32_t> carriers(const MeshData& mesh) {
    const size_t count = mesh.restPositions.size();
    VertexSets parts(count, mesh.triangles);
    const auto& p = mesh.restPositions;
    const MergedVertices merged = mergeVertices(p);
    std::vector<uint32_t> firstAt(merged.count, UINT32_MAX);
    for (uint32_t v = 0; v < count; ++v) {
        uint32_t& first = firstAt[merged.placeOf[v]];
        if (first == UINT32_MAX) first = v;
        parts.join(v, first);
    }
    std::vector<uint32_t> size(count, 0);
    for (uint32_t v = 0; v < count; ++v) ++size[parts.find(v)];
    const uint32_t largest = uint32_t(std::max_element(size.begin(), size.end()) - size.begin());
    std::vector<uint32_t> carrier(count);
    for (uint32_t v = 0; v < count; ++v) {
        carrier[v] = v;
        if (size[parts.find(v)] * 5 >= size[largest] || size[parts.find(v)] == 1)
            continue;  // a large part (a garment) moves by itself; a loose vertex has no triangles
        float nearest = 1e30f;
        for (uint32_t u = 0; u < count; ++u) {
            if (parts.find(u) != largest) continue;
            const Vec3f d = p[u] - p[v];
            if (const float d2 = glm::dot(d, d); d2 < nearest) nearest = d2, carrier[v] = u;
        }
    }
    return carrier;
}

class Fitter {
public:
    Fitter(const MeshData& mesh, std::span<const JointData> joints, std::span<const SurfaceView> views, const SurfaceFitSettings& settings,
           Jobs& jobs)
        : mesh_(mesh),
          joints_(joints),
          views_(views),
          settings_(settings),
          jobs_(jobs),
          offsets_(mesh.restPositions.size(), Vec3f(0)),
          poses_(views.size()),
          sway_(views.size(), Vec3f(0)),
          targets_(views.size()),
          carrier_(carriers(mesh)) {
        for (size_t i = 0; i < views.size(); ++i) poses_[i] = views[i].pose;
    }

    Result<SurfaceFit> run() {
        jobs_.forBlocks(views_.size(), [&](size_t i, uint32_t) {
            const auto& mask = views_[i].mask;
            std::vector<uint8_t> inside(mask.pixels.size());
            for (size_t k = 0; k < inside.size(); ++k) inside[k] = isPerson(mask.pixels[k]);
            targets_[i] = contourPoints(inside, mask.widthPx, mask.heightPx);
        });
        if (std::all_of(targets_.begin(), targets_.end(), [](const auto& t) { return t.empty(); }))
            return fail(Code::CorruptData, "no mask of the still pictures shows a person; check the masks");
        SurfaceFit fit;
        DPL_TRY(fit.iouBefore, surfaceIou(mesh_, joints_, {}, views_, jobs_));
        const uint32_t total = settings_.levels * settings_.roundsPerLevel;
        for (uint32_t level = 0; level < settings_.levels; ++level) {
            const double t = settings_.levels > 1 ? double(level) / (settings_.levels - 1) : 1;
            const double length = settings_.startSmoothingM * std::pow(settings_.endSmoothingM / settings_.startSmoothingM, t);
            DPL_TRY(const LargeSteps smooth, LargeSteps::create(mesh_.restPositions, mesh_.triangles, length));
            for (uint32_t round = 0; round < settings_.roundsPerLevel; ++round, ++fit.rounds) {
                DPL_RETURN_IF_ERROR(taskAt(double(fit.rounds) / total, formatText("{} silhouettes", views_.size())));
                step(smooth, settings_.maxSwayM > 0 && 2 * level >= settings_.levels);
            }
        }
        fit.iouAfter = posedIou(mesh_, joints_, offsets_, views_, poses_, jobs_);
        fit.viewTranslationsM = sway_;
        const auto mean = [](const std::vector<double>& v) { return std::accumulate(v.begin(), v.end(), 0.0) / double(v.size()); };
        fit.meanIouBefore = mean(fit.iouBefore), fit.meanIouAfter = mean(fit.iouAfter);
        for (const Vec3f& o : offsets_) {
            if (!std::isfinite(o.x + o.y + o.z)) return fail(Code::Internal, "the surface fit diverged; report this scan");
            fit.meanOffsetM += glm::length(o) / double(offsets_.size());
            fit.largestOffsetM = std::max(fit.largestOffsetM, double(glm::length(o)));
        }
        fit.restOffsets = std::move(offsets_);
        return fit;
    }

private:
    const MeshData& mesh_;
    std::span<const JointData> joints_;
    std::span<const SurfaceView> views_;
    const SurfaceFitSettings& settings_;
    Jobs& jobs_;
    std::vector<Vec3f> offsets_;
    std::vector<Pose> poses_;  // poses of the views, with sway_ added
    std::vector<Vec3f> sway_;
    std::vector<std::vector<ContourPoint>> targets_;
    std::vector<uint32_t> carrier_;

    void step(const LargeSteps& smooth, bool moveViews) {
        const size_t count = mesh_.restPositions.size();
        std::vector<std::vector<Pull>> pulls(views_.size());
        std::vector<Vec3f> translations(views_.size(), Vec3f(0));
        jobs_.forBlocks(views_.size(), [&](size_t i, uint32_t) {
            if (targets_[i].empty()) return;
            const PosedView posed = poseVertices(mesh_, joints_, offsets_, poses_[i]);
            ViewPulls view(mesh_, views_[i], posed, targets_[i], carrier_);
            translations[i] = view.translation();
            pulls[i] = view.take();
        });
        if (moveViews) addSway(translations);
        std::vector<Vec3f> sum(count, Vec3f(0)), weight(count, Vec3f(0)), spreadSum(count), spreadWeight(count), u(smooth.size());
        for (const auto& list : pulls)  // in the order of the views, so that sums do not depend on threads
            for (const Pull& p : list) sum[p.vertex] += p.weighted, weight[p.vertex].x += p.weight;
        smooth.backward(sum, u, 0);
        smooth.offsets(u, spreadSum, 0);
        smooth.backward(weight, u, 0);
        smooth.offsets(u, spreadWeight, 0);
        double meanWeight = 0;
        for (const Vec3f& w : spreadWeight) meanWeight += w.x / double(count);
        const float epsilon = float(0.02 * meanWeight) + 1e-12f;  // keeps vertices at rest where no pull is near
        std::vector<Vec3f> next(offsets_);
        for (size_t v = 0; v < count; ++v) {
            Vec3f move = float(kStep) * spreadSum[v] / (std::max(0.0f, spreadWeight[v].x) + epsilon);
            if (const float length = glm::length(move); length > settings_.maxStepM) move *= float(settings_.maxStepM) / length;
            next[v] += move;
        }
        relax(next);
        for (size_t v = 0; v < count; ++v) {
            if (carrier_[v] != v) next[v] = next[carrier_[v]];
            if (const float length = glm::length(next[v]); length > settings_.maxOffsetM) next[v] *= float(settings_.maxOffsetM) / length;
        }
        offsets_ = std::move(next);
    }

    /** Adds half of each view's translation per round, minus the mean over the views, which belongs to the shape. */
    void addSway(std::span<const Vec3f> translations) {
        Vec3f mean(0);
        for (size_t i = 0; i < sway_.size(); ++i) {
            sway_[i] += 0.5f * translations[i];
            if (const float length = glm::length(sway_[i]); length > settings_.maxSwayM) sway_[i] *= float(settings_.maxSwayM) / length;
            mean += sway_[i] / float(sway_.size());
        }
        for (size_t i = 0; i < sway_.size(); ++i) {
            sway_[i] -= mean;
            poses_[i].rootTranslation = views_[i].pose.rootTranslation + sway_[i];
        }
    }

    /** Moves each offset slightly towards the mean of its neighbours, so that triangles do not fold where pulls disagree. */
    void relax(std::vector<Vec3f>& offsets) const {
        std::vector<Vec3f> sum(offsets.size(), Vec3f(0));
        std::vector<float> count(offsets.size(), 0);
        for (const Triangle& t : mesh_.triangles)
            for (int k = 0; k < 3; ++k) {
                sum[t[k]] += offsets[t[(k + 1) % 3]] + offsets[t[(k + 2) % 3]];
                count[t[k]] += 2;
            }
        for (size_t v = 0; v < offsets.size(); ++v)
            if (count[v] > 0) offsets[v] += float(kRelax) * (sum[v] / count[v] - offsets[v]);
    }
};

}  // namespace

Result<std::vector<double>> surfaceIou(const MeshData& mesh, std::span<const JointData> joints, std::span<const Vec3f> restOffsets,
                                       std::span<const SurfaceView> views, Jobs& jobs) {
    DPL_RETURN_IF_ERROR(checkInput(mesh, joints, restOffsets, views));
    std::vector<Pose> poses;
    for (const auto& view : views) poses.push_back(view.pose);
    return posedIou(mesh, joints, restOffsets, views, poses, jobs);
}

Result<SurfaceFit> fitSurface(const MeshData& mesh, std::span<const JointData> joints, std::span<const SurfaceView> views,
                              const SurfaceFitSettings& settings, Jobs& jobs) {
    if (views.empty()) return fail(Code::InvalidArgument, "the surface fit needs at least one still picture with a mask");
    const bool sane = settings.levels > 0 && settings.roundsPerLevel > 0 && settings.endSmoothingM > 0 &&
                      settings.startSmoothingM >= settings.endSmoothingM && settings.maxOffsetM > 0 && settings.maxStepM > 0 &&
                      settings.maxSwayM >= 0;
    if (!sane)
        return fail(Code::InvalidArgument,
                    "surface fit settings: levels, rounds and lengths must be above 0, and the first smoothing the longest");
    DPL_RETURN_IF_ERROR(checkInput(mesh, joints, {}, views));
    return Fitter(mesh, joints, views, settings, jobs).run();
}

}  // namespace dpl
