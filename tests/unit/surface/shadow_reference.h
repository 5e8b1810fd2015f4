// SPDX-License-Identifier: Apache-2.0
// The contact shadow in double precision, pixel by pixel, written from docs/reference/surface.md. Slow.
#pragma once

#include <cmath>
#include <optional>
#include <vector>

#include "sdk/surface/contact_shadow.h"

namespace dpl::test {

/** Height above the plane where the line through p along `up` meets the triangle; nothing if it does not. */
inline std::optional<double> heightAt(const Vec3d& a, const Vec3d& b, const Vec3d& c, const Vec3d& p, const Vec3d& up) {
    const Vec3d normal = glm::cross(b - a, c - a);
    const double facing = glm::dot(normal, up);
    if (std::abs(facing) < 1e-12) return std::nullopt;
    const double height = glm::dot(normal, a - p) / facing;
    const Vec3d at = p + height * up;
    const double sign = facing < 0 ? -1 : 1;
    for (const auto& [from, to] : {std::pair(a, b), std::pair(b, c), std::pair(c, a)})
        if (sign * glm::dot(glm::cross(to - from, at - from), up) < 0) return std::nullopt;
    return height;
}

/** Alpha from 0 to 1, row by row. place: where the picture lies. */
inline std::vector<double> referenceShadow(const std::vector<Vec3f>& positions, const std::vector<Triangle>& triangles, const Vec3d& up,
                                           const ContactShadow& place) {
    constexpr int n = 64, m = 4;
    constexpr double reach = 0.3, blur = 0.04;
    const double pixel = glm::length(place.across) / n;
    std::vector<double> sums(size_t(n) * n, 0);
    for (int y = 0; y < n; ++y)
        for (int x = 0; x < n; ++x) {
            double weight = 0, height = 0, cx = 0, cy = 0;
            for (int j = 0; j < m; ++j)
                for (int i = 0; i < m; ++i) {
                    const double u = x + (i + 0.5) / m, v = y + (j + 0.5) / m;
                    double h = reach;
                    for (const Triangle& t : triangles)
                        if (const auto found = heightAt(Vec3d(positions[t.x]), Vec3d(positions[t.y]), Vec3d(positions[t.z]),
                                                        place.corner + u / n * place.across + v / n * place.along, up))
                            h = std::min(h, std::abs(*found));
                    const double w = std::pow(1 - h / reach, 2);
                    weight += w, height += w * h, cx += w * u, cy += w * v;
                }
            if (weight == 0) continue;
            cx /= weight, cy /= weight;
            for (const double wider : {0.0, 0.12}) {
                const double radius = (std::max(1.5 * pixel, blur + height / weight) + wider) / pixel;
                std::vector<double> blot(size_t(n) * n, 0);
                double whole = 0;
                for (int py = 0; py < n; ++py)
                    for (int px = 0; px < n; ++px) {
                        const double d2 = std::pow(px + 0.5 - cx, 2) + std::pow(py + 0.5 - cy, 2);
                        if (d2 >= radius * radius) continue;
                        whole += blot[size_t(py * n + px)] = std::pow(1 - d2 / (radius * radius), 2);
                    }
                for (size_t i = 0; i < blot.size(); ++i) sums[i] += weight / (m * m) / 2 * blot[i] / whole;
            }
        }
    for (double& s : sums) s = std::min(1.0, s);
    return sums;
}

}  // namespace dpl::test
