// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/subject/garments/still_views.h"

namespace dpl {
namespace {

struct Rigid {
    Mat3d rotation;
    Vec3d translation;
};

Rigid rootTransform(std::span<const JointData> joints, const Pose& pose) {
    const Mat3d r = glm::mat3_cast(glm::normalize(Quat<double>(pose.localRotations[0])));
    const Vec3d p(joints[0].restPosition);
    return {r, Vec3d(pose.rootTranslation) + p - r * p};
}

}  // namespace

StillViews compensateSway(std::span<const JointData> joints, std::span<const GarmentView> views) {
    StillViews still{views[0].pose, {}};
    const Rigid reference = rootTransform(joints, still.pose);
    for (const GarmentView& view : views) {
        // world of this view = sway · world of the reference pose
        const Rigid root = rootTransform(joints, view.pose);
        const Mat3d swayRotation = root.rotation * glm::transpose(reference.rotation);
        const Vec3d swayTranslation = root.translation - swayRotation * reference.translation;
        Camerad camera = view.camera;
        camera.viewFromWorldTranslation = view.camera.viewFromWorldRotation * swayTranslation + view.camera.viewFromWorldTranslation;
        camera.viewFromWorldRotation = view.camera.viewFromWorldRotation * swayRotation;
        still.cameras.push_back(camera);
    }
    return still;
}

}  // namespace dpl
