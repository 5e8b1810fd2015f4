// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/input/cameras/bundle.h"

#include <ceres/autodiff_cost_function.h>
#include <ceres/loss_function.h>
#include <ceres/manifold.h>
#include <ceres/problem.h>
#include <ceres/solver.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "reconstruction/input/cameras/bundle_cost.h"
#include "sdk/core/percentile.h"
#include "sdk/core/task.h"

namespace dpl {
namespace {

constexpr size_t kFewestObservations = 10;
constexpr double kOutlierMedians = 6;  // an observation is only left out when it misses by more than this many medians
constexpr double kMinDepth = 1e-6;     // world units, in front of the camera

bool finite(const Vec3d& v) {
    return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}

/** The scene as blocks of numbers that Ceres changes. */
struct Blocks {
    std::vector<std::array<double, 4>> rotations;  // xyzw
    std::vector<std::array<double, 3>> translations, points;
    std::array<double, 2> lens{};  // ln of the focal factor, k1

    explicit Blocks(const BundleScene& scene) : lens{0, scene.lens.k1} {
        for (const Camerad& camera : scene.cameras) {
            const Quatd q = glm::quat_cast(camera.viewFromWorldRotation);
            const Vec3d& t = camera.viewFromWorldTranslation;
            rotations.push_back({q.x, q.y, q.z, q.w}), translations.push_back({t.x, t.y, t.z});
        }
        for (const Vec3d& p : scene.points) points.push_back({p.x, p.y, p.z});
    }
    void store(BundleScene& scene) const {
        for (size_t c = 0; c < scene.cameras.size(); ++c) {
            Camerad& camera = scene.cameras[c];
            const auto& q = rotations[c];
            camera.viewFromWorldRotation = glm::mat3_cast(glm::normalize(Quatd(q[3], q[0], q[1], q[2])));
            camera.viewFromWorldTranslation = {translations[c][0], translations[c][1], translations[c][2]};
            camera.fx *= std::exp(lens[0]), camera.fy *= std::exp(lens[0]);
        }
        for (size_t p = 0; p < scene.points.size(); ++p) scene.points[p] = {points[p][0], points[p][1], points[p][2]};
        scene.lens.k1 = lens[1];
    }
};

class Adjuster {
public:
    Adjuster(BundleScene& scene, const BundleSettings& settings) : scene_(scene), settings_(settings) {}

    Result<BundleEnd> run() {
        DPL_RETURN_IF_ERROR(check());
        BundleScene found = scene_;
        std::vector<double> misses = measure(found);
        counts_.resize(misses.size());
        for (size_t i = 0; i < misses.size(); ++i) counts_[i] = std::isfinite(misses[i]);
        dropLonelyPoints(found);
        if (size_t(std::count(counts_.begin(), counts_.end(), true)) < kFewestObservations)
            return fail(Code::InvalidArgument, "too few matches between the pictures: fewer than {} points lie in front of their cameras",
                        kFewestObservations);
        BundleEnd end;
        end.missBeforePx = middle(misses);
        const double focalBefore = found.cameras[0].fx;
        for (uint32_t round = 0; round < std::max(1u, settings_.rounds); ++round) {
            DPL_TRY(end.how, solve(found));
            misses = measure(found);
            const double limit = std::max(settings_.outlierPx, kOutlierMedians * middle(misses));
            for (size_t i = 0; i < misses.size(); ++i) counts_[i] = misses[i] <= limit;
            dropLonelyPoints(found);
        }
        end.missAfterPx = middle(misses);
        end.focalFactor = found.cameras[0].fx / focalBefore;
        end.seen.assign(found.cameras.size(), 0);
        for (size_t i = 0; i < misses.size(); ++i)
            if (counts_[i]) ++end.used, ++end.seen[found.observations[i].camera];
        scene_ = std::move(found);
        return end;
    }

private:
    BundleScene& scene_;
    const BundleSettings& settings_;
    std::vector<bool> counts_;  // which observations count

    Status check() const {
        if (scene_.cameras.empty()) return fail(Code::InvalidArgument, "no camera to adjust");
        if (!settings_.fixed.empty() && settings_.fixed.size() != scene_.cameras.size())
            return fail(Code::InvalidArgument, "{} flags for {} cameras", settings_.fixed.size(), scene_.cameras.size());
        for (const BundleObservation& o : scene_.observations)
            if (o.camera >= scene_.cameras.size() || o.point >= scene_.points.size() || !std::isfinite(o.px.x) || !std::isfinite(o.px.y))
                return fail(Code::InvalidArgument, "an observation names camera {} and point {}; there are {} and {}", o.camera, o.point,
                            scene_.cameras.size(), scene_.points.size());
        for (const Vec3d& p : scene_.points)
            if (!finite(p)) return fail(Code::InvalidArgument, "a point is not finite");
        for (const Camerad& c : scene_.cameras)
            if (!finite(c.viewFromWorldTranslation) || !(c.fx > 0) || !(c.fy > 0))
                return fail(Code::InvalidArgument, "a camera is not finite");
        return {};
    }

    /** Leaves out points that one picture shows: their depth is open. */
    void dropLonelyPoints(const BundleScene& scene) {
        if (settings_.fixedPoints) return;
        std::vector<uint32_t> views(scene.points.size(), 0);
        for (size_t i = 0; i < counts_.size(); ++i) views[scene.observations[i].point] += counts_[i];
        for (size_t i = 0; i < counts_.size(); ++i) counts_[i] = counts_[i] && views[scene.observations[i].point] >= 2;
    }

    /** The miss of each observation, px; infinite behind the camera. */
    static std::vector<double> measure(const BundleScene& scene) {
        std::vector<double> misses;
        for (const BundleObservation& o : scene.observations) {
            const Camerad& camera = scene.cameras[o.camera];
            const bool front = camera.toView(scene.points[o.point]).z > kMinDepth;
            misses.push_back(front ? glm::length(storedPixel(camera, scene.lens, scene.points[o.point]) - o.px) : INFINITY);
        }
        return misses;
    }

    double middle(const std::vector<double>& misses) const {
        std::vector<double> counted;
        for (size_t i = 0; i < misses.size(); ++i)
            if (counts_[i] && std::isfinite(misses[i])) counted.push_back(misses[i]);
        return percentile(std::move(counted), 0.5);
    }

    Result<std::string> solve(BundleScene& scene) const {
        Blocks blocks(scene);
        ceres::Problem::Options owners;
        owners.loss_function_ownership = owners.manifold_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
        ceres::CauchyLoss loss(settings_.lossPx);
        ceres::EigenQuaternionManifold unit;
        std::vector<int> onlyFocal{1}, onlyLens{0};
        ceres::SubsetManifold holdK1(2, onlyFocal), holdFocal(2, onlyLens);
        ceres::Problem problem(owners);
        for (size_t i = 0; i < scene.observations.size(); ++i) {
            if (!counts_[i]) continue;
            const BundleObservation& o = scene.observations[i];
            const Camerad& c = scene.cameras[o.camera];
            auto* cost = new ceres::AutoDiffCostFunction<ReprojectionMiss, 2, 4, 3, 2, 3>(
                new ReprojectionMiss{c.fx, c.fy, c.cx, c.cy, scene.lens.k2, o.px.x, o.px.y});
            problem.AddResidualBlock(cost, &loss, blocks.rotations[o.camera].data(), blocks.translations[o.camera].data(),
                                     blocks.lens.data(), blocks.points[o.point].data());
        }
        for (size_t c = 0; c < scene.cameras.size(); ++c) {
            double *rotation = blocks.rotations[c].data(), *translation = blocks.translations[c].data();
            if (!problem.HasParameterBlock(rotation)) continue;
            problem.SetManifold(rotation, &unit);
            // Without a fixed camera the world could drift as a whole, which makes the equations singular. So the first stays.
            const bool holds = settings_.fixed.empty() ? c == 0 && !settings_.fixedPoints : settings_.fixed[c];
            if (!holds) continue;
            problem.SetParameterBlockConstant(rotation), problem.SetParameterBlockConstant(translation);
        }
        if (settings_.fixedPoints)
            for (auto& point : blocks.points)
                if (problem.HasParameterBlock(point.data())) problem.SetParameterBlockConstant(point.data());
        if (!settings_.findFocal && !settings_.findLens)
            problem.SetParameterBlockConstant(blocks.lens.data());
        else if (!settings_.findLens)
            problem.SetManifold(blocks.lens.data(), &holdK1);
        else if (!settings_.findFocal)
            problem.SetManifold(blocks.lens.data(), &holdFocal);

        ceres::Solver::Options options;
        options.linear_solver_type = settings_.fixedPoints ? ceres::DENSE_QR : ceres::DENSE_SCHUR;
        options.max_num_iterations = int(settings_.stepsPerRound);
        options.num_threads = 1;  // the same result on every machine
        options.logging_type = ceres::SILENT;
        Cancel cancel;
        options.callbacks.push_back(&cancel);
        ceres::Solver::Summary summary;
        ceres::Solve(options, &problem, &summary);
        DPL_RETURN_IF_ERROR(cancel.goesOn);
        if (!summary.IsSolutionUsable()) return fail(Code::Internal, "the bundle adjustment failed: {}", summary.message);
        blocks.store(scene);
        return summary.message;
    }

    struct Cancel : ceres::IterationCallback {
        Status goesOn;
        ceres::CallbackReturnType operator()(const ceres::IterationSummary&) override {
            goesOn = taskAt(0);
            return goesOn ? ceres::SOLVER_CONTINUE : ceres::SOLVER_ABORT;
        }
    };
};

}  // namespace

Vec2d storedPixel(const Camerad& camera, const LensDistortion& lens, const Vec3d& world) {
    const Vec3d view = camera.toView(world);
    const double x = view.x / view.z, y = view.y / view.z, r2 = x * x + y * y;
    const double scale = 1 + lens.k1 * r2 + lens.k2 * r2 * r2;
    return {camera.fx * scale * x + camera.cx, camera.fy * scale * y + camera.cy};
}

Result<BundleEnd> adjustBundle(BundleScene& scene, const BundleSettings& settings) {
    return Adjuster(scene, settings).run();
}

}  // namespace dpl
