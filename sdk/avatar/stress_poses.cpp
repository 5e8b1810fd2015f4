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

}  // namespace

std::vector<Pose> stressPoses(std::span<const JointData> joints) {
    const PoseAimer aimer(joints);
    if (!aimer.known()) return {};
    std::vector<Pose> poses;
    for (const AimedPose& stress : kStress) poses.push_back(aimer.pose(stress));
    return poses;
}

}  // namespace dpl
