// SPDX-License-Identifier: Apache-2.0
// An avatar follows every kind of tracker. Prints degrees and millimetres per format, and the delay in frames.
#include "sdk/motion/tracker.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>

#include "sdk/motion/retarget.h"
#include "tests/unit/motion/mocap.h"
#include "tests/unit/motion/track_streams.h"

namespace dpl {
namespace {

using test::Performer;
using test::personRig;
using test::Stream;
using test::StreamNoise;
using test::swing;

constexpr int64_t kSecond = 1'000'000'000, kStartNs = 5 * kSecond;

/** A performer of other build and rest pose than the avatar: in T-pose, 1.45 m high. */
std::vector<JointData> performerRig() {
    auto rig = personRig(0.0f, 0.0f);
    for (JointData& joint : rig) joint.restPosition *= Vec3f(0.82f, 0.86f, 0.86f);
    return rig;
}

std::vector<JointData> avatarRig() {
    return personRig(0.8f);
}

std::unique_ptr<Tracker> trackerFor(const Stream& stream, TrackFormat format, TrackerOptions options = {}) {
    auto made = Tracker::create(avatarRig(), format, options, stream.rest());
    EXPECT_TRUE(made) << made.error().message;
    return made ? std::move(*made) : nullptr;
}

Pose posed(Tracker& tracker, int64_t timeNs, size_t joints) {
    Pose pose = Pose::rest(joints);
    tracker.pose(timeNs, true, pose);
    EXPECT_TRUE(checkPose(avatarRig(), pose));
    return pose;
}

struct Limb {
    const char *bone, *next;
};
constexpr Limb kArms[] = {{"leftUpperArm", "leftLowerArm"}, {"leftLowerArm", "leftHand"},       {"rightUpperArm", "rightLowerArm"},
                          {"rightLowerArm", "rightHand"},   {"leftHand", "leftMiddleProximal"}, {"rightHand", "rightMiddleProximal"}};
constexpr Limb kLegs[] = {
    {"leftUpperLeg", "leftLowerLeg"}, {"leftLowerLeg", "leftFoot"}, {"rightUpperLeg", "rightLowerLeg"}, {"rightLowerLeg", "rightFoot"}};
constexpr const char* kTorso[] = {"hips", "upperChest", "head"};

float degreesBetween(const Vec3f& a, const Vec3f& b) {
    return glm::degrees(std::acos(std::clamp(glm::dot(glm::normalize(a), glm::normalize(b)), -1.0f, 1.0f)));
}

/** Mean degrees by which the avatar's bones point elsewhere than the performer's; of the torso, by which they are turned. */
struct Errors {
    double arms = 0, legs = 0, torso = 0, hands = 0, wristMm = 0;
    int count = 0;

    void add(const Performer& performer, const Performer& avatar, const Quatf& heading) {
        const auto mean = [&](auto&& limbs) {
            double sum = 0;
            for (const Limb& limb : limbs) {
                const auto direction = [&](const Performer& p) { return p.positions[p.at(limb.next)] - p.positions[p.at(limb.bone)]; };
                sum += double(degreesBetween(heading * direction(performer), direction(avatar)));
            }
            return sum / double(std::size(limbs));
        };
        const auto turned = [&](const char* bone) {
            return double(glm::degrees(
                glm::length(stepBetween(heading * performer.rotations[performer.at(bone)], avatar.rotations[avatar.at(bone)]))));
        };
        arms += mean(kArms), legs += mean(kLegs);
        for (const char* bone : kTorso) torso += turned(bone) / 3;
        for (const std::string side : {"left", "right"}) {
            const auto palm = [&](const Performer& p) {
                const auto from = [&](const char* knuckle) { return p.positions[p.at(side + knuckle)] - p.positions[p.at(side + "Hand")]; };
                return glm::cross(from("IndexProximal"), from("LittleProximal"));
            };
            hands += 0.5 * double(degreesBetween(heading * palm(performer), palm(avatar)));
        }
        for (const char* bone : {"leftHand", "rightHand"})
            wristMm += 500 * double(glm::length(heading * performer.positions[performer.at(bone)] - avatar.positions[avatar.at(bone)]));
        ++count;
    }
    void finish() { arms /= count, legs /= count, torso /= count, hands /= count, wristMm /= count; }
};

using Motion3 = std::function<Pose(double)>;  // pose of the performer at a time

/** Runs a stream of `seconds` at `hz` and compares pose and performer at the times of the frames. */
Errors follow(TrackFormat format, const Motion3& motion, StreamNoise noise, TrackerOptions options, double hz, double seconds,
              float headingRad = 0) {
    Stream stream(format, performerRig(), 7, noise, headingRad);
    const auto tracker = trackerFor(stream, format, options);
    Performer avatar{avatarRig(), {}, {}};
    Errors errors;
    if (!tracker) return errors;
    for (int k = 0; k < int(seconds * hz); ++k) {
        const int64_t timeNs = kStartNs + int64_t(double(k) / hz * double(kSecond));
        stream.show(motion(double(k) / hz));
        EXPECT_TRUE(tracker->add(stream.frame(timeNs)));
        avatar.show(posed(*tracker, timeNs, avatar.rig.size()));
        if (k > 30) errors.add(stream.performer, avatar, glm::angleAxis(headingRad, Vec3f(0, 1, 0)));
    }
    errors.finish();
    return errors;
}

const char* nameOf(TrackFormat format) {
    static constexpr const char* kNames[] = {"VRM", "Unity", "ARKit", "FB body", "OpenXR hands", "MediaPipe"};
    return kNames[size_t(format)];
}

TEST(Tracker, boneFormatsAreExactWithoutNoise) {
    const auto rig = performerRig();
    TrackerOptions raw;
    raw.raw = true;
    for (const TrackFormat format : {TrackFormat::Vrm, TrackFormat::Unity, TrackFormat::ArkitBody, TrackFormat::FbBody}) {
        SCOPED_TRACE(nameOf(format));
        for (const float heading : {0.0f, 2.0f}) {
            const Errors e = follow(
                format, [&](double t) { return swing(rig, t); }, {}, raw, 60, 3,
                format == TrackFormat::Unity ? 3.14159265f + heading : heading);
            std::printf("%-12s exact: arms %.2f legs %.2f torso %.2f degrees\n", nameOf(format), e.arms, e.legs, e.torso);
            EXPECT_LT(e.arms, 0.1);
            EXPECT_LT(e.torso, 0.1);
            EXPECT_LT(e.hands, 0.1);
            if (format != TrackFormat::FbBody) {  // which knows no legs
                EXPECT_LT(e.legs, 0.1);
            }
        }
    }
}

TEST(Tracker, pointsTellDirectionsAndTwists) {
    const auto rig = performerRig();
    TrackerOptions raw;
    raw.raw = true;
    const Errors e = follow(
        TrackFormat::MediapipePose, [&](double t) { return swing(rig, t); }, {}, raw, 30, 4);
    std::printf("MediaPipe    exact points: arms %.2f legs %.2f torso %.2f, palms %.2f degrees\n", e.arms, e.legs, e.torso, e.hands);
    EXPECT_LT(e.arms, 3);
    EXPECT_LT(e.legs, 3);
    EXPECT_LT(e.torso, 10);
}

/** The performer's motions: a recorded clip on the performer's rig, as a function of time. */
std::optional<ClipData> recorded(const char* name) {
    const auto motion = test::mocap(name);
    if (!motion) return std::nullopt;
    RetargetOptions options;
    options.plantFeet = options.levelHead = false;
    auto clip = retarget(*motion, performerRig(), options);
    EXPECT_TRUE(clip);
    return clip ? std::optional(std::move(*clip)) : std::nullopt;
}

struct Table {
    TrackFormat format;
    double hz;
    StreamNoise noise;  // white, assumed: no device was at hand
    // Bars: 1.3 times the largest that was measured over the motions below, degrees and mm; 0: the format does not tell.
    double armsDeg, legsDeg, torsoDeg, palmsDeg, wristsMm;
};
constexpr Table kTables[] = {
    {TrackFormat::Vrm, 60, {0, 0}, 0.2, 0.5, 0.3, 0.3, 0},
    {TrackFormat::Unity, 60, {0, 0}, 0.2, 0.5, 0.3, 0.3, 0},
    {TrackFormat::ArkitBody, 60, {0.0087f, 0.005f}, 2.6, 2.1, 2.7, 3.2, 0},
    {TrackFormat::FbBody, 72, {0.0052f, 0.003f}, 1.0, 0, 0.8, 1.2, 0},
    {TrackFormat::OpenxrHands, 72, {0.0052f, 0.001f}, 0, 0, 0, 0.6, 80},
    {TrackFormat::MediapipePose, 30, {0, 0.004f}, 6.0, 3.5, 10.0, 12.1, 0},
};

TEST(Tracker, smoothedStreamsStayNearTheirPerformer) {
    const auto rig = performerRig();
    std::vector<std::pair<std::string, Motion3>> motions = {{"synthetic", [&](double t) { return swing(rig, t); }}};
    std::vector<ClipData> clips;
    clips.reserve(3);
    for (const char* name : {"02_01", "02_05", "09_01"})
        if (auto clip = recorded(name)) {
            clips.push_back(std::move(*clip));
            motions.push_back({name, [&rig, at = &clips.back()](double t) { return samplePose(*at, rig, t); }});
        }
    if (clips.empty()) std::printf("shared/data/mocap-cmu is not at hand: the synthetic motion alone\n");
    for (const Table& table : kTables) {
        for (const auto& [name, motion] : motions) {
            SCOPED_TRACE(std::string(nameOf(table.format)) + " " + name);
            const double seconds = name == "synthetic" ? 4.0 : 2.5;
            TrackerOptions options;
            options.keepPlace = true;
            const Errors e = follow(table.format, motion, table.noise, options, table.hz, seconds);
            const auto check = [](const char* what, double value, double bar) {
                if (bar > 0)
                    std::printf(" %s %.2f", what, value);
                else
                    std::printf(" %s -", what);
                EXPECT_TRUE(bar <= 0 || value < bar) << what << " " << value << ", bar " << bar;
            };
            std::printf("%-13s %-9s %2.0f Hz, degrees:", nameOf(table.format), name.c_str(), table.hz);
            check("arms", e.arms, table.armsDeg), check("legs", e.legs, table.legsDeg), check("torso", e.torso, table.torsoDeg);
            check("palms", e.hands, table.palmsDeg), check("wrists (mm)", e.wristMm, table.wristsMm);
            std::printf("\n");
        }
    }
}

/** Rotation of an elbow about its hinge over time, radians: of a stream at `hz` whose pictures are shown aheadS after each frame. */
struct Elbow {
    std::vector<double> timesS, angles;
    double filterFrames = 0;
};

Elbow elbowOf(TrackerOptions options, StreamNoise noise, double hz, double aheadS) {
    const auto rig = performerRig();
    Stream stream(TrackFormat::ArkitBody, rig, 3, noise);
    const auto tracker = trackerFor(stream, TrackFormat::ArkitBody, options);
    Performer avatar{avatarRig(), {}, {}};
    Elbow elbow;
    std::vector<double> delays;
    for (int k = 0; k < int(8 * hz); ++k) {
        const double timeS = double(k) / hz;
        stream.show(swing(rig, timeS));
        EXPECT_TRUE(tracker->add(stream.frame(kStartNs + int64_t(timeS * double(kSecond)))));
        avatar.show(posed(*tracker, kStartNs + int64_t((timeS + aheadS) * double(kSecond)), avatar.rig.size()));
        if (timeS < 1) continue;
        const Vec3f upper = avatar.positions[avatar.at("leftLowerArm")] - avatar.positions[avatar.at("leftUpperArm")],
                    lower = avatar.positions[avatar.at("leftHand")] - avatar.positions[avatar.at("leftLowerArm")];
        elbow.timesS.push_back(timeS + aheadS);
        elbow.angles.push_back(double(glm::radians(degreesBetween(upper, lower))));
        delays.push_back(double(tracker->status().delayS) * hz);
    }
    std::nth_element(delays.begin(), delays.begin() + std::ptrdiff_t(delays.size() / 2), delays.end());
    elbow.filterFrames = delays[delays.size() / 2];
    return elbow;
}

/** Seconds by which the avatar's elbow lags behind the performer's: the shift with the least squared difference. */
double lagS(const Elbow& elbow) {
    Performer performer{performerRig(), {}, {}};
    double best = 1e9, lag = 0;
    for (double shift = -0.06; shift <= 0.12; shift += 0.001) {
        double sum = 0;
        for (size_t i = 0; i < elbow.timesS.size(); i += 4) {
            performer.show(swing(performer.rig, elbow.timesS[i] - shift));
            const Vec3f upper = performer.positions[performer.at("leftLowerArm")] - performer.positions[performer.at("leftUpperArm")],
                        lower = performer.positions[performer.at("leftHand")] - performer.positions[performer.at("leftLowerArm")];
            const double d = double(glm::radians(degreesBetween(upper, lower))) - elbow.angles[i];
            sum += d * d;
        }
        if (sum < best) best = sum, lag = shift;
    }
    return lag;
}

TEST(Tracker, delayOfTheFilterIsMadeUpForByExtrapolation) {
    struct Case {
        const char* name;
        StreamNoise noise;
        bool raw;
        double aheadS, leastFrames, mostFrames;  // measured, and 0.3 frames to either side
    };
    for (const Case& c :
         {Case{"raw", {0.0087f, 0}, true, 0, -0.4, 0.3}, Case{"raw, 2 frames ahead", {0.0087f, 0}, true, 2 / 60.0, 1.7, 2.3},
          Case{"smoothed", {0.0087f, 0}, false, 0, 0.2, 0.9}, Case{"smoothed, 2 frames ahead", {0.0087f, 0}, false, 2 / 60.0, 1.4, 2.0},
          Case{"no noise, 2 frames ahead", {0, 0}, false, 2 / 60.0, 0.2, 0.9}}) {
        TrackerOptions options;
        options.raw = c.raw;
        const Elbow elbow = elbowOf(options, c.noise, 60, c.aheadS);
        const double frames = lagS(elbow) * 60;
        std::printf("elbow at 60 Hz, %-26s lags by %5.2f frames; group delay of the filter %.2f frames (median)\n", c.name, frames,
                    elbow.filterFrames);
        EXPECT_GE(frames, c.leastFrames) << c.name;
        EXPECT_LE(frames, c.mostFrames) << c.name;
    }
}

/** Standard deviation of the wrist of a person who stands still, mm. */
double jitterMm(bool raw) {
    const auto rig = performerRig();
    Stream stream(TrackFormat::ArkitBody, rig, 5, {0.0087f, 0.005f});
    TrackerOptions options;
    options.raw = raw;
    const auto tracker = trackerFor(stream, TrackFormat::ArkitBody, options);
    Performer avatar{avatarRig(), {}, {}};
    Vec3f sum(0);
    float squares = 0;
    int count = 0;
    for (int k = 0; k < 600; ++k) {
        stream.show(swing(rig, 0.2));
        EXPECT_TRUE(tracker->add(stream.frame(kStartNs + k * kSecond / 60)));
        avatar.show(posed(*tracker, kStartNs + k * kSecond / 60 + 20'000'000, avatar.rig.size()));
        if (k < 300) continue;
        const Vec3f wrist = avatar.positions[avatar.at("leftHand")] - avatar.positions[avatar.at("hips")];
        sum += wrist, squares += glm::dot(wrist, wrist), ++count;
    }
    if (!raw) {
        EXPECT_NEAR(tracker->status().noiseDeg, 0.5f, 0.25f) << "the filter learns the noise of the stream";
        EXPECT_NEAR(tracker->status().rateHz, 60, 1);
    }
    const Vec3f mean = sum / float(count);
    return 1000 * double(std::sqrt(std::max(0.0f, squares / float(count) - glm::dot(mean, mean))));
}

TEST(Tracker, aStillPersonHardlyTrembles) {
    const double raw = jitterMm(true), smoothed = jitterMm(false);
    std::printf("wrist of a still person, ARKit with 0.5 degrees of noise: %.1f mm raw, %.1f mm smoothed and extrapolated by 20 ms\n", raw,
                smoothed);
    EXPECT_GT(raw, 4);
    EXPECT_LT(smoothed, 0.7 * raw) << "measured 0.57";
}

/** Largest step of any joint from one picture at 90 Hz to the next, degrees, while the stream fails from lostS to backS. */
struct Fate {
    float largestStepDeg = 0;
    TrackerState whileLost = TrackerState::Waiting, after = TrackerState::Waiting;
    uint32_t drivenWhileLost = 0;
    float lostFromRestDeg = 0;
};

Fate survive(const std::function<void(Stream&, double)>& damage, double lostS, double backS, TrackFormat format = TrackFormat::ArkitBody) {
    const auto rig = performerRig();
    Stream stream(format, rig, 3);
    const auto tracker = trackerFor(stream, format);
    const size_t joints = avatarRig().size();
    Pose before;
    Fate fate;
    double nextFrameS = 0;
    for (double t = 0; t < backS + 2; t += 1 / 90.0) {
        for (; nextFrameS <= t; nextFrameS += 1 / 60.0) {
            stream.show(swing(rig, nextFrameS));
            const bool lost = nextFrameS >= lostS && nextFrameS < backS;
            if (lost) damage(stream, nextFrameS);
            if (!stream.positions.empty()) (void)tracker->add(stream.frame(kStartNs + int64_t(nextFrameS * 1e9)));
        }
        const Pose now = posed(*tracker, kStartNs + int64_t(t * 1e9), joints);
        for (size_t j = 0; j < joints && !before.localRotations.empty(); ++j)
            fate.largestStepDeg =
                std::max(fate.largestStepDeg, glm::degrees(glm::length(stepBetween(before.localRotations[j], now.localRotations[j]))));
        before = now;
        if (t < backS - 0.02) {
            fate.whileLost = tracker->status().state, fate.drivenWhileLost = tracker->status().drivenJoints;
            fate.lostFromRestDeg = 0;
            for (const Quatf& q : now.localRotations)
                fate.lostFromRestDeg = std::max(fate.lostFromRestDeg, glm::degrees(glm::length(stepBetween(Quatf(1, 0, 0, 0), q))));
        }
        fate.after = tracker->status().state;
    }
    return fate;
}

// Largest step of an undamaged stream: 3.4 degrees at 90 Hz (an elbow at 300 degrees a second). Fades of 70 degrees in 0.25 s add 4.7.
constexpr float kStepBarDeg = 9;

TEST(Tracker, gapsFadeOutAndInWithoutAJump) {
    const Fate whole = survive([](Stream&, double) {}, 2, 3);
    std::printf("largest step between pictures at 90 Hz: %.2f degrees undamaged\n", double(whole.largestStepDeg));
    EXPECT_LT(whole.largestStepDeg, 5);
    EXPECT_EQ(whole.whileLost, TrackerState::Tracking);
    const auto gap = [](Stream& s, double) { s.positions.clear(); };
    for (const double length : {0.15, 0.5, 2.0}) {
        const Fate fate = survive(gap, 2, 2 + length);
        std::printf("  gap of %.2f s: %.2f degrees\n", length, double(fate.largestStepDeg));
        EXPECT_LT(fate.largestStepDeg, kStepBarDeg) << length;
        EXPECT_EQ(fate.after, TrackerState::Tracking);
        EXPECT_EQ(fate.whileLost, length > 0.35 ? TrackerState::Lost : TrackerState::Tracking);
        if (length > 1) {
            EXPECT_EQ(fate.drivenWhileLost, 0u);
            EXPECT_LT(fate.lostFromRestDeg, 0.1f) << "after 0.8 s the pose beneath shows";
        }
    }
}

TEST(Tracker, numbersThatAreNotFiniteAreJointsThatAreNotTracked) {
    const float nan = std::numeric_limits<float>::quiet_NaN(), infinite = std::numeric_limits<float>::infinity();
    for (const float bad : {nan, infinite, 1e30f}) {
        const Fate fate = survive([&](Stream& s, double) { std::fill(s.positions.begin(), s.positions.end(), bad); }, 2, 4);
        EXPECT_EQ(fate.whileLost, TrackerState::Lost);
        EXPECT_EQ(fate.after, TrackerState::Tracking);
        EXPECT_LT(fate.largestStepDeg, kStepBarDeg);
    }
    const Fate arm = survive([&](Stream& s, double) { s.rotations[4 * 20] = nan, s.rotations[4 * 21 + 3] = nan; }, 2, 4);
    EXPECT_EQ(arm.whileLost, TrackerState::Tracking) << "one arm of ARKit's is lost, the rest goes on";
    EXPECT_LT(arm.largestStepDeg, kStepBarDeg);
    const Fate none = survive([&](Stream& s, double) { std::fill(s.confidence.begin(), s.confidence.end(), 0.49f); }, 2, 4);
    EXPECT_EQ(none.whileLost, TrackerState::Lost);
    const Fate zeros = survive([&](Stream& s, double) { std::fill(s.rotations.begin(), s.rotations.end(), 0.0f); }, 2, 4);
    EXPECT_EQ(zeros.whileLost, TrackerState::Lost);
}

/** Exchanges what the names of a format call left and right. */
void swapSides(TrackFormat format, Stream& s) {
    const auto table = trackedJoints(format);
    for (size_t j = 0; j < table.size(); ++j) {
        if (!table[j].name.starts_with("left") && !table[j].name.starts_with("LEFT")) continue;
        const std::string other = (table[j].name[0] == 'l' ? "right" : "RIGHT") + table[j].name.substr(4);
        for (size_t k = 0; k < table.size(); ++k)
            if (table[k].name == other) {
                std::swap_ranges(s.rotations.begin() + std::ptrdiff_t(4 * j), s.rotations.begin() + std::ptrdiff_t(4 * j + 4),
                                 s.rotations.begin() + std::ptrdiff_t(4 * k));
                std::swap_ranges(s.positions.begin() + std::ptrdiff_t(3 * j), s.positions.begin() + std::ptrdiff_t(3 * j + 3),
                                 s.positions.begin() + std::ptrdiff_t(3 * k));
            }
    }
}

TEST(Tracker, swappedSidesAreNoticedAndDropped) {
    const auto rig = performerRig();
    for (const TrackFormat format :
         {TrackFormat::Vrm, TrackFormat::ArkitBody, TrackFormat::FbBody, TrackFormat::MediapipePose, TrackFormat::OpenxrHands}) {
        SCOPED_TRACE(nameOf(format));
        Stream stream(format, rig, 3);
        const auto tracker = trackerFor(stream, format);
        for (int k = 0; k < 60; ++k) {
            stream.show(swing(rig, k / 30.0));
            ASSERT_TRUE(tracker->add(stream.frame(kStartNs + k * kSecond / 30))) << "a true frame is taken";
            stream.show(swing(rig, k / 30.0 + 0.01));
            swapSides(format, stream);
            const auto swapped = tracker->add(stream.frame(kStartNs + k * kSecond / 30 + 10'000'000));
            ASSERT_FALSE(swapped);
            EXPECT_EQ(swapped.error().code, Code::CorruptData);
            EXPECT_NE(swapped.error().message.find("swapped"), std::string::npos);
        }
        EXPECT_EQ(tracker->status().framesTaken, 60u);
        EXPECT_EQ(tracker->status().framesDropped, 60u);
    }
    Stream stream(TrackFormat::ArkitBody, rig, 3);
    std::swap(stream.restPositions, stream.positions), std::swap(stream.restRotations, stream.rotations);
    swapSides(TrackFormat::ArkitBody, stream);
    std::swap(stream.restPositions, stream.positions), std::swap(stream.restRotations, stream.rotations);
    const auto made = Tracker::create(avatarRig(), TrackFormat::ArkitBody, {}, stream.rest());
    ASSERT_FALSE(made) << "a rest pose with swapped sides";
    EXPECT_EQ(made.error().code, Code::CorruptData);
}

TEST(Tracker, anotherSkeletonIsRefused) {
    const auto rig = performerRig();
    Stream stream(TrackFormat::ArkitBody, rig, 3);
    const auto tracker = trackerFor(stream, TrackFormat::ArkitBody);
    stream.show(swing(rig, 1));
    for (const float scale : {0.8f, 1.3f}) {
        Stream other = stream;
        for (float& p : other.positions) p *= scale;
        EXPECT_TRUE(tracker->add(other.frame(kStartNs + int64_t(scale * 1e9f)))) << "a person of another size is no other skeleton";
    }
    Stream centimetres = stream;
    for (float& p : centimetres.positions) p *= 3;
    EXPECT_EQ(tracker->add(centimetres.frame(kStartNs + 3 * kSecond)).error().code, Code::CorruptData);
    Stream shuffled = stream;
    std::rotate(shuffled.positions.begin(), shuffled.positions.begin() + 30, shuffled.positions.end());
    EXPECT_EQ(tracker->add(shuffled.frame(kStartNs + 3 * kSecond)).error().code, Code::CorruptData);
    TrackFrame less = stream.frame(kStartNs + 3 * kSecond);
    less.positions = less.positions.first(270);
    EXPECT_EQ(tracker->add(less).error().code, Code::InvalidArgument);
    less = stream.frame(kStartNs + 3 * kSecond);
    less.rotations = {};
    EXPECT_EQ(tracker->add(less).error().code, Code::InvalidArgument);
    EXPECT_FALSE(Tracker::create(avatarRig(), TrackFormat::ArkitBody, {}, {})) << "ARKit's rest must be given";
    EXPECT_FALSE(Tracker::create(avatarRig(), TrackFormat(6), {}, {}));
    auto nameless = avatarRig();
    nameless.resize(6);  // a trunk without limbs
    for (JointData& joint : nameless) joint.humanoidBone.clear(), joint.name = "bone";
    EXPECT_EQ(Tracker::create(nameless, TrackFormat::Vrm, {}, {}).error().code, Code::Unsupported);
    Stream lying = stream;
    for (size_t j = 0; j < 91; ++j) lying.restPositions[3 * j] = lying.restPositions[3 * j + 1] = 0;
    EXPECT_EQ(Tracker::create(avatarRig(), TrackFormat::ArkitBody, {}, lying.rest()).error().code, Code::CorruptData);
}

TEST(Tracker, lateFramesAreDroppedAndANewClockBeginsANewStream) {
    const auto rig = performerRig();
    Stream stream(TrackFormat::Vrm, rig, 3);
    const auto tracker = trackerFor(stream, TrackFormat::Vrm);
    const auto give = [&](double motionS, int64_t timeNs) {
        stream.show(swing(rig, motionS));
        EXPECT_TRUE(tracker->add(stream.frame(timeNs)));
        return tracker->status().framesDropped;
    };
    EXPECT_EQ(give(0, kStartNs), 0u);
    EXPECT_EQ(give(0.1, kStartNs + kSecond / 10), 0u);
    EXPECT_EQ(give(0.1, kStartNs + kSecond / 10), 1u) << "the same time again";
    EXPECT_EQ(give(0.05, kStartNs + kSecond / 20), 2u) << "out of order";
    EXPECT_EQ(give(0.2, kSecond), 2u) << "four seconds back is another clock";
    EXPECT_EQ(give(0.3, kSecond + kSecond / 10), 2u);
    (void)posed(*tracker, kSecond + kSecond / 10, avatarRig().size());
    EXPECT_EQ(tracker->status().state, TrackerState::Tracking);
    for (const int64_t extreme : {std::numeric_limits<int64_t>::max(), std::numeric_limits<int64_t>::min(), int64_t(0)}) {
        (void)give(0.4, extreme);
        (void)posed(*tracker, extreme, avatarRig().size());
        (void)posed(*tracker, ~extreme, avatarRig().size());
    }
}

TEST(Tracker, oneTimeStampFarAheadCostsFewFrames) {
    const auto rig = performerRig();
    Stream stream(TrackFormat::Vrm, rig, 3);
    const auto tracker = trackerFor(stream, TrackFormat::Vrm);
    for (int k = 0; k < 60; ++k) {
        const int64_t wrongNs = k == 30 ? 900'000'000 : 0;  // less than a second, so no other clock by itself
        stream.show(swing(rig, k / 30.0));
        EXPECT_TRUE(tracker->add(stream.frame(kStartNs + k * kSecond / 30 + wrongNs)));
        (void)posed(*tracker, kStartNs + k * kSecond / 30, avatarRig().size());
        if (k < 35) continue;
        EXPECT_EQ(tracker->status().state, TrackerState::Tracking) << k;
    }
    EXPECT_EQ(tracker->status().framesDropped, 3u);
    EXPECT_EQ(tracker->status().framesTaken, 57u);
}

/** Every number of a stream's places in another unit. */
void inUnit(Stream& stream, float unitsPerMetre, bool restToo) {
    for (float& p : stream.positions) p *= unitsPerMetre;
    if (restToo)
        for (float& p : stream.restPositions) p *= unitsPerMetre;
}

TEST(Tracker, otherUnitsThanMetresAreRefusedBySentence) {
    const auto rig = performerRig();
    for (const TrackFormat format : {TrackFormat::Vrm, TrackFormat::Unity, TrackFormat::ArkitBody, TrackFormat::FbBody,
                                     TrackFormat::OpenxrHands, TrackFormat::MediapipePose})
        for (const float units : {100.0f, 1000.0f}) {
            SCOPED_TRACE(std::string(nameOf(format)) + formatText(", {} units a metre", units));
            Stream stream(format, rig, 3);
            const auto tracker = trackerFor(stream, format);
            ASSERT_TRUE(tracker);
            stream.show(swing(rig, 0.3));
            Stream other = stream;
            inUnit(other, units, false);
            const Status taken = tracker->add(other.frame(kStartNs));
            ASSERT_FALSE(taken);
            EXPECT_EQ(taken.error().code, Code::CorruptData);
            EXPECT_NE(taken.error().message.find("metres are needed"), std::string::npos) << taken.error().message;
            EXPECT_TRUE(tracker->add(stream.frame(kStartNs + kSecond))) << "metres go on";
            if (!stream.needsRest()) continue;
            inUnit(other, 1, false), other.restPositions = stream.restPositions;
            for (float& p : other.restPositions) p *= units;
            const auto made = Tracker::create(avatarRig(), format, {}, other.rest());
            ASSERT_FALSE(made) << "a rest pose";
            EXPECT_NE(made.error().message.find("metres are needed"), std::string::npos) << made.error().message;
        }
    Stream stream(TrackFormat::Vrm, rig, 3);  // without a rest pose, the standard T-pose tells the size
    auto made = Tracker::create(avatarRig(), TrackFormat::Vrm, {}, {});
    ASSERT_TRUE(made);
    stream.show(swing(rig, 0.3));
    EXPECT_TRUE((*made)->add(stream.frame(kStartNs)));
    Stream small = stream;
    inUnit(small, 0.3f, false);
    EXPECT_TRUE((*made)->add(small.frame(kStartNs + kSecond))) << "half a metre high, a figure of a game";
    Stream turnsOnly = stream;
    inUnit(turnsOnly, 0, false);
    EXPECT_TRUE((*made)->add(turnsOnly.frame(kStartNs + 2 * kSecond))) << "a program that gives rotations alone";
    inUnit(stream, 100, false);
    EXPECT_FALSE((*made)->add(stream.frame(kStartNs + 3 * kSecond)));
}

/** The picture of a front camera: x is mirrored, and a network names the sides by what it sees, or the program mirrors the points only. */
TEST(Tracker, mirroredFrontCameras) {
    const auto rig = performerRig();
    const auto mirror = [](Stream& s) {
        for (size_t p = 0; p < s.positions.size(); p += 3) s.positions[p] = -s.positions[p];
    };
    Stream stream(TrackFormat::MediapipePose, rig, 3);
    const auto tracker = trackerFor(stream, TrackFormat::MediapipePose);
    Performer avatar{avatarRig(), {}, {}}, twin{rig, {}, {}};
    for (int k = 0; k < 30; ++k) {
        // A mirror image with sides named anew is a person who moves as in a mirror.
        Pose pose = swing(rig, k / 30.0);
        stream.show(pose);
        Stream pointsOnly = stream;
        mirror(pointsOnly);
        const Status refused = tracker->add(pointsOnly.frame(kStartNs + k * kSecond / 30));
        ASSERT_FALSE(refused) << "mirrored points whose names are not exchanged";
        EXPECT_NE(refused.error().message.find("mirrored picture"), std::string::npos);
        swapSides(TrackFormat::MediapipePose, pointsOnly);
        ASSERT_TRUE(tracker->add(pointsOnly.frame(kStartNs + k * kSecond / 30)));
        avatar.show(posed(*tracker, kStartNs + k * kSecond / 30, avatar.rig.size()));
    }
    const auto directionOf = [](const Performer& p, const std::string& side) {
        return glm::normalize(p.positions[p.at(side + "Hand")] - p.positions[p.at(side + "UpperArm")]);
    };
    twin.show(swing(rig, 29 / 30.0));
    for (const auto& [shown, mirrored] : {std::pair("left", "right"), {"right", "left"}})
        EXPECT_LT(degreesBetween(directionOf(avatar, shown), directionOf(twin, mirrored) * Vec3f(-1, 1, 1)), 12.0f) << shown;
}

TEST(Tracker, bonesThatAModelLacksGoWithTheirCarriers) {
    const auto rig = performerRig();
    Stream stream(TrackFormat::Vrm, rig, 3);
    const float nan = std::numeric_limits<float>::quiet_NaN();
    const auto table = trackedJoints(TrackFormat::Vrm);
    const auto lacks = [&](size_t j) {
        return table[j].bone == "upperChest" || table[j].bone == "leftShoulder" || table[j].bone == "rightShoulder";
    };
    for (size_t j = 0; j < table.size(); ++j)
        if (lacks(j)) stream.restPositions[3 * j] = nan;
    for (const bool withRest : {true, false}) {
        TrackerOptions raw;
        raw.raw = true;
        auto made = Tracker::create(avatarRig(), TrackFormat::Vrm, raw, withRest ? stream.rest() : TrackFrame{});
        ASSERT_TRUE(made);
        Performer avatar{avatarRig(), {}, {}};
        for (int k = 0; k < 30; ++k) {
            Pose pose = swing(rig, k / 30.0);
            stream.show(pose);
            for (size_t j = 0; j < table.size(); ++j)
                if (lacks(j)) stream.confidence[j] = 0;
            ASSERT_TRUE((*made)->add(stream.frame(kStartNs + k * kSecond / 30)));
            avatar.show(posed(**made, kStartNs + k * kSecond / 30, avatar.rig.size()));
        }
        Errors e;
        e.add(stream.performer, avatar, Quatf(1, 0, 0, 0));
        EXPECT_LT(e.arms, withRest ? 0.1 : 3.0) << "without a rest, the standard T-pose stands for it";
        EXPECT_LT(e.torso, 0.1) << "the chest carries the arms";
    }
}

TEST(Tracker, someoneAtADeskIsTrackedWithoutHips) {
    const auto rig = performerRig();
    Stream stream(TrackFormat::MediapipePose, rig, 3);
    const auto tracker = trackerFor(stream, TrackFormat::MediapipePose);
    Performer avatar{avatarRig(), {}, {}};
    for (int k = 0; k < 60; ++k) {
        stream.show(swing(rig, k / 30.0));
        for (size_t p = 23; p < 33; ++p) stream.confidence[p] = 0.1f;
        ASSERT_TRUE(tracker->add(stream.frame(kStartNs + k * kSecond / 30)));
        avatar.show(posed(*tracker, kStartNs + k * kSecond / 30, avatar.rig.size()));
    }
    Errors e;
    e.add(stream.performer, avatar, Quatf(1, 0, 0, 0));
    EXPECT_LT(e.arms, 2);
    EXPECT_EQ(tracker->status().state, TrackerState::Tracking);
}

TEST(Tracker, framesANanosecondApartDoNotCatapult) {
    const auto rig = performerRig();
    Stream stream(TrackFormat::ArkitBody, rig, 3);
    const auto tracker = trackerFor(stream, TrackFormat::ArkitBody);
    for (int k = 0; k < 4; ++k) {
        Pose pose = Pose::rest(rig.size());
        pose.rootTranslation.x = 0.2f * float(k);
        stream.show(pose);
        ASSERT_TRUE(tracker->add(stream.frame(kStartNs + k)));
    }
    const Pose pose = posed(*tracker, kStartNs + 50'000'000, avatarRig().size());
    EXPECT_LT(glm::length(pose.rootTranslation), 2.0f) << "metres; 2e8 m/s were seen";
}

TEST(Tracker, feetStandOnTheFloorAndJumpsShow) {
    const auto rig = performerRig();
    Stream stream(TrackFormat::ArkitBody, rig, 3);
    const auto tracker = trackerFor(stream, TrackFormat::ArkitBody);
    Performer avatar{avatarRig(), {}, {}};
    float lowestStanding = 1e9f, highest = 0;
    for (int k = 0; k < 180; ++k) {
        Pose pose = swing(rig, k / 60.0);
        const bool jumps = k >= 120 && k < 150;
        pose.rootTranslation.y = 7 + (jumps ? 0.3f * std::sin(float(k - 120) / 30 * 3.1416f) : 0.0f);  // ARKit's floor lies anywhere
        stream.show(pose);
        ASSERT_TRUE(tracker->add(stream.frame(kStartNs + k * kSecond / 60)));
        avatar.show(posed(*tracker, kStartNs + k * kSecond / 60, avatar.rig.size()));
        float lowest = 1e9f;
        for (const char* bone : {"leftToes", "rightToes", "leftFoot", "rightFoot"})
            lowest = std::min(lowest, avatar.positions[avatar.at(bone)].y - avatar.rig[avatar.at(bone)].restPosition.y);
        if (k > 30 && k < 118) lowestStanding = std::min(lowestStanding, std::abs(lowest));
        if (jumps) highest = std::max(highest, lowest);
    }
    EXPECT_LT(lowestStanding, 0.005f);
    EXPECT_GT(highest, 0.12f);
    EXPECT_LT(highest, 0.4f);
}

TEST(Tracker, hipsThatSinkBendTheKneesOfABodyWithoutLegs) {
    const auto rig = performerRig();
    Stream stream(TrackFormat::FbBody, rig, 3);
    const auto tracker = trackerFor(stream, TrackFormat::FbBody);
    Performer avatar{avatarRig(), {}, {}};
    for (int k = 0; k < 120; ++k) {
        Pose pose = Pose::rest(rig.size());
        pose.rootTranslation.y = k < 60 ? 0.0f : -0.3f;
        stream.show(pose);
        ASSERT_TRUE(tracker->add(stream.frame(kStartNs + k * kSecond / 60)));
        avatar.show(posed(*tracker, kStartNs + k * kSecond / 60, avatar.rig.size()));
    }
    const auto height = [&](const char* bone) { return avatar.positions[avatar.at(bone)].y - avatar.rig[avatar.at(bone)].restPosition.y; };
    EXPECT_LT(height("hips"), -0.25f);
    EXPECT_NEAR(height("leftFoot"), 0, 0.005f);
    EXPECT_GT(avatar.positions[avatar.at("leftLowerLeg")].z, 0.2f) << "knees go ahead";
}

}  // namespace
}  // namespace dpl
