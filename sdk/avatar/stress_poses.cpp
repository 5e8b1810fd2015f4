// SPDX-License-Identifier: Apache-2.0
#include "sdk/avatar/stress_poses.h"

#include "sdk/avatar/aimed_pose.h"

namespace dpl {
namespace {

const std::vector<AimedPose> kStress = {
    {{thighAim(40), shankAim(10), armAim(-25, 12)}, {thighAim(-25), shankAim(-45), armAim(25, 12)}, {0, 10, 0}},  // a brisk step
    {{thighAim(-25), shankAim(-45), armAim(25, 12)}, {thighAim(40), shankAim(10), armAim(-25, 12)}, {0, -10, 0}},
    {{thighAim(20), armAim(-10, 12)}, {thighAim(-15), armAim(10, 12)}, {}},
    {{thighAim(-15), armAim(10, 12)}, {thighAim(20), armAim(-10, 12)}, {}},
    {{thighAim(0, 25), armAim(0, 90)}, {thighAim(0, 25), armAim(0, 90)}, {}},      // a wide stance, arms level
    {{thighAim(30), armAim(30, 15)}, {thighAim(30), armAim(30, 15)}, {25, 0, 0}},  // a bow
    {{armAim(5, 3)}, {armAim(5, 3)}, {}},                                          // arms that hang
    {{armAim(80, 10)}, {armAim(0, 12)}, {0, -20, 0}},                              // one hand forwards
    {{armAim(0, 12)}, {armAim(80, 10)}, {0, 20, 0}},
};

const std::vector<AimedPose> kFar = {
    {{thighAim(90), shankAim(10), armAim(-40, 12)}, {thighAim(-30), shankAim(-60), armAim(60, 12)}, {0, 15, 0}},  // a lunge
    {{thighAim(-30), shankAim(-60), armAim(60, 12)}, {thighAim(90), shankAim(10), armAim(-40, 12)}, {0, -15, 0}},
    {{thighAim(95, 15), shankAim(-20), armAim(60, 20)}, {thighAim(95, 15), shankAim(-20), armAim(60, 20)}, {40, 0, 0}},  // a deep squat
    {{thighAim(0, 45), armAim(0, 150)}, {thighAim(0, 10), armAim(60, -30)}, {0, 30, 10}},  // a kick sideways, an arm overhead, one across
    {{thighAim(0, 10), armAim(60, -30)}, {thighAim(0, 45), armAim(0, 150)}, {0, -30, -10}},
    {{armAim(170, 10)}, {armAim(170, 10)}, {}},  // arms overhead, from the front
    {{armAim(0, 150)}, {armAim(0, 150)}, {}},    // and from the sides
};

std::vector<Pose> posesOf(std::span<const JointData> joints, std::initializer_list<const std::vector<AimedPose>*> lists) {
    const PoseAimer aimer(joints);
    std::vector<Pose> poses;
    if (!aimer.known()) return poses;
    for (const std::vector<AimedPose>* list : lists)
        for (const AimedPose& aimed : *list) poses.push_back(aimer.pose(aimed));
    return poses;
}

}  // namespace

std::vector<Pose> stressPoses(std::span<const JointData> joints) {
    return posesOf(joints, {&kStress});
}

std::vector<Pose> clothPoses(std::span<const JointData> joints) {
    return posesOf(joints, {&kStress, &kFar});
}

}  // namespace dpl
