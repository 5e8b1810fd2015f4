// SPDX-License-Identifier: Apache-2.0
// Small motion files that tests write themselves: one motion under many names, rest poses, axes and containers.
#pragma once

#include <cmath>
#include <functional>
#include <string>
#include <vector>

#include "sdk/avatar/rig.h"
#include "sdk/format/glb_builder.h"
#include "tests/unit/avatar/rigs.h"
#include "tests/unit/motion/track_streams.h"

namespace dpl::test {

/** How a motion is written. */
struct Writing {
    std::function<std::string(const std::string& bone)> name;  // of a joint by its humanoid bone; empty: SMPL-X names of the rig
    bool alongBones = false;   // bones lie along +x of their joints' axes, as in LAFAN1, so that all angles zero are no pose; false: T-pose
    Quatf turned{1, 0, 0, 0};  // axes of the file: v of the rig becomes turned · v
};

/** A rig's motion in the joints and axes of a file. */
struct WrittenMotion {
    std::vector<JointData> rig;
    std::vector<std::string> names;
    std::vector<Vec3f> offsets;             // from the parent, in its axes
    std::vector<std::vector<Quatf>> turns;  // by key and joint, in the world of the file
    std::vector<Vec3f> rootPlaces;          // by key

    WrittenMotion(std::vector<JointData> joints, const std::vector<Pose>& poses, const Writing& how) : rig(std::move(joints)) {
        std::vector<Quatf> axes;  // of joints at rest, in the world of the file
        for (size_t j = 0; j < rig.size(); ++j) {
            names.push_back(how.name ? how.name(rig[j].humanoidBone) : rig[j].name);
            axes.push_back(how.alongBones ? how.turned * turnTo(directionOf(j)) : Quatf(1, 0, 0, 0));
            const int32_t parent = rig[j].parent;
            offsets.push_back(parent < 0 ? Vec3f(0)
                                         : glm::conjugate(axes[size_t(parent)]) *
                                               (how.turned * (rig[j].restPosition - rig[size_t(parent)].restPosition)));
        }
        Performer performer;
        performer.rig = rig;
        for (const Pose& pose : poses) {
            performer.show(pose);
            auto& key = turns.emplace_back();
            for (size_t j = 0; j < rig.size(); ++j)
                key.push_back(glm::normalize(how.turned * performer.rotations[j] * glm::conjugate(how.turned) * axes[j]));
            rootPlaces.push_back(how.turned * performer.positions[0]);
        }
    }

    Quatf localAt(size_t key, size_t joint) const {
        const int32_t parent = rig[joint].parent;
        return parent < 0 ? turns[key][joint] : glm::normalize(glm::conjugate(turns[key][size_t(parent)]) * turns[key][joint]);
    }
    std::vector<size_t> childrenOf(size_t joint) const {
        std::vector<size_t> out;
        for (size_t j = 0; j < rig.size(); ++j)
            if (rig[j].parent == int32_t(joint)) out.push_back(j);
        return out;
    }

private:
    Vec3f directionOf(size_t joint) const {
        for (size_t j = joint + 1; j < rig.size(); ++j)
            if (rig[j].parent == int32_t(joint)) return rig[j].restPosition - rig[joint].restPosition;
        return rig[joint].parent < 0 ? Vec3f(0, 1, 0) : rig[joint].restPosition - rig[size_t(rig[joint].parent)].restPosition;
    }
    static Quatf turnTo(const Vec3f& direction) {
        const Vec3f x = glm::normalize(direction), other = std::abs(x.y) < 0.9f ? Vec3f(0, 1, 0) : Vec3f(0, 0, 1);
        const Vec3f z = glm::normalize(glm::cross(x, other));
        return glm::normalize(glm::quat_cast(Mat3f(x, glm::cross(z, x), z)));
    }
};

/** Angles of R = Rz · Rx · Ry, degrees. */
inline Vec3f zxyDegrees(const Quatf& q) {
    const Mat3f m = glm::mat3_cast(q);  // m[column][row]
    const float x = std::asin(std::fmin(1.0f, std::fmax(-1.0f, m[1][2])));
    return glm::degrees(Vec3f(std::atan2(-m[1][0], m[1][1]), x, std::atan2(-m[0][2], m[2][2])));
}

/** BVH in centimetres at 30 frames a second, ends included. */
inline std::string bvhOf(const WrittenMotion& motion) {
    std::string text = "HIERARCHY\n";
    std::vector<size_t> order;
    const std::function<void(size_t)> joint = [&](size_t j) {
        order.push_back(j);
        const Vec3f o = 100.0f * motion.offsets[j];
        text += (j == 0 ? "ROOT " : "JOINT ") + motion.names[j] + "\n{\n" + formatText("OFFSET {} {} {}\n", o.x, o.y, o.z);
        text += j == 0 ? "CHANNELS 6 Xposition Yposition Zposition Zrotation Xrotation Yrotation\n"
                       : "CHANNELS 3 Zrotation Xrotation Yrotation\n";
        for (size_t child : motion.childrenOf(j)) joint(child);
        if (motion.childrenOf(j).empty()) {
            const Vec3f end = 0.4f * o;
            text += formatText("End Site\n{\nOFFSET {} {} {}\n}\n", end.x, end.y, end.z);
        }
        text += "}\n";
    };
    joint(0);
    text += formatText("MOTION\nFrames: {}\nFrame Time: 0.0333333\n", motion.turns.size());
    for (size_t k = 0; k < motion.turns.size(); ++k) {
        const Vec3f p = 100.0f * motion.rootPlaces[k];
        text += formatText("{} {} {}", p.x, p.y, p.z);
        for (size_t j : order) {
            const Vec3f angles = zxyDegrees(motion.localAt(k, j));
            text += formatText(" {} {} {}", angles.x, angles.y, angles.z);
        }
        text += "\n";
    }
    return text;
}

/** The same as a .glb with one animation of that name for each name; all but the last are a rest pose of one joint. root: more of the JSON.
 */
inline std::vector<uint8_t> glbOf(const WrittenMotion& motion, const std::vector<std::string>& animations, const Json& more = {}) {
    GlbBuilder glb;
    glb.root = {{"asset", {{"version", "2.0"}}}, {"scene", 0}, {"scenes", {{{"nodes", {0}}}}}};
    const size_t keys = motion.turns.size();
    std::vector<float> timesS;
    for (size_t k = 0; k < keys; ++k) timesS.push_back(float(k) / 30.0f);
    glb.addAccessor(glb.addView(timesS), kGltfF32, "SCALAR", uint32_t(keys)).update({{"min", {0}}, {"max", {timesS.back()}}});
    const uint32_t times = glb.lastAccessor();
    Json nodes = Json::array(), all = Json::array();
    for (size_t j = 0; j < motion.rig.size(); ++j) {
        const Vec3f& o = motion.offsets[j];
        const Vec3f at = j == 0 ? motion.rig[0].restPosition : o;
        Json node = {{"name", motion.names[j]}, {"translation", {at.x, at.y, at.z}}};
        for (size_t child : motion.childrenOf(j)) node["children"].push_back(child);
        nodes.push_back(node);
    }
    for (size_t a = 0; a < animations.size(); ++a) {
        Json channels = Json::array(), samplers = Json::array();
        const auto animate = [&](size_t joint, const char* path, const std::vector<float>& values, const char* type) {
            glb.addAccessor(glb.addView(values), kGltfF32, type, uint32_t(keys));
            samplers.push_back({{"input", times}, {"output", glb.lastAccessor()}});
            channels.push_back({{"sampler", samplers.size() - 1}, {"target", {{"node", joint}, {"path", path}}}});
        };
        const bool moves = a + 1 == animations.size();
        for (size_t j = 0; j < (moves ? motion.rig.size() : 1); ++j) {
            std::vector<float> values;
            for (size_t k = 0; k < keys; ++k) {
                const Quatf q = moves ? motion.localAt(k, j) : Quatf(1, 0, 0, 0);
                values.insert(values.end(), {q.x, q.y, q.z, q.w});
            }
            animate(j, "rotation", values, "VEC4");
        }
        std::vector<float> places;
        for (size_t k = 0; k < keys && moves; ++k) {
            const Vec3f& p = motion.rootPlaces[k];
            places.insert(places.end(), {p.x, p.y, p.z});
        }
        if (moves) animate(0, "translation", places, "VEC3");
        all.push_back({{"name", animations[a]}, {"samplers", samplers}, {"channels", channels}});
    }
    glb.root["nodes"] = nodes;
    glb.root["animations"] = all;
    for (const auto& [key, value] : more.items()) glb.root[key] = value;
    return glb.finish([](std::string&, std::span<const uint8_t>) {});
}

}  // namespace dpl::test
