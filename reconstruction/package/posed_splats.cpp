#include "reconstruction/package/posed_splats.h"

#include <array>
#include <cmath>

#include "sdk/avatar/posed_mesh.h"
#include "sdk/math/binding.h"
#include "sdk/math/sh.h"

namespace dpl {
namespace {

/** Turns SH coefficients by a rotation. Band l is a (2l+1)-dimensional space of functions: its values at 2l+1 well-spread directions
 *  determine it, so coefficients' = P⁻¹·Q·coefficients with P the band at those directions and Q the band at the turned-back ones. */
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

    /** sh: coefficient-major, turned in place so that evaluating at R·d gives what evaluating at d gave before. */
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

    // Irrational steps around a spiral that is not symmetric about any axis: the band matrices are well conditioned.
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

/** Rotation and scales with R·diag(s1,s2,·) spanning the same ellipse as the axes a1, a2 (their 2×2 Gram matrix diagonalised). */
void ellipseOf(const Vec3d& a1, const Vec3d& a2, const Vec3d& normal, Quatf& rotation, Vec3f& scale) {
    const double p = glm::dot(a1, a1) , q = glm::dot(a1, a2), r = glm::dot(a2, a2);
    const double angle = 0.5 * std::atan2(2 * q, p - r), c = std::cos(angle), s = std::sin(angle);
    const Vec3d major = c * a1 + s * a2, minor = c * a2 - s * a1;
    const double s1 = glm::length(major), s2 = glm::length(minor);
    const Vec3d x = s1 > 0 ? major / s1 : glm::normalize(glm::cross(normal, Vec3d(0.31, 0.77, 0.55)));
    const Vec3d y = glm::normalize(glm::cross(normal, x));
    rotation = Quatf(glm::quat_cast(Mat3d(x, y, glm::cross(x, y))));
    scale = {float(s1), float(s2), kFlatThicknessM};
}

}  // namespace

Result<StaticSplatData> posedSplats(const AvatarData& avatar, const Pose& pose) {
    DPL_CHECK_OK(checkPose(avatar.joints, pose));
    Jobs jobs(1);
    const std::vector<RestTriangle<float>> bind = restTriangles(avatar.mesh);
    PosedMesh posed;
    posed.pose({avatar.joints, avatar.mesh, avatar.correctives, bind}, pose, jobs);
    const std::span<const TriangleFrame<float>> frames = posed.frames();

    const SplatData& in = avatar.splats;
    const uint32_t shFloats = 3 * shCoefficientCount(in.shDegree);
    const ShRotator rotator;
    StaticSplatData out;
    out.shDegree = in.shDegree;
    for (size_t t = 0; t + 1 < in.triangleStart.size(); ++t) {
        const TriangleFrame<float>& frame = frames[t];
        if (!frame.valid) continue;
        for (uint32_t i = in.triangleStart[t]; i < in.triangleStart[t + 1]; ++i) {
            Vec3f a1, a2;
            splatAxes(frame, in.phi[i], in.scaleM[i].x, in.scaleM[i].y, a1, a2);
            Quatf rotation;
            Vec3f scale;
            ellipseOf(Vec3d(a1), Vec3d(a2), Vec3d(frame.normal), rotation, scale);
            out.position.push_back(splatCentre(frame, in.uv[i]));
            out.rotation.push_back(rotation);
            out.scaleM.push_back(scale);
            out.opacity.push_back(in.opacity[i]);
            out.sh.insert(out.sh.end(), in.sh.begin() + size_t(i) * shFloats, in.sh.begin() + size_t(i + 1) * shFloats);
            float* sh = out.sh.data() + out.sh.size() - shFloats;
            rotator.rotate(Mat3d(frame.worldFromRest), in.shDegree, sh);
            // (0.5 + dc·C0 + …)·L as plain SH: the half moves into dc.
            const float light = splatLight(frame, in.uv[i]);
            for (uint32_t k = 0; k < shFloats; ++k) sh[k] = light * sh[k] + (k < 3 ? (light - 1) * 0.5f / float(kShC0) : 0.0f);
        }
    }
    return out;
}

}  // namespace dpl
