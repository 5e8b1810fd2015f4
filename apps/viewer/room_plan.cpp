// SPDX-License-Identifier: Apache-2.0
#include "apps/viewer/room_plan.h"

#include <algorithm>

namespace dpl {

platform::RoomPlan roomAround(const std::vector<ViewedSubject>& subjects, const WorldBox& box, double cameraM) {
    platform::RoomPlan plan;
    for (const ViewedSubject& subject : subjects)
        if (subject.isAvatar()) plan.stands.push_back({float(subject.place().x), float(subject.place().z)});
    plan.floorY = plan.stands.empty() && !subjects.empty() ? float(box.low.y) : -platform::kStandHeightM;
    if (subjects.empty()) plan.stands.push_back({0, 0});
    plan.ringRadiusM = std::clamp(float(1.1 * cameraM + 0.4), platform::kMinRingRadiusM, platform::kMaxRingRadiusM);
    return plan;
}

}  // namespace dpl
