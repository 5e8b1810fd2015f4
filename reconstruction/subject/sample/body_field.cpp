// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/subject/sample/body_field.h"

namespace dpl {
namespace {

// Stations are {s, centreU, centreV, radius towards +u, −u, +v, −v}, metres. Sizes of a 1.75 m adult, chosen by eye.

Tube makeTorso() {
    // The axis points up from y = 0.79 and u points left, so v = axis × u points back: radiusV is the back, radiusVBack the front.
    auto at = [](float y, float halfWidth, float front, float back) {
        return TubeStation{y - 0.79f, 0, 0, halfWidth, halfWidth, back, front};
    };
    return Tube({0, 0.79f, 0}, {0, 1, 0}, {1, 0, 0},
                {at(0.790f, 0.070f, 0.035f, 0.060f), at(0.830f, 0.128f, 0.074f, 0.094f), at(0.870f, 0.162f, 0.092f, 0.110f),
                 at(0.910f, 0.170f, 0.100f, 0.114f), at(0.960f, 0.167f, 0.106f, 0.106f), at(1.010f, 0.158f, 0.108f, 0.095f),
                 at(1.070f, 0.149f, 0.108f, 0.088f), at(1.130f, 0.150f, 0.109f, 0.091f), at(1.200f, 0.159f, 0.111f, 0.102f),
                 at(1.270f, 0.168f, 0.112f, 0.113f), at(1.330f, 0.168f, 0.106f, 0.119f), at(1.380f, 0.152f, 0.090f, 0.114f),
                 at(1.420f, 0.120f, 0.066f, 0.098f), at(1.455f, 0.078f, 0.040f, 0.080f), at(1.480f, 0.048f, 0.025f, 0.066f)},
                2.25f);
}

Tube makeThigh() {
    const Vec3f hip(0.092f, 0.902f, -0.004f), knee(0.121f, 0.495f, 0.008f);
    // The axis points down and u outward, so v = axis × u points forward.
    return Tube(hip, knee - hip, {1, 0, 0},
                {{-0.040f, 0, 0, 0.066f, 0.075f, 0.078f, 0.086f},
                 {0.020f, 0, 0, 0.079f, 0.083f, 0.085f, 0.092f},
                 {0.080f, 0, 0, 0.082f, 0.083f, 0.086f, 0.088f},
                 {0.160f, 0, 0, 0.077f, 0.076f, 0.083f, 0.079f},
                 {0.240f, 0, 0, 0.068f, 0.066f, 0.075f, 0.069f},
                 {0.320f, 0, 0, 0.057f, 0.057f, 0.064f, 0.060f},
                 {0.380f, 0, 0, 0.052f, 0.053f, 0.055f, 0.054f},
                 {0.410f, 0, 0, 0.049f, 0.051f, 0.051f, 0.051f},
                 {0.450f, 0, 0, 0.043f, 0.044f, 0.043f, 0.044f}});
}

Tube makeCalf() {
    const Vec3f knee(0.121f, 0.495f, 0.008f), ankle = leftFootChain()[0];
    return Tube(knee, ankle - knee, {1, 0, 0},
                {{-0.050f, 0, 0, 0.044f, 0.045f, 0.044f, 0.046f},
                 {-0.010f, 0, 0, 0.048f, 0.050f, 0.050f, 0.050f},
                 {0.030f, 0, 0, 0.048f, 0.049f, 0.050f, 0.052f},
                 {0.080f, 0, 0, 0.052f, 0.053f, 0.047f, 0.062f},
                 {0.130f, 0, 0, 0.054f, 0.055f, 0.044f, 0.067f},
                 {0.190f, 0, 0, 0.049f, 0.050f, 0.042f, 0.060f},
                 {0.260f, 0, 0, 0.039f, 0.041f, 0.038f, 0.045f},
                 {0.330f, 0, 0, 0.031f, 0.032f, 0.033f, 0.036f},
                 {0.390f, 0, 0, 0.030f, 0.031f, 0.034f, 0.038f},
                 {0.430f, 0, 0, 0.033f, 0.034f, 0.036f, 0.040f}});
}

Tube makeFoot() {
    const auto chain = leftFootChain();
    Vec3f forward = chain[2] - chain[0];
    forward.y = 0;
    forward = glm::normalize(forward);
    const Vec3f heel(chain[0].x, 0, chain[0].z);
    // The axis points forward and u outward, so v = axis × u points up.
    auto at = [](float s, float side, float halfOut, float halfIn, float height, float down, float up) {
        return TubeStation{s, side, height, halfOut, halfIn, up, down};
    };
    return Tube(heel, forward, {1, 0, 0},
                {at(-0.058f, 0, 0.010f, 0.010f, 0.030f, 0.014f, 0.016f), at(-0.048f, 0, 0.024f, 0.024f, 0.031f, 0.028f, 0.030f),
                 at(-0.025f, 0, 0.031f, 0.031f, 0.035f, 0.035f, 0.044f), at(0.010f, 0, 0.032f, 0.033f, 0.040f, 0.040f, 0.052f),
                 at(0.045f, 0.001f, 0.035f, 0.033f, 0.036f, 0.036f, 0.042f), at(0.085f, 0.003f, 0.039f, 0.035f, 0.028f, 0.028f, 0.032f),
                 at(0.120f, 0.004f, 0.043f, 0.043f, 0.021f, 0.021f, 0.023f), at(0.148f, 0.003f, 0.043f, 0.045f, 0.016f, 0.016f, 0.016f),
                 at(0.166f, 0.002f, 0.036f, 0.040f, 0.013f, 0.013f, 0.011f)},
                2.3f);
}

Tube makeUpperArm(const Vec3f& shoulder, const Vec3f& elbow) {
    // The axis points along the arm and u forward (biceps). v points up and outward or the opposite way; its two radii are nearly equal.
    return Tube(shoulder, elbow - shoulder, {0, 0, 1},
                {{-0.010f, 0, 0, 0.050f, 0.052f, 0.050f, 0.050f},
                 {0.050f, 0, 0, 0.050f, 0.052f, 0.050f, 0.048f},
                 {0.110f, 0.002f, 0, 0.049f, 0.049f, 0.046f, 0.045f},
                 {0.160f, 0.003f, 0, 0.048f, 0.047f, 0.043f, 0.042f},
                 {0.210f, 0.002f, 0, 0.043f, 0.043f, 0.040f, 0.039f},
                 {0.260f, 0, 0, 0.039f, 0.041f, 0.038f, 0.038f},
                 {0.295f, 0, 0, 0.038f, 0.041f, 0.038f, 0.038f}});
}

Tube makeForearm(const Vec3f& elbow, const Vec3f& wrist) {
    return Tube(elbow, wrist - elbow, {0, 0, 1},
                {{-0.015f, 0, 0, 0.038f, 0.041f, 0.038f, 0.038f},
                 {0.030f, 0.002f, 0, 0.042f, 0.041f, 0.040f, 0.040f},
                 {0.070f, 0.002f, 0, 0.043f, 0.041f, 0.040f, 0.040f},
                 {0.120f, 0.001f, 0, 0.039f, 0.037f, 0.036f, 0.035f},
                 {0.175f, 0, 0, 0.033f, 0.031f, 0.028f, 0.028f},
                 {0.225f, 0, 0, 0.029f, 0.028f, 0.022f, 0.022f},
                 {0.262f, 0, 0, 0.029f, 0.029f, 0.021f, 0.021f}});
}

Tube makePalm(const HandFrame& h) {
    // u points to the thumb. v points out of the back of the hand or of the palm; its two radii are equal.
    return Tube(h.wrist, h.along, h.thumbward,
                {{-0.012f, 0, 0, 0.028f, 0.028f, 0.019f, 0.019f},
                 {0.012f, 0, 0, 0.031f, 0.031f, 0.018f, 0.018f},
                 {0.035f, 0, 0, 0.037f, 0.037f, 0.0165f, 0.0165f},
                 {0.060f, 0, 0, 0.040f, 0.041f, 0.015f, 0.015f},
                 {0.078f, 0, 0, 0.041f, 0.0425f, 0.0135f, 0.0135f},
                 {0.092f, 0.002f, 0, 0.037f, 0.037f, 0.011f, 0.011f},
                 {0.100f, 0.004f, 0, 0.030f, 0.028f, 0.008f, 0.008f}},
                2.6f);
}

Tube makeFace() {
    // The axis points up from the chin and u left, so v points back: radiusV is the back, radiusVBack the front. Centres are at z = 0.03.
    auto at = [](float y, float halfWidth, float front, float back) {
        return TubeStation{y - 1.522f, 0, -0.03f, halfWidth, halfWidth, back, front - 0.03f};
    };
    return Tube({0, 1.522f, 0}, {0, 1, 0}, {1, 0, 0},
                {at(1.522f, 0.016f, 0.074f, 0.01f), at(1.532f, 0.030f, 0.0885f, 0.012f), at(1.548f, 0.042f, 0.0930f, 0.02f),
                 at(1.565f, 0.051f, 0.0925f, 0.04f), at(1.585f, 0.0575f, 0.0925f, 0.05f), at(1.605f, 0.062f, 0.0915f, 0.06f),
                 at(1.630f, 0.0655f, 0.0905f, 0.07f), at(1.655f, 0.067f, 0.0905f, 0.08f), at(1.680f, 0.066f, 0.0870f, 0.08f),
                 at(1.705f, 0.058f, 0.0765f, 0.08f), at(1.728f, 0.040f, 0.050f, 0.07f)},
                2.2f);
}

Tube makeNeck() {
    const Vec3f low(0, 1.415f, -0.030f), high(0, 1.590f, -0.008f);
    return Tube(low, high - low, {1, 0, 0},
                {{0, 0, 0, 0.072f, 0.072f, 0.055f, 0.056f},
                 {0.035f, 0, 0, 0.062f, 0.062f, 0.056f, 0.056f},
                 {0.075f, 0, 0, 0.056f, 0.056f, 0.056f, 0.055f},
                 {0.120f, 0, 0, 0.055f, 0.055f, 0.055f, 0.055f},
                 {0.175f, 0, 0, 0.056f, 0.056f, 0.055f, 0.055f}});
}

Vec3f mirrored(const Vec3f& p) {
    return {std::abs(p.x), p.y, p.z};
}

constexpr float kFingerRadius[kFingerCount][4] = {
    {0.0098f, 0.0092f, 0.0085f, 0.0074f},  // index
    {0.0100f, 0.0095f, 0.0087f, 0.0076f},  // middle
    {0.0087f, 0.0080f, 0.0073f, 0.0064f},  // pinky
    {0.0096f, 0.0090f, 0.0083f, 0.0072f},  // ring
    {0.0155f, 0.0122f, 0.0106f, 0.0084f},  // thumb
};

}  // namespace

BodyField::BodyField()
    : torso_(makeTorso()),
      thigh_(makeThigh()),
      calf_(makeCalf()),
      foot_(makeFoot()),
      face_(makeFace()),
      neck_(makeNeck()),
      hand_(leftHandFrame()) {
    const auto joints = builtinSkeleton();
    upperArm_ = makeUpperArm(joints[kLeftShoulder].restPosition, joints[kLeftElbow].restPosition);
    forearm_ = makeForearm(joints[kLeftElbow].restPosition, joints[kLeftWrist].restPosition);
    palm_ = makePalm(hand_);
    for (int f = 0; f < kFingerCount; ++f) fingers_[f] = leftFingerChain(Finger(f));
}

float BodyField::torso(const Vec3f& p) const {
    float d = torso_.distance(p);
    d = smoothUnion(d, ellipsoid(p, {0.076f, 0.885f, -0.060f}, {0.084f, 0.086f, 0.070f}), 0.05f);  // glutes
    d = smoothUnion(d, ellipsoid(p, {0.076f, 1.306f, 0.066f}, {0.084f, 0.062f, 0.043f}), 0.055f);  // pectorals
    d = smoothUnion(d, taperedCapsule(p, {0.100f, 1.330f, 0.045f}, {0.182f, 1.388f, 0.000f}, 0.034f, 0.038f),
                    0.05f);  // the front of the armpit
    d = smoothUnion(d, taperedCapsule(p, {0.100f, 1.335f, -0.070f}, {0.182f, 1.388f, -0.040f}, 0.034f, 0.038f),
                    0.05f);  // the back of the armpit
    d = smoothUnion(d, taperedCapsule(p, {0.120f, 1.436f, -0.026f}, {0.182f, 1.424f, -0.022f}, 0.032f, 0.040f),
                    0.04f);                                                                        // top of the shoulder
    d = smoothUnion(d, ellipsoid(p, {0.085f, 1.330f, -0.088f}, {0.052f, 0.072f, 0.030f}), 0.04f);  // shoulder blades
    d = smoothUnion(d, taperedCapsule(p, {0.030f, 1.500f, -0.038f}, {0.150f, 1.434f, -0.028f}, 0.038f, 0.036f), 0.05f);  // trapezius
    d = smoothUnion(d, taperedCapsule(p, {0.016f, 1.424f, 0.042f}, {0.135f, 1.445f, 0.002f}, 0.011f, 0.012f), 0.025f);   // collarbone
    d = smoothUnion(d, ellipsoid(p, {0.128f, 1.285f, -0.045f}, {0.034f, 0.085f, 0.060f}), 0.04f);                        // latissimus
    d = smoothDifference(d, taperedCapsule(p, {0, 1.02f, -0.118f}, {0, 1.36f, -0.142f}, 0.014f, 0.012f),
                         0.035f);                                                                                // groove of the spine
    d = smoothDifference(d, taperedCapsule(p, {0, 1.12f, 0.125f}, {0, 1.33f, 0.137f}, 0.010f, 0.012f), 0.030f);  // between the pectorals
    d = smoothDifference(d, ellipsoid(p, {0, 1.052f, 0.112f}, {0.006f, 0.007f, 0.009f}), 0.012f);                // navel
    return d;
}

float BodyField::toes(const Vec3f& p) const {
    const auto chain = leftFootChain();
    Vec3f f = chain[2] - chain[0];
    f.y = 0;
    f = glm::normalize(f);
    const Vec3f side(f.z, 0, -f.x), heel(chain[0].x, 0, chain[0].z);
    auto at = [&](float s, float u, float y) { return heel + f * s + side * u + Vec3f(0, y, 0); };
    // From the big toe (inside) to the little toe. s: metres from the ankle along the foot; u: sideways; y: height.
    float d = taperedCapsule(p, at(0.140f, -0.026f, 0.014f), at(0.192f, -0.022f, 0.012f), 0.0150f, 0.0125f);
    d = smoothUnion(d, taperedCapsule(p, at(0.150f, -0.003f, 0.013f), at(0.196f, 0.0015f, 0.009f), 0.0100f, 0.0085f), 0.004f);
    d = smoothUnion(d, taperedCapsule(p, at(0.146f, 0.013f, 0.012f), at(0.188f, 0.018f, 0.0085f), 0.0095f, 0.0080f), 0.004f);
    d = smoothUnion(d, taperedCapsule(p, at(0.138f, 0.027f, 0.011f), at(0.176f, 0.033f, 0.008f), 0.0092f, 0.0077f), 0.004f);
    return smoothUnion(d, taperedCapsule(p, at(0.125f, 0.039f, 0.010f), at(0.160f, 0.046f, 0.0078f), 0.0090f, 0.0075f), 0.004f);
}

float BodyField::foot(const Vec3f& p) const {
    return foot_.distance(p);
}

float BodyField::leg(const Vec3f& p) const {
    if (p.y > 1.1f) return glm::length(p - Vec3f(0.1f, 0.95f, 0)) - 0.12f;
    float d = 1e3f;
    if (p.y > 0.30f) d = thigh_.distance(p);
    if (p.y < 0.80f) {
        d = smoothUnion(d, calf_.distance(p), 0.03f);
        d = smoothUnion(d, ellipsoid(p, {0.120f, 0.502f, 0.042f}, {0.028f, 0.036f, 0.018f}), 0.028f);  // kneecap
    }
    if (p.y < 0.30f) {
        float sole = smoothUnion(foot(p), toes(p), 0.010f);
        sole = smoothUnion(sole, ellipsoid(p, {0.174f, 0.080f, -0.036f}, {0.010f, 0.014f, 0.013f}), 0.020f);  // outer ankle
        sole = smoothUnion(sole, ellipsoid(p, {0.117f, 0.088f, -0.026f}, {0.010f, 0.014f, 0.013f}), 0.020f);  // inner ankle
        d = smoothUnion(d, sole, 0.035f);
        d = smoothIntersection(d, -p.y + 0.0f, 0.010f);  // it stands on the floor
    }
    return d;
}

float BodyField::arm(const Vec3f& p) const {
    float d = smoothUnion(upperArm_.distance(p), forearm_.distance(p), 0.025f);
    d = smoothUnion(d, ellipsoid(p, {0.186f, 1.398f, -0.022f}, {0.053f, 0.062f, 0.056f}), 0.035f);  // deltoid
    return d;
}

float BodyField::palm(const Vec3f& p) const {
    const Vec3f q = p - hand_.wrist;
    const Vec3f local(glm::dot(q, hand_.along), glm::dot(q, hand_.thumbward), glm::dot(q, hand_.dorsal));
    float d = palm_.distance(p);
    d = smoothUnion(d, ellipsoid(local, {0.042f, 0.026f, -0.011f}, {0.034f, 0.019f, 0.014f}), 0.018f);           // ball of the thumb
    d = smoothUnion(d, ellipsoid(local, {0.040f, -0.026f, -0.010f}, {0.036f, 0.015f, 0.012f}), 0.016f);          // heel of the hand
    return smoothDifference(d, ellipsoid(local, {0.060f, -0.002f, -0.026f}, {0.028f, 0.018f, 0.014f}), 0.016f);  // hollow
}

float BodyField::finger(const Vec3f& p, Finger f) const {
    const auto& c = fingers_[f];
    const float* r = kFingerRadius[f];
    const float k = f == kThumb ? 0.010f : 0.004f;
    float d = smoothUnion(taperedCapsule(p, c[0], c[1], r[0], r[1]), taperedCapsule(p, c[1], c[2], r[1], r[2]), k);
    return smoothUnion(d, taperedCapsule(p, c[2], c[3] - (c[3] - c[2]) * 0.25f, r[2], r[3]), k);
}

float BodyField::hand(const Vec3f& p) const {
    float fingers = std::min({finger(p, kIndex), finger(p, kMiddle), finger(p, kRing), finger(p, kPinky)});
    return smoothUnion(smoothUnion(palm(p), fingers, 0.009f), finger(p, kThumb), 0.016f);
}

float BodyField::cranium(const Vec3f& p) const {
    float d = ellipsoid(p, {0, 1.660f, -0.012f}, {0.0765f, 0.092f, 0.097f});
    return smoothUnion(d, ellipsoid(p, {0, 1.640f, -0.050f}, {0.062f, 0.062f, 0.055f}), 0.05f);  // back of the head
}

float BodyField::neck(const Vec3f& p) const {
    float d = neck_.distance(p);
    d = smoothUnion(d, taperedCapsule(p, {0.055f, 1.580f, -0.022f}, {0.014f, 1.440f, 0.030f}, 0.012f, 0.009f),
                    0.022f);                                                                     // sternomastoid
    return smoothUnion(d, ellipsoid(p, {0, 1.508f, 0.034f}, {0.012f, 0.014f, 0.010f}), 0.016f);  // Adam's apple
}

float BodyField::scalp(const Vec3f& p) const {
    return smoothUnion(smoothUnion(cranium(p), face_.distance(p), 0.030f), neck_.distance(p), 0.022f);
}

float BodyField::head(const Vec3f& p) const {
    float d = smoothUnion(cranium(p), face_.distance(p), 0.030f);
    if (p.y < 1.75f && p.y > 1.49f && p.z > -0.03f) {
        d = smoothUnion(d, ellipsoid(p, {0.0455f, 1.620f, 0.0585f}, {0.021f, 0.018f, 0.022f}), 0.030f);                       // cheekbone
        d = smoothUnion(d, ellipsoid(p, {0.0400f, 1.592f, 0.056f}, {0.0215f, 0.026f, 0.0240f}), 0.030f);                      // cheek
        d = smoothUnion(d, taperedCapsule(p, {0.010f, 1.668f, 0.085f}, {0.046f, 1.669f, 0.068f}, 0.0095f, 0.0085f), 0.016f);  // brow
        d = smoothUnion(d, ellipsoid(p, {0, 1.538f, 0.086f}, {0.020f, 0.014f, 0.013f}), 0.014f);                              // chin
        d = smoothUnion(d, taperedCapsule(p, {0.049f, 1.583f, 0.006f}, {0.022f, 1.537f, 0.067f}, 0.011f, 0.010f), 0.028f);    // jaw line
        d = smoothDifference(d, ellipsoid(p, {0.0325f, 1.6455f, 0.102f}, {0.0185f, 0.0115f, 0.0165f}), 0.012f);               // eye socket
        d = smoothUnion(d, ellipsoid(p, {0.0318f, 1.6455f, 0.0745f}, {0.0155f, 0.0128f, 0.0142f}), 0.0040f);           // eyeball and lids
        d = smoothUnion(d, taperedCapsule(p, {0, 1.662f, 0.0865f}, {0, 1.6150f, 0.1070f}, 0.0078f, 0.0102f), 0.014f);  // nose
        d = smoothUnion(d, ellipsoid(p, {0, 1.6100f, 0.1080f}, {0.0105f, 0.0088f, 0.0092f}), 0.010f);                  // its tip
        d = smoothUnion(d, ellipsoid(p, {0.0108f, 1.6075f, 0.0985f}, {0.0078f, 0.0074f, 0.0110f}), 0.011f);            // nostril wings
        d = smoothDifference(d, ellipsoid(p, {0.0062f, 1.5990f, 0.1040f}, {0.0030f, 0.0040f, 0.0045f}), 0.004f);       // nostrils
        d = smoothUnion(d, ellipsoid(p, {0, 1.581f, 0.0870f}, {0.028f, 0.022f, 0.0095f}), 0.022f);                     // mouth region
        d = smoothUnion(d, taperedCapsule(p, {0, 1.5815f, 0.0948f}, {0.0225f, 1.5780f, 0.0845f}, 0.0048f, 0.0028f), 0.0055f);  // upper lip
        d = smoothUnion(d, taperedCapsule(p, {0, 1.5720f, 0.0935f}, {0.0200f, 1.5755f, 0.0850f}, 0.0060f, 0.0032f), 0.0055f);  // lower lip
        d = smoothDifference(d, taperedCapsule(p, {0, 1.5772f, 0.1005f}, {0.0170f, 1.5768f, 0.0935f}, 0.0012f, 0.0008f),
                             0.0040f);  // mouth line
    }
    // The ear is tilted backwards and away from the head.
    Vec3f e = p - Vec3f(0.0775f, 1.628f, -0.016f);
    e = {e.x * 0.94f + e.z * 0.34f, e.y * 0.97f - e.z * 0.22f, e.z * 0.92f - e.x * 0.30f + e.y * 0.22f};
    float ear = ellipsoid(e, {0, 0, 0}, {0.0085f, 0.0310f, 0.0180f});
    ear = smoothDifference(ear, ellipsoid(e, {0.0085f, 0.003f, 0.002f}, {0.0065f, 0.0200f, 0.0095f}), 0.004f);
    d = smoothUnion(d, ear, 0.007f);
    return smoothUnion(d, neck(p), 0.022f);
}

float BodyField::distance(const Vec3f& world) const {
    const Vec3f p = mirrored(world);
    float d = 1e3f;
    if (p.y > 0.72f && p.x < 0.45f) d = torso(p);
    if (p.y > 1.36f && p.x < 0.30f) d = smoothUnion(d, head(p), 0.030f);
    if (p.y < 1.10f && p.x < 0.45f) d = smoothUnion(d, leg(p), 0.040f);
    if (p.y > 0.80f && p.x > 0.05f) {
        float a = 1e3f;
        if (p.x < 0.68f) a = arm(p);
        if (p.x > 0.50f) a = smoothUnion(a, hand(p), 0.014f);
        d = smoothUnion(d, a, 0.045f);
    }
    return d < 900 ? d : 0.3f;
}

Vec3f BodyField::normal(const Vec3f& p) const {
    constexpr float h = 5e-4f;
    const Vec3f a(h, -h, -h), b(-h, -h, h), c(-h, h, -h), d(h, h, h);
    return glm::normalize(a * distance(p + a) + b * distance(p + b) + c * distance(p + c) + d * distance(p + d));
}

BodyPart BodyField::part(const Vec3f& world) const {
    const Vec3f p = mirrored(world);
    if (p.x > 0.50f) {
        float best = std::min(arm(p), 1e3f);
        BodyPart part = BodyPart::Arm;
        auto take = [&](float d, BodyPart candidate) {
            if (d < best) best = d, part = candidate;
        };
        take(palm(p), BodyPart::Palm);
        take(finger(p, kIndex), BodyPart::Index);
        take(finger(p, kMiddle), BodyPart::Middle);
        take(finger(p, kPinky), BodyPart::Pinky);
        take(finger(p, kRing), BodyPart::Ring);
        take(finger(p, kThumb), BodyPart::Thumb);
        return part;
    }
    const float torsoDistance = torso(p), legDistance = p.y < 1.1f ? leg(p) : 1e3f, armDistance = p.x > 0.05f ? arm(p) : 1e3f;
    const float headDistance = p.y > 1.36f ? head(p) : 1e3f;
    const float best = std::min({torsoDistance, legDistance, armDistance, headDistance});
    if (best == torsoDistance) return BodyPart::Torso;
    if (best == headDistance) return BodyPart::Head;
    return best == legDistance ? BodyPart::Leg : BodyPart::Arm;
}

float bodyEdgeLength(const Vec3f& world) {
    const Vec3f p = mirrored(world);
    float length = 0.0158f;
    const HandFrame hand = leftHandFrame();
    const float s = glm::dot(p - hand.wrist, hand.along);
    if (p.x > 0.5f) length = std::min(length, s > 0.07f ? 0.0058f : 0.0058f + std::max(0.0f, 0.02f - s) * 0.16f);
    if (p.y > 1.50f) {
        const float fromFace = glm::length(p - Vec3f(0.02f, 1.61f, 0.09f));
        length = std::min(length, 0.0036f + std::max(0.0f, fromFace - 0.045f) * 0.085f);
        const float fromEar = glm::length(p - Vec3f(0.082f, 1.625f, -0.014f));
        length = std::min(length, 0.0048f + std::max(0.0f, fromEar - 0.035f) * 0.12f);
    }
    if (p.y < 0.14f) length = std::min(length, p.z > 0.08f ? 0.0070f : 0.0070f + std::max(0.0f, 0.08f - p.z) * 0.06f);
    return length;
}

}  // namespace dpl
