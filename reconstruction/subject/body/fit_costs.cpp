// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/subject/body/fit_costs.h"

#include <ceres/autodiff_cost_function.h>
#include <ceres/rotation.h>

#include <algorithm>
#include <cmath>

#include "reconstruction/subject/body/priors.h"

namespace dpl {
namespace {

constexpr double kMinDepthM = 0.05;      // keypoints nearer to the camera are ignored
constexpr double kRangeSigmaRad = 0.03;  // σ of the part beyond a joint's range
constexpr double kMorphWallSigma = 0.1;  // σ of the part beyond a morph's range, in morph values

/** The residual whose square is Cauchy's cost log(1 + r²). */
template <class T>
T cauchy(const T& r) {
    using std::log, std::sqrt;
    const T s = r * r;
    if (s < 1e-8) return r;
    const T size = sqrt(log(s + 1.0));
    return r < 0.0 ? -size : size;
}
double cauchySlope(double r) {
    const double s = r * r;
    return s < 1e-8 ? 1.0 : std::abs(r) / (std::sqrt(std::log1p(s)) * (1 + s));
}

struct RootSmoothness {
    Mat3d reference[3];
    Vec3d up;
    double before, after, mean;  // seconds
    AccelerationSpread spread;

    template <class T>
    void worldRotation(const T* root, int i, T* columnMajor) const {
        T turn[9];
        ceres::AngleAxisToRotationMatrix(root, turn);
        for (int c = 0; c < 3; ++c)
            for (int r = 0; r < 3; ++r)
                columnMajor[3 * c + r] = turn[r] * reference[i][c][0] + turn[3 + r] * reference[i][c][1] + turn[6 + r] * reference[i][c][2];
    }
    template <class T>
    static void relative(const T* to, const T* from, T* angleAxis) {  // log(to · fromᵀ)
        T product[9];
        for (int c = 0; c < 3; ++c)
            for (int r = 0; r < 3; ++r) product[3 * c + r] = to[r] * from[c] + to[3 + r] * from[3 + c] + to[6 + r] * from[6 + c];
        ceres::RotationMatrixToAngleAxis(product, angleAxis);
    }
    template <class T>
    bool operator()(const T* a, const T* b, const T* c, T* residual) const {
        T rotation[3][9], first[3], second[3];
        worldRotation(a, 0, rotation[0]);
        worldRotation(b, 1, rotation[1]);
        worldRotation(c, 2, rotation[2]);
        relative(rotation[1], rotation[0], first);
        relative(rotation[2], rotation[1], second);
        T turn[3];
        for (int i = 0; i < 3; ++i) turn[i] = (second[i] / after - first[i] / before) / mean;
        const T aboutUp = turn[0] * up.x + turn[1] * up.y + turn[2] * up.z;
        for (int i = 0; i < 3; ++i) {
            residual[i] = (turn[i] - aboutUp * up[i]) / priors::kTiltAccelerationRadS2 + aboutUp * up[i] / priors::kTurnAccelerationRadS2;
            residual[3 + i] = ((c[3 + i] - b[3 + i]) / after - (b[3 + i] - a[3 + i]) / before) / (mean * priors::kRootAccelerationMS2);
        }
        for (int i = 0; i < 6 && spread.tail; ++i) residual[i] = cauchy(T(residual[i] / spread.share));
        return true;
    }
};

}  // namespace

ceres::Solver::Options solverOptions(int maxSteps) {
    ceres::Solver::Options options;
    options.num_threads = 1;
    options.max_num_iterations = maxSteps;
    options.function_tolerance = 1e-6;  // relative change of the cost; later steps gain far less than the keypoint noise
    options.logging_type = ceres::SILENT;
    options.linear_solver_type = ceres::SPARSE_NORMAL_CHOLESKY;
    if (ceres::IsSparseLinearAlgebraLibraryTypeAvailable(ceres::EIGEN_SPARSE))
        options.sparse_linear_algebra_library_type = ceres::EIGEN_SPARSE;  // a BLAS backend would start threads
    return options;
}

std::vector<double> poseOfBlocks(double const* const* blocks, size_t joints) {
    std::vector<double> pose;
    pose.reserve(3 * joints);
    for (size_t j = 0; j < joints; ++j) pose.insert(pose.end(), blocks[j], blocks[j] + 3);
    return pose;
}

void setPoseRow(double* const* jacobians, size_t row, const double* columns, size_t joints) {
    for (size_t j = 0; j < joints; ++j)
        if (jacobians[j]) std::copy_n(columns + 3 * j, 3, jacobians[j] + 3 * row);
}

void holdPose(ceres::Problem& problem, std::vector<double>& pose) {
    for (size_t at = 0; at < pose.size(); at += 3)
        if (problem.HasParameterBlock(&pose[at])) problem.SetParameterBlockConstant(&pose[at]);
}

ReprojectionCost::ReprojectionCost(const FitContext& context, const Camerad& camera, const Mat3d& rootReference,
                                   const std::vector<Keypoint>& keypoints, double sigmaPx, bool withSway)
    : context_(context), camera_(camera), rootReference_(rootReference), keypoints_(keypoints), sigmaPx_(sigmaPx), withSway_(withSway) {
    for (size_t k = 0; k < keypoints_.size(); ++k)
        if (keypoints_[k].confidence > 0 && context.chain->hasKeypoint(k)) seen_.push_back(k);
    set_num_residuals(int(2 * seen_.size()));
    auto& sizes = *mutable_parameter_block_sizes();
    sizes = {int(context.chain->shapeCount()), 1, kRootSize};
    addPoseBlockSizes(sizes, context.chain->posedCount());
    if (withSway) sizes.push_back(context.sway.size());
}

bool ReprojectionCost::Evaluate(double const* const* blocks, double* residuals, double** jacobians) const {
    const KeypointChain& chain = *context_.chain;
    const size_t joints = chain.posedCount(), shapes = chain.shapeCount(), width = chain.columns();
    double root[kRootSize];
    std::copy(blocks[2], blocks[2] + kRootSize, root);
    std::vector<double> pose = poseOfBlocks(blocks + 3, joints);
    if (withSway_) {
        const double* sway = blocks[3 + joints];
        for (int i = 0; i < kRootSize; ++i) root[i] += sway[i];
        for (size_t s = 0; s < context_.sway.slots.size(); ++s)
            for (int i = 0; i < 3; ++i) pose[3 * context_.sway.slots[s] + size_t(i)] += sway[kRootSize + 3 * int(s) + i];
    }
    thread_local KeypointChain::Output posed;
    chain.evaluate(rootReference_, root, pose.data(), blocks[0], jacobians != nullptr, posed);
    const double unit = std::exp(blocks[1][0]);
    const Mat3d& R = camera_.viewFromWorldRotation;
    const Vec3d shift = unit * camera_.viewFromWorldTranslation;
    const double c2 = context_.outlierSigmas * context_.outlierSigmas;
    std::vector<double> row(width + 1);  // root, pose, shape, log unit
    for (size_t i = 0; i < seen_.size(); ++i) {
        const Keypoint& k = keypoints_[seen_[i]];
        const Vec3d view = R * posed.points[seen_[i]] + shift;
        const bool inFront = view.z > kMinDepthM;
        const double z = inFront ? view.z : kMinDepthM;
        const double inverseSigma = k.confidence / sigmaPx_;
        const Vec2d r = inFront ? inverseSigma * (camera_.pixelOf(Vec3d(view.x, view.y, z)) - k.px) : Vec2d(1e3);
        const double s = glm::dot(r, r), scale = std::sqrt(c2 / (s + c2));
        residuals[2 * i] = scale * r.x;
        residuals[2 * i + 1] = scale * r.y;
        if (!jacobians) continue;
        // d(scale·r) = scale (I − r rᵀ/(s+c²)) dr
        const double g = inFront ? scale : 0.0;
        const double m[2][2] = {{g * (1 - r.x * r.x / (s + c2)), -g * r.x * r.y / (s + c2)},
                                {-g * r.x * r.y / (s + c2), g * (1 - r.y * r.y / (s + c2))}};
        const Vec3d du = inverseSigma * camera_.fx / z * Vec3d(1, 0, -view.x / z),
                    dv = inverseSigma * camera_.fy / z * Vec3d(0, 1, -view.y / z);
        const Mat3d Rt = glm::transpose(R);
        const double* chainRows = &posed.jacobian[seen_[i] * 3 * width];
        for (int a = 0; a < 2; ++a) {
            const Vec3d dView = m[a][0] * du + m[a][1] * dv, dWorld = Rt * dView;
            for (size_t c = 0; c < width; ++c)
                row[c] = dWorld.x * chainRows[c] + dWorld.y * chainRows[width + c] + dWorld.z * chainRows[2 * width + c];
            const size_t line = 2 * i + size_t(a);
            if (jacobians[0]) std::copy_n(&row[kRootSize + 3 * joints], shapes, jacobians[0] + line * shapes);
            if (jacobians[1]) jacobians[1][line] = glm::dot(dView, shift);
            if (jacobians[2]) std::copy_n(&row[0], kRootSize, jacobians[2] + line * kRootSize);
            setPoseRow(jacobians + 3, line, &row[kRootSize], joints);
            if (withSway_ && jacobians[3 + joints]) {
                double* out = jacobians[3 + joints] + line * size_t(context_.sway.size());
                std::copy_n(&row[0], kRootSize, out);
                for (size_t slot = 0; slot < context_.sway.slots.size(); ++slot)
                    std::copy_n(&row[kRootSize + 3 * context_.sway.slots[slot]], 3, out + kRootSize + 3 * slot);
            }
        }
    }
    return true;
}

JointPriorCost::JointPriorCost(const JointPrior& prior, const Vec3d& mean) : prior_(prior), mean_(mean) {}

bool JointPriorCost::Evaluate(double const* const* blocks, double* residuals, double** jacobians) const {
    const JointPrior& p = prior_;
    const Vec3d w(blocks[0][0], blocks[0][1], blocks[0][2]);
    for (int a = 0; a < 3; ++a) {
        const double angle = glm::dot(p.axes[a], w);
        const double beyond = angle < p.lowRad[a] ? angle - p.lowRad[a] : angle > p.highRad[a] ? angle - p.highRad[a] : 0.0;
        const double r = (angle - glm::dot(p.axes[a], mean_)) / p.sigmaRad[a];
        const double c2 = p.tailSigmas[a] * p.tailSigmas[a],
                     scale = c2 > 0 ? std::sqrt(c2 / (r * r + c2)) : 1.0;  // ρ as in ReprojectionCost
        const double slope = c2 > 0 ? scale * c2 / (r * r + c2) : 1.0;
        residuals[a] = scale * r;
        residuals[3 + a] = beyond / kRangeSigmaRad;
        if (!jacobians || !jacobians[0]) continue;
        for (int i = 0; i < 3; ++i) {
            jacobians[0][3 * a + i] = slope * p.axes[a][i] / p.sigmaRad[a];
            jacobians[0][3 * (3 + a) + i] = beyond != 0 ? p.axes[a][i] / kRangeSigmaRad : 0.0;
        }
    }
    return true;
}

void addPosePrior(ceres::Problem& problem, const std::vector<JointPrior>& priors, const std::vector<double>& mean, double* pose) {
    for (size_t j = 0; j < priors.size(); ++j)
        problem.AddResidualBlock(new JointPriorCost(priors[j], {mean[3 * j], mean[3 * j + 1], mean[3 * j + 2]}), nullptr, pose + 3 * j);
}

DiagonalPrior::DiagonalPrior(std::vector<double> mean, std::vector<double> sigma) : mean_(std::move(mean)), sigma_(std::move(sigma)) {
    set_num_residuals(int(mean_.size()));
    mutable_parameter_block_sizes()->push_back(int(mean_.size()));
}

bool DiagonalPrior::Evaluate(double const* const* blocks, double* residuals, double** jacobians) const {
    const size_t n = mean_.size();
    if (jacobians && jacobians[0]) std::fill_n(jacobians[0], n * n, 0.0);
    for (size_t i = 0; i < n; ++i) {
        residuals[i] = (blocks[0][i] - mean_[i]) / sigma_[i];
        if (jacobians && jacobians[0]) jacobians[0][i * n + i] = 1 / sigma_[i];
    }
    return true;
}

void addDiagonalPosePrior(ceres::Problem& problem, const std::vector<double>& mean, const std::vector<double>& sigma, double* pose) {
    const auto three = [](const std::vector<double>& values, size_t at) {
        return std::vector<double>(values.begin() + ptrdiff_t(at), values.begin() + ptrdiff_t(at) + 3);
    };
    for (size_t at = 0; at < mean.size(); at += 3)
        problem.AddResidualBlock(new DiagonalPrior(three(mean, at), three(sigma, at)), nullptr, pose + at);
}

ShapePrior::ShapePrior(const std::vector<ShapeMorph>& morphs) {
    for (const ShapeMorph& m : morphs) low_.push_back(m.minValue), high_.push_back(m.maxValue);
    set_num_residuals(int(2 * morphs.size()));
    mutable_parameter_block_sizes()->push_back(int(morphs.size()));
}

bool ShapePrior::Evaluate(double const* const* blocks, double* residuals, double** jacobians) const {
    const size_t n = low_.size();
    if (jacobians && jacobians[0]) std::fill_n(jacobians[0], 2 * n * n, 0.0);
    for (size_t i = 0; i < n; ++i) {
        const double x = blocks[0][i], beyond = x < low_[i] ? x - low_[i] : x > high_[i] ? x - high_[i] : 0.0;
        residuals[2 * i] = x;
        residuals[2 * i + 1] = beyond / kMorphWallSigma;
        if (!jacobians || !jacobians[0]) continue;
        jacobians[0][2 * i * n + i] = 1;
        jacobians[0][(2 * i + 1) * n + i] = beyond != 0 ? 1 / kMorphWallSigma : 0.0;
    }
    return true;
}

JointSmoothness::JointSmoothness(const JointPrior& prior, double t0, double t1, double t2, AccelerationSpread spread)
    : accelerationRadS2_(prior.accelerationRadS2), spread_(spread) {
    const double before = t1 - t0, after = t2 - t1, mean = 0.5 * (before + after);
    weight_[0] = 1 / (before * mean);
    weight_[1] = -(1 / before + 1 / after) / mean;
    weight_[2] = 1 / (after * mean);
}

bool JointSmoothness::Evaluate(double const* const* blocks, double* residuals, double** jacobians) const {
    const double scale = 1 / (accelerationRadS2_ * spread_.share);
    for (int i = 0; i < 3; ++i) {
        const double r = (weight_[0] * blocks[0][i] + weight_[1] * blocks[1][i] + weight_[2] * blocks[2][i]) * scale;
        residuals[i] = spread_.tail ? cauchy(r) : r;
        const double slope = scale * (spread_.tail ? cauchySlope(r) : 1.0);
        for (int b = 0; jacobians && b < 3; ++b) {
            if (!jacobians[b]) continue;
            std::fill_n(jacobians[b] + 3 * i, 3, 0.0);
            jacobians[b][3 * i + i] = weight_[b] * slope;
        }
    }
    return true;
}

ceres::CostFunction* makeRootSmoothness(const Mat3d (&references)[3], const Vec3d& up, double t0, double t1, double t2,
                                        AccelerationSpread spread) {
    return new ceres::AutoDiffCostFunction<RootSmoothness, 6, kRootSize, kRootSize, kRootSize>(
        new RootSmoothness{{references[0], references[1], references[2]}, up, t1 - t0, t2 - t1, 0.5 * (t2 - t0), spread});
}

namespace {
struct RootUpright {
    Mat3d reference;
    Vec3d bodyUp, up;
    template <class T>
    bool operator()(const T* root, T* residual) const {
        const Vec3d b = reference * bodyUp;
        const T before[3] = {T(b.x), T(b.y), T(b.z)};
        T after[3];
        ceres::AngleAxisRotatePoint(root, before, after);
        for (int i = 0; i < 3; ++i) residual[i] = (after[i] - up[i]) / priors::kTiltRad;
        return true;
    }
};
}  // namespace

ceres::CostFunction* makeRootUpright(const Mat3d& reference, const Vec3d& bodyUp, const Vec3d& up) {
    return new ceres::AutoDiffCostFunction<RootUpright, 3, kRootSize>(new RootUpright{reference, bodyUp, up});
}

FootRest::FootRest(const FitContext& context, std::vector<size_t> keypoints, const Mat3d& reference0, const Mat3d& reference1,
                   double sigmaM)
    : context_(context), keypoints_(std::move(keypoints)), reference_{reference0, reference1}, sigmaM_(sigmaM) {
    set_num_residuals(int(3 * keypoints_.size()));
    auto& sizes = *mutable_parameter_block_sizes();
    sizes.push_back(int(context.chain->shapeCount()));
    for (int frame = 0; frame < 2; ++frame) {
        sizes.push_back(kRootSize);
        addPoseBlockSizes(sizes, context.chain->posedCount());
    }
}

bool FootRest::Evaluate(double const* const* blocks, double* residuals, double** jacobians) const {
    const KeypointChain& chain = *context_.chain;
    const size_t joints = chain.posedCount(), shapes = chain.shapeCount(), width = chain.columns();
    const size_t rootBlock[2] = {1, 2 + joints};  // those of the pose follow
    thread_local KeypointChain::Output posed[2];
    for (int i = 0; i < 2; ++i)
        chain.evaluate(reference_[i], blocks[rootBlock[i]], poseOfBlocks(blocks + rootBlock[i] + 1, joints).data(), blocks[0],
                       jacobians != nullptr, posed[i]);
    std::vector<double> row(3 * joints);
    const double c2 = priors::kFootOutlierSigmas * priors::kFootOutlierSigmas, sigmaM = sigmaM_ * context_.footSigmaScale;
    for (size_t n = 0; n < keypoints_.size(); ++n) {
        const size_t k = keypoints_[n];
        const Vec3d r = (posed[1].points[k] - posed[0].points[k]) / sigmaM;
        const double s = glm::dot(r, r), scale = std::sqrt(c2 / (s + c2));
        for (int a = 0; a < 3; ++a) residuals[3 * n + size_t(a)] = scale * r[a];
        if (!jacobians) continue;
        const Mat3d m = scale / sigmaM * (Mat3d(1.0) - glm::outerProduct(r, r) / (s + c2));  // symmetric
        for (int a = 0; a < 3; ++a) {
            const size_t line = 3 * n + size_t(a);
            const auto entry = [&](int frame, size_t column) {
                const double* rows = &posed[frame].jacobian[k * 3 * width + column];
                return m[a].x * rows[0] + m[a].y * rows[width] + m[a].z * rows[2 * width];
            };
            if (jacobians[0])
                for (size_t c = 0; c < shapes; ++c)
                    jacobians[0][line * shapes + c] = entry(1, kRootSize + 3 * joints + c) - entry(0, kRootSize + 3 * joints + c);
            for (int i = 0; i < 2; ++i) {
                const double sign = i == 0 ? -1 : 1;
                if (double* root = jacobians[rootBlock[i]])
                    for (size_t c = 0; c < kRootSize; ++c) root[line * kRootSize + c] = sign * entry(i, c);
                for (size_t c = 0; c < row.size(); ++c) row[c] = sign * entry(i, kRootSize + c);
                setPoseRow(jacobians + rootBlock[i] + 1, line, row.data(), joints);
            }
        }
    }
    return true;
}

}  // namespace dpl
