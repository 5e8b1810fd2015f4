// SPDX-License-Identifier: Apache-2.0
#include "sdk/avatar/posed_mesh.h"

#include <algorithm>

#include "sdk/avatar/scene_light.h"

namespace dpl {

bool samePose(const Pose& a, const Pose& b) {
    return a.localRotations.size() == b.localRotations.size() && a.rootTranslation == b.rootTranslation && a.before == b.before &&
           a.clothStiffness == b.clothStiffness && a.expression == b.expression &&
           std::equal(a.localRotations.begin(), a.localRotations.end(), b.localRotations.begin());
}

void PosedMesh::control(const PosedSubject& s, const Pose& pose) {
    coefficients_.clear(), nodes_.clear(), pushedM_ = 0;
    jointTransforms(s.joints, pose, worldFromRest_);
    if (s.correctives.empty()) return;
    const float drawn = correctiveCoefficients(s.correctives, pose, coefficients_).drawn;
    correctiveNodes(s.correctives, coefficients_, nodes_);
    if (s.expressions) addExpression(*s.expressions, pose.expression, coefficients_, nodes_);
    if (s.cloth) pushedM_ = s.cloth->apply(worldFromRest_, drawn, nodes_, cloth_);
}

void PosedMesh::vertices(const PosedSubject& s, Jobs& jobs) {
    if (s.correctives.empty()) {
        moved_.assign(s.mesh.restPositions.begin(), s.mesh.restPositions.end());
        light_.clear();
    } else {
        spreadCorrectives(s.correctives, nodes_, s.mesh.restPositions, jobs, moved_, light_);
    }
    skin(s.mesh, moved_, worldFromRest_, jobs, positions_);
}

void PosedMesh::surface(const PosedSubject& s, Jobs& jobs) {
    vertices(s, jobs);
    addSceneLight(s, jobs);
    poseTriangles(s.mesh, s.rest, positions_, jobs, frames_, light_);
}

void PosedMesh::addSceneLight(const PosedSubject& s, Jobs& jobs) {
    scene_.clear();
    if (!s.light || s.light->empty()) return;
    std::span<const Vec3f> normals = s.normals;
    if (normals.empty()) normals = normals_ = restVertexNormals(s.mesh);
    lightFactors(s.mesh, *s.light, normals, worldFromRest_, jobs, scene_);
    if (light_.empty()) light_.assign(scene_.size(), 1.0f);
    for (size_t v = 0; v < light_.size(); ++v) light_[v] = std::clamp(light_[v] * scene_[v], kMinLight, kMaxLight);
}

}  // namespace dpl
