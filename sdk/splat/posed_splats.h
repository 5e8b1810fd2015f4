// SPDX-License-Identifier: Apache-2.0
// Splats of a posed avatar as general splats in the world, for exporters and for apps that draw splats themselves.
//
//   triangle frame ─► PosedTriangle ─► each flat splat on it: centre, axes or covariance, opacity, light
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "sdk/core/jobs.h"
#include "sdk/format/avatar_data.h"
#include "sdk/format/coded_splats.h"
#include "sdk/math/binding.h"
#include "sdk/math/detail.h"
#include "sdk/math/ellipse.h"
#include "sdk/math/placement.h"
#include "sdk/math/sh_rotation.h"
#include "sdk/math/strided_numbers.h"
#include "sdk/visibility/kept_splats.h"

namespace dpl {

using SplatEllipse = EllipseFormulas<float>::PlaneEllipse;

/** Axes of a general splat: R·diag(s), with the long axis first and the normal last. */
struct GaussianAxes {
    Quatf rotation;
    Vec3f scaleM;
};

/** A posed triangle, as the splats on it need it to leave it, one at a time. PosedSplatWriter does the same by SIMD. */
class PosedTriangle {
public:
    /** Borrows the frame. */
    explicit PosedTriangle(const TriangleFrame<float>& frame);

    Vec3f centre(const Vec2f& uv) const { return splatCentre(frame_, uv); }
    float light(const Vec2f& uv) const { return splatLight(frame_, uv); }
    SplatEllipse ellipse(const Formulas<float>::PlaneAxes& axes) const;
    GaussianAxes axes(const SplatEllipse& ellipse) const;
    /** xx, xy, xz, yy, yz, zz; m². */
    void covariance(const SplatEllipse& ellipse, float* six) const;
    /** Factor of the opacity: 0 where the triangle shows nothing; with an eye, the gate of single-face splats. */
    float shown(const Vec3f& centre, bool singleFace, const std::optional<Vec3f>& eye) const;
    const TriangleFrame<float>& frame() const { return frame_; }

private:
    const TriangleFrame<float>& frame_;
    Vec3f t1_{1, 0, 0}, t2_{0, 1, 0}, normal_{0, 0, 1};  // orthonormal; the first two in the plane
    float f00_ = 0, f01_ = 0, f10_ = 0, f11_ = 0;        // F from the plane at rest to (t1, t2)
};

/** Folds the light of a splat into plain SH (EllipseFormulas::litCoefficient0). */
void foldLight(float light, uint32_t shDegree, float* sh);

enum class SplatNumbers : uint8_t { Position, Rotation, Scale, Covariance, Opacity, Colour, Sh, RotationWxyz };

/** Numbers of a splat. shDegree: of Sh. */
constexpr uint32_t numbersOf(SplatNumbers what, uint32_t shDegree) {
    constexpr uint32_t kCounts[] = {3, 4, 3, 6, 1, 3, 0, 4};
    return what == SplatNumbers::Sh ? 3 * shCoefficientCount(shDegree) : kCounts[size_t(what)];
}

struct SplatColumn {
    SplatNumbers what;
    StridedNumbers to;
};

/** Writes the splats of a posed avatar, in the order of its file. Keeps its buffers: a warm call allocates nothing. One thread at a time.
 */
class PosedSplatWriter {
public:
    /** Chooses what is written: all splats, or those that level of detail keeps at a density; returns how many. splats.groups must be
     *  filled for the latter (measureDetail). */
    uint32_t choose(const CodedSplats& splats, const SplatDetail& detail);
    /** Writes what choose() chose of the same splats. frames: of the avatar's triangles, in its own space. eye: world; without one, splats
     *  show both sides, and Colour is that of SH band 0. shDegree: of Sh; bands that the avatar lacks are 0. Returns how many numbers were
     *  too large for a half. */
    uint64_t write(const CodedSplats& splats, std::span<const TriangleFrame<float>> frames, const Placement& placement,
                   std::span<const SplatColumn> columns, const std::optional<Vec3f>& eye, uint32_t shDegree, Jobs& jobs) const;

private:
    SplatDetail detail_;
    std::vector<KeptSplat> kept_;  // empty where all are written
    ShRotator rotator_;
};

}  // namespace dpl
