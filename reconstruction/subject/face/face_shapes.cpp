// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/subject/face/face_shapes.h"

#include <algorithm>
#include <cmath>
#include <string_view>

#include "reconstruction/subject/face/smooth.h"
#include "sdk/format/expression_names.h"

namespace dpl {
namespace {

// All sizes are metres on a face of the built-in body's size, from the middle between the eyes: x to the subject's left, y up, z forward.
constexpr float kEyeX = 0.0318f, kMouthY = -0.0682f, kChinY = -0.123f;
constexpr float kEyeHalfM = 0.0150f, kTopLidM = 0.0060f, kLowLidM = -0.0046f, kEyeBallZ = -0.0125f;
constexpr float kCornerX = 0.0245f, kCornerY = -0.0672f;
constexpr float kHeadM = 0.30f;  // farther from the mouth nothing moves
constexpr float kHingeY = -0.030f, kHingeZ = -0.092f, kJawTurnRad = 0.11f;

/** 1 in the middle, 0 beyond the radii; smooth. */
float bump(const Vec3f& q, float x, float y, float radiusX, float radiusY) {
    const float dx = (q.x - x) / radiusX, dy = (q.y - y) / radiusY, left = 1 - dx * dx - dy * dy;
    return left > 0 ? left * left : 0;
}

/** The front of the head. */
float front(const Vec3f& q) {
    return smooth(-0.075f, -0.045f, q.z);
}

/** 1 on the left half, 0 on the right; half at the middle. */
float leftHalf(const Vec3f& q) {
    return smooth(-0.006f, 0.006f, q.x);
}

// ---------------------------------------------------------------- eyes, of the left one

struct Lids {
    float u, open, top, low;  // place along the opening (−1 to 1), how open it is there, and both edges
    explicit Lids(const Vec3f& q) {
        u = (q.x - kEyeX) / kEyeHalfM, open = std::max(0.0f, 1 - u * u);
        top = kTopLidM * open + 0.0008f * u, low = kLowLidM * open + 0.0008f * u;
    }
};

/** The upper lid slides down over the ball to the lower one, `share` of the way. What is seen of the eye is pressed together there. */
Vec3f blink(const Vec3f& q, float share) {
    constexpr float kAboveM = 0.0025f, kSlitM = 0.0004f, kFoldM = 0.0060f;
    const Lids lids(q);
    if (lids.open <= 0 || q.z < kEyeBallZ + 0.002f) return Vec3f(0);
    const float edge = lids.top + kAboveM * std::min(1.0f, 3 * lids.open), slit = lids.low + kSlitM * lids.open, end = edge + kFoldM;
    if (q.y <= lids.low || q.y >= end) return Vec3f(0);
    float to = q.y;
    if (q.y <= edge) to = lids.low + (slit - lids.low) * (q.y - lids.low) / (edge - lids.low);
    if (q.y > edge) to = slit + (end - slit) * (q.y - edge) / kFoldM;
    to = q.y + share * (to - q.y);
    const float forward = q.z - kEyeBallZ, radius2 = q.y * q.y + forward * forward;
    return {0, to - q.y, std::sqrt(std::max(radius2 - to * to, 1e-6f)) - forward};
}

Vec3f moveUpperLid(const Vec3f& q, float byM) {
    const Lids lids(q);
    const float share = q.y < lids.top ? smooth(lids.low, lids.top, q.y) : 1 - smooth(lids.top + 0.001f, lids.top + 0.009f, q.y);
    return {0, byM * lids.open * share, 0};
}

Vec3f moveLowerLid(const Vec3f& q, float byM) {
    const Lids lids(q);
    const float share = q.y > lids.low ? 1 - smooth(lids.low, lids.top, q.y) : smooth(lids.low - 0.010f, lids.low - 0.001f, q.y);
    return {0, byM * lids.open * share, 0};
}

/** What is seen of the eye slides behind the lids. */
Vec3f look(const Vec3f& q, float xM, float yM) {
    const Lids lids(q);
    const float half = 0.5f * (lids.top - lids.low), off = half > 0 ? (q.y - 0.5f * (lids.top + lids.low)) / half : 2;
    const float share = lids.open * std::max(0.0f, 1 - off * off * off * off);
    return share * Vec3f(xM, yM, 0);
}

// ---------------------------------------------------------------- mouth and jaw

/** Height above the line between the lips. */
float aboveLips(const Vec3f& q) {
    const float x = q.x / kCornerX;
    return q.y - (kMouthY + 0.0010f * std::min(x * x, 4.0f));
}

/** How far a point belongs to the lower lip and what hangs on it, or to the upper one: 0 beyond the line between them. */
float lowerLip(const Vec3f& q) {
    const float d = -aboveLips(q);
    return smooth(-0.0008f, 0.0022f, d) * (1 - smooth(0.012f, 0.026f, d)) * (1 - smooth(0.010f, 0.026f, std::abs(q.x)));
}
float upperLip(const Vec3f& q) {
    const float d = aboveLips(q);
    return smooth(-0.0008f, 0.0022f, d) * (1 - smooth(0.010f, 0.018f, d)) * (1 - smooth(0.010f, 0.026f, std::abs(q.x)));
}

/** Both lips. */
float lips(const Vec3f& q, float innerM, float outerM) {
    return (1 - smooth(innerM, outerM, std::abs(aboveLips(q)))) * (1 - smooth(0.020f, 0.034f, std::abs(q.x)));
}

/** How far a point below `fromM` under the line between the lips moves with the jaw; all of it from `toM` on. Cheeks begin more softly. */
float withJaw(const Vec3f& q, float fromM, float toM) {
    const float wider = std::clamp(0.9f * (std::abs(q.x) - 0.016f), 0.0f, 0.022f);
    return smooth(fromM - wider, toM + wider, -aboveLips(q)) * smooth(-0.170f, -0.128f, q.y) * smooth(-0.100f, -0.060f, q.z);
}

/** Skin stretches to twice its length at most, or its splats would no longer cover it. So half of the way lies between the lips, and half
 *  in the lower lip and the chin. */
Vec3f turnJaw(const Vec3f& q) {
    const float angle = kJawTurnRad * (0.55f * withJaw(q, -0.003f, 0.006f) + 0.45f * withJaw(q, 0.006f, 0.028f));
    const float y = q.y - kHingeY, z = q.z - kHingeZ, c = std::cos(angle), s = std::sin(angle);
    return {0, c * y - s * z - y, s * y + c * z - z};
}

// ---------------------------------------------------------------- names

/** Expressions of the left side; those of the right are their mirrors. */
Vec3f leftShape(std::string_view name, const Vec3f& q) {
    const float half = leftHalf(q), corner = bump(q, kCornerX, kCornerY, 0.030f, 0.026f) * half;
    const float brow = smooth(0.0060f, 0.0165f, q.y) * (1 - smooth(0.024f, 0.052f, q.y));
    if (name == "eyeBlink") return blink(q, 1);
    if (name == "eyeWide") return moveUpperLid(q, 0.0024f) + moveLowerLid(q, -0.0008f);
    if (name == "eyeSquint") return moveLowerLid(q, 0.0026f) + moveUpperLid(q, -0.0010f);
    if (name == "eyeLookUp") return look(q, 0, 0.0024f) + moveUpperLid(q, 0.0010f);
    if (name == "eyeLookDown") return look(q, 0, -0.0014f) + blink(q, 0.25f);
    if (name == "eyeLookIn") return look(q, -0.0030f, 0);
    if (name == "eyeLookOut") return look(q, 0.0030f, 0);
    if (name == "browDown") return brow * smooth(-0.004f, 0.008f, q.x) * (1 - smooth(0.045f, 0.066f, q.x)) * Vec3f(-0.0015f, -0.0045f, 0);
    if (name == "browOuterUp") return brow * smooth(0.016f, 0.034f, q.x) * (1 - smooth(0.054f, 0.074f, q.x)) * Vec3f(0, 0.0060f, 0);
    if (name == "cheekSquint")
        return bump(q, 0.036f, -0.026f, 0.028f, 0.020f) * half * Vec3f(0, 0.0045f, 0.0010f) + moveLowerLid(q, 0.0012f);
    if (name == "noseSneer")
        return half * (bump(q, 0.012f, -0.034f, 0.016f, 0.022f) * Vec3f(0, 0.0040f, 0) +
                       bump(q, 0.012f, -0.058f, 0.016f, 0.014f) * Vec3f(0, 0.0018f, 0));
    if (name == "mouthSmile")
        return corner * Vec3f(0.0060f, 0.0065f, -0.0030f) +
               bump(q, 0.038f, -0.036f, 0.024f, 0.022f) * half * Vec3f(0.0005f, 0.0025f, 0.0015f);
    if (name == "mouthFrown") return corner * Vec3f(0.0010f, -0.0065f, -0.0008f);
    if (name == "mouthStretch") return corner * Vec3f(0.0070f, -0.0030f, -0.0025f);
    if (name == "mouthDimple") return bump(q, kCornerX + 0.002f, kCornerY, 0.020f, 0.018f) * Vec3f(0.0035f, 0.0005f, -0.0040f);
    if (name == "mouthPress") return half * lips(q, 0.008f, 0.016f) * Vec3f(0, -0.40f * aboveLips(q), -0.0015f);
    if (name == "mouthLowerDown") return half * lowerLip(q) * Vec3f(0, -0.0050f, 0);
    if (name == "mouthUpperUp") return half * upperLip(q) * Vec3f(0, 0.0042f, 0);
    return Vec3f(0);
}

/** Expressions of both sides. */
Vec3f middleShape(std::string_view name, const Vec3f& q) {
    const float d = aboveLips(q), x = std::abs(q.x), side = q.x < 0 ? -1.0f : 1.0f;
    if (name == "jawOpen") return turnJaw(q);
    if (name == "jawForward") return withJaw(q, -0.008f, 0.008f) * Vec3f(0, 0, 0.0050f);
    if (name == "jawLeft" || name == "jawRight") return withJaw(q, -0.010f, 0.010f) * Vec3f(name == "jawLeft" ? 0.0065f : -0.0065f, 0, 0);
    const float ring = (1 - smooth(0.022f, 0.046f, x)) * (1 - smooth(0.014f, 0.032f, std::abs(d)));
    if (name == "mouthClose") return lips(q, 0.010f, 0.022f) * Vec3f(0, -0.35f * d, 0);
    if (name == "mouthFunnel")
        return ring * Vec3f(-0.25f * q.x, 0, 0.0060f) + upperLip(q) * Vec3f(0, 0.0032f, 0) - lowerLip(q) * Vec3f(0, 0.0042f, 0);
    if (name == "mouthPucker") return ring * Vec3f(-0.38f * q.x, -0.12f * d, 0.0065f);
    if (name == "mouthLeft" || name == "mouthRight")
        return bump(q, 0, kMouthY, 0.046f, 0.034f) * Vec3f(name == "mouthLeft" ? 0.0075f : -0.0075f, 0, 0);
    if (name == "mouthRollLower")
        return d < 0 ? lips(q, 0.006f, 0.015f) * Vec3f(0, -0.40f * d, -0.0035f * smooth(0, -0.003f, d)) : Vec3f(0);
    if (name == "mouthRollUpper") return d > 0 ? lips(q, 0.006f, 0.015f) * Vec3f(0, -0.40f * d, -0.0035f * smooth(0, 0.003f, d)) : Vec3f(0);
    if (name == "mouthShrugLower") return bump(q, 0, -0.086f, 0.034f, 0.028f) * Vec3f(0, 0.0050f, 0.0015f);
    if (name == "mouthShrugUpper") return bump(q, 0, -0.058f, 0.032f, 0.020f) * Vec3f(0, 0.0036f, 0.0014f);
    if (name == "browInnerUp")
        return smooth(0.0060f, 0.0165f, q.y) * (1 - smooth(0.024f, 0.052f, q.y)) * (1 - smooth(0.010f, 0.036f, x)) * Vec3f(0, 0.0065f, 0);
    if (name == "cheekPuff") return bump({x, q.y, q.z}, 0.042f, -0.062f, 0.028f, 0.032f) * Vec3f(0.0065f * side, 0, 0.0060f);
    return Vec3f(0);
}

Vec3f shapeOf(std::string_view name, const Vec3f& q) {
    constexpr std::string_view kMiddle[] = {"mouthLeft", "mouthRight"};
    const bool left = name.ends_with("Left"), right = name.ends_with("Right");
    if (name.starts_with("jaw")) return middleShape(name, q);
    if ((!left && !right) || std::find(std::begin(kMiddle), std::end(kMiddle), name) != std::end(kMiddle))
        return front(q) * middleShape(name, q);
    if (left) return front(q) * leftShape(name.substr(0, name.size() - 4), q);
    const Vec3f mirrored = leftShape(name.substr(0, name.size() - 5), {-q.x, q.y, q.z});
    return front(q) * Vec3f(-mirrored.x, mirrored.y, mirrored.z);
}

}  // namespace

FaceLandmarks builtinFace() {
    constexpr Vec3f kMiddle(0, 1.6450f, 0.0870f);
    return {kMiddle + Vec3f(kEyeX, 0, 0), kMiddle - Vec3f(kEyeX, 0, 0), kMiddle + Vec3f(0, kMouthY, 0.008f), kMiddle + Vec3f(0, kChinY, 0)};
}

bool hasFaceShape(size_t expression) {
    return expression < kExpressionCount && kExpressionNames[expression] != std::string_view("tongueOut");
}

Vec3f faceOffset(const FaceLandmarks& face, size_t expression, const Vec3f& point) {
    const Vec3f middle = 0.5f * (face.leftEye + face.rightEye), across = glm::normalize(face.leftEye - face.rightEye);
    const Vec3f up = glm::normalize(Vec3f(0, 1, 0) - across.y * across), forward = glm::cross(across, up), at = point - middle;
    // Sizes go with the distance of the eyes; heights below them with those of mouth and chin.
    const float size = glm::length(face.leftEye - face.rightEye) / (2 * kEyeX);
    const float toMouth = glm::dot(middle - face.mouth, up), toChin = glm::dot(face.mouth - face.chin, up), y = glm::dot(at, up);
    Vec3f q(glm::dot(at, across) / size, y / size, glm::dot(at, forward) / size);
    if (y < 0) q.y = y > -toMouth ? y / toMouth * -kMouthY : kMouthY + (y + toMouth) / toChin * (kMouthY - kChinY);
    const Vec3f offset = shapeOf(kExpressionNames[expression], q);
    return size * (offset.x * across + offset.y * up + offset.z * forward);
}

std::vector<ExpressionShape> faceShapes(const FaceLandmarks& face, std::span<const Vec3f> points) {
    std::vector<ExpressionShape> shapes;
    for (size_t expression = 0; expression < kExpressionCount; ++expression) {
        if (!hasFaceShape(expression)) continue;
        ExpressionShape& shape = shapes.emplace_back(ExpressionShape{uint8_t(expression), {}});
        for (const Vec3f& point : points)
            shape.offsetsM.push_back(glm::length(point - face.mouth) < kHeadM ? faceOffset(face, expression, point) : Vec3f(0));
    }
    return shapes;
}

}  // namespace dpl
