// SPDX-License-Identifier: Apache-2.0
// Streams of every tracker format, made from a performer whose joints are known exactly: recorded or synthetic motions on a rig, written in
// the joints, axes, rest rotations and noise of the format.
#pragma once

#include <algorithm>
#include <random>
#include <string>
#include <vector>

#include "sdk/motion/clip.h"
#include "sdk/motion/track_format.h"
#include "sdk/motion/track_source.h"
#include "tests/unit/avatar/rigs.h"

namespace dpl::test {

/** World rotations since rest and positions of all joints. */
struct Performer {
    std::vector<JointData> rig;
    std::vector<Quatf> rotations;
    std::vector<Vec3f> positions;

    void show(const Pose& pose) {
        std::vector<Mat3x4f> g;
        jointTransforms(rig, pose, g);
        rotations.resize(rig.size()), positions.resize(rig.size());
        for (size_t j = 0; j < rig.size(); ++j) {
            rotations[j] = glm::normalize(glm::quat_cast(Mat3f(g[j])));
            positions[j] = g[j] * Vec4f(rig[j].restPosition, 1);
        }
    }
    size_t at(const std::string& bone) const { return jointOf(rig, bone); }
};

/** A person who walks on the spot, swings bent arms, twists and nods: a pose for every time, twice differentiable. */
inline Pose swing(const std::vector<JointData>& rig, double timeS) {
    Pose pose = Pose::rest(rig.size());
    const auto turn = [&](const std::string& bone, Vec3f axis, double amplitude, double hz, double phase, double offset = 0) {
        const size_t j = jointOf(rig, bone);
        if (j == SIZE_MAX) return;
        const auto angle = float(offset + amplitude * std::sin(6.283185307 * (hz * timeS) + phase));
        pose.localRotations[j] = glm::normalize(pose.localRotations[j] * glm::angleAxis(angle, glm::normalize(axis)));
    };
    turn("hips", {0, 1, 0}, 0.15, 0.9, 0.3);
    turn("chest", {0, 1, 0}, 0.2, 0.9, 3.4), turn("chest", {1, 0, 0}, 0.08, 0.45, 0);
    turn("head", {1, 0, 0}, 0.15, 0.5, 1), turn("head", {0, 1, 0}, 0.3, 0.3, 2);
    for (const double side : {1.0, -1.0}) {
        const std::string s = side > 0 ? "left" : "right";
        const double phase = side > 0 ? 0 : 3.14159;
        turn(s + "UpperArm", {0, 0, 1}, 0.1, 0.9, phase, -1.0 * side), turn(s + "UpperArm", {1, 0, 0}, 0.5, 0.9, phase);
        turn(s + "LowerArm", {0, 1, 0}, 0.3, 0.9, phase, -0.8 * side);
        turn(s + "Hand", {0, 0, 1}, 0.25, 1.3, phase);
        turn(s + "UpperLeg", {1, 0, 0}, 0.45, 0.9, phase + 3.14159), turn(s + "LowerLeg", {1, 0, 0}, 0.4, 0.9, phase + 2.2, 0.45);
        for (const char* finger : {"Index", "Middle", "Ring", "Little"})
            turn(s + finger + "Proximal", {0, 0, 1}, 0.3, 0.7, phase, -0.4 * side);
    }
    pose.rootTranslation = Vec3f(0.1f * float(std::sin(2 * timeS)), 0, 0.4f * float(timeS));
    return pose;
}

struct StreamNoise {
    float turnRad = 0, placeM = 0;  // standard deviation about one axis
};

/** One stream: its rest pose and its frames as arrays of the format. */
class Stream {
public:
    Stream(TrackFormat format, std::vector<JointData> rig, uint32_t seed, StreamNoise noise = {}, float headingRad = 0)
        : format_(format), random_(seed), noise_(noise), heading_(glm::angleAxis(headingRad, Vec3f(0, 1, 0))) {
        performer.rig = std::move(rig);
        const size_t count = trackedJoints(format).size();
        std::normal_distribution<float> normal;
        for (size_t j = 0; j < count; ++j) {
            const bool plain = format == TrackFormat::Vrm || format == TrackFormat::OpenxrHands;
            restTurns_.push_back(plain ? Quatf(1, 0, 0, 0)
                                       : glm::normalize(Quatf(normal(random_), normal(random_), normal(random_), normal(random_))));
        }
        performer.show(Pose::rest(performer.rig.size()));
        write(false);
        restRotations = rotations, restPositions = positions;
    }

    /** The frame of a pose. Joints that the performer lacks are not tracked. */
    void show(const Pose& pose) {
        performer.show(pose);
        write(true);
    }

    bool needsRest() const { return format_ != TrackFormat::OpenxrHands && format_ != TrackFormat::MediapipePose; }
    TrackFrame rest() const { return needsRest() ? TrackFrame{0, restRotations, restPositions, {}} : TrackFrame{}; }
    TrackFrame frame(int64_t timeNs) const {
        TrackFrame out{timeNs, rotations, positions, confidence};
        if (format_ == TrackFormat::MediapipePose) out.rotations = {};
        return out;
    }

    Performer performer;
    std::vector<float> rotations, positions, confidence, restRotations, restPositions;

private:
    void put(size_t joint, Quatf turn, Vec3f place, bool noisy) {
        std::normal_distribution<float> normal;
        if (noisy) {
            const Vec3f r(normal(random_), normal(random_), normal(random_)), p(normal(random_), normal(random_), normal(random_));
            const Vec3f angle = noise_.turnRad * r;
            if (glm::length(angle) > 0) turn = turn * glm::angleAxis(glm::length(angle), glm::normalize(angle));
            place += noise_.placeM * p;
            turn = heading_ * turn, place = heading_ * place;
        }
        if (format_ == TrackFormat::Unity) turn = Quatf(turn.w, -turn.x, -turn.y, turn.z), place.z = -place.z;
        if (format_ == TrackFormat::MediapipePose) place = Vec3f(place.x, -place.y, -place.z);
        const float r[4] = {turn.x, turn.y, turn.z, turn.w}, p[3] = {place.x, place.y, place.z};
        std::copy(r, r + 4, rotations.begin() + std::ptrdiff_t(4 * joint));
        std::copy(p, p + 3, positions.begin() + std::ptrdiff_t(3 * joint));
        confidence[joint] = 1;
    }

    void write(bool noisy) {
        const auto table = trackedJoints(format_);
        rotations.assign(4 * table.size(), 0.0f), positions.assign(3 * table.size(), 0.0f), confidence.assign(table.size(), 0.0f);
        for (size_t j = 0; j < table.size(); ++j) rotations[4 * j + 3] = 1;
        if (format_ == TrackFormat::MediapipePose) return writePoints();
        if (format_ == TrackFormat::OpenxrHands) return writeHands();
        for (size_t j = 0; j < table.size(); ++j) {
            const size_t own = table[j].bone.empty() ? performer.at("hips") : performer.at(table[j].bone);
            if (own == SIZE_MAX) {
                if (!noisy) put(j, restTurns_[j], performer.positions[performer.at("hips")], false);
                continue;
            }
            put(j, performer.rotations[own] * restTurns_[j], performer.positions[own], noisy);
        }
    }

    void writePoints() {
        const Vec3f hips = 0.5f * (performer.positions[performer.at("leftUpperLeg")] + performer.positions[performer.at("rightUpperLeg")]);
        const auto bone = [&](const std::string& name) { return performer.positions[performer.at(name)] - hips; };
        const auto on = [&](const std::string& name, const Vec3f& offset) {
            return bone(name) + performer.rotations[performer.at(name)] * offset;
        };
        // A head: ear holes level with the lower rims of the eyes.
        const Vec3f face[] = {{0, 0.055f, 0.12f},          {0.02f, 0.1f, 0.09f},   {0.032f, 0.1f, 0.09f},   {0.045f, 0.1f, 0.085f},
                              {-0.02f, 0.1f, 0.09f},       {-0.032f, 0.1f, 0.09f}, {-0.045f, 0.1f, 0.085f}, {0.075f, 0.08875f, 0.005f},
                              {-0.075f, 0.08875f, 0.005f}, {0.025f, 0.02f, 0.1f},  {-0.025f, 0.02f, 0.1f}};
        size_t point = 0;
        const auto add = [&](const Vec3f& place) { put(point++, Quatf(1, 0, 0, 0), place, true); };
        for (const Vec3f& p : face) add(on("head", p));
        const auto both = [&](const std::string& name) { add(bone("left" + name)), add(bone("right" + name)); };
        both("UpperArm"), both("LowerArm"), both("Hand"), both("LittleProximal"), both("IndexProximal"), both("IndexProximal");
        both("UpperLeg"), both("LowerLeg"), both("Foot");
        for (const Vec3f& offset : {Vec3f(0, -0.06f, -0.05f), Vec3f(0, -0.06f, 0.13f)})
            for (const char* side : {"leftFoot", "rightFoot"}) add(on(side, offset));
    }

    /** Axes of a joint of XR_EXT_hand_tracking: -z along the bone, y out of the back of the hand. */
    static Quatf handAxes(const Vec3f& along, const Vec3f& back) {
        const Vec3f z = -glm::normalize(along), y = glm::normalize(back - z * glm::dot(back, z));
        return glm::normalize(glm::quat_cast(Mat3f(glm::cross(y, z), y, z)));
    }

    void writeHands() {
        const auto bone = [&](const std::string& name) { return performer.positions[performer.at(name)]; };
        put(0, performer.rotations[performer.at("head")] * Quatf(0, 0, 1, 0), bone("head"), true);
        for (size_t side = 0; side < 2; ++side) {
            const std::string s = side == 0 ? "left" : "right";
            const Vec3f wrist = bone(s + "Hand");
            const Vec3f back =
                (side == 0 ? 1.0f : -1.0f) * glm::cross(bone(s + "IndexProximal") - wrist, bone(s + "LittleProximal") - wrist);
            put(handJoint(side, kWrist), handAxes(bone(s + "MiddleProximal") - wrist, back), wrist, true);
            size_t joint = 6;
            for (const std::string finger : {"Index", "Middle", "Ring", "Little"}) {
                const Vec3f at[] = {bone(s + finger + "Proximal"), bone(s + finger + "Intermediate"), bone(s + finger + "Distal")};
                const Vec3f last = at[2] + (at[2] - at[1]);
                for (size_t i = 0; i < 3; ++i)
                    put(handJoint(side, joint + 1 + i), handAxes((i < 2 ? at[i + 1] : last) - at[i], back), at[i], true);
                joint += 5;
            }
        }
    }

    TrackFormat format_;
    std::mt19937 random_;
    StreamNoise noise_;
    Quatf heading_;
    std::vector<Quatf> restTurns_;
};

}  // namespace dpl::test
