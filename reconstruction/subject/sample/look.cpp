// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/subject/sample/look.h"

#include <algorithm>
#include <cmath>
#include <span>
#include <vector>

#include "reconstruction/subject/sample/chart.h"
#include "reconstruction/subject/sample/garments.h"
#include "reconstruction/subject/sample/random.h"
#include "reconstruction/subject/sample/skeleton.h"
#include "reconstruction/subject/sample/subject.h"

namespace dpl {
namespace {

Vec3f linear(int r, int g, int b) {
    auto decode = [](int v) {
        const float x = float(v) / 255;
        return x <= 0.04045f ? x / 12.92f : std::pow((x + 0.055f) / 1.055f, 2.4f);
    };
    return {decode(r), decode(g), decode(b)};
}

/** 1 inside (distance < 0), 0 outside, with a ramp one footprint wide. */
float coverage(float distance, float footprint) {
    return std::clamp(0.5f - distance / std::max(footprint, 1e-5f), 0.0f, 1.0f);
}

/** Contrast that remains of a pattern of this period at this footprint, 0 to 1. */
float resolved(float periodM, float footprintM) {
    return std::clamp(1.5f - 2.0f * footprintM / periodM, 0.0f, 1.0f);
}

float lattice(int x, int y, int z, uint64_t seed) {
    return float(mixBits(uint64_t(uint32_t(x)) * 0x8da6b343u ^ uint64_t(uint32_t(y)) * 0xd8163841u << 16 ^
                         uint64_t(uint32_t(z)) * 0xcb1ab31fu << 24 ^ seed) >>
                 40) *
           0x1p-24f;
}

/** Smooth noise in [0, 1]; a lattice cell has side 1 in the units of p. */
float noise(const Vec3f& p, uint64_t seed) {
    const Vec3f f = glm::floor(p);
    Vec3f t = p - f;
    t = t * t * (3.0f - 2.0f * t);
    const int x = int(f.x), y = int(f.y), z = int(f.z);
    float sum = 0;
    for (int c = 0; c < 8; ++c) {
        const int i = c & 1, j = c >> 1 & 1, k = c >> 2;
        sum += (i ? t.x : 1 - t.x) * (j ? t.y : 1 - t.y) * (k ? t.z : 1 - t.z) * lattice(x + i, y + j, z + k, seed);
    }
    return sum;
}

float segment(const Vec2f& p, const Vec2f& a, const Vec2f& b) {
    const Vec2f ab = b - a;
    const float t = std::clamp(glm::dot(p - a, ab) / std::max(glm::dot(ab, ab), 1e-9f), 0.0f, 1.0f);
    return glm::length(p - a - ab * t);
}

/** The letters of DOPPEL as polylines in a cell of 1 × 1.5. */
const std::vector<std::vector<Vec2f>>& lettersDoppel() {
    static const std::vector<Vec2f> d{{0, 0},         {0, 1.5f},      {0.45f, 1.5f}, {0.78f, 1.35f}, {0.92f, 1.05f},
                                      {0.92f, 0.45f}, {0.78f, 0.15f}, {0.45f, 0},    {0, 0}};
    static const std::vector<Vec2f> o{{0.3f, 0},     {0.08f, 0.2f}, {0, 0.5f},     {0, 1},     {0.08f, 1.3f},
                                      {0.3f, 1.5f},  {0.62f, 1.5f}, {0.84f, 1.3f}, {0.92f, 1}, {0.92f, 0.5f},
                                      {0.84f, 0.2f}, {0.62f, 0},    {0.3f, 0}};
    static const std::vector<Vec2f> p{{0, 0},        {0, 1.5f},      {0.55f, 1.5f},  {0.82f, 1.38f},
                                      {0.9f, 1.12f}, {0.82f, 0.86f}, {0.55f, 0.72f}, {0, 0.72f}};
    static const std::vector<Vec2f> e{{0.85f, 1.5f}, {0, 1.5f}, {0, 0.78f}, {0.7f, 0.78f}, {0, 0.78f}, {0, 0}, {0.85f, 0}};
    static const std::vector<Vec2f> l{{0, 1.5f}, {0, 0}, {0.82f, 0}};
    static const std::vector<std::vector<Vec2f>> word{d, o, p, p, e, l};
    return word;
}

/** Distance to the strokes of DOPPEL, whose first letter begins at x = left; 1 where it is far. */
float distanceToLetters(const Vec2f& at, float left, float cell, float pitch) {
    const auto& word = lettersDoppel();
    const float margin = cell * (2.0f / 3);
    float distance = 1;
    for (size_t i = 0; i < word.size(); ++i) {
        const Vec2f q(at.x - (left + pitch * float(i)), at.y);
        if (q.x < -margin || q.x > cell + margin || q.y < -margin || q.y > 1.5f * cell + margin) continue;
        for (size_t k = 0; k + 1 < word[i].size(); ++k) distance = std::min(distance, segment(q, word[i][k] * cell, word[i][k + 1] * cell));
    }
    return distance;
}

struct SkinPaint {
    const Look& look;
    Vec3f p;  // x mirrored
    float x;  // signed
    float footprint;

    SurfaceColour paint() const {
        SurfaceColour out;
        Vec3f c = look.skin;
        // Redder skin on cheeks, nose, ears, knees and elbows, and mottling everywhere.
        auto near = [&](Vec3f centre, float radius) { return std::exp(-glm::dot(p - centre, p - centre) / (radius * radius)); };
        const float red = 0.55f * near({0.046f, 1.610f, 0.075f}, 0.024f) + 0.5f * near({0, 1.608f, 0.115f}, 0.014f) +
                          0.6f * near({0.085f, 1.628f, -0.012f}, 0.030f) + 0.5f * near({0.121f, 0.50f, 0.05f}, 0.05f) +
                          0.35f * near({0.37f, 1.22f, -0.06f}, 0.05f);
        c *= Vec3f(1 + 0.10f * red, 1 - 0.12f * red, 1 - 0.10f * red);
        const float mottle = noise(Vec3f(x, p.y, p.z) * 45.0f, look.seed) - 0.5f,
                    fine = noise(Vec3f(x, p.y, p.z) * 220.0f, look.seed + 1) - 0.5f;
        c *= 1 + 0.10f * mottle + 0.10f * fine * resolved(0.009f, footprint);
        if (fine > 0.38f && p.y > 0.3f) c *= 1 - 0.22f * resolved(0.006f, footprint) * ramp(fine, 0.38f, 0.46f);  // freckles and moles
        out.sheen = 0.25f;
        if (p.y > 1.49f && p.z > -0.02f) face(c, out);
        if (p.x > 0.55f) nails(c, out);
        out.albedo = c;
        return out;
    }

    void face(Vec3f& c, SurfaceColour& out) const {
        // Stubble on jaw, chin and upper lip.
        const float jaw = ramp(p.y, 1.612f, 1.585f) * ramp(p.y, 1.505f, 1.528f) * ramp(p.z, -0.010f, 0.020f);
        const float moustache = std::exp(-glm::dot((p - Vec3f(0.008f, 1.592f, 0.098f)) / Vec3f(0.020f, 0.0055f, 0.02f),
                                                   (p - Vec3f(0.008f, 1.592f, 0.098f)) / Vec3f(0.020f, 0.0055f, 0.02f)));
        const float grain = 0.75f + 0.5f * noise(Vec3f(x, p.y, p.z) * 700.0f, look.seed + 2) * resolved(0.003f, footprint);
        c = glm::mix(c, look.hair * 0.8f + Vec3f(0.05f), std::clamp(look.stubble * (jaw + moustache) * 0.42f * grain, 0.0f, 0.6f));
        // Lips with a dark line between them.
        const float lx = p.x / 0.0245f, mouthY = 1.5768f + 0.0010f * lx * lx;
        if (lx < 1.15f && p.z > 0.07f) {
            const float upper = 0.0072f * (1 - lx * lx) * (1 - 0.22f * std::exp(-lx * lx * 30)), lower = 0.0092f * (1 - lx * lx);
            const float y = p.y - mouthY, inside = y >= 0 ? y - upper : -y - lower;
            const float lip = lx < 1 ? coverage(inside, std::max(footprint, 0.0016f)) : 0;
            c = glm::mix(c, look.lips, 0.75f * lip);
            out.gloss += 0.18f * lip;
            const float line =
                coverage(std::abs(y) - 0.0009f * (1 - lx * lx * 0.6f), std::max(footprint, 0.0012f)) * ramp(lx, 1.08f, 0.98f);
            c = glm::mix(c, look.lips * 0.22f, 0.85f * line);
        }
        // Nostrils.
        const Vec3f n = (p - Vec3f(0.0060f, 1.6000f, 0.1040f)) / Vec3f(0.0034f, 0.0032f, 0.008f);
        c = glm::mix(c, c * 0.18f, coverage(glm::length(n) - 1, 0.45f));
        // Brows: an arc of short hairs.
        const float bx = (p.x - 0.0125f) / 0.040f;
        if (bx > -0.1f && bx < 1.1f && p.z > 0.03f) {
            const float arc = 1.6635f + 0.0085f * bx * (1.55f - bx),
                        half = 0.0042f * (1 - 0.55f * std::max(bx, 0.0f)) * ramp(bx, -0.08f, 0.10f) * ramp(bx, 1.08f, 0.85f);
            const float hairs = 0.86f + 0.14f * std::sin(1900 * p.x + 900 * p.y) * resolved(0.003f, footprint);
            c = glm::mix(c, look.hair * 0.9f,
                         hairs * coverage(std::abs(p.y - arc) - half, std::max(footprint, 0.0022f)) * float(half > 2e-4f));
        }
        // Eyes: an almond shape with white, iris, pupil, highlight and lash line, shaded by the upper lid.
        const Vec2f e(p.x - 0.0318f, p.y - 1.6450f);
        if (std::abs(e.x) < 0.022f && std::abs(e.y) < 0.014f && p.z > 0.055f) {
            const float u = e.x / 0.0150f, tilt = 0.0008f * u;
            const float top = 0.0060f * (1 - u * u) + tilt, bottom = -0.0046f * (1 - u * u) + tilt;
            const float open = std::max(e.y - top, bottom - e.y);
            const float white = std::abs(u) < 1 ? coverage(open, std::max(footprint, 0.0010f)) : 0;
            Vec3f eye(0.62f, 0.58f, 0.55f);
            const float r = glm::length(e - Vec2f(0, 0.0004f));
            const float fibres = 0.8f + 0.4f * noise(Vec3f(std::atan2(e.y, e.x) * 6, r * 900, 3), look.seed + 5);
            eye = glm::mix(eye, look.iris * fibres, coverage(r - 0.0059f, std::max(footprint, 0.0008f)));
            eye = glm::mix(eye, look.iris * 0.25f, coverage(std::abs(r - 0.0057f) - 0.0004f, std::max(footprint, 0.0006f)) * 0.8f);
            eye = glm::mix(eye, Vec3f(0.008f), coverage(r - 0.0025f, std::max(footprint, 0.0006f)));
            eye = glm::mix(eye, Vec3f(0.95f), coverage(glm::length(e - Vec2f(-0.0016f, 0.0022f)) - 0.0009f, std::max(footprint, 0.0005f)));
            eye *= 0.72f + 0.28f * ramp(top - e.y, 0.0f, 0.0035f);  // the upper lid's shadow
            c = glm::mix(c, eye, white);
            out.gloss += 0.5f * white;
            if (std::abs(u) < 1.12f) {
                const float lash = coverage(std::abs(e.y - top - 0.0004f) - 0.0009f * (1 - 0.5f * u * u), std::max(footprint, 0.0009f));
                c = glm::mix(c, look.hair * 0.4f, 0.85f * lash * ramp(std::abs(u), 1.12f, 1.0f));
                const float crease = coverage(std::abs(e.y - top - 0.0042f) - 0.0005f, std::max(footprint, 0.0014f));
                c *= 1 - 0.30f * crease * ramp(std::abs(u), 1.1f, 0.8f);
                const float lowLid = coverage(std::abs(e.y - bottom) - 0.0004f, std::max(footprint, 0.0010f));
                c *= 1 - 0.22f * lowLid * ramp(std::abs(u), 1.1f, 0.9f);
            }
        }
    }

    void nails(Vec3f& c, SurfaceColour& out) const {
        static const HandFrame hand = leftHandFrame();
        for (int f = 0; f < kFingerCount; ++f) {
            static const std::array<std::array<Vec3f, 4>, kFingerCount> chains = [] {
                std::array<std::array<Vec3f, 4>, kFingerCount> all;
                for (int i = 0; i < kFingerCount; ++i) all[i] = leftFingerChain(Finger(i));
                return all;
            }();
            const auto& chain = chains[f];
            const Vec3f along = glm::normalize(chain[3] - chain[2]);
            const Vec3f up =
                glm::normalize((f == kThumb ? hand.dorsal * 0.6f + hand.thumbward * 0.8f : hand.dorsal) -
                               along * glm::dot(f == kThumb ? hand.dorsal * 0.6f + hand.thumbward * 0.8f : hand.dorsal, along));
            const Vec3f q = p - (chain[3] - along * 0.0055f);
            const float s = glm::dot(q, along), w = glm::dot(q, glm::cross(along, up)), n = glm::dot(q, up);
            if (n < 0.001f || std::abs(s) > 0.02f || std::abs(w) > 0.012f) continue;
            const float wide = f == kThumb ? 0.0062f : f == kPinky ? 0.0040f : 0.0050f;
            const float nail = coverage((std::sqrt(s * s / 0.000049f + w * w / (wide * wide)) - 1) * 0.005f, std::max(footprint, 0.0012f));
            c = glm::mix(c, glm::mix(c, Vec3f(0.80f, 0.58f, 0.52f), 0.45f), nail);
            out.gloss += 0.12f * nail;
        }
    }
};

SurfaceColour shirtColour(const Look& look, const Vec3f& p, float footprint) {
    SurfaceColour out;
    static const auto joints = builtinSkeleton();
    const Vec3f a(std::abs(p.x), p.y, p.z), shoulder = joints[kLeftShoulder].restPosition;
    const Vec3f arm = glm::normalize(joints[kLeftElbow].restPosition - shoulder);
    const float s = glm::dot(a - shoulder, arm);
    const bool sleeve = s > -0.005f && glm::dot(a - shoulder, Vec3f(0.669f, 0.743f, 0)) > kSleeveReachM;
    // `row` is metres along the trunk or sleeve, `column` about metres around it.
    const float row = sleeve ? s : p.y, column = sleeve ? std::atan2(a.z + 0.02f, glm::dot(a - shoulder, Vec3f(-arm.y, arm.x, 0))) * 0.06f
                                                        : std::atan2(p.x, p.z) * 0.15f;
    Vec3f c = look.shirt;
    auto stripe = [&](float x, float period, float width) { return bars(x, period, width, footprint); };
    if (look.shirtPattern == 0)
        c = glm::mix(c, look.shirtStripe, stripe(row, 0.042f, 0.010f));
    else if (look.shirtPattern == 1) {
        const float across = stripe(row, 0.036f, 0.012f), down = stripe(column, 0.036f, 0.012f);
        c = glm::mix(c, look.shirtStripe, 0.30f * (across + down) + 0.25f * across * down);
    } else {
        const float melange = noise(p * Vec3f(720, 300, 720), look.seed + 3) - 0.5f;
        c = glm::mix(c, look.shirtStripe, 0.25f + 0.5f * melange * resolved(0.006f, footprint));
    }
    // The weave: fine rows and columns, visible only close up.
    const float weave = std::sin(6.2832f * row / 0.0032f) * std::sin(6.2832f * column / 0.0032f);
    c *= 1 + 0.12f * weave * resolved(0.0034f, footprint) + 0.08f * (noise(p * 70.0f, look.seed + 4) - 0.5f);
    // Stitching at seams and hems.
    const float hemLine = std::min(std::abs(p.y - look.shirtHemY - 0.022f), std::abs(look.sleeveM - s - 0.020f) + (sleeve ? 0.0f : 1.0f));
    c *= 1 - 0.35f * coverage(hemLine - 0.0012f, std::max(footprint, 0.001f)) * resolved(0.012f, footprint);
    if (!sleeve)
        c *= 1 - 0.30f * coverage(std::abs(s + 0.006f) - 0.0012f, std::max(footprint, 0.001f)) * float(a.y > 1.30f) *
                     resolved(0.012f, footprint);
    const float neckZ = p.z + 0.006f - 0.20f * (p.y - 1.45f);
    const float neck = std::sqrt(p.x * p.x / (0.094f * 0.094f) + neckZ * neckZ / (neckZ > 0 ? 0.087f * 0.087f : 0.073f * 0.073f)) - 1;
    if (p.y > 1.36f && neck < 0)
        c = look.shirt * (0.62f + 0.10f * std::sin(6.2832f * std::atan2(p.x, p.z) * 0.08f / 0.004f) * resolved(0.005f, footprint));
    // The print on the chest, and a number on the back.
    if (look.chart && !sleeve && p.z > 0.02f) {
        const ChartInk chart = chartInk(Vec2f(p) - kChartCentre, footprint);
        c = glm::mix(c, glm::mix(Vec3f(0.72f), Vec3f(0.03f), chart.ink), chart.panel);
    } else if (!sleeve && p.z > 0.02f && p.y > 1.05f) {
        const Vec2f ink = logoInk({p.x, p.y - 1.225f}, footprint);
        c = glm::mix(glm::mix(c, look.logoAccent, ink.y), look.logoInk, ink.x);
    }
    if (!sleeve && p.z < -0.04f && p.y > 1.1f) {
        const Vec2f q(-p.x, p.y - 1.27f);  // "2", mirrored so that it reads correctly from behind
        const Vec2f strokes[] = {{-0.035f, 0.035f}, {-0.02f, 0.06f},   {0.02f, 0.06f},  {0.036f, 0.035f},
                                 {0.03f, 0.01f},    {-0.036f, -0.06f}, {0.038f, -0.06f}};
        float d = 1;
        for (int i = 0; i + 1 < int(std::size(strokes)); ++i) d = std::min(d, segment(q, strokes[i], strokes[i + 1]));
        c = glm::mix(c, look.logoInk, 0.92f * coverage(d - 0.010f, footprint));
    }
    out.albedo = c;
    out.sheen = 0.35f;
    return out;
}

}  // namespace

float bars(float x, float periodM, float widthM, float footprintM) {
    const float d = std::abs(x - periodM * std::round(x / periodM)) - 0.5f * widthM;
    return glm::mix(widthM / periodM, coverage(d, footprintM), resolved(periodM, footprintM));
}

float wordInk(const Vec2f& at, float heightM, float footprintM) {
    const float cell = heightM / 1.5f;
    return coverage(distanceToLetters(at, 0, cell, 1.25f * cell) - 0.14f * cell, footprintM);
}

Vec2f logoInk(const Vec2f& at, float footprintM) {
    constexpr float cell = 0.030f, pitch = 0.0375f, stroke = 0.0042f;
    const float left = -0.5f * (pitch * float(lettersDoppel().size()) - (pitch - cell * 0.92f));
    const float letters = distanceToLetters(at, left, cell, pitch);
    // Two overlapping rings and a bar under the word.
    const Vec2f c1 = at - Vec2f(-0.022f, -0.062f), c2 = at - Vec2f(0.022f, -0.062f);
    float emblem = std::min(std::abs(glm::length(c1) - 0.030f) - 0.0048f, std::abs(glm::length(c2) - 0.030f) - 0.0048f);
    emblem = std::min(emblem, std::max(glm::length(c1) - 0.025f, glm::length(c2) - 0.025f));  // the intersection of the rings
    emblem = std::min(emblem, std::max(std::abs(at.x) - 0.105f, std::abs(at.y + 0.014f) - 0.0022f));
    return {coverage(letters - stroke, footprintM), coverage(emblem, footprintM)};
}

Look makeLook(uint64_t seed) {
    Random random(seed, 55);
    Look look;
    look.seed = seed;
    const Vec3f skins[] = {linear(232, 190, 162), linear(214, 164, 132), linear(190, 136, 104), linear(148, 100, 74), linear(102, 68, 50)};
    look.skin = glm::mix(skins[random.below(4)], skins[1 + random.below(4)], float(random.uniform(0, 0.6)));
    look.lips = look.skin * Vec3f(0.86f, 0.50f, 0.52f);
    const Vec3f irises[] = {linear(70, 110, 140), linear(96, 66, 36), linear(84, 104, 64), linear(52, 34, 22)};
    look.iris = irises[random.below(4)];
    const Vec3f hairs[] = {linear(42, 30, 24), linear(84, 56, 34), linear(124, 88, 50), linear(26, 22, 22)};
    look.hair = hairs[random.below(4)];
    look.stubble = float(random.uniform(0.1, 0.9));
    const Vec3f shirts[] = {linear(36, 74, 118), linear(150, 44, 40), linear(44, 104, 84), linear(196, 188, 172), linear(72, 60, 110)};
    const Vec3f stripes[] = {linear(226, 222, 210), linear(240, 214, 180), linear(230, 226, 200), linear(60, 84, 120),
                             linear(214, 200, 226)};
    const Vec3f inks[] = {linear(250, 244, 226), linear(252, 240, 220), linear(248, 240, 196), linear(28, 34, 52), linear(250, 240, 250)};
    const Vec3f accents[] = {linear(236, 150, 40), linear(248, 204, 90), linear(232, 112, 60), linear(196, 60, 44), linear(240, 190, 70)};
    const uint32_t shirt = random.below(5);
    look.shirt = shirts[shirt], look.shirtStripe = stripes[shirt], look.logoInk = inks[shirt], look.logoAccent = accents[shirt];
    look.shirtPattern = int(random.below(3));
    const Vec3f shorts[] = {linear(120, 104, 78), linear(58, 64, 74), linear(84, 96, 72), linear(48, 56, 92)};
    look.shorts = shorts[random.below(4)];
    const Vec3f shoes[] = {linear(214, 212, 206), linear(70, 72, 80), linear(180, 60, 48)};
    look.shoes = shoes[random.below(3)];
    look.shoeAccent = random.below(2) ? linear(40, 70, 130) : linear(30, 30, 34);
    return look;
}

SurfaceColour surfaceColour(const Look& look, uint8_t label, const Vec3f& p, float footprint) {
    SurfaceColour out;
    switch (label) {
        case kLabelTop:
            return shirtColour(look, p, footprint);
        case kLabelBottom: {
            // Twill (slanted rows), pocket and side seams, fly and stitched hem.
            const float twill = std::sin(6.2832f * (p.y + 0.6f * std::atan2(std::abs(p.x) - 0.1f, p.z) * 0.09f) / 0.0040f);
            Vec3f c = look.shorts * (1 + 0.10f * twill * resolved(0.0042f, footprint) + 0.16f * (noise(p * 38.0f, look.seed + 6) - 0.5f));
            if (look.dotted) {
                constexpr float kPitchM = 0.055f, kRadiusM = 0.013f;
                const float row = std::floor(p.y / kPitchM), around = std::atan2(p.x, p.z) * 0.21f + 0.5f * kPitchM * row;
                const Vec2f fromDot(around - kPitchM * std::round(around / kPitchM), p.y - kPitchM * (row + 0.5f));
                c = glm::mix(c, look.shirtStripe, coverage(glm::length(fromDot) - kRadiusM, footprint));
            }
            const float side = std::abs(p.z + 0.005f) + (std::abs(p.x) > 0.12f ? 0.0f : 1.0f);
            const float pocket = std::abs(p.z - 0.055f + 0.55f * (p.y - 0.93f)) +
                                 (std::abs(p.x) > 0.09f && p.y > 0.80f && p.y < 0.95f && p.z > 0.0f ? 0.0f : 1.0f);
            const float hem = std::abs(p.y - look.bottomHemY - 0.028f), fly = std::abs(p.x) + (p.z > 0.05f && p.y > 0.83f ? 0.0f : 1.0f);
            const float seams[] = {hem, side, pocket, fly};
            for (float seam : std::span(seams).first(look.dotted ? 1 : 4))
                c *= 1 - 0.40f * coverage(seam - 0.0016f, std::max(footprint, 0.0012f)) * resolved(0.014f, footprint);
            out.albedo = c;
            out.sheen = 0.30f;
            return out;
        }
        case kLabelHair: {
            const float strand = noise(Vec3f((p.x + 0.010f * std::sin(34 * p.z)) * 900, p.y * 90, p.z * 60), look.seed + 7);
            const float lock = noise(Vec3f(p.x * 160, p.y * 26, p.z * 22), look.seed + 8);
            out.albedo = look.hair * (0.55f + 0.5f * lock + 0.6f * (strand - 0.5f) * resolved(0.0022f, footprint) + 0.15f);
            out.sheen = 0.20f;
            out.gloss = 0.03f;
            return out;
        }
        case kLabelShoes: {
            const Vec3f a(std::abs(p.x), p.y, p.z);
            Vec3f c = look.shoes * (1 + 0.06f * std::sin(6.2832f * (p.z + 0.3f * p.y) / 0.005f) * resolved(0.005f, footprint) +
                                    0.08f * (noise(p * 120.0f, look.seed + 9) - 0.5f));
            if (p.y < 0.006f)
                c = Vec3f(0.72f, 0.71f, 0.68f) * (1 - 0.25f * coverage(std::abs(p.y + 0.004f) - 0.0016f, std::max(footprint, 0.001f)));
            else {
                // Laces over the instep, a stripe on the side, a toe cap.
                const Vec3f forward = glm::normalize(Vec3f(0.026f, 0, 0.202f));
                const float s = glm::dot(a - Vec3f(0.146f, 0, -0.030f), forward),
                            w = glm::dot(a - Vec3f(0.146f, 0, -0.030f), Vec3f(forward.z, 0, -forward.x));
                const float lace = std::abs(s - 0.014f * std::round(s / 0.014f)) - 0.003f;
                if (s > 0.045f && s < 0.115f && std::abs(w) < 0.020f)
                    c = glm::mix(look.shoeAccent, Vec3f(0.8f), coverage(lace, footprint) * resolved(0.012f, footprint));
                const float flash = std::max(std::abs(p.y - 0.030f - 0.22f * (s - 0.05f)) - 0.006f, std::abs(s - 0.05f) - 0.055f);
                if (std::abs(w) > 0.022f) c = glm::mix(c, look.shoeAccent, coverage(flash, footprint));
                if (s > 0.155f) c *= 0.80f;
            }
            out.albedo = c;
            out.sheen = 0.1f;
            out.gloss = 0.12f;
            return out;
        }
        default:
            return SkinPaint{look, {std::abs(p.x), p.y, p.z}, p.x, footprint}.paint();
    }
}

}  // namespace dpl
