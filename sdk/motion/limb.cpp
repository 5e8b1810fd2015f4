// SPDX-License-Identifier: Apache-2.0
#include "sdk/motion/limb.h"

#include <algorithm>
#include <cmath>

namespace dpl {

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
