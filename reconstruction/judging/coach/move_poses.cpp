// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/judging/coach/move_poses.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "reconstruction/output/package/clip_of_poses.h"

namespace dpl {
namespace {

constexpr double kTurn = 2 * std::numbers::pi;
constexpr LimbAim kHangingArm = armAim(0, 14);

/** A leg of a walker and the arm of its side. phase: radians of the stride; at 0 the leg swings past the other one. reach: 1 for long
 *  steps, less for shorter ones. */
std::vector<LimbAim> strideSide(double phase, double reach) {
    const float thigh = float(6 + 26 * reach * std::sin(phase)), bend = float(8 + 46 * reach * std::max(0.0, std::cos(phase + 0.4)));
    const float arm = float(-22 * reach * std::sin(phase));
    return {thighAim(thigh, 3), shankAim(thigh - bend), armAim(arm, 10), forearmAim(arm + 20, 8)};
}

AimedPose stride(double phase, double reach = 1) {
    return {strideSide(phase, reach), strideSide(phase + kTurn / 2, reach), Vec3f(0, float(-7 * reach * std::sin(phase)), 0)};
}

/** depth: 0 standing, 1 thighs level. */
AimedPose squat(double depth) {
    const float d = float(depth);
    const std::vector<LimbAim> side = {thighAim(90 * d, 6 + 8 * d), shankAim(-30 * d), armAim(80 * d, 14 - 6 * d)};
    return {side, side, Vec3f(35 * d, 0, 0)};
}

AimedPose bothSides(std::vector<LimbAim> side, Vec3f spineDegrees = Vec3f(0)) {
    return {side, side, spineDegrees};
}

/** Turns the whole person about the vertical through the root, where it rests. */
void turnAround(Pose& pose, double radians) {
    pose.localRotations[0] = glm::angleAxis(float(radians), Vec3f(0, 1, 0)) * pose.localRotations[0];
}

/** Raises or lowers poses so that the lowest of feet and toes is as high as at rest. */
class Floor {
public:
    explicit Floor(std::span<const JointData> joints) : joints_(joints) {
        const BoneMap bones = bonesOf(joints);
        for (const char* bone : {"leftFoot", "rightFoot", "leftToes", "rightToes"})
            if (const auto joint = findBone(bones, bone)) feet_.push_back(*joint);
        rest_ = lowest(Pose::rest(joints.size()));
    }
    void stand(Pose& pose) {
        if (!feet_.empty()) pose.rootTranslation.y += rest_ - lowest(pose);
    }

private:
    std::span<const JointData> joints_;
    std::vector<size_t> feet_;
    std::vector<Mat3x4f> worldFromRest_;
    float rest_ = 0;

    float lowest(const Pose& pose) {
        jointTransforms(joints_, pose, worldFromRest_);
        float y = 1e9f;
        for (const size_t joint : feet_) y = std::min(y, (worldFromRest_[joint] * Vec4f(joints_[joint].restPosition, 1)).y);
        return y;
    }
};

}  // namespace

std::vector<MoveClip> moveClips(std::span<const JointData> joints) {
    const PoseAimer aimer(joints);
    if (!aimer.known()) return {};
    std::vector<MoveClip> clips = {{"walking", 1.2, {}}, {"squatting", 2.4, {}}, {"turning", 4, {}}};
    constexpr size_t kPictures[] = {16, 16, 24};
    Floor floor(joints);
    for (size_t c = 0; c < clips.size(); ++c)
        for (size_t i = 0; i < kPictures[c]; ++i) {
            const double phase = kTurn * double(i) / double(kPictures[c]);
            Pose pose = aimer.pose(c == 0 ? stride(phase) : c == 1 ? squat(0.5 - 0.5 * std::cos(phase)) : bothSides({kHangingArm}));
            if (c == 2) turnAround(pose, phase);
            floor.stand(pose);
            clips[c].poses.push_back(std::move(pose));
        }
    return clips;
}

std::vector<ClipData> walkClips(std::span<const JointData> joints) {
    const PoseAimer aimer(joints);
    if (!aimer.known()) return {};
    struct Walk {
        const char* name;
        double seconds, reach;
    };
    constexpr size_t kKeys = 16;
    Floor floor(joints);
    std::vector<ClipData> clips;
    for (const Walk& walk : {Walk{"walk", 1.2, 1}, Walk{"stroll", 1.6, 0.6}}) {
        std::vector<float> timesS;
        std::vector<Pose> poses;
        for (size_t i = 0; i <= kKeys; ++i) {
            timesS.push_back(float(walk.seconds * double(i) / kKeys));
            poses.push_back(aimer.pose(stride(kTurn * double(i % kKeys) / kKeys, walk.reach)));
            floor.stand(poses.back());
        }
        clips.push_back(clipOfPoses(walk.name, std::move(timesS), poses));
    }
    return clips;
}

Pose poseOfMove(std::span<const JointData> joints, std::string_view sentence) {
    struct Shown {
        std::string_view words;
        AimedPose pose;
        double turnRad = 0;
    };
    const std::vector<LimbAim> standing = {thighAim(0), kHangingArm};
    const Shown kMoves[] = {
        {"raise both arms", bothSides({armAim(0, 150)})},
        {"bend both elbows", bothSides({kHangingArm, forearmAim(110, 10)})},
        {"lift one knee", {{thighAim(80), shankAim(-5), kHangingArm}, standing, {}}},
        {"bow", bothSides({thighAim(0), armAim(30, 12)}, {55, 0, 0})},
        {"twist", bothSides({armAim(0, 45)}, {0, 35, 0})},
        {"turn the head", bothSides({kHangingArm}, {0, 20, 0})},
        {"walk on the spot", stride(kTurn / 4)},
        {"turn on the spot", bothSides({kHangingArm}), 0.9},
    };
    const PoseAimer aimer(joints);
    Pose pose = aimer.pose(bothSides({kHangingArm}));
    size_t first = sentence.size();
    for (const Shown& move : kMoves) {
        const size_t at = sentence.find(move.words);
        if (at >= first) continue;  // also when it is npos
        first = at;
        pose = aimer.pose(move.pose);
        turnAround(pose, move.turnRad);
    }
    return pose;
}

}  // namespace dpl
