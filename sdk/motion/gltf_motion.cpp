// SPDX-License-Identifier: Apache-2.0
// Reads glTF animations as motions. A glTF joint may have any rest rotation Q (world); that of its parent is Q_p. Motions use joint frames
// that are parallel to the world at rest. There the animated local rotation A becomes  R = Q_p · A · Q⁻¹.
#include <algorithm>
#include <cmath>

#include "sdk/core/numbers.h"
#include "sdk/format/skinned_gltf.h"
#include "sdk/motion/motion.h"

namespace dpl {
namespace {

constexpr size_t kMaxKeys = 200000;
constexpr size_t kMaxRotations = size_t(32) << 20;  // keys × joints; 512 MiB
constexpr float kCubicRateHz = 60;

/** World rotation of every node at rest, without scale. */
std::vector<Quatf> restRotations(const SkinnedGltf& gltf) {
    std::vector<Quatf> world(gltf.nodes.size());
    for (size_t n = 0; n < world.size(); ++n) {
        const SkinnedGltf::Node& node = gltf.nodes[n];
        world[n] = node.parent < 0 ? node.rotation : glm::normalize(world[size_t(node.parent)] * node.rotation);
    }
    return world;
}

Result<std::vector<float>> keyTimes(const SkinnedGltf::Animation& animation, std::string_view name) {
    std::vector<float> times;
    size_t wanted = 0;
    for (const SkinnedGltf::Channel& channel : animation.channels) wanted += channel.timesS.size();
    times.reserve(std::min(wanted, kMaxKeys));
    bool cubic = false;
    for (const SkinnedGltf::Channel& channel : animation.channels) {
        cubic |= channel.interpolation == SkinnedGltf::Interpolation::Cubic;
        std::vector<float> merged;
        merged.reserve(times.size() + channel.timesS.size());
        std::set_union(times.begin(), times.end(), channel.timesS.begin(), channel.timesS.end(), std::back_inserter(merged));
        times = std::move(merged);
        if (times.size() > kMaxKeys) return fail(Code::Unsupported, "{}: more than {} different key times", name, kMaxKeys);
    }
    if (times.empty()) return fail(Code::CorruptData, "{}: the animation has no keys", name);
    if (cubic) {
        const float begin = times.front(), end = times.back();
        if ((end - begin) * kCubicRateHz > float(kMaxKeys))
            return fail(Code::Unsupported, "{}: the animation lasts {} s", name, end - begin);
        const size_t count = size_t((end - begin) * kCubicRateHz);
        for (size_t i = 1; i <= count; ++i) times.push_back(begin + float(i) / kCubicRateHz);
        std::sort(times.begin(), times.end());
    }
    // Keys less than 10 µs apart count as one: exporters round the same time differently in different channels.
    times.erase(std::unique(times.begin(), times.end(), [](float a, float b) { return b - a < 1e-5f; }), times.end());
    return times;
}

/** "'idle' (0), 'walk' (1)", without the animation `but`. */
std::string listed(const std::vector<SkinnedGltf::Animation>& animations, size_t but = SIZE_MAX) {
    constexpr size_t kMost = 20;
    std::string text;
    for (size_t a = 0, shown = 0; a < animations.size(); ++a) {
        if (a == but) continue;
        if (shown++ == kMost) return text + " and more";
        text += formatText("{}'{}' ({})", text.empty() ? "" : ", ", animations[a].name, a);
    }
    return text;
}

Result<size_t> chooseAnimation(const std::vector<SkinnedGltf::Animation>& animations, const MotionChoice& choice, std::string_view name) {
    if (animations.empty()) return fail(Code::NotFound, "{}: the file holds no animation, so nothing in it moves", name);
    const auto missing = [&](const std::string& wanted) {
        return fail(Code::NotFound, "{}: there is no animation {}; the file holds {}: {}", name, wanted, animations.size(),
                    listed(animations));
    };
    if (choice.animation.empty()) {
        if (choice.index >= animations.size()) return missing(std::to_string(choice.index));
        return size_t(choice.index);
    }
    for (size_t a = 0; a < animations.size(); ++a)
        if (animations[a].name == choice.animation) return a;
    uint32_t number = 0;
    if (!readNumber(choice.animation, number) || number >= animations.size()) return missing("'" + choice.animation + "'");
    return size_t(number);
}

}  // namespace

Result<Motion> readGltfMotion(std::span<const uint8_t> bytes, std::string_view name, const MotionChoice& choice) {
    SkinnedGltfOptions options;
    options.requireSkin = false;
    DPL_TRY(const SkinnedGltf gltf, readSkinnedGltf(bytes, options));
    DPL_TRY(const size_t taken, chooseAnimation(gltf.animations, choice, name));
    const SkinnedGltf::Animation& clip = gltf.animations[taken];
    if (clip.channels.empty() && !clip.leftOut.empty())
        return fail(Code::CorruptData, "{}: animation '{}' has no sound key; {}", name, clip.name, clip.leftOut);
    if (clip.channels.empty())
        return fail(Code::Unsupported,
                    "{}: animation '{}' moves no node, as of a face or a material: it has no skeleton to take a motion from", name,
                    clip.name);

    // The joints of the motion are the skin's joints, the animated nodes and all their ancestors. A file without a skin does not name its
    // skeleton, so all its nodes are joints.
    std::vector<bool> wanted(gltf.nodes.size(), gltf.joints.empty());
    for (const SkinnedGltf::Joint& joint : gltf.joints) wanted[joint.node] = true;
    for (const SkinnedGltf::Channel& channel : clip.channels) wanted[channel.node] = true;
    for (size_t n = gltf.nodes.size(); n-- > 0;)
        if (wanted[n] && gltf.nodes[n].parent >= 0) wanted[size_t(gltf.nodes[n].parent)] = true;

    Motion motion;
    motion.name = clip.name.empty() ? std::string(name) : clip.name;
    if (choice.animation.empty() && gltf.animations.size() > 1)
        motion.notes.push_back(formatText("the file holds {} animations: took '{}' ({}), left {}; choose by name or number (--animation)",
                                          gltf.animations.size(), clip.name, taken, listed(gltf.animations, taken)));
    if (!clip.leftOut.empty()) motion.notes.push_back(clip.leftOut);
    const std::vector<Mat4f> sceneFromNode = gltf.restTransforms();
    const std::vector<Quatf> rest = restRotations(gltf);
    std::vector<int32_t> jointOf(gltf.nodes.size(), -1);
    for (size_t n = 0; n < gltf.nodes.size(); ++n) {
        if (!wanted[n]) continue;
        jointOf[n] = int32_t(motion.joints.size());
        const SkinnedGltf::Node& node = gltf.nodes[n];
        motion.joints.push_back(
            {node.name, node.parent < 0 ? -1 : jointOf[size_t(node.parent)], Vec3f(sceneFromNode[n][3]), node.humanoidBone});
    }
    DPL_TRY(motion.timesS, keyTimes(clip, name));
    const size_t keys = motion.timesS.size(), joints = motion.joints.size();
    if (keys * joints > kMaxRotations) return fail(Code::Unsupported, "{}: {} keys of {} joints are too many", name, keys, joints);
    motion.rotations.assign(keys * joints, Quatf(1, 0, 0, 0));
    for (const SkinnedGltf::Channel& channel : clip.channels) {
        const SkinnedGltf::Node& node = gltf.nodes[channel.node];
        const size_t joint = size_t(jointOf[channel.node]);
        const Quatf parentRest = node.parent < 0 ? Quatf(1, 0, 0, 0) : rest[size_t(node.parent)];
        if (channel.path == SkinnedGltf::Path::Rotation) {
            const Quatf inverseRest = glm::conjugate(rest[channel.node]);
            for (size_t k = 0; k < keys; ++k) {
                const Vec4f v = sampleChannel(channel, motion.timesS[k]);
                motion.rotations[k * joints + joint] = glm::normalize(parentRest * Quatf(v.w, v.x, v.y, v.z) * inverseRest);
            }
        } else if (channel.path == SkinnedGltf::Path::Translation) {
            const Mat3f linear = node.parent < 0 ? Mat3f(1) : Mat3f(sceneFromNode[size_t(node.parent)]);
            Motion::Translation translation{uint32_t(joint), std::vector<Vec3f>(keys)};
            for (size_t k = 0; k < keys; ++k)
                translation.offsets[k] = linear * (Vec3f(sampleChannel(channel, motion.timesS[k])) - node.translation);
            motion.translations.push_back(std::move(translation));
        }
    }
    for (const Quatf& q : motion.rotations)
        if (!std::isfinite(q.w + q.x + q.y + q.z))
            return fail(Code::CorruptData, "{}: a rotation of '{}' is not finite", name, motion.name);
    const float begin = motion.timesS.front();
    for (float& t : motion.timesS) t -= begin;
    scaleToMetres(motion);
    return motion;
}

}  // namespace dpl
