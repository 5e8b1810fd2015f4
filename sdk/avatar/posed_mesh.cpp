#include "sdk/avatar/posed_mesh.h"

namespace dpl {

void PosedMesh::pose(const PosedSubject& s, const Pose& pose, Jobs& jobs) {
    if (s.correctives.empty()) {
        moved_.assign(s.mesh.restPositions.begin(), s.mesh.restPositions.end());
        light_.clear();
    } else {
        correctiveCoefficients(s.correctives, pose, coefficients_);
        correctiveNodes(s.correctives, coefficients_, nodes_);
        spreadCorrectives(s.correctives, nodes_, s.mesh.restPositions, jobs, moved_, light_);
    }
    jointTransforms(s.joints, pose, worldFromRest_);
    skin(s.mesh, moved_, worldFromRest_, jobs, positions_);
    poseTriangles(s.mesh, s.bind, positions_, jobs, frames_, light_);
}

}  // namespace dpl
