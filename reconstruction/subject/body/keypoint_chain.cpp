// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/subject/body/keypoint_chain.h"

#include <algorithm>
#include <cmath>
#include <map>

namespace dpl {
namespace {

Mat3d crossMatrix(const Vec3d& v) {
    return Mat3d(0, v.z, -v.y, -v.z, 0, v.x, v.y, -v.x, 0);
}  // columns

}  // namespace

Mat3d rotationOf(const Vec3d& w) {
    const double angle2 = glm::dot(w, w), angle = std::sqrt(angle2);
    const double a = angle < 1e-4 ? 1 - angle2 / 6 : std::sin(angle) / angle;
    const double b = angle < 1e-4 ? 0.5 - angle2 / 24 : (1 - std::cos(angle)) / angle2;
    const Mat3d k = crossMatrix(w);
    return Mat3d(1.0) + a * k + b * (k * k);
}

Mat3d leftJacobian(const Vec3d& w) {
    const double angle2 = glm::dot(w, w), angle = std::sqrt(angle2);
    const double a = angle < 1e-4 ? 0.5 - angle2 / 24 : (1 - std::cos(angle)) / angle2;
    const double b = angle < 1e-4 ? 1.0 / 6 - angle2 / 120 : (angle - std::sin(angle)) / (angle2 * angle);
    const Mat3d k = crossMatrix(w);
    return Mat3d(1.0) + a * k + b * (k * k);
}

Vec3d rotationVector(const Mat3d& r) {
    Quatd q = glm::normalize(glm::quat_cast(r));
    if (q.w < 0) q = -q;
    const Vec3d v(q.x, q.y, q.z);
    const double s = glm::length(v);
    return s < 1e-12 ? 2.0 * v : (2 * std::atan2(s, q.w) / s) * v;
}

KeypointChain::KeypointChain(const BodyModel& body, std::span<const std::string> keypointNames, std::vector<uint32_t> posedJoints)
    : shapeCount_(body.morphs.size()), posedJoints_(std::move(posedJoints)) {
    const size_t joints = body.joints.size();
    slotOfJoint_.assign(joints, -1);
    for (size_t s = 0; s < posedJoints_.size(); ++s) slotOfJoint_[posedJoints_[s]] = int32_t(s);
    slotOfJoint_[0] = -2;
    restPerShape_.resize(joints);
    for (size_t j = 0; j < joints; ++j) {
        parents_.push_back(body.joints[j].parent);
        rest_.push_back(Vec3d(body.joints[j].restPosition));
        for (const ShapeMorph& m : body.morphs) restPerShape_[j].push_back(Vec3d(m.jointOffsets[j]));
    }
    for (const std::string& name : keypointNames) {
        std::map<uint32_t, Contribution> byJoint;
        const auto of = [&](uint32_t joint) -> Contribution& {
            Contribution& c = byJoint[joint];
            c.joint = joint;
            c.offsetPerShape.resize(shapeCount_, Vec3d(0));
            return c;
        };
        const auto keypoint =
            std::find_if(body.keypoints.begin(), body.keypoints.end(), [&](const BodyKeypoint& k) { return k.name == name; });
        if (keypoint != body.keypoints.end()) {
            for (auto [joint, weight] : keypoint->joints) of(joint).jointWeight += weight;
            for (auto [vertex, weight] : keypoint->vertices)
                for (int i = 0; i < 4; ++i) {
                    const double w = double(weight) * body.mesh.jointWeights[vertex][i] / 255.0;
                    if (w == 0) continue;
                    const uint32_t joint = body.mesh.jointIndices[vertex][i];
                    Contribution& c = of(joint);
                    c.jointWeight += w;
                    c.offset += w * (Vec3d(body.mesh.restPositions[vertex]) - rest_[joint]);
                    for (size_t m = 0; m < shapeCount_; ++m)
                        c.offsetPerShape[m] += w * (Vec3d(body.morphs[m].vertexOffsets[vertex]) - restPerShape_[joint][m]);
                }
        }
        std::vector<Contribution> list;
        for (auto& [joint, contribution] : byJoint) list.push_back(std::move(contribution));
        keypoints_.push_back(std::move(list));
    }
    offsets_.assign(keypoints_.size(), Vec3d(0));
}

uint32_t KeypointChain::carrier(size_t k) const {
    return std::max_element(keypoints_[k].begin(), keypoints_[k].end(),
                            [](const Contribution& a, const Contribution& b) { return a.jointWeight < b.jointWeight; })
        ->joint;
}

Vec3d KeypointChain::restPlace(size_t joint, const double* shape) const {
    Vec3d p = rest_[joint];
    for (size_t m = 0; m < shapeCount_; ++m) p += shape[m] * restPerShape_[joint][m];
    return p;
}

void KeypointChain::evaluate(const Mat3d& rootReference, const double* root, const double* pose, const double* shape, bool wantJacobian,
                             Output& out, std::span<const Mat3d> held) const {
    const size_t joints = rest_.size(), shapes = shapeCount_, width = columns();
    std::vector<Vec3d> rest(joints);
    for (size_t j = 0; j < joints; ++j) rest[j] = restPlace(j, shape);
    out.rotations.resize(joints);
    out.places.resize(joints);
    out.turns.assign(wantJacobian ? joints : 0, Mat3d(0));
    std::vector<Mat3d>& turn = out.turns;
    std::vector<Vec3d> placePerShape(wantJacobian ? joints * shapes : 0);
    for (size_t j = 0; j < joints; ++j) {
        const int32_t slot = slotOfJoint_[j];
        if (slot == -2) {
            const Vec3d w(root[0], root[1], root[2]);
            out.rotations[j] = rotationOf(w) * rootReference;
            out.places[j] = rest[j] + Vec3d(root[3], root[4], root[5]);
            if (wantJacobian) {
                turn[j] = leftJacobian(w);
                for (size_t m = 0; m < shapes; ++m) placePerShape[j * shapes + m] = restPerShape_[j][m];
            }
            continue;
        }
        const size_t parent = size_t(parents_[j]);
        const Mat3d& up = out.rotations[parent];
        out.places[j] = out.places[parent] + up * (rest[j] - rest[parent]);
        out.rotations[j] = slot < 0 && !held.empty() ? up * held[j] : up;
        if (slot >= 0) {
            const Vec3d w(pose[3 * slot], pose[3 * slot + 1], pose[3 * slot + 2]);
            out.rotations[j] = up * rotationOf(w);
            if (wantJacobian) turn[j] = up * leftJacobian(w);
        }
        if (wantJacobian)
            for (size_t m = 0; m < shapes; ++m)
                placePerShape[j * shapes + m] = placePerShape[parent * shapes + m] + up * (restPerShape_[j][m] - restPerShape_[parent][m]);
    }

    out.points.assign(keypoints_.size(), Vec3d(0));
    if (wantJacobian) out.jacobian.assign(keypoints_.size() * 3 * width, 0.0);
    std::vector<Vec3d> lever(wantJacobian ? joints : 0);
    for (size_t k = 0; k < keypoints_.size(); ++k) {
        if (keypoints_[k].empty()) continue;
        double* rows = wantJacobian ? &out.jacobian[k * 3 * width] : nullptr;
        if (wantJacobian) std::fill(lever.begin(), lever.end(), Vec3d(0));
        const uint32_t carriedBy = carrier(k);
        for (const Contribution& c : keypoints_[k]) {
            Vec3d offset = c.joint == carriedBy ? c.offset + offsets_[k] : c.offset;
            for (size_t m = 0; m < shapes; ++m) offset += shape[m] * c.offsetPerShape[m];
            const Vec3d arm = out.rotations[c.joint] * offset;
            out.points[k] += arm + c.jointWeight * out.places[c.joint];
            if (!wantJacobian) continue;
            for (int32_t j = int32_t(c.joint); j >= 0; j = parents_[size_t(j)])
                lever[size_t(j)] += arm + c.jointWeight * (out.places[c.joint] - out.places[size_t(j)]);
            for (int r = 0; r < 3; ++r) rows[size_t(r) * width + 3 + size_t(r)] += c.jointWeight;
            for (size_t m = 0; m < shapes; ++m) {
                const Vec3d d = out.rotations[c.joint] * c.offsetPerShape[m] + c.jointWeight * placePerShape[c.joint * shapes + m];
                for (int r = 0; r < 3; ++r) rows[size_t(r) * width + kRootSize + 3 * posedCount() + m] += d[r];
            }
        }
        if (!wantJacobian) continue;
        for (size_t j = 0; j < joints; ++j) {
            if (slotOfJoint_[j] == -1 || lever[j] == Vec3d(0)) continue;
            const size_t column = slotOfJoint_[j] == -2 ? 0 : kRootSize + 3 * size_t(slotOfJoint_[j]);
            const Mat3d d = crossMatrix(lever[j]) * -1.0 * turn[j];  // ω × lever = −[lever]× ω
            for (int r = 0; r < 3; ++r)
                for (int c = 0; c < 3; ++c) rows[size_t(r) * width + column + size_t(c)] = d[c][r];
        }
    }
}

}  // namespace dpl
