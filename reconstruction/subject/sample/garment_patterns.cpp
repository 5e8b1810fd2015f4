// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <memory>

#include "reconstruction/subject/sample/garments.h"

namespace dpl {
namespace {

Vec3f mirroredSide(const Vec3f& p) {
    return {std::abs(p.x), p.y, p.z};
}

/** Position along the upper arm, metres from the shoulder joint. p.x ≥ 0. */
float alongArm(const Vec3f& p) {
    static const auto joints = builtinSkeleton();
    const Vec3f shoulder = joints[kLeftShoulder].restPosition, elbow = joints[kLeftElbow].restPosition;
    return glm::dot(p - shoulder, glm::normalize(elbow - shoulder));
}

/** True for points around the arm, false for the side of the trunk below it. p.x ≥ 0. */
bool besideArm(const Vec3f& p) {
    static const Vec3f shoulder = builtinSkeleton()[kLeftShoulder].restPosition;
    return glm::dot(p - shoulder, Vec3f(0.669f, 0.743f, 0)) > kSleeveReachM;
}

/** A section around the trunk, widened by slackM on all sides. */
TubeStation trunkSection(float y, float halfWidth, float front, float back, float slackM) {
    return {y, 0, 0, halfWidth + slackM, halfWidth + slackM, back + slackM, front + slackM};
}

/** The shirt's shape over the trunk: cloth hangs from chest and shoulder blades and bridges the hollows below them. */
Tube makeDrape(float looseness) {
    const float l = 0.006f * looseness;
    auto at = [&](float y, float halfWidth, float front, float back, float share) {
        return trunkSection(y, halfWidth, front, back, l * share);
    };
    return Tube({0, 0, 0}, {0, 1, 0}, {1, 0, 0},
                {at(0.70f, 0.187f, 0.114f, 0.134f, 3), at(0.80f, 0.187f, 0.116f, 0.136f, 2.6f), at(0.90f, 0.185f, 0.118f, 0.135f, 2.2f),
                 at(1.00f, 0.176f, 0.121f, 0.124f, 2), at(1.10f, 0.170f, 0.122f, 0.118f, 2), at(1.20f, 0.172f, 0.122f, 0.120f, 1.6f),
                 at(1.30f, 0.172f, 0.120f, 0.128f, 1), at(1.38f, 0.150f, 0.094f, 0.118f, 0.5f), at(1.43f, 0.105f, 0.060f, 0.095f, 0)},
                2.3f);
}

float shortsField(const BodyField& body, const WardrobeChoice& c, const Vec3f& world) {
    const Vec3f p = mirroredSide(world);
    const float flare = ramp(p.y, 0.85f, c.shortsHemY);
    const Vec3f axis(0.092f + 0.029f * (0.902f - p.y) / 0.407f, 0, -0.004f);
    const float angle = std::atan2(p.z - axis.z, p.x - axis.x);
    const float side = world.x < 0 ? 1.7f : 0.0f;
    const float folds = flare * (0.0035f * std::sin(5 * angle + c.foldPhase + side) + 0.0018f * std::sin(11 * angle + 40 * p.y + side));
    const float wrinkles = 0.0016f * ramp(std::abs(p.y - 0.83f), 0.10f, 0.0f) * std::sin(150 * p.y + 40 * p.x + 9 * p.z);
    const float leg = body.leg(p) - (0.007f + 0.017f * c.looseness * flare + folds + wrinkles);
    const float trunk = body.torso(p) - 0.006f;
    return smoothUnion(p.y > 0.74f ? trunk : 1.0f, leg, 0.045f);
}

/** The skirt without folds: it lies on the hips and widens evenly below them. */
Tube makeSkirtCone(float looseness) {
    const float l = 0.012f * looseness;
    auto at = [&](float y, float halfWidth, float front, float back, float share) {
        return trunkSection(y, halfWidth, front, back, l * share);
    };
    return Tube({0, 0, 0}, {0, 1, 0}, {1, 0, 0},
                {at(0.36f, 0.268f, 0.240f, 0.246f, 3), at(0.46f, 0.254f, 0.222f, 0.229f, 2.6f), at(0.58f, 0.236f, 0.195f, 0.205f, 2.1f),
                 at(0.70f, 0.214f, 0.163f, 0.178f, 1.5f), at(0.80f, 0.196f, 0.135f, 0.156f, 0.9f), at(0.90f, 0.182f, 0.112f, 0.134f, 0.3f),
                 at(1.00f, 0.150f, 0.095f, 0.100f, 0), at(1.06f, 0.120f, 0.080f, 0.080f, 0)},
                2.2f);
}

float skirtField(const BodyField& body, const Tube& cone, const WardrobeChoice& c, const Vec3f& p) {
    const float low = ramp(p.y, 0.86f, c.skirtHemY), angle = std::atan2(p.x / 0.25f, p.z / 0.22f);
    const float folds = low * (0.011f * std::sin(9 * angle + c.foldPhase) + 0.005f * std::sin(14 * angle + 1.7f * c.foldPhase + 6 * p.y));
    return smoothUnion(p.y > 0.74f ? body.torso(p) - 0.006f : 1.0f, cone.distance(p) - folds, 0.03f);
}

float shirtField(const BodyField& body, const Tube& drape, const WardrobeChoice& c, const ScalarField& bottom, const Vec3f& world) {
    const Vec3f p = mirroredSide(world);
    const float angle = std::atan2(world.x / 0.18f, world.z / 0.12f);
    const float low = ramp(p.y, 1.16f, c.shirtHemY);
    float folds = low * (0.0042f * std::sin(6 * angle + c.foldPhase) + 0.0024f * std::sin(11 * angle + 1.3f * c.foldPhase + 9 * p.y));
    // Slanted wrinkles above the waist and fine ones around the armpit.
    folds += 0.0026f * ramp(std::abs(p.y - 1.00f), 0.16f, 0.0f) * std::sin(62 * p.y + 2.5f * std::sin(2 * angle + c.foldPhase) + 7 * angle);
    folds += 0.0020f * ramp(glm::length(p - Vec3f(0.17f, 1.31f, 0.0f)), 0.14f, 0.02f) * std::sin(120 * (p.y - 0.55f * p.x) + c.foldPhase);
    const float trunk = smoothUnion(body.torso(p) - 0.0065f, drape.distance(p), 0.03f) - folds;
    const float s = alongArm(p), flare = ramp(s, 0.02f, c.sleeveM);
    const float cuff = 0.010f + 0.014f * c.looseness * flare +
                       0.0024f * flare * std::sin(3.0f * std::atan2(p.z + 0.02f, p.y - 1.35f) + c.foldPhase) +
                       0.0018f * std::sin(95 * s + 30 * p.z) * ramp(s, -0.02f, 0.05f);
    float sleeve = p.x > 0.06f ? body.arm(p) - cuff : 1.0f;
    float d = smoothUnion(trunk, sleeve, 0.05f);
    if (p.y < 1.04f) d = smoothUnion(d, bottom(world) - 0.0065f, 0.012f);
    return d;
}

float hairline(float z) {
    // Pairs of z (forward, metres) and the height where the hair ends, from the nape over the ear to the forehead.
    constexpr float table[][2] = {{-0.13f, 1.578f},  {-0.085f, 1.580f}, {-0.058f, 1.598f}, {-0.044f, 1.650f},
                                  {-0.020f, 1.668f}, {0.008f, 1.662f},  {0.020f, 1.640f},  {0.032f, 1.648f},
                                  {0.040f, 1.690f},  {0.055f, 1.706f},  {0.12f, 1.708f}};
    if (z <= table[0][0]) return table[0][1];
    for (size_t i = 1; i < std::size(table); ++i)
        if (z < table[i][0])
            return table[i - 1][1] + (table[i][1] - table[i - 1][1]) * (z - table[i - 1][0]) / (table[i][0] - table[i - 1][0]);
    return table[std::size(table) - 1][1];
}

float hairKeep(const Vec3f& p) {
    float sum = 0;  // averaging rounds the corners of the table
    for (float dz : {-0.008f, -0.004f, 0.0f, 0.004f, 0.008f}) sum += hairline(p.z + dz);
    return (p.y - sum / 5) * 0.8f;
}

}  // namespace

GarmentPattern shirtPattern(const BodyField& body, const WardrobeChoice& choice, const GarmentPattern& bottom) {
    auto drape = std::make_shared<Tube>(makeDrape(choice.looseness));
    GarmentPattern g;
    g.field = [&body, drape, choice, under = bottom.field](const Vec3f& p) { return shirtField(body, *drape, choice, under, p); };
    g.keep = [choice](const Vec3f& world) {
        const Vec3f p = mirroredSide(world);
        const float hem =
            p.y - (choice.shirtHemY - 0.012f * ramp(p.z, 0.05f, -0.10f) + 0.006f * std::sin(2.2f * world.x * 10 + choice.foldPhase));
        const float cuff = choice.sleeveM - alongArm(p);
        // Crew neck: an oval opening around the neck, tilted like the spine.
        const float z = p.z + 0.006f - 0.20f * (p.y - 1.45f);
        const float neck =
            p.y > 1.33f ? (std::sqrt(p.x * p.x / (0.080f * 0.080f) + z * z / (z > 0 ? 0.073f * 0.073f : 0.059f * 0.059f)) - 1) * 0.072f
                        : 1.0f;
        return std::min({hem, p.x > 0.15f && besideArm(p) ? cuff : 1.0f, neck});
    };
    g.low = {-0.42f, 0.79f, -0.21f}, g.high = {0.42f, 1.56f, 0.20f};
    g.edgeLengthM = 0.0125f;
    return g;
}

GarmentPattern shortsPattern(const BodyField& body, const WardrobeChoice& choice) {
    GarmentPattern g;
    g.field = [&body, choice](const Vec3f& p) { return shortsField(body, choice, p); };
    g.keep = [choice](const Vec3f& p) { return std::min(1.010f - p.y, p.y - choice.shortsHemY + 0.05f * (std::abs(p.x) - 0.12f)); };
    g.low = {-0.28f, 0.50f, -0.22f}, g.high = {0.28f, 1.06f, 0.20f};
    g.edgeLengthM = 0.0130f;
    return g;
}

GarmentPattern skirtPattern(const BodyField& body, const WardrobeChoice& choice) {
    auto cone = std::make_shared<Tube>(makeSkirtCone(choice.looseness));
    GarmentPattern g;
    g.field = [&body, cone, choice](const Vec3f& p) { return skirtField(body, *cone, choice, p); };
    g.keep = [choice](const Vec3f& p) { return std::min(1.010f - p.y, p.y - choice.skirtHemY); };
    g.low = {-0.36f, 0.41f, -0.34f}, g.high = {0.36f, 1.06f, 0.34f};
    g.edgeLengthM = 0.0145f;
    return g;
}

GarmentPattern shoePattern(const BodyField& body, const WardrobeChoice&) {
    GarmentPattern g;
    g.field = [&body](const Vec3f& p) {
        // Upper with a blunt toe box, then a sole that is slightly wider.
        float d = smoothUnion(body.leg({p.x, std::max(p.y, 0.004f), p.z}), ellipsoid(p, {0.167f, 0.019f, 0.146f}, {0.043f, 0.017f, 0.044f}),
                              0.02f) -
                  0.0060f;
        const float outline = smoothUnion(body.foot({p.x, 0.022f, p.z}),
                                          ellipsoid({p.x, 0.02f, p.z}, {0.168f, 0.02f, 0.142f}, {0.046f, 0.03f, 0.052f}), 0.03f) -
                              0.0095f;
        const float slab = std::max(outline, std::abs(p.y - 0.003f) - (kSoleM + 0.003f));
        d = smoothUnion(d, slab, 0.006f);
        return smoothIntersection(d, -p.y - kSoleM, 0.006f);
    };
    g.keep = [](const Vec3f& p) { return (0.078f + 0.10f * std::abs(p.z + 0.035f) - p.y) * 0.9f; };
    g.low = {0.06f, -0.03f, -0.12f}, g.high = {0.27f, 0.13f, 0.22f};
    g.edgeLengthM = 0.0090f;
    g.mirroredPair = true;
    return g;
}

GarmentPattern hairPattern(const BodyField& body, const WardrobeChoice& choice) {
    GarmentPattern g;
    g.field = [&body, choice](const Vec3f& p) {
        const float inside = ramp(hairKeep(p), -0.004f, 0.055f), crown = ramp(p.y, 1.63f, 1.74f);
        // Locks of hair, running back from the forehead.
        const float across = p.x + 0.010f * std::sin(34 * p.z + choice.foldPhase);
        const float locks =
            0.0022f * std::sin(across * 300 + 9 * std::sin(p.z * 24 + choice.foldPhase)) + 0.0012f * std::sin(across * 710 + 55 * p.y + 2);
        const float quiff = choice.quiffM * ramp(p.z, 0.02f, 0.075f) * crown;
        const float thickness = 0.0022f + inside * (choice.hairM * (0.55f + 0.45f * crown) + quiff + locks);
        return body.scalp(p) - thickness;
    };
    g.keep = hairKeep;
    g.low = {-0.13f, 1.53f, -0.17f}, g.high = {0.13f, 1.83f, 0.17f};
    g.edgeLengthM = 0.0085f;
    return g;
}

}  // namespace dpl
