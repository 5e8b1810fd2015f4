// SPDX-License-Identifier: Apache-2.0
// A small body of painted tubes, and pictures of it, for tests of registration.
#pragma once

#include <cmath>
#include <random>

#include "reconstruction/subject/body/body_tools.h"
#include "reconstruction/subject/body/body_truth.h"
#include "reconstruction/subject/registration/register_frames.h"
#include "reconstruction/subject/surface/mesh_raster.h"
#include "sdk/avatar/rig.h"
#include "tests/unit/recon_body/small_body.h"

namespace dpl::test {

constexpr uint32_t kRings = 10, kSides = 14;

inline Camerad cameraAround(double azimuth) {
    Camerad c;
    c.widthPx = 189, c.heightPx = 252, c.fx = c.fy = 190, c.cx = 94.5, c.cy = 126;
    const Vec3d eye(2.3 * std::sin(azimuth), 1.3, 2.3 * std::cos(azimuth)), target(0, 0.85, 0);
    const Vec3d z = glm::normalize(target - eye), x = glm::normalize(glm::cross(Vec3d(0, -1, 0), z)), y = glm::cross(z, x);
    c.viewFromWorldRotation = glm::transpose(Mat3d(x, y, z));
    c.viewFromWorldTranslation = -(c.viewFromWorldRotation * eye);
    return c;
}

/** A closed tube about each bone, carried by the bone's upper joint. Colours change over a few centimetres. */
inline MeshData tubes(const std::vector<JointData>& joints) {
    MeshData mesh;
    for (uint32_t j = 1; j < joints.size(); ++j) {
        const Vec3f from = joints[size_t(joints[j].parent)].restPosition, to = joints[j].restPosition;
        const float length = glm::length(to - from), radius = joints[j].name == "head" ? 0.09f : length > 0.3f ? 0.06f : 0.045f;
        if (length < 0.02f) continue;
        const Vec3f axis = (to - from) / length, side = glm::normalize(glm::cross(axis, Vec3f(0.3f, 0.1f, 1))), up = glm::cross(axis, side);
        const uint32_t first = uint32_t(mesh.restPositions.size());
        for (uint32_t r = 0; r <= kRings; ++r)
            for (uint32_t s = 0; s < kSides; ++s) {
                const float t = float(r) / kRings, a = 6.2831853f * float(s) / kSides,
                            width = radius * std::sin(3.14159265f * (0.06f + 0.88f * t));
                mesh.restPositions.push_back(from + t * length * axis + width * (std::cos(a) * side + std::sin(a) * up));
                const Vec3f p = 55.0f * mesh.restPositions.back() + float(j);
                const auto shade = [](float x) { return uint8_t(128 + 90 * std::sin(x)); };
                mesh.colours.push_back({shade(p.x + 2 * p.y), shade(p.y - p.z), shade(p.z + 1.3f * p.x), 255});
                mesh.jointIndices.push_back({uint16_t(joints[j].parent), 0, 0, 0});
                mesh.jointWeights.push_back({255, 0, 0, 0});
            }
        for (uint32_t r = 0; r < kRings; ++r)
            for (uint32_t s = 0; s < kSides; ++s) {
                const uint32_t a = first + r * kSides + s, b = first + r * kSides + (s + 1) % kSides;
                mesh.triangles.push_back({a, b, a + kSides});
                mesh.triangles.push_back({b, b + kSides, a + kSides});
            }
    }
    // Turn every triangle outwards: its normal away from the bone.
    for (Triangle& t : mesh.triangles) {
        const uint32_t tube = t.x / (kSides * (kRings + 1)) * kSides * (kRings + 1);
        const uint32_t ring = (t.x - tube) / kSides;
        Vec3f middle(0);
        for (uint32_t s = 0; s < kSides; ++s) middle += mesh.restPositions[tube + ring * kSides + s] / float(kSides);
        const Vec3f &a = mesh.restPositions[t.x], &b = mesh.restPositions[t.y], &c = mesh.restPositions[t.z];
        if (glm::dot(glm::cross(b - a, c - a), (a + b + c) / 3.0f - middle) < 0) std::swap(t.y, t.z);
    }
    mesh.layers = {{"body", "body", 0, uint32_t(mesh.restPositions.size()), 0, uint32_t(mesh.triangles.size())}};
    return mesh;
}

inline FramePicture pictureOf(const std::vector<JointData>& joints, const MeshData& mesh, const Pose& pose, const Camerad& camera,
                              Jobs& jobs) {
    std::vector<Mat3x4f> worldFromRest;
    std::vector<Vec3f> positions;
    jointTransforms(joints, pose, worldFromRest);
    skin(mesh, worldFromRest, jobs, positions);
    const MeshRaster raster = rasteriseMesh(positions, mesh.triangles, camera);
    FramePicture picture;
    picture.image = {camera.widthPx, camera.heightPx, std::vector<uint8_t>(raster.triangle.size() * 3, 40)};
    picture.mask = {camera.widthPx, camera.heightPx, std::vector<uint8_t>(raster.triangle.size(), 0)};
    for (size_t i = 0; i < raster.triangle.size(); ++i) {
        if (raster.triangle[i] == kNoTriangle) continue;
        const Triangle& t = mesh.triangles[raster.triangle[i]];
        const Vec2f uv = raster.barycentric[i];
        const Vec3f colour =
            (1 - uv.x - uv.y) * Vec3f(mesh.colours[t.x]) + uv.x * Vec3f(mesh.colours[t.y]) + uv.y * Vec3f(mesh.colours[t.z]);
        for (int a = 0; a < 3; ++a) picture.image.pixels[3 * i + size_t(a)] = uint8_t(colour[a] + 0.5f);
        picture.mask.pixels[i] = 255;
    }
    return picture;
}

/** Twelve still pictures and `movingFrames` of a raised arm and leg, with noisy keypoints and wrong start poses. */
struct PaintedScene {
    explicit PaintedScene(int movingFrames, bool moves = true, uint32_t seed = 7, double phasePerFrame = 0.3) {
        std::mt19937 random(seed);
        std::normal_distribution<double> normal;
        body.morphs.clear();
        mesh = tubes(body.joints);
        names = {scanKeypointNames().begin(), scanKeypointNames().end()};
        rigid.assign(mesh.triangles.size(), 1);
        const auto turn = [&](Pose& pose, const char* bone, Vec3d w) {
            pose.localRotations[size_t(findHumanoid(body, bone))] = Quatf(glm::quat_cast(rotationOf(w)));
        };
        const Pose still = Pose::rest(body.joints.size());
        const int total = 12 + movingFrames;
        pictures.resize(size_t(total));
        keypoints.resize(size_t(total));
        for (int i = 0; i < total; ++i) {
            const bool isStill = i < 12;
            const double phase = moves ? phasePerFrame * (i - 12) : 1.0, azimuth = isStill ? 0.5236 * i : 0.1 * (i - 12);
            Pose pose = still;
            if (!isStill) {
                turn(pose, "leftUpperArm", {0, 0, 0.7 * (1 - std::cos(phase))});
                turn(pose, "rightUpperLeg", {-0.4 * (1 - std::cos(phase)), 0, 0});
            }
            truth.push_back(pose);
            const Camerad camera = cameraAround(azimuth);
            pictures[size_t(i)] = std::make_shared<FramePicture>(pictureOf(body.joints, mesh, pose, camera, jobs));
            for (const PosedKeypoint& k : posedKeypoints(body, pose, names)) {
                keypoints[size_t(i)].push_back({});
                if (!k.present) continue;
                keypoints[size_t(i)].back() = {camera.pixelOf(camera.toView(k.place)) + 1.2 * Vec2d(normal(random), normal(random)), 1.0};
            }
            Pose start = pose;
            if (!isStill) {
                start.rootTranslation += Vec3f(0.02f, -0.01f, 0.015f);
                turn(start, "leftUpperArm", {0.06, 0.05, 0.7 * (1 - std::cos(phase)) + 0.08});
            }
            frames.push_back({isStill ? FrameKind::StaticFull : FrameKind::Dynamic, isStill ? 0.0 : 0.2 * (i - 12), camera, start,
                              LazyPicture(pictures[size_t(i)]), keypoints[size_t(i)], Split::Train});
        }
    }
    PaintedScene(const PaintedScene&) = delete;

    RegisterInput input() const {
        RegisterInput in;
        in.body = &body, in.surface = &mesh, in.rigidTriangle = rigid, in.keypointNames = names;
        in.keypointSigma = 1.2 / std::hypot(189, 252);
        in.stillPose = Pose::rest(body.joints.size());
        in.frames = frames;
        return in;
    }
    Result<Registration> registered(const RegisterSettings& settings = {}) { return registerFrames(input(), settings, jobs); }
    double errorMm(const std::vector<Pose>& poses, FrameKind kind) const {
        double sum = 0;
        size_t count = 0;
        for (size_t f = 0; f < frames.size(); ++f) {
            if (frames[f].kind != kind) continue;
            const auto is = posedKeypoints(body, poses[f], names), should = posedKeypoints(body, truth[f], names);
            for (size_t k = 0; k < is.size(); ++k)
                if (is[k].present) sum += 1000 * glm::length(is[k].place - should[k].place), ++count;
        }
        return sum / double(count);
    }
    std::vector<Pose> starts() const {
        std::vector<Pose> poses;
        for (const RegisterFrame& frame : frames) poses.push_back(frame.pose);
        return poses;
    }

    Jobs jobs{2};
    BodyModel body = smallBody();
    MeshData mesh;
    std::vector<std::string> names;
    std::vector<uint8_t> rigid;
    std::vector<Pose> truth;
    std::vector<std::shared_ptr<FramePicture>> pictures;  // of the frames
    std::vector<std::vector<Keypoint>> keypoints;
    std::vector<RegisterFrame> frames;
};

}  // namespace dpl::test
