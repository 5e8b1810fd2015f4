// SPDX-License-Identifier: Apache-2.0
// Rotates spherical harmonics coefficients.
#pragma once

#include <array>
#include <cmath>
#include <utility>

#include "sdk/math/sh.h"

namespace dpl {

/** Rotates SH coefficients. Band l spans 2l+1 functions, so its values at 2l+1 well-spread directions determine it: coefficients' =
 *  P⁻¹·Q·coefficients, with P the band at those directions and Q the band at the same directions turned back. Immutable after
 *  construction; any thread. */
class ShRotator {
public:
    ShRotator() {
        for (uint32_t band = 1; band <= kMaxShDegree; ++band) {
            const uint32_t n = 2 * band + 1;
            for (uint32_t i = 0; i < n; ++i) directions_[band][i] = spreadDirection(i, n);
            Square p{};
            for (uint32_t i = 0; i < n; ++i) {
                const auto row = bandValues(band, directions_[band][i]);
                for (uint32_t m = 0; m < n; ++m) p[i][m] = row[m];
            }
            inverse_[band] = invert(p, n);
        }
    }

    /** Rotates `sh` (coefficient-major) in place: its value at R·d becomes what its value at d was. */
    void rotate(const Mat3d& rotation, uint32_t degree, float* sh) const {
        const Mat3d back = glm::transpose(rotation);
        for (uint32_t band = 1; band <= degree; ++band) {
            const uint32_t n = 2 * band + 1, first = band * band;
            for (uint32_t channel = 0; channel < 3; ++channel) {
                std::array<double, 7> values{}, turned{};
                for (uint32_t i = 0; i < n; ++i) {
                    const auto row = bandValues(band, back * directions_[band][i]);
                    for (uint32_t m = 0; m < n; ++m) values[i] += row[m] * sh[(first + m) * 3 + channel];
                }
                for (uint32_t m = 0; m < n; ++m)
                    for (uint32_t i = 0; i < n; ++i) turned[m] += inverse_[band][m][i] * values[i];
                for (uint32_t m = 0; m < n; ++m) sh[(first + m) * 3 + channel] = float(turned[m]);
            }
        }
    }

private:
    using Square = std::array<std::array<double, 7>, 7>;

    // A spiral in golden-angle steps. The offsets break its symmetry, which keeps the band matrices well conditioned.
    static Vec3d spreadDirection(uint32_t i, uint32_t n) {
        const double z = 0.93 - 1.81 * (i + 0.4) / n, angle = 2.399963229728653 * i + 0.37, r = std::sqrt(1 - z * z);
        return {r * std::cos(angle), r * std::sin(angle), z};
    }
    static std::array<double, 7> bandValues(uint32_t band, const Vec3d& d) {
        double basis[kMaxShCoefficients];
        shBasis(d, band, basis);
        std::array<double, 7> values{};
        for (uint32_t m = 0; m < 2 * band + 1; ++m) values[m] = basis[band * band + m];
        return values;
    }
    static Square invert(Square a, uint32_t n) {
        Square inverse{};
        for (uint32_t i = 0; i < n; ++i) inverse[i][i] = 1;
        for (uint32_t column = 0; column < n; ++column) {
            uint32_t pivot = column;
            for (uint32_t row = column + 1; row < n; ++row)
                if (std::abs(a[row][column]) > std::abs(a[pivot][column])) pivot = row;
            std::swap(a[column], a[pivot]);
            std::swap(inverse[column], inverse[pivot]);
            const double scale = 1 / a[column][column];
            for (uint32_t k = 0; k < n; ++k) a[column][k] *= scale, inverse[column][k] *= scale;
            for (uint32_t row = 0; row < n; ++row) {
                if (row == column) continue;
                const double factor = a[row][column];
                for (uint32_t k = 0; k < n; ++k) a[row][k] -= factor * a[column][k], inverse[row][k] -= factor * inverse[column][k];
            }
        }
        return inverse;
    }

    std::array<std::array<Vec3d, 7>, kMaxShDegree + 1> directions_;
    std::array<Square, kMaxShDegree + 1> inverse_;
};

}  // namespace dpl
