// SPDX-License-Identifier: Apache-2.0
#include "sdk/motion/clip_mix.h"

#include <algorithm>
#include <cmath>

#include "sdk/motion/clip.h"

namespace dpl {
namespace {

constexpr double kHeadingS = 1;  // over which the heading of a joined clip is taken: about two steps
constexpr int kHeadings = 31;    // samples of it

Vec2d turned(const Vec2d& at, double headingRad) {
    const double s = std::sin(headingRad), c = std::cos(headingRad);
    return {c * at.x + s * at.y, c * at.y - s * at.x};
}

/** The root's part of a rotation that is about +Y. */
double headingOf(const Quatf& root) {
    return 2 * std::atan2(double(root.y), double(root.w));
}

GroundPlace standing(std::span<const JointData> joints, const Quatf& rotation, const Vec3f& translation) {
    const Vec3d at = Vec3d(joints[0].restPosition) + Vec3d(translation);
    return {headingOf(rotation), {at.x, at.z}};
}

/** What one round of a clip adds to the place of its root. */
GroundPlace roundOf(const ClipData& clip, std::span<const JointData> joints) {
    Quatf first(1, 0, 0, 0), last(1, 0, 0, 0);
    for (const ClipChannel& channel : clip.channels)
        if (channel.joint == 0) first = channel.rotations.front(), last = channel.rotations.back();
    const bool moves = !clip.rootTranslations.empty();
    const Vec3f from = moves ? clip.rootTranslations.front() : Vec3f(0), to = moves ? clip.rootTranslations.back() : Vec3f(0);
    return standing(joints, last, to) * inverse(standing(joints, first, from));
}

/** Where the layer puts its clip at this time. */
GroundPlace placeAt(const ClipLayer& layer, std::span<const JointData> joints, double timeS) {
    const double durationS = clipDurationS(*layer.clip);
    if (!layer.loops || !layer.travels || !(durationS > 0)) return layer.place;
    return layer.place * repeated(roundOf(*layer.clip, joints), std::floor(timeS / durationS));
}

void sampleLayer(const ClipLayer& layer, std::span<const JointData> joints, double timeS, Pose& pose) {
    samplePose(*layer.clip, joints, layer.loops ? loopedTimeS(*layer.clip, timeS) : timeS, pose);
    const GroundPlace place = placeAt(layer, joints, timeS);
    if (place.none()) return;
    const Vec3d at = Vec3d(joints[0].restPosition) + Vec3d(pose.rootTranslation);
    const Vec2d moved = turned({at.x, at.z}, place.headingRad) + place.shiftM;
    pose.rootTranslation = Vec3f(Vec3d(moved.x, at.y, moved.y) - Vec3d(joints[0].restPosition));
    const Quatd turn = glm::angleAxis(place.headingRad, Vec3d(0, 1, 0));
    pose.localRotations[0] = Quatf(glm::normalize(turn * Quatd(pose.localRotations[0])));
}

/** Where the root stands now and which way it faces in the mean. */
GroundPlace groundOf(const ClipLayer& layer, std::span<const JointData> joints) {
    Pose pose;
    Vec2d facing(0);
    for (int k = 0; k < kHeadings; ++k) {
        sampleLayer(layer, joints, layer.timeS + kHeadingS * (double(k) / (kHeadings - 1) - 0.5), pose);
        const double heading = headingOf(pose.localRotations[0]);
        facing += Vec2d(std::sin(heading), std::cos(heading));
    }
    sampleLayer(layer, joints, layer.timeS, pose);
    GroundPlace ground = standing(joints, pose.localRotations[0], pose.rootTranslation);
    ground.headingRad = std::atan2(facing.x, facing.y);
    return ground;
}

/** Adds a rotation to a sum of rotations, by the shorter arc, so the sum only grows. */
Quatf plus(const Quatf& sum, const Quatf& q, float share) {
    return sum + q * (glm::dot(sum, q) < 0 ? -share : share);
}

}  // namespace

GroundPlace operator*(const GroundPlace& a, const GroundPlace& b) {
    return {a.headingRad + b.headingRad, turned(b.shiftM, a.headingRad) + a.shiftM};
}

GroundPlace inverse(const GroundPlace& place) {
    return {-place.headingRad, -turned(place.shiftM, -place.headingRad)};
}

GroundPlace repeated(const GroundPlace& place, double rounds) {
    // The sum of the shifts, each turned by one heading more than the one before it, is a geometric series.
    const double heading = std::remainder(place.headingRad, 2 * glm::pi<double>()), sine = std::sin(0.5 * heading);
    const double times = std::abs(sine) > 1e-12 ? std::sin(0.5 * rounds * heading) / sine : rounds;
    return {rounds * heading, turned(place.shiftM, 0.5 * (rounds - 1) * heading) * times};
}

GroundPlace placeAfter(const ClipLayer& before, const ClipLayer& layer, std::span<const JointData> joints) {
    ClipLayer unplaced = layer;
    unplaced.place = {};
    GroundPlace place = groundOf(before, joints) * inverse(groundOf(unplaced, joints));
    place.headingRad = std::remainder(place.headingRad, 2 * glm::pi<double>());
    return place;
}

Status ClipMix::check(std::span<const ClipLayer> layers, std::span<const JointData> joints) {
    if (layers.empty()) return fail(Code::InvalidArgument, "a mix needs at least one layer");
    double whole = 0;
    bool first = true;
    for (size_t i = 0; i < layers.size(); ++i) {
        const ClipLayer& layer = layers[i];
        if (!std::isfinite(layer.timeS)) return fail(Code::InvalidArgument, "layer {}: timeS is not finite", i);
        if (!std::isfinite(layer.weight) || layer.weight < 0)
            return fail(Code::InvalidArgument, "layer {}: the weight is {}; it must be finite and not below 0", i, layer.weight);
        const Vec2d& shift = layer.place.shiftM;
        if (!std::isfinite(layer.place.headingRad) || !std::isfinite(shift.x) || !std::isfinite(shift.y))
            return fail(Code::InvalidArgument, "layer {}: the heading or the shift is not finite", i);
        if (layer.joint >= joints.size())
            return fail(Code::NotFound, "layer {}: there is no joint {}; the avatar has {}", i, layer.joint, joints.size());
        if (layers[0].joint != 0)
            return fail(Code::InvalidArgument, "layer 0 moves only joint '{}' and what is below it; layers of the whole body come first",
                        joints[layer.joint].name);
        first = first && layer.joint == 0;
        if (first) whole += layer.weight;
    }
    if (!(whole > 0)) return fail(Code::InvalidArgument, "the weights of the layers of the whole body sum to 0, so nothing poses it");
    return {};
}

Status ClipMix::mix(std::span<const ClipLayer> layers, std::span<const JointData> joints, Pose& pose) {
    DPL_RETURN_IF_ERROR(check(layers, joints));
    for (size_t begin = 0; begin < layers.size();) {
        size_t end = begin;
        double total = 0;
        for (; end < layers.size() && layers[end].joint == layers[begin].joint; ++end) total += layers[end].weight;
        if (total > 0) {
            average(layers.subspan(begin, end - begin), total, joints);
            if (begin == 0)
                pose = average_;
            else
                put(layers[begin].joint, float(std::min(total, 1.0)), joints, pose);
        }
        begin = end;
    }
    return {};
}

void ClipMix::average(std::span<const ClipLayer> group, double total, std::span<const JointData> joints) {
    const auto most =
        std::max_element(group.begin(), group.end(), [](const ClipLayer& a, const ClipLayer& b) { return a.weight < b.weight; });
    sampleLayer(*most, joints, most->timeS, average_);
    if (most->weight == total) return;  // alone it keeps its bytes
    const float share = float(most->weight / total);
    for (Quatf& q : average_.localRotations) q *= share;
    average_.rootTranslation *= share;
    for (const ClipLayer& layer : group) {
        if (&layer == &*most || layer.weight == 0) continue;
        const float more = float(layer.weight / total);
        sampleLayer(layer, joints, layer.timeS, sampled_);
        for (size_t j = 0; j < joints.size(); ++j)
            average_.localRotations[j] = plus(average_.localRotations[j], sampled_.localRotations[j], more);
        average_.rootTranslation += more * sampled_.rootTranslation;
    }
    for (Quatf& q : average_.localRotations) q = glm::normalize(q);
}

void ClipMix::put(uint32_t joint, float share, std::span<const JointData> joints, Pose& pose) {
    moved_.assign(joints.size(), uint8_t(0));
    for (size_t j = 0; j < joints.size(); ++j) {
        moved_[j] = joint == 0 || j == joint || (joints[j].parent >= 0 && moved_[size_t(joints[j].parent)]);
        if (!moved_[j]) continue;
        Quatf& q = pose.localRotations[j];
        q = share < 1 ? glm::normalize(plus(q * (1 - share), average_.localRotations[j], share)) : average_.localRotations[j];
    }
    if (joint == 0) pose.rootTranslation = glm::mix(pose.rootTranslation, average_.rootTranslation, share);
}

}  // namespace dpl
