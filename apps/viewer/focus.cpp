// SPDX-License-Identifier: Apache-2.0
#include "apps/viewer/focus.h"

namespace dpl {
namespace {

constexpr double kTallM = 1.75;  // of the person of whom these are measures:
constexpr double kFaceFromHeadM = 0.09, kFaceHalfM = 0.17;
constexpr double kPalmFromWristM = 0.08, kHandHalfM = 0.13;

std::optional<Vec3d> jointAt(const ViewedSubject& subject, const char* bone) {
    uint32_t joint = 0;
    if (dplFindJoint(subject.avatar.handle(), bone, &joint) != DPL_OK) return std::nullopt;
    const auto positions = subject.avatar.jointPositions();
    if (!positions) return std::nullopt;
    return Vec3d((*positions)[3 * joint], (*positions)[3 * joint + 1], (*positions)[3 * joint + 2]);
}

/** A cube whose middle lies beyond `tip`, on the line from `root`. */
WorldBox cubeBeyond(const Vec3d& root, const Vec3d& tip, double beyondM, double halfM) {
    const Vec3d along = tip - root;
    const double length = glm::length(along);
    const Vec3d middle = length > 1e-4 ? tip + beyondM / length * along : tip;
    return {middle - halfM, middle + halfM};
}

}  // namespace

std::optional<WorldBox> boxOfPart(const ViewedSubject& subject, SeenPart part) {
    const WorldBox whole = subject.box();
    if (part == SeenPart::Whole) return whole;
    if (!subject.isAvatar()) return std::nullopt;
    const double size = (whole.high.y - whole.low.y) / kTallM;
    const bool face = part == SeenPart::Face, left = part == SeenPart::LeftHand;
    const auto tip = jointAt(subject, face ? "head" : left ? "leftHand" : "rightHand");
    const auto root = jointAt(subject, face ? "neck" : left ? "leftLowerArm" : "rightLowerArm");
    if (!tip) return std::nullopt;
    return cubeBeyond(root.value_or(*tip), *tip, size * (face ? kFaceFromHeadM : kPalmFromWristM), size * (face ? kFaceHalfM : kHandHalfM));
}

std::optional<PickedPlace> placeAt(const std::vector<ViewedSubject>& subjects, const Camerad& camera, const Vec2d& px) {
    std::vector<DplAvatar> avatars;
    std::vector<size_t> from;
    for (size_t i = 0; i < subjects.size(); ++i)
        if (subjects[i].isAvatar() && subjects[i].shown) avatars.push_back(subjects[i].avatar.handle()), from.push_back(i);
    if (avatars.empty()) return std::nullopt;
    const Vec3d ray((px.x - camera.cx) / camera.fx, (px.y - camera.cy) / camera.fy, 1);
    const Vec3f origin(camera.eye()), direction(glm::transpose(camera.viewFromWorldRotation) * ray);
    DplPick pick{};
    pick.structSize = sizeof pick;
    if (dplPick(avatars.data(), uint32_t(avatars.size()), &origin.x, &direction.x, &pick) != DPL_OK || !pick.hit) return std::nullopt;
    return PickedPlace{from[pick.avatar], Vec3d(pick.point[0], pick.point[1], pick.point[2])};
}

}  // namespace dpl
