// SPDX-License-Identifier: Apache-2.0
// The coarsest tier of culling: whole components of an avatar that no view can see are not even posed (docs/reference/gate.md).
//
//   load:   triangles ─► components (layer × region of the body) ─► of each: one box a joint, and how far its splats reach
//   frame:  joints, modes ─► boxes against the sides of the views ─► bits of the components that nobody sees
//
// Decided on the CPU from the joints alone, so that nothing must be skinned to tell what need not be skinned. A posed vertex is a mean of
// where its joints carry it, so it lies in the hull of their boxes; what is beyond one side of a view with all its boxes is beyond it with
// all its vertices.
#pragma once

#include <span>
#include <vector>

#include "sdk/avatar/rig.h"
#include "sdk/format/coded_splats.h"
#include "sdk/format/splat_reach.h"
#include "sdk/math/camera.h"

namespace dpl {

constexpr uint32_t kMaxComponents = 32;  // of an avatar; what is beyond belongs to the last

/** Which component each triangle belongs to. Every layer is one, and of a body's layer also trunk, head, hands and legs, by the joint that
 * holds most of the triangle. */
struct ComponentMap {
    uint32_t count = 0;
    std::vector<uint8_t> ofTriangle;  // F
    std::vector<uint32_t> ofVertex;   // V: bits of the components whose triangles use it; all bits where none does
};
ComponentMap componentsOf(const AvatarData& avatar);

/** What must be known of an avatar's components to leave them out. */
class Components {
public:
    Components() = default;
    /** reach: reachOfTriangles. An avatar whose weights do not add up to 255 everywhere is always seen: its vertices may lie anywhere. */
    Components(const AvatarData& avatar, const ComponentMap& map, std::span<const TriangleReach> reach);

    uint32_t count() const { return uint32_t(components_.size()); }
    /** The bits of all of them. */
    uint32_t all() const { return count() == kMaxComponents ? ~0u : (1u << count()) - 1; }
    /** Bits of the components of which no view can show a splat or a vertex. worldFromRest: jointTransforms; coefficients:
     * correctiveCoefficients or empty; kappaPx2: of a pixel; growth: the largest of a splat (level of detail), ≥ 1. Never a component that
     * shows: proven in components_test against the double reference. Allocates nothing. */
    uint32_t unseen(std::span<const Mat3x4f> worldFromRest, std::span<const float> coefficients, std::span<const Cameraf> views,
                    float kappaPx2, float growth) const;

private:
    struct Corners {  // the box about vertices at rest that hang on a joint
        uint32_t joint = 0;
        Vec3d centre{0}, half{0};
    };
    /** Vertices whose share of `joint` differs from that of their triangle's first corner: where the two joints carry them apart by x
     * metres, triangles may stretch by reachPerM · x of their splats' reach and by overPerM · x of their own size. */
    struct Crease {
        Corners at;
        uint32_t against = 0;  // joint
        double reachPerM = 0, overPerM = 0;
    };
    /** What a mode of the pose correctives adds at most, for a coefficient of 1: to where vertices are, to the reach of splats and to the
     * size of triangles. */
    struct Mode {
        double offsetM = 0, reachM = 0, overM = 0;
    };
    struct Component {
        std::vector<Corners> boxes;
        std::vector<Crease> creases;
        std::vector<Mode> modes;
        double reachM = 0;  // of its splats at rest
        double overM = 0;   // size of the triangles whose splats overshoot them
        double rootLevel = 0;
    };
    std::vector<Component> components_;
};

}  // namespace dpl
