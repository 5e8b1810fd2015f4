// SPDX-License-Identifier: Apache-2.0
#include "sdk/motion/plant_feet.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <string>

#include "sdk/motion/clip.h"
#include "sdk/motion/limb.h"

namespace dpl {
namespace {

constexpr float kStandMPerS = 0.35f, kStandHeightM = 0.08f;  // walking feet pass at 1 m/s and more
constexpr float kSpeedWindowS = 0.04f;                       // speeds are taken over this time, so noise of 120 Hz does not matter
constexpr float kShortestStanceS = 0.08f, kShortestSwingS = 0.06f;
constexpr float kFloorM = 0.08f, kLargestOffsetM = 0.15f, kDeepestHipsM = 0.06f;
constexpr float kStraight = 0.995f;  // share of its length to which a leg is stretched; knees of straighter legs jump
constexpr float kFloorS = 0.04f;     // half of the time over which heights are averaged where heel gives way to ball
constexpr float kLargestToesUpRad = 0.5236f;
constexpr float kSinkS = 0.12f;  // half of the time over which the hips sink and rise

std::optional<size_t> jointOf(std::span<const JointData> joints, const std::string& bone) {
    for (size_t j = 0; j < joints.size(); ++j)
        if (joints[j].humanoidBone == bone) return j;
    return std::nullopt;
}

ClipChannel* channelOf(ClipData& clip, size_t joint) {
    for (ClipChannel& channel : clip.channels)
        if (channel.joint == joint) return &channel;
    return nullptr;
}

struct Key {
    std::vector<Quatf> rotations;  // world, J
    std::vector<Vec3f> positions;  // world, J
};

std::vector<Key> keysOf(std::span<const JointData> joints, const ClipData& clip) {
    std::vector<Key> keys(clip.timesS.size());
    for (size_t k = 0; k < keys.size(); ++k) {
        std::vector<Quatf>& turned = keys[k].rotations;
        std::vector<Vec3f>& at = keys[k].positions;
        turned.assign(joints.size(), Quatf(1, 0, 0, 0));
        at.resize(joints.size());
        for (const ClipChannel& channel : clip.channels) turned[channel.joint] = channel.rotations[k];
        for (size_t j = 0; j < joints.size(); ++j) {
            if (joints[j].parent < 0) {
                at[j] = joints[j].restPosition + (j == 0 && !clip.rootTranslations.empty() ? clip.rootTranslations[k] : Vec3f(0));
                continue;
            }
            const size_t p = size_t(joints[j].parent);
            at[j] = at[p] + turned[p] * (joints[j].restPosition - joints[p].restPosition);
            turned[j] = glm::normalize(turned[p] * turned[j]);
        }
    }
    return keys;
}

/** Inverts runs of `value` that are shorter than `shortestS`; runs at the ends stay. */
void dropShortRuns(std::span<const float> timesS, std::vector<uint8_t>& flags, bool value, float shortestS) {
    for (size_t begin = 0; begin < flags.size();) {
        size_t end = begin + 1;
        while (end < flags.size() && flags[end] == flags[begin]) ++end;
        if (bool(flags[begin]) == value && end < flags.size() && begin > 0 && timesS[end] - timesS[begin] < shortestS)
            std::fill(flags.begin() + std::ptrdiff_t(begin), flags.begin() + std::ptrdiff_t(end), uint8_t(!value));
        begin = end;
    }
}

std::vector<uint8_t> standing(std::span<const Key> keys, std::span<const float> timesS, size_t joint, float restHeightM) {
    std::vector<uint8_t> stands(keys.size(), 0);
    size_t a = 0, b = 0;
    for (size_t k = 0; k < keys.size(); ++k) {
        while (a < k && timesS[k] - timesS[a] > 0.5f * kSpeedWindowS + 1e-4f) ++a;
        while (b + 1 < keys.size() && timesS[b] - timesS[k] < 0.5f * kSpeedWindowS - 1e-4f) ++b;
        const size_t from = a == b && a > 0 ? a - 1 : a;
        if (from == b) continue;
        const float speed = glm::length(keys[b].positions[joint] - keys[from].positions[joint]) / (timesS[b] - timesS[from]);
        stands[k] = speed < kStandMPerS && keys[k].positions[joint].y - restHeightM < kStandHeightM;
    }
    dropShortRuns(timesS, stands, false, kShortestSwingS);
    dropShortRuns(timesS, stands, true, kShortestStanceS);
    return stands;
}

struct Leg {
    size_t upper = 0, lower = 0, foot = 0;
    std::optional<size_t> ball;
    std::vector<FootContact> contacts;  // K
    std::vector<Vec3f> offsets;         // K, of the foot, metres
};

std::vector<FootContact> contactsOf(std::span<const JointData> joints, std::span<const Key> keys, std::span<const float> timesS,
                                    std::optional<size_t> foot, std::optional<size_t> ball) {
    std::vector<FootContact> contacts(keys.size());
    if (ball) {
        const auto stands = standing(keys, timesS, *ball, joints[*ball].restPosition.y);
        for (size_t k = 0; k < keys.size(); ++k) contacts[k].ball = stands[k] != 0;
    }
    if (foot) {
        const auto stands = standing(keys, timesS, *foot, joints[*foot].restPosition.y);
        for (size_t k = 0; k < keys.size(); ++k) contacts[k].ankle = stands[k] != 0;
    }
    return contacts;
}

/** By how much the toes point up while ball and ankle stand, radians: the median over these keys, as a flat foot at rest has 0. Zero
 * without such keys, or beyond 30°. */
float toesUp(std::span<const JointData> joints, std::span<const Key> keys, const Leg& leg) {
    if (!leg.ball) return 0;
    const auto elevation = [](const Vec3f& v) { return std::atan2(v.y, std::hypot(v.x, v.z)); };
    const float flat = elevation(joints[*leg.ball].restPosition - joints[leg.foot].restPosition);
    std::vector<float> up;
    for (size_t k = 0; k < keys.size(); ++k)
        if (leg.contacts[k].ball && leg.contacts[k].ankle)
            up.push_back(elevation(keys[k].positions[*leg.ball] - keys[k].positions[leg.foot]) - flat);
    if (up.empty()) return 0;
    const auto middle = up.begin() + std::ptrdiff_t(up.size() / 2);
    std::nth_element(up.begin(), middle, up.end());
    return std::abs(*middle) < kLargestToesUpRad ? *middle : 0.0f;
}

float smooth(float t) {
    return t * t * (3 - 2 * t);
}

/** Mean over the values within windowS of each, of [begin, end). */
void average(std::span<const float> timesS, size_t begin, size_t end, float windowS, std::vector<float>& values) {
    const std::vector<float> in = values;
    for (size_t k = begin; k < end; ++k) {
        float sum = in[k], count = 1;
        for (size_t n = k; n > begin && timesS[k] - timesS[n - 1] <= windowS; --n) sum += in[n - 1], ++count;
        for (size_t n = k + 1; n < end && timesS[n] - timesS[k] <= windowS; ++n) sum += in[n], ++count;
        values[k] = sum / count;
    }
}

/** Fills leg.offsets: within a stance the standing point stays where it is, at its rest height. Between stances the offset passes over. */
void findOffsets(std::span<const JointData> joints, std::span<const Key> keys, std::span<const float> timesS, Leg& leg) {
    const size_t count = keys.size();
    leg.offsets.assign(count, Vec3f(0));
    std::vector<uint8_t> stands(count);
    for (size_t k = 0; k < count; ++k) stands[k] = leg.contacts[k].ball || leg.contacts[k].ankle;
    std::vector<float> up(count);  // offset that brings the standing point to its rest height
    std::optional<size_t> last;    // last key of the stance before
    for (size_t begin = 0; begin < count;) {
        if (!stands[begin]) {
            ++begin;
            continue;
        }
        size_t end = begin + 1;
        while (end < count && stands[end]) ++end;
        Vec3f sum(0);
        for (size_t k = begin; k < end; ++k) {
            const FootContact now = leg.contacts[k];
            const size_t joint = now.ball && leg.ball ? *leg.ball : leg.foot;
            if (k > begin) {
                const FootContact before = leg.contacts[k - 1];
                const bool ball = now.ball && before.ball, ankle = now.ankle && before.ankle;
                const size_t held = ball && leg.ball ? *leg.ball : leg.foot;
                const Vec3f moved = ball || ankle ? keys[k].positions[held] - keys[k - 1].positions[held] : Vec3f(0);
                leg.offsets[k] = leg.offsets[k - 1] - moved;
            }
            sum += leg.offsets[k];
            up[k] = std::clamp(joints[joint].restPosition.y - keys[k].positions[joint].y, -kFloorM, kFloorM);
        }
        average(timesS, begin, end, kFloorS, up);
        sum /= float(end - begin);
        for (size_t k = begin; k < end; ++k) {
            leg.offsets[k] -= sum;  // the least offset that holds the foot
            leg.offsets[k].y = up[k];
            if (const float length = glm::length(leg.offsets[k]); length > kLargestOffsetM) leg.offsets[k] *= kLargestOffsetM / length;
        }
        for (size_t k = last ? *last + 1 : 0; k < begin; ++k) {
            const Vec3f from = last ? leg.offsets[*last] : leg.offsets[begin];
            const float t = last ? (timesS[k] - timesS[*last]) / (timesS[begin] - timesS[*last]) : 1.0f;
            leg.offsets[k] = glm::mix(from, leg.offsets[begin], smooth(t));
        }
        last = end - 1;
        begin = end;
    }
    for (size_t k = last ? *last + 1 : count; k < count; ++k) leg.offsets[k] = leg.offsets[*last];
}

/** By how much the hips must sink so that a leg reaches its ankle; hip: the leg's upper joint. */
float sinkFor(const Vec3f& hip, const Vec3f& ankle, float lengthM) {
    const Vec3f v = ankle - hip;
    const float across = v.x * v.x + v.z * v.z, free = lengthM * lengthM - across;
    if (glm::dot(v, v) <= lengthM * lengthM || free <= 0) return 0;
    return std::clamp(-v.y - std::sqrt(free), 0.0f, kDeepestHipsM);
}

/** The largest value within kSinkS of each key, averaged over the same time: never less than the value itself. */
std::vector<float> spread(std::span<const float> timesS, const std::vector<float>& values) {
    const auto over = [&](const std::vector<float>& in, auto&& join) {
        std::vector<float> out(in.size());
        for (size_t k = 0; k < in.size(); ++k) {
            size_t a = k, b = k;
            while (a > 0 && timesS[k] - timesS[a - 1] <= kSinkS) --a;
            while (b + 1 < in.size() && timesS[b + 1] - timesS[k] <= kSinkS) ++b;
            out[k] = join(std::span(in).subspan(a, b - a + 1));
        }
        return out;
    };
    const auto largest = over(values, [](std::span<const float> v) { return *std::max_element(v.begin(), v.end()); });
    return over(largest, [](std::span<const float> v) {
        float sum = 0;
        for (const float x : v) sum += x;
        return sum / float(v.size());
    });
}

}  // namespace

std::vector<FootContact> footContacts(std::span<const JointData> joints, const ClipData& clip, std::string_view side) {
    const std::string s(side);
    return contactsOf(joints, keysOf(joints, clip), clip.timesS, jointOf(joints, s + "Foot"), jointOf(joints, s + "Toes"));
}

void plantFeet(std::span<const JointData> joints, ClipData& clip) {
    const size_t count = clip.timesS.size();
    if (count < 2 || joints.empty()) return;
    std::vector<Key> keys = keysOf(joints, clip);
    std::vector<Leg> legs;
    for (const std::string side : {"left", "right"}) {
        const auto upper = jointOf(joints, side + "UpperLeg"), lower = jointOf(joints, side + "LowerLeg"),
                   foot = jointOf(joints, side + "Foot");
        if (!upper || !lower || !foot || joints[*lower].parent != int32_t(*upper) || joints[*foot].parent != int32_t(*lower)) continue;
        if (joints[*upper].parent < 0 || !channelOf(clip, *upper) || !channelOf(clip, *lower) || !channelOf(clip, *foot)) continue;
        Leg leg{*upper, *lower, *foot, jointOf(joints, side + "Toes"), {}, {}};
        leg.contacts = contactsOf(joints, keys, clip.timesS, foot, leg.ball);
        const Quatf flatten = glm::angleAxis(toesUp(joints, keys, leg), Vec3f(1, 0, 0));
        for (Quatf& rotation : channelOf(clip, *foot)->rotations) rotation = glm::normalize(rotation * flatten);
        legs.push_back(std::move(leg));
    }
    keys = keysOf(joints, clip);  // with flat feet
    for (Leg& leg : legs) {
        leg.contacts = contactsOf(joints, keys, clip.timesS, leg.foot, leg.ball);
        findOffsets(joints, keys, clip.timesS, leg);
    }
    std::vector<float> sink(count, 0.0f);
    for (const Leg& leg : legs)
        for (size_t k = 0; k < count; ++k) {
            const auto& at = keys[k].positions;
            const float length = glm::length(at[leg.lower] - at[leg.upper]) + glm::length(at[leg.foot] - at[leg.lower]);
            const float allowed = std::max(kStraight * length, glm::length(at[leg.foot] - at[leg.upper]));
            sink[k] = std::max(sink[k], sinkFor(at[leg.upper], at[leg.foot] + leg.offsets[k], allowed));
        }
    sink = spread(clip.timesS, sink);
    if (clip.rootTranslations.empty()) clip.rootTranslations.assign(count, Vec3f(0));
    for (size_t k = 0; k < count; ++k) {
        const Vec3f down(0, -sink[k], 0);
        clip.rootTranslations[k] += down;
        for (const Leg& leg : legs) {
            const auto& at = keys[k].positions;
            const auto& turned = keys[k].rotations;
            const auto solved = reachWith({at[leg.upper] + down, at[leg.lower] + down, at[leg.foot] + down}, at[leg.foot] + leg.offsets[k],
                                          turned[leg.upper] * Vec3f(0, 0, 1));
            const Quatf upper = solved[0] * turned[leg.upper], lower = solved[1] * turned[leg.lower];
            const auto set = [&](size_t joint, const Quatf& above, const Quatf& world) {
                std::vector<Quatf>& rotations = channelOf(clip, joint)->rotations;
                Quatf local = glm::normalize(glm::conjugate(above) * world);
                if (k > 0 && glm::dot(rotations[k - 1], local) < 0) local = -local;
                rotations[k] = local;
            };
            set(leg.upper, turned[size_t(joints[leg.upper].parent)], upper);
            set(leg.lower, upper, lower);
            set(leg.foot, lower, turned[leg.foot]);
        }
    }
}

}  // namespace dpl
