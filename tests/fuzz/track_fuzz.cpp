// SPDX-License-Identifier: Apache-2.0
// Fuzz target of trackers. The input damages a synthetic stream; no frame may crash or give a pose that is not one.
//   byte: format, byte: options (bit 0 raw, 1 keeps place, 2 in place, 3 rest pose damaged too)
//   then frames: byte: kind (0 a frame, 1 sides mirrored, 2 scaled by 10), int64: nanoseconds since the last one, then
//     damages: byte 1, byte joint, byte number (0-3 rotation, 4-6 position, 7 confidence), float; any other byte ends them
#include <cstdio>
#include <cstdlib>
#include <cstring>

#include "sdk/motion/tracker.h"
#include "tests/unit/motion/track_streams.h"

namespace {

void mustHold(bool condition, const char* what) {
    if (condition) return;
    std::fprintf(stderr, "fuzz: %s\n", what);
    std::abort();
}

class Input {
public:
    Input(const uint8_t* data, size_t size) : at_(data), end_(data + size) {}
    bool done() const { return at_ == end_; }
    template <class T>
    T next() {
        T value{};
        const size_t count = std::min(sizeof value, size_t(end_ - at_));
        std::memcpy(&value, at_, count);
        at_ += count;
        return value;
    }

private:
    const uint8_t *at_, *end_;
};

void damage(Input& in, std::vector<float>& rotations, std::vector<float>& positions, std::vector<float>& confidence) {
    while (!in.done() && in.next<uint8_t>() == 1) {
        const size_t joint = in.next<uint8_t>() % confidence.size(), number = in.next<uint8_t>() % 8;
        const float value = in.next<float>();
        (number < 4 ? rotations[4 * joint + number] : number < 7 ? positions[3 * joint + number - 4] : confidence[joint]) = value;
    }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
    using namespace dpl;
    static const std::vector<JointData> performer = test::personRig(0.0f), avatar = test::personRig(0.8f);
    Input in(data, size);
    const auto format = TrackFormat(in.next<uint8_t>() % kTrackFormats);
    const uint8_t bits = in.next<uint8_t>();
    TrackerOptions options;
    options.raw = bits & 1, options.keepPlace = bits & 2, options.inPlace = bits & 4;
    test::Stream stream(format, performer, 1);
    if (bits & 8) damage(in, stream.restRotations, stream.restPositions, stream.confidence);
    auto tracker = Tracker::create(avatar, format, options, stream.rest());
    mustHold(tracker || !tracker.error().message.empty(), "an error without a sentence");
    if (!tracker) return 0;
    uint64_t timeNs = 0;
    for (int k = 0; k < 40 && !in.done(); ++k) {
        stream.show(test::swing(performer, 0.03 * k));
        const uint8_t kind = in.next<uint8_t>() % 3;
        timeNs += in.next<uint64_t>();  // wraps round
        if (kind == 1)
            for (size_t i = 0; i < stream.positions.size(); i += 3) stream.positions[i] *= -1;
        if (kind == 2)
            for (float& p : stream.positions) p *= 10;
        damage(in, stream.rotations, stream.positions, stream.confidence);
        const auto added = (*tracker)->add(stream.frame(int64_t(timeNs)));
        mustHold(added || !added.error().message.empty(), "an error without a sentence");
        for (const uint64_t later : {uint64_t(0), uint64_t(20'000'000), uint64_t(400'000'000)}) {
            Pose pose = Pose::rest(avatar.size());
            (*tracker)->pose(int64_t(timeNs + later), (bits & 16) == 0, pose);
            const auto good = checkPose(avatar, pose);
            mustHold(bool(good), "a pose that is not finite or has rotations of zero");
            for (const Quatf& q : pose.localRotations) mustHold(std::abs(glm::length(q) - 1) < 1e-3f, "a rotation that is not of length 1");
        }
    }
    return 0;
}
