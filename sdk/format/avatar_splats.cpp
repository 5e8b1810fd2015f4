// SPDX-License-Identifier: Apache-2.0
// Sorts splats into file order and rebinds them to another rest mesh.
#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

#include "sdk/format/avatar_file.h"
#include "sdk/format/splat_codec.h"
#include "sdk/math/binding.h"
#include "sdk/math/sh.h"

namespace dpl {
namespace {

template <class T>
void permute(std::vector<T>& values, const std::vector<uint32_t>& order, size_t perSplat = 1) {
    std::vector<T> out(values.size());
    for (size_t i = 0; i < order.size(); ++i)
        std::copy_n(values.begin() + ptrdiff_t(order[i] * perSplat), perSplat, out.begin() + ptrdiff_t(i * perSplat));
    values = std::move(out);
}

}  // namespace

Result<std::vector<uint32_t>> sortSplats(AvatarData& avatar, std::span<const uint32_t> triangleOfSplat) {
    SplatData& s = avatar.splats;
    const size_t n = s.uv.size(), triangleCount = avatar.mesh.triangles.size(), perSplat = size_t(shCoefficientCount(s.shDegree)) * 3;
    if (triangleOfSplat.size() != n || s.phi.size() != n || s.scaleM.size() != n || s.opacity.size() != n || s.flags.size() != n ||
        s.sh.size() != n * perSplat)
        return fail(Code::InvalidArgument, "the arrays of {} splats differ in length", n);
    std::vector<uint32_t> start(triangleCount + 1, 0), morton(n);
    for (size_t i = 0; i < n; ++i) {
        if (triangleOfSplat[i] >= triangleCount)
            return fail(Code::InvalidArgument, "splat {} sits on triangle {} of {}", i, triangleOfSplat[i], triangleCount);
        ++start[triangleOfSplat[i] + 1];
        morton[i] = splatMorton(s.uv[i]);
    }
    std::partial_sum(start.begin(), start.end(), start.begin());
    std::vector<uint32_t> order(n);
    std::iota(order.begin(), order.end(), 0u);
    std::stable_sort(order.begin(), order.end(), [&](uint32_t a, uint32_t b) {
        return triangleOfSplat[a] != triangleOfSplat[b] ? triangleOfSplat[a] < triangleOfSplat[b] : morton[a] < morton[b];
    });
    permute(s.uv, order), permute(s.phi, order), permute(s.scaleM, order), permute(s.opacity, order), permute(s.flags, order),
        permute(s.sh, order, perSplat);
    s.triangleStart = std::move(start);
    return order;
}

std::vector<uint32_t> sortSplats(AvatarData& avatar) {
    const SplatData& s = avatar.splats;
    std::vector<uint32_t> triangle(s.uv.size());
    for (size_t t = 0; t + 1 < s.triangleStart.size(); ++t)
        for (uint32_t i = s.triangleStart[t]; i < s.triangleStart[t + 1] && i < triangle.size(); ++i) triangle[i] = uint32_t(t);
    auto order = sortSplats(avatar, triangle);
    if (order) return std::move(*order);
    std::vector<uint32_t> unchanged(s.uv.size());
    std::iota(unchanged.begin(), unchanged.end(), 0u);
    return unchanged;
}

Result<uint32_t> rebaseSplats(std::span<const Vec3f> oldRest, AvatarData& avatar) {
    const MeshData& mesh = avatar.mesh;
    SplatData& s = avatar.splats;
    if (oldRest.size() != mesh.restPositions.size())
        return fail(Code::InvalidArgument, "{} old rest positions for {} vertices", oldRest.size(), mesh.restPositions.size());
    if (s.triangleStart.size() != mesh.triangles.size() + 1 || s.triangleStart.back() != s.uv.size())
        return fail(Code::InvalidArgument, "triangleStart does not match {} triangles and {} splats", mesh.triangles.size(), s.uv.size());
    uint32_t left = 0;
    for (size_t t = 0; t < mesh.triangles.size(); ++t) {
        if (s.triangleStart[t] == s.triangleStart[t + 1]) continue;
        const Triangle& f = mesh.triangles[t];
        auto corners = [&](auto&& positions, int k) { return Vec3d(positions[f[k]]); };
        const auto from = restTriangle(corners(oldRest, 0), corners(oldRest, 1), corners(oldRest, 2));
        const auto to = restTriangle(corners(mesh.restPositions, 0), corners(mesh.restPositions, 1), corners(mesh.restPositions, 2));
        if (!from.valid || !to.valid) {
            left += s.triangleStart[t + 1] - s.triangleStart[t];
            continue;
        }
        // M: deformation gradient from the old to the new rest triangle, in the frame of the new one. With F and F' the gradients from the
        // old and the new rest to the pose, F = F'·M and A = F·R·S = F'·(M·R·S). Any A₀' with the same A₀'A₀'ᵀ draws the same ellipse.
        const Vec3d d1 = corners(mesh.restPositions, 1) - corners(mesh.restPositions, 0),
                    d2 = corners(mesh.restPositions, 2) - corners(mesh.restPositions, 0);
        const Vec3d f0 = d1 * from.inverse.i00, f1 = d1 * from.inverse.i01 + d2 * from.inverse.i11;
        const double m00 = glm::dot(to.frame[0], f0), m01 = glm::dot(to.frame[0], f1), m10 = glm::dot(to.frame[1], f0),
                     m11 = glm::dot(to.frame[1], f1);
        for (uint32_t i = s.triangleStart[t]; i < s.triangleStart[t + 1]; ++i) {
            const double c = std::cos(double(s.phi[i])), sn = std::sin(double(s.phi[i])), s1 = s.scaleM[i].x, s2 = s.scaleM[i].y;
            const double a00 = s1 * (m00 * c + m01 * sn), a10 = s1 * (m10 * c + m11 * sn), a01 = s2 * (m01 * c - m00 * sn),
                         a11 = s2 * (m11 * c - m10 * sn);
            const double p = a00 * a00 + a01 * a01, q = a00 * a10 + a01 * a11, r = a10 * a10 + a11 * a11;
            const double major2 = (p + r) / 2 + std::hypot((p - r) / 2, q);
            if (!(major2 > 0) || !std::isfinite(major2)) {
                ++left;
                continue;
            }
            const double major = std::sqrt(major2);
            double phi = 0.5 * std::atan2(2 * q, p - r);
            if (phi < 0) phi += std::numbers::pi;
            s.phi[i] = float(phi);
            s.scaleM[i] = {float(major), float(std::abs(a00 * a11 - a01 * a10) / major)};
        }
    }
    return left;
}

}  // namespace dpl
