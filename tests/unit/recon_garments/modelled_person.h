// SPDX-License-Identifier: Apache-2.0
// A person made of capsules, and pictures of it in clothes: masks and labels.
#pragma once

#include <algorithm>
#include <cmath>
#include <functional>
#include <vector>

#include "capsule.h"
#include "reconstruction/subject/garments/still_views.h"
#include "reconstruction/subject/shape/implicit_mesh.h"
#include "reconstruction/subject/surface/mesh_raster.h"
#include "sdk/avatar/rig.h"

namespace dpl {

constexpr uint8_t kSkin = 1, kTop = 2, kBottom = 3, kShoes = 5, kBadge = 6, kBelt = 7;  // labels

/** Metres, negative inside. The legs stand 4 cm apart, up to the trunk at 0.8 m. */
inline float bodyField(const Vec3f& p) {
    const Vec3f side(std::abs(p.x), p.y, p.z);
    const float trunk = capsule(p, {0, 0.95f, 0}, {0, 1.25f, 0}, 0.14f), neck = capsule(p, {0, 1.3f, 0}, {0, 1.5f, 0}, 0.06f);
    const float head = glm::length(p - Vec3f(0, 1.6f, 0)) - 0.11f, leg = capsule(side, {0.1f, 0.1f, 0}, {0.09f, 0.9f, 0}, 0.07f);
    return std::min(std::min(trunk, neck), std::min(head, leg));
}

inline SurfaceMesh meshOf(const ScalarField& field, float step) {
    SampleGrid grid;
    appendSamples(grid.xs, -0.4f, 0.4f, step);
    appendSamples(grid.ys, -0.1f, 1.8f, step);
    appendSamples(grid.zs, -0.4f, 0.4f, step);
    Jobs jobs(1);
    return remesh(largestPiece(marchField(field, grid, jobs)), field, {[&](const Vec3f&) { return 1.4f * step; }, 3}, jobs);
}

/** At rest, with weights of joints(). */
inline const MeshData& body() {
    static const MeshData made = [] {
        const SurfaceMesh mesh = meshOf(bodyField, 0.018f);
        MeshData m;
        m.restPositions = mesh.positions;
        m.triangles = mesh.triangles;
        for (const Vec3f& p : mesh.positions) {
            const float leg = std::clamp((0.95f - p.y) / 0.15f, 0.0f, 1.0f);
            const float left = leg * std::clamp(0.5f + p.x / 0.06f, 0.0f, 1.0f), right = leg - left;
            const auto l = uint8_t(std::lround(255 * left)), r = uint8_t(std::min(255 - int(l), int(std::lround(255 * right))));
            m.jointIndices.push_back({0, 1, 2, 0});
            m.jointWeights.push_back({uint8_t(255 - l - r), l, r, 0});
        }
        m.layers = {{"body", "body", 0, uint32_t(m.restPositions.size()), 0, uint32_t(m.triangles.size())}};
        return m;
    }();
    return made;
}

inline std::vector<JointData> joints() {
    return {{"hips", -1, {0, 0.95f, 0}, "hips"},
            {"left", 0, {0.09f, 0.9f, 0}, "leftUpperLeg"},
            {"right", 0, {-0.09f, 0.9f, 0}, "rightUpperLeg"}};
}

/** Surfaces with labels. Each vertex moves with one joint. */
struct ModelledPerson {
    std::vector<Vec3f> positions;
    std::vector<uint16_t> joint;
    std::vector<Triangle> triangles;
    std::vector<uint8_t> labels;
    /** Triangles with label 0 are left out. */
    void add(
        const SurfaceMesh& part, const std::function<uint8_t(const Vec3f&)>& labelAt,
        const std::function<uint16_t(const Vec3f&)>& jointAt = [](const Vec3f&) { return uint16_t(0); }) {
        const auto first = uint32_t(positions.size());
        positions.insert(positions.end(), part.positions.begin(), part.positions.end());
        for (const Vec3f& p : part.positions) joint.push_back(jointAt(p));
        for (const Triangle& t : part.triangles) {
            const uint8_t label = labelAt((part.positions[t.x] + part.positions[t.y] + part.positions[t.z]) / 3.0f);
            if (label != 0) triangles.push_back(t + first), labels.push_back(label);
        }
    }
};

/** Picture i of a ring around the person at two heights. */
inline GarmentView picture(const ModelledPerson& person, const Pose& pose, int i, int count) {
    GarmentView view;
    const double a = 6.283185307179586 * i / count, c = std::cos(a), s = std::sin(a), height = i % 2 ? 1.4 : 0.6;
    view.camera = {150, 220, 230, 230, 75, 110};
    const Vec3d eye(2.4 * s, height, 2.4 * c), target(0, 0.85, 0), z = glm::normalize(target - eye);
    const Vec3d x = glm::normalize(glm::cross(z, Vec3d(0, 1, 0))), y = glm::cross(z, x);
    view.camera.viewFromWorldRotation = glm::transpose(Mat3d(x, y, z));
    view.camera.viewFromWorldTranslation = -(view.camera.viewFromWorldRotation * eye);
    view.pose = pose;
    std::vector<Mat3x4f> world;
    jointTransforms(joints(), pose, world);
    std::vector<Vec3f> posed;
    for (size_t v = 0; v < person.positions.size(); ++v) posed.push_back(world[person.joint[v]] * Vec4f(person.positions[v], 1));
    const MeshRaster image = rasteriseMesh(posed, person.triangles, view.camera);
    view.mask = view.labels = {150, 220, std::vector<uint8_t>(150 * 220, 0)};
    for (size_t k = 0; k < image.triangle.size(); ++k)
        if (image.triangle[k] != kNoTriangle) view.mask.pixels[k] = 255, view.labels.pixels[k] = person.labels[image.triangle[k]];
    return view;
}

/** Still pictures. The subject sways, so that root poses differ. */
inline std::vector<GarmentView> stillPictures(const ModelledPerson& person, int count) {
    std::vector<GarmentView> out;
    for (int i = 0; i < count; ++i) {
        Pose pose = Pose::rest(3);
        pose.localRotations[0] = glm::angleAxis(0.02f * float(i % 3 - 1), glm::normalize(Vec3f(1, 2, 0)));
        pose.rootTranslation = {0.01f * float(i % 3 - 1), 0, 0.008f * float(i % 5 - 2)};
        out.push_back(picture(person, pose, i, count));
    }
    return out;
}

/** The top: a shirt 16 mm off the trunk. */
inline SurfaceMesh topSurface() {
    return meshOf([](const Vec3f& p) { return bodyField(p) - 0.016f; }, 0.018f);
}

/** One layer of a finished mesh. */
inline SurfaceMesh layerOf(const MeshData& mesh, size_t index) {
    const LayerData& layer = mesh.layers[index];
    SurfaceMesh out;
    out.positions.assign(mesh.restPositions.begin() + layer.firstVertex,
                         mesh.restPositions.begin() + layer.firstVertex + layer.vertexCount);
    for (uint32_t t = 0; t < layer.triangleCount; ++t) out.triangles.push_back(mesh.triangles[layer.firstTriangle + t] - layer.firstVertex);
    return out;
}

}  // namespace dpl
