// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/subject/sample/builtin_body.h"

#include "reconstruction/subject/face/face_shapes.h"
#include "reconstruction/subject/sample/builtin_parts.h"

namespace dpl {

SurfaceMesh meshBody(const BodyField& field, Jobs& jobs) {
    // Grid spacing in metres, finer where fingers, toes and the face are. remesh() then sets the final edge lengths.
    SampleGrid grid;
    appendSamples(grid.xs, -0.80f, -0.575f, 0.0042f);
    appendSamples(grid.xs, -0.575f, 0.575f, 0.0075f);
    appendSamples(grid.xs, 0.575f, 0.80f, 0.0042f);
    appendSamples(grid.ys, -0.02f, 0.09f, 0.005f);
    appendSamples(grid.ys, 0.09f, 0.86f, 0.010f);
    appendSamples(grid.ys, 0.86f, 1.09f, 0.0045f);
    appendSamples(grid.ys, 1.09f, 1.52f, 0.009f);
    appendSamples(grid.ys, 1.52f, 1.70f, 0.004f);
    appendSamples(grid.ys, 1.70f, 1.78f, 0.007f);
    appendSamples(grid.zs, -0.18f, -0.05f, 0.008f);
    appendSamples(grid.zs, -0.05f, 0.14f, 0.0046f);
    appendSamples(grid.zs, 0.14f, 0.24f, 0.006f);
    const ScalarField solid = [&](const Vec3f& p) { return field.distance(p); };
    const SurfaceMesh raw = largestPiece(marchField(solid, grid, jobs));
    return remesh(raw, solid, {bodyEdgeLength, 8}, jobs);
}

BodyModel makeBuiltinBody(Jobs& jobs) {
    const BodyField field;
    BodyModel body;
    body.name = "builtin";
    body.joints = builtinSkeleton();
    const SurfaceMesh mesh = meshBody(field, jobs);
    const std::vector<float> dense = bodyWeights(field, mesh, body.joints, jobs);
    body.mesh.restPositions = mesh.positions;
    body.mesh.triangles = mesh.triangles;
    body.mesh.colours.assign(mesh.positions.size(), glm::u8vec4(205, 164, 140, 255));
    cutWeights(dense, body.joints.size(), body.mesh.jointIndices, body.mesh.jointWeights);
    body.mesh.layers = {{"body", "body", 0, uint32_t(mesh.positions.size()), 0, uint32_t(mesh.triangles.size())}};
    body.morphs = bodyMorphs(mesh, dense, body.joints);
    body.keypoints = bodyKeypoints(mesh);
    const std::vector<BodyKeypoint> fingers = fingerKeypoints(mesh);
    body.keypoints.insert(body.keypoints.end(), fingers.begin(), fingers.end());
    body.expressions = faceShapes(builtinFace(), mesh.positions);
    return body;
}

BodyModel makeBuiltinBody() {
    Jobs jobs;
    return makeBuiltinBody(jobs);
}

}  // namespace dpl
