// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/subject/sample/field.h"

namespace dpl {
namespace {

constexpr int kFineStations = 49;

struct Knot {
    float s = 0, value = 0;
};

/** The value at s, between `a` and `b`. */
float catmullRom(const Knot& before, const Knot& a, const Knot& b, const Knot& after, float s) {
    // Tangents take the spacing into account, which prevents overshoot between unevenly spaced stations.
    const float m1 = (b.value - before.value) / (b.s - before.s), m2 = (after.value - a.value) / (after.s - a.s);
    const float h = b.s - a.s, t = (s - a.s) / h, t2 = t * t, t3 = t2 * t;
    return (2 * t3 - 3 * t2 + 1) * a.value + (t3 - 2 * t2 + t) * h * m1 + (-2 * t3 + 3 * t2) * b.value + (t3 - t2) * h * m2;
}

}  // namespace

Tube::Tube(const Vec3f& origin, const Vec3f& axis, const Vec3f& u, std::vector<TubeStation> stations, float exponent)
    : origin_(origin), axis_(glm::normalize(axis)), exponent_(exponent) {
    u_ = glm::normalize(u - axis_ * glm::dot(u, axis_));
    v_ = glm::cross(axis_, u_);
    start_ = stations.front().s;
    length_ = stations.back().s - start_;
    const int last = int(stations.size()) - 1;
    fine_.resize(kFineStations);
    float widest = 0;
    for (int i = 0; i < kFineStations; ++i) {
        const float s = start_ + length_ * float(i) / float(kFineStations - 1);
        int k = 0;
        while (k + 1 < last && s > stations[k + 1].s) ++k;
        // The neighbour missing at either end is the end station itself, one spacing further out.
        TubeStation before = stations[std::max(k - 1, 0)], after = stations[std::min(k + 2, last)];
        if (k == 0) before.s = stations[0].s - (stations[1].s - stations[0].s);
        if (k + 2 > last) after.s = stations[last].s + (stations[last].s - stations[last - 1].s);
        const TubeStation &a = stations[k], &b = stations[k + 1];
        auto at = [&](float TubeStation::*m) {
            return catmullRom({before.s, before.*m}, {a.s, a.*m}, {b.s, b.*m}, {after.s, after.*m}, s);
        };
        fine_[i] = {s,
                    at(&TubeStation::centreU),
                    at(&TubeStation::centreV),
                    at(&TubeStation::radiusU),
                    at(&TubeStation::radiusUBack),
                    at(&TubeStation::radiusV),
                    at(&TubeStation::radiusVBack)};
        widest = std::max({widest, std::abs(fine_[i].centreU) + std::max(fine_[i].radiusU, fine_[i].radiusUBack),
                           std::abs(fine_[i].centreV) + std::max(fine_[i].radiusV, fine_[i].radiusVBack)});
    }
    boundCentre_ = origin_ + axis_ * (start_ + 0.5f * length_);
    boundRadius_ = std::sqrt(0.25f * length_ * length_ + 2 * widest * widest);
}

float Tube::distance(const Vec3f& p) const {
    const Vec3f q = p - origin_;
    const float s = glm::dot(q, axis_) - start_;
    const float position = std::clamp(s / length_, 0.0f, 1.0f) * float(kFineStations - 1);
    const int i = std::min(int(position), kFineStations - 2);
    const float t = position - float(i);
    const TubeStation &a = fine_[i], &b = fine_[i + 1];
    const float x = glm::dot(q, u_) - (a.centreU + (b.centreU - a.centreU) * t);
    const float y = glm::dot(q, v_) - (a.centreV + (b.centreV - a.centreV) * t);
    const float ru = x >= 0 ? a.radiusU + (b.radiusU - a.radiusU) * t : a.radiusUBack + (b.radiusUBack - a.radiusUBack) * t;
    const float rv = y >= 0 ? a.radiusV + (b.radiusV - a.radiusV) * t : a.radiusVBack + (b.radiusVBack - a.radiusVBack) * t;
    const float ex = std::abs(x) / ru, ey = std::abs(y) / rv;
    float lateral;
    if (exponent_ == 2.0f) {
        const float k0 = std::sqrt(ex * ex + ey * ey), k1 = std::sqrt(ex * ex / (ru * ru) + ey * ey / (rv * rv));
        lateral = k1 > 1e-5f ? k0 * (k0 - 1) / k1 : -std::min(ru, rv);
    } else {
        const float px = std::pow(ex, exponent_ - 1), py = std::pow(ey, exponent_ - 1);
        const float sum = px * ex + py * ey;
        const float r = std::pow(sum, 1 / exponent_);
        const float slope = sum > 1e-9f ? (r / sum) * std::sqrt(px * px / (ru * ru) + py * py / (rv * rv)) : 0;
        lateral = slope > 1e-5f ? (r - 1) / slope : -std::min(ru, rv);
    }
    const float end = std::abs(s - 0.5f * length_) - 0.5f * length_;
    if (lateral <= 0 || end <= 0) return std::max(lateral, end);
    return std::sqrt(lateral * lateral + end * end);
}

}  // namespace dpl
