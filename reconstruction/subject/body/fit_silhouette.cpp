// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/subject/body/fit_silhouette.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "reconstruction/subject/body/priors.h"

namespace dpl {
namespace {

constexpr double kGrazing = 0.25;       // largest |cos| between normal and line of sight of an outline sample
constexpr double kSameDirection = 0.7;  // least cosine between a sample's image normal and the mask's outward direction

}  // namespace

double MaskDistance::sample(const Vec2d& cameraPx, Vec2d& gradient) const {
    const double x = std::clamp(cameraPx.x * maskPerCameraPx - 0.5, 0.0, double(widthPx) - 1.001),
                 y = std::clamp(cameraPx.y * maskPerCameraPx - 0.5, 0.0, double(heightPx) - 1.001);
    const size_t ix = size_t(x), iy = size_t(y);
    const double fx = x - double(ix), fy = y - double(iy);
    const float* row = &distancePx[iy * widthPx + ix];
    const double a = row[0], b = row[1], c = row[widthPx], d = row[widthPx + 1];
    gradient = {(1 - fy) * (b - a) + fy * (d - c),
                (1 - fx) * (c - a) + fx * (d - b)};  // mask px per mask px, which equals camera px per camera px
    return ((1 - fy) * ((1 - fx) * a + fx * b) + fy * ((1 - fx) * c + fx * d)) / maskPerCameraPx;
}

Result<MaskDistance> maskDistance(const ImageGrey8& image, uint32_t maxSidePx) {
    if (image.widthPx < 2 || image.heightPx < 2)
        return fail(Code::CorruptData, "a mask of {} × {} pixels is too small", image.widthPx, image.heightPx);
    cv::Mat mask(int(image.heightPx), int(image.widthPx), CV_8UC1, const_cast<uint8_t*>(image.pixels.data()));
    const double scale = std::min(1.0, double(maxSidePx) / double(std::max(image.widthPx, image.heightPx)));
    cv::Mat small, inside, outside, toPerson, toBackground;
    if (scale < 1)
        cv::resize(mask, small, cv::Size(std::max(2, int(image.widthPx * scale)), std::max(2, int(image.heightPx * scale))), 0, 0,
                   cv::INTER_AREA);
    else
        small = mask;
    inside = small > 127;
    outside = small <= 127;
    if (cv::countNonZero(inside) == 0 || cv::countNonZero(outside) == 0) return fail(Code::NotFound, "the mask shows no outline");
    cv::distanceTransform(outside, toPerson, cv::DIST_L2, cv::DIST_MASK_PRECISE);
    cv::distanceTransform(inside, toBackground, cv::DIST_L2, cv::DIST_MASK_PRECISE);
    MaskDistance d;
    d.widthPx = uint32_t(small.cols), d.heightPx = uint32_t(small.rows);
    d.maskPerCameraPx = double(small.cols) / double(image.widthPx);
    for (int y = 0; y < small.rows; ++y)
        for (int x = 0; x < small.cols; ++x) {
            const float out = toPerson.at<float>(y, x), in = toBackground.at<float>(y, x);
            d.distancePx.push_back(out > 0 ? out - 0.5f : 0.5f - in);  // the edge lies between two pixel centres
        }
    return d;
}

SkinSamples sampleSkin(const BodyModel& body, size_t count) {
    SkinSamples samples;
    samples.body = body;
    samples.body.keypoints.clear();
    const auto& positions = body.mesh.restPositions;
    std::vector<Vec3d> normals(positions.size(), Vec3d(0));
    std::vector<double> area(positions.size(), 0.0);
    for (const Triangle& t : body.mesh.triangles) {
        const Vec3d n = glm::cross(Vec3d(positions[t.y] - positions[t.x]), Vec3d(positions[t.z] - positions[t.x]));
        for (int i = 0; i < 3; ++i) normals[t[i]] += n, area[t[i]] += glm::length(n);
    }
    // Sample by area: each vertex adds its area to a running sum, and a sample is taken whenever the sum passes the next multiple of
    // `step`.
    double total = 0, sum = 0;
    for (double a : area) total += a;
    const double step = total / double(std::max<size_t>(count, 1));
    double next = 0.5 * step;
    for (uint32_t v = 0; v < positions.size(); ++v) {
        sum += area[v];
        if (sum < next || glm::length(normals[v]) < 1e-12) continue;
        while (next <= sum) next += step;
        samples.names.push_back(formatText("skin{}", v));
        samples.body.keypoints.push_back({samples.names.back(), {{v, 1.0f}}, {}});
        int heaviest = 0;
        for (int i = 1; i < 4; ++i)
            if (body.mesh.jointWeights[v][i] > body.mesh.jointWeights[v][heaviest]) heaviest = i;
        samples.joint.push_back(body.mesh.jointIndices[v][heaviest]);
        samples.restNormal.push_back(glm::normalize(normals[v]));
    }
    return samples;
}

std::vector<size_t> outlineSamples(const SkinSamples& samples, const KeypointChain::Output& posed, const Camerad& camera,
                                   const MaskDistance& mask) {
    std::vector<size_t> outline;
    for (size_t i = 0; i < posed.points.size(); ++i) {
        const Vec3d view = camera.toView(posed.points[i]);
        if (!(view.z > 0.1)) continue;
        const Vec3d normal = camera.viewFromWorldRotation * (posed.rotations[samples.joint[i]] * samples.restNormal[i]);
        if (std::abs(glm::dot(normal, glm::normalize(view))) > kGrazing) continue;
        const Vec2d px = camera.pixelOf(view), flat(normal.x, normal.y);
        if (px.x < 1 || px.y < 1 || px.x > camera.widthPx - 1.0 || px.y > camera.heightPx - 1.0 || glm::length(flat) < 1e-6) continue;
        Vec2d gradient;
        const double distanceM = mask.sample(px, gradient) * view.z / camera.fx;
        if (std::abs(distanceM) > priors::kOutlineReachM || glm::length(gradient) < 0.3) continue;
        if (glm::dot(glm::normalize(gradient), glm::normalize(flat)) > kSameDirection) outline.push_back(i);
    }
    return outline;
}

SilhouetteCost::SilhouetteCost(const FitContext& context, const KeypointChain& skin, const Camerad& camera, const Mat3d& rootReference,
                               const MaskDistance& mask, std::vector<size_t> outline)
    : context_(context), skin_(skin), camera_(camera), rootReference_(rootReference), mask_(mask), outline_(std::move(outline)) {
    set_num_residuals(int(outline_.size()));
    auto& sizes = *mutable_parameter_block_sizes();
    sizes = {int(skin.shapeCount()), 1, kRootSize};
    addPoseBlockSizes(sizes, skin.posedCount());
    sizes.push_back(context.sway.size());
}

bool SilhouetteCost::Evaluate(double const* const* blocks, double* residuals, double** jacobians) const {
    const size_t joints = skin_.posedCount(), shapes = skin_.shapeCount(), width = skin_.columns();
    const double* sway = blocks[3 + joints];
    double root[kRootSize];
    for (int i = 0; i < kRootSize; ++i) root[i] = blocks[2][i] + sway[i];
    std::vector<double> pose = poseOfBlocks(blocks + 3, joints);
    for (size_t s = 0; s < context_.sway.slots.size(); ++s)
        for (int i = 0; i < 3; ++i) pose[3 * context_.sway.slots[s] + size_t(i)] += sway[kRootSize + 3 * int(s) + i];
    thread_local KeypointChain::Output posed;
    skin_.evaluate(rootReference_, root, pose.data(), blocks[0], jacobians != nullptr, posed);
    const Mat3d& R = camera_.viewFromWorldRotation;
    const Mat3d Rt = glm::transpose(R);
    const Vec3d shift = std::exp(blocks[1][0]) * camera_.viewFromWorldTranslation;
    const double weight = std::sqrt(priors::kOutlineFrameWeight / double(outline_.size())),
                 c2 = priors::kOutlineOutlierSigmas * priors::kOutlineOutlierSigmas;
    std::vector<double> row(width);
    for (size_t n = 0; n < outline_.size(); ++n) {
        const Vec3d view = R * posed.points[outline_[n]] + shift;
        const double z = std::max(view.z, 0.1);
        Vec2d gradient;
        const double distancePx = mask_.sample(camera_.pixelOf(Vec3d(view.x, view.y, z)), gradient);
        const double perPx =
            z / camera_.fx /
            (distancePx > 0 ? priors::kOutsideMaskM
                            : priors::kClothesStandOffM);  // its derivative by z is ignored: far below the gradient's error
        const double r = distancePx * perPx, scale = std::sqrt(c2 / (r * r + c2));
        residuals[n] = weight * scale * r;
        if (!jacobians) continue;
        const double d = weight * scale * (1 - r * r / (r * r + c2)) * perPx;
        const Vec3d dView = d * (gradient.x * camera_.fx / z * Vec3d(1, 0, -view.x / z) +
                                 gradient.y * camera_.fy / z * Vec3d(0, 1, -view.y / z)),
                    dWorld = Rt * dView;
        const double* rows = &posed.jacobian[outline_[n] * 3 * width];
        for (size_t c = 0; c < width; ++c) row[c] = dWorld.x * rows[c] + dWorld.y * rows[width + c] + dWorld.z * rows[2 * width + c];
        if (jacobians[0]) std::copy_n(&row[kRootSize + 3 * joints], shapes, jacobians[0] + n * shapes);
        if (jacobians[1]) jacobians[1][n] = glm::dot(dView, shift);
        if (jacobians[2]) std::copy_n(&row[0], kRootSize, jacobians[2] + n * kRootSize);
        setPoseRow(jacobians + 3, n, &row[kRootSize], joints);
        if (double* out = jacobians[3 + joints]) {
            out += n * size_t(context_.sway.size());
            std::copy_n(&row[0], kRootSize, out);
            for (size_t s = 0; s < context_.sway.slots.size(); ++s)
                std::copy_n(&row[kRootSize + 3 * context_.sway.slots[s]], 3, out + kRootSize + 3 * s);
        }
    }
    return true;
}

}  // namespace dpl
