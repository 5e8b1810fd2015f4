// SPDX-License-Identifier: Apache-2.0
// Rotates spherical harmonics coefficients.
#pragma once

#include <array>
#include <cmath>
#include <utility>

#include "sdk/math/sh.h"

namespace dpl {

/** One rotation of SH coefficients: a matrix for each band, row by row. */
template <class T>
struct ShTurn {
    uint32_t degree = 0;
    std::array<T, 9> band1;
    std::array<T, 25> band2;
    std::array<T, 49> band3;

    /** Rotates `sh` (coefficient-major) in place: its value at R·d becomes what its value at d was. */
    void apply(float* sh) const {
        if (degree >= 1) applyBand<3>(band1, sh + 3);
        if (degree >= 2) applyBand<5>(band2, sh + 12);
        if (degree >= 3) applyBand<7>(band3, sh + 27);
    }

private:
    template <uint32_t n>
    static void applyBand(const std::array<T, n * n>& matrix, float* band) {
        T turned[n * 3] = {};
        for (uint32_t m = 0; m < n; ++m)
            for (uint32_t i = 0; i < n; ++i)
                for (uint32_t channel = 0; channel < 3; ++channel) turned[m * 3 + channel] += matrix[m * n + i] * T(band[i * 3 + channel]);
        for (uint32_t k = 0; k < n * 3; ++k) band[k] = float(turned[k]);
    }
};

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
                double basis[kMaxShCoefficients];
                shBasis(directions_[band][i], band, basis);
                for (uint32_t m = 0; m < n; ++m) p[i][m] = basis[band * band + m];
            }
            inverse_[band] = invert(p, n);
        }
    }

    /** The rotation R as matrices of the bands up to `degree`. */
    template <class T>
    ShTurn<T> turn(const Mat3<T>& rotation, uint32_t degree) const {
        const Mat3<T> back = glm::transpose(rotation);
        ShTurn<T> out;
        out.degree = degree;
        if (degree >= 1) turnBand<1>(back, out.band1);
        if (degree >= 2) turnBand<2>(back, out.band2);
        if (degree >= 3) turnBand<3>(back, out.band3);
        return out;
    }

    /** What turn() is made of, for the shader that does the same: direction i of a band, and P⁻¹. */
    const Vec3d& direction(uint32_t band, uint32_t i) const { return directions_[band][i]; }
    double inverse(uint32_t band, uint32_t row, uint32_t column) const { return inverse_[band][row][column]; }

private:
    using Square = std::array<std::array<double, 7>, 7>;

    template <uint32_t band, class T, size_t size>
    void turnBand(const Mat3<T>& back, std::array<T, size>& matrix) const {
        constexpr uint32_t n = 2 * band + 1;
        static_assert(size == n * n);
        T q[n][n];
        for (uint32_t i = 0; i < n; ++i) {
            T basis[kMaxShCoefficients];
            shBasis(back * Vec3<T>(directions_[band][i]), band, basis);
            for (uint32_t m = 0; m < n; ++m) q[i][m] = basis[band * band + m];
        }
        matrix = {};
        for (uint32_t m = 0; m < n; ++m)
            for (uint32_t i = 0; i < n; ++i) {
                const T p = T(inverse_[band][m][i]);
                for (uint32_t k = 0; k < n; ++k) matrix[m * n + k] += p * q[i][k];
            }
    }

    // A spiral in golden-angle steps. The offsets break its symmetry, which keeps the band matrices well conditioned.
    static Vec3d spreadDirection(uint32_t i, uint32_t n) {
        const double z = 0.93 - 1.81 * (i + 0.4) / n, angle = 2.399963229728653 * i + 0.37, r = std::sqrt(1 - z * z);
        return {r * std::cos(angle), r * std::sin(angle), z};
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
