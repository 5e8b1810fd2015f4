// SPDX-License-Identifier: Apache-2.0
#include "sdk/avatar/posed_mesh.h"

namespace dpl {

void PosedMesh::control(const PosedSubject& s, const Pose& pose) {
    coefficients_.clear(), nodes_.clear();
    if (!s.correctives.empty()) {
        correctiveCoefficients(s.correctives, pose, coefficients_);
        correctiveNodes(s.correctives, coefficients_, nodes_);
    }
    jointTransforms(s.joints, pose, worldFromRest_);
}

void PosedMesh::surface(const PosedSubject& s, Jobs& jobs) {
    if (s.correctives.empty()) {
        moved_.assign(s.mesh.restPositions.begin(), s.mesh.restPositions.end());
        light_.clear();
    } else {
        spreadCorrectives(s.correctives, nodes_, s.mesh.restPositions, jobs, moved_, light_);
    }
    skin(s.mesh, moved_, worldFromRest_, jobs, positions_);
    poseTriangles(s.mesh, s.rest, positions_, jobs, frames_, light_);
}

}  // namespace dpl
