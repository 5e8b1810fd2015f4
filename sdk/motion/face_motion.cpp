// SPDX-License-Identifier: Apache-2.0
#include "sdk/motion/face_motion.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "sdk/format/expression_names.h"
#include "sdk/motion/gaze.h"

namespace dpl {
namespace {

// A seed's time is cut into blocks, so that any time is reached without those before it. In a block, events follow one another.
constexpr int64_t kBlockNs = 32'000'000'000;
constexpr double kBlockS = 32;

// Blinks at rest. The times between them are logarithmic normal; their spread is a share of the mean.
constexpr double kBlinkEveryS = 60.0 / 17, kBlinkSpread = 0.6;
constexpr double kLeastBetweenS = 0.4;  // from the begin of a blink to that of the next: no blink is cut
constexpr double kCloseS[] = {0.075, 0.1}, kOpenS[] = {0.15, 0.2};

// Fixations: a refractory time, then a saccade is equally likely at any time. How long it takes goes with its size.
constexpr double kLeastFixationS = 0.3, kFixationTailS = 1.2;
constexpr double kSaccadeS = 0.021, kSaccadeSPerDeg = 0.0022;
constexpr double kMeanGlanceDeg = 1.5, kGlanceUpDown = 0.6;  // sizes are exponential, and flatter up and down

enum class Stream : uint64_t { Blinks = 1, Glances = 2 };

/** Random numbers of a block (SplitMix64). */
class Draws {
public:
    Draws(uint32_t seed, Stream stream, int64_t block)
        : state_((uint64_t(seed) << 32 | uint64_t(stream)) ^ uint64_t(block) * 0xd1342543de82ef95ULL) {
        (void)next();
    }
    /** 0 to 1, neither of both. */
    double share() { return (double(next() >> 12) + 0.5) * 0x1p-52; }
    double between(const double (&ends)[2]) { return ends[0] + share() * (ends[1] - ends[0]); }
    double exponential(double mean) { return -mean * std::log(share()); }
    double normal() {
        const double r = std::sqrt(-2 * std::log(share()));
        return r * std::cos(2 * glm::pi<double>() * share());
    }

private:
    uint64_t next() {
        uint64_t z = state_ += 0x9e3779b97f4a7c15ULL;
        z = (z ^ z >> 30) * 0xbf58476d1ce4e5b9ULL;
        z = (z ^ z >> 27) * 0x94d049bb133111ebULL;
        return z ^ z >> 31;
    }
    uint64_t state_;
};

/** The block of a time, and the seconds since its begin. */
std::pair<int64_t, double> blockOf(int64_t timeNs) {
    int64_t block = timeNs / kBlockNs, rest = timeNs % kBlockNs;
    if (rest < 0) --block, rest += kBlockNs;
    return {block, 1e-9 * double(rest)};
}

double smooth(double t) {
    t = std::clamp(t, 0.0, 1.0);
    return t * t * (3 - 2 * t);
}

double blinkEveryS(Draws& draws) {
    const double variance = std::log(1 + kBlinkSpread * kBlinkSpread);
    return std::max(kLeastBetweenS, kBlinkEveryS * std::exp(std::sqrt(variance) * draws.normal() - 0.5 * variance));
}

Vec2d target(Draws& draws) {
    const double sizeDeg = std::min(draws.exponential(kMeanGlanceDeg), kFarthestGlanceDeg), angle = 2 * glm::pi<double>() * draws.share();
    return {sizeDeg * std::cos(angle), kGlanceUpDown * sizeDeg * std::sin(angle)};
}

size_t indexOf(std::string_view name) {
    return *expressionOf(name);  // of kExpressionNames
}

}  // namespace

Status checkFaceMotion(const FaceMotion& motion) {
    for (const auto& [name, value, most] :
         {std::tuple("blinks", motion.blinks, 1.0f), {"glances", motion.glances, 1.0f}, {"holdS", motion.holdS, kMostHoldS}})
        if (!(value >= 0 && value <= most)) return fail(Code::InvalidArgument, "{} is {}; it must be 0 to {}", name, value, most);
    return {};
}

double blinkAt(uint32_t seed, int64_t timeNs) {
    const auto [block, nowS] = blockOf(timeNs);
    Draws draws(seed, Stream::Blinks, block);
    double atS = draws.share() * blinkEveryS(draws);  // the block begins somewhere between two blinks
    while (atS <= nowS && atS + kLeastBetweenS < kBlockS) {
        const double closeS = draws.between(kCloseS), openS = draws.between(kOpenS), sinceS = nowS - atS;
        if (sinceS < closeS + openS) return sinceS < closeS ? smooth(sinceS / closeS) : 1 - smooth((sinceS - closeS) / openS);
        atS += blinkEveryS(draws);
    }
    return 0;
}

Vec2d glanceAt(uint32_t seed, int64_t timeNs) {
    const auto [block, nowS] = blockOf(timeNs);
    Draws draws(seed, Stream::Glances, block);
    Vec2d from(0), to(0);  // a block begins and ends straight ahead
    double atS = 0;        // the saccade to `to` begins
    while (true) {
        const double nextS = atS + kLeastFixationS + draws.exponential(kFixationTailS);
        const bool last = nextS + kLeastFixationS > kBlockS;
        const double backS = kBlockS - kLeastFixationS;
        if (nowS < (last ? backS : nextS)) break;
        from = std::exchange(to, last ? Vec2d(0) : target(draws));
        atS = last ? backS : nextS;
        if (last) break;
    }
    const double takesS = kSaccadeS + kSaccadeSPerDeg * glm::length(to - from);
    return from + smooth((nowS - atS) / takesS) * (to - from);
}

ExpressionWeights faceAt(const ExpressionWeights& given, const FaceMotion& motion, int64_t timeNs) {
    static const size_t kBlink[] = {indexOf("eyeBlinkLeft"), indexOf("eyeBlinkRight")};
    static const size_t kToLeft[] = {indexOf("eyeLookOutLeft"), indexOf("eyeLookInRight")};
    static const size_t kToRight[] = {indexOf("eyeLookInLeft"), indexOf("eyeLookOutRight")};
    static const size_t kUp[] = {indexOf("eyeLookUpLeft"), indexOf("eyeLookUpRight")};
    static const size_t kDown[] = {indexOf("eyeLookDownLeft"), indexOf("eyeLookDownRight")};

    ExpressionWeights shown = given;
    if (motion.holdS > 0) {
        const double silentS = 1e-9 * (double(timeNs) - double(motion.heardNs)) - double(motion.holdS);
        const auto share = float(1 - smooth(silentS / kFaceFadeS));
        for (float& weight : shown) weight *= share;
    }
    const auto add = [&shown](const size_t(&which)[2], double weight) {
        for (const size_t i : which) shown[i] = std::clamp(shown[i] + float(weight), 0.0f, 1.0f);
    };
    if (motion.blinks > 0)
        if (const double closed = blinkAt(motion.seed, timeNs); closed > 0) add(kBlink, double(motion.blinks) * closed);
    if (motion.glances > 0) {
        // Weights of 1 are the limits of eyes that look at a point.
        const Vec2d turn = double(motion.glances) * glm::radians(glanceAt(motion.seed, timeNs)) / Vec2d(kUsualEyeLimitRad);
        if (turn.x != 0) add(turn.x > 0 ? kToLeft : kToRight, std::abs(turn.x));
        if (turn.y != 0) add(turn.y > 0 ? kUp : kDown, std::abs(turn.y));
    }
    return shown;
}

}  // namespace dpl
