// SPDX-License-Identifier: Apache-2.0
#include "sdk/motion/limb.h"

#include <algorithm>
#include <cmath>

namespace dpl {
namespace {

constexpr float kBendBegins = 0.17f, kBendTells = 0.5f;  // sine of the bend of an elbow or knee: its plane begins to count; alone counts

float smoothStep(float from, float to, float x) {
    const float t = std::clamp((x - from) / (to - from), 0.0f, 1.0f);
    return t * t * (3 - 2 * t);
}

}  // namespace

Quatf shortestTurn(const Vec3f& from, const Vec3f& to) {
    const float lengths = glm::length(from) * glm::length(to);
    if (!(lengths > 1e-12f)) return Quatf(1, 0, 0, 0);
    const float cosine = glm::dot(from, to) / lengths;
    if (cosine < -0.999999f) {  // opposite directions: any perpendicular axis will do
        const Vec3f axis = glm::cross(from, std::abs(from.x) < 0.9f * glm::length(from) ? Vec3f(1, 0, 0) : Vec3f(0, 1, 0));
        return glm::angleAxis(glm::pi<float>(), glm::normalize(axis));
    }
    const Vec3f c = glm::cross(from, to) / lengths;
    return glm::normalize(Quatf(1 + cosine, c.x, c.y, c.z));
}

Quatf frameOf(const Vec3f& left, const Vec3f& up) {
    const Vec3f y = glm::normalize(up), across = left - y * glm::dot(left, y);
    if (!(glm::length(across) > 1e-6f)) return Quatf(1, 0, 0, 0);
    const Vec3f x = glm::normalize(across);
    return glm::normalize(glm::quat_cast(Mat3f(x, y, glm::cross(x, y))));
}

Quatf turnOf(const Vec3f& a, const Vec3f& b, const Vec3f& toA, const Vec3f& toB) {
    return frameOf(toB, toA) * glm::conjugate(frameOf(b, a));
}

std::array<Quatf, 2> hingedLimb(const Quatf& before, const Vec3f& rest, const Vec3f& hinge, const Vec3f& upper, const Vec3f& lower) {
    const Quatf hanging = shortestTurn(before * rest, upper) * before;
    const Vec3f u = glm::normalize(upper), axis = glm::cross(u, glm::normalize(lower));
    const float told = smoothStep(kBendBegins, kBendTells, glm::length(axis));
    Quatf first = hanging;
    if (told > 0) first = glm::slerp(hanging, turnOf(rest, hinge, upper, axis), told);
    first = shortestTurn(first * rest, upper) * first;
    return {glm::normalize(first), glm::normalize(shortestTurn(first * rest, lower) * first)};
}

std::array<Quatf, 2> reachWith(const std::array<Vec3f, 3>& at, const Vec3f& target, const Vec3f& bend) {
    constexpr float kLeastM = 1e-4f;
    const Vec3f upper = at[1] - at[0], lower = at[2] - at[1], old = at[2] - at[0], wanted = target - at[0];
    const float a = glm::length(upper), b = glm::length(lower), wantedLength = glm::length(wanted);
    if (!(a > kLeastM) || !(b > kLeastM) || !(wantedLength > kLeastM) || !(glm::length(old) > kLeastM))
        return {Quatf(1, 0, 0, 0), Quatf(1, 0, 0, 0)};
    const float d = std::clamp(wantedLength, std::abs(a - b) + kLeastM, a + b - kLeastM);
    const Vec3f along = glm::normalize(old);
    Vec3f side = upper - along * glm::dot(upper, along);
    if (glm::length(side) < 1e-3f * a) side = bend - along * glm::dot(bend, along);
    if (!(glm::length(side) > 1e-6f)) return {Quatf(1, 0, 0, 0), Quatf(1, 0, 0, 0)};
    side = glm::normalize(side);
    const float cosine = std::clamp((a * a + d * d - b * b) / (2 * a * d), -1.0f, 1.0f), sine = std::sqrt(1 - cosine * cosine);
    const Quatf swing = shortestTurn(old, wanted);
    const Vec3f middle = swing * (a * (cosine * along + sine * side)), end = glm::normalize(wanted) * d;
    const Quatf first = shortestTurn(swing * upper, middle) * swing;
    return {first, shortestTurn(first * lower, end - middle) * first};
}

}  // namespace dpl
