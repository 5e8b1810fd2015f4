// SPDX-License-Identifier: Apache-2.0
// The coarsest tier of culling: components of an avatar that no view can see are not posed (docs/reference/gate.md).
//
//   load:   triangles ─► components (layer × region of the body) ─► for each: one box a joint, and how far its splats reach
//   frame:  joints, modes ─► boxes against the sides of the views ─► bits of the components that no view sees
//
// The CPU decides from joints and modes alone, so nothing is skinned for it. A posed vertex is a weighted mean of the places where its
// joints carry it, so it lies in the hull of the boxes of its joints. If all boxes of a component lie beyond one side of a view, all its
// vertices do.
#pragma once

#include <span>
#include <vector>

#include "sdk/avatar/rig.h"
#include "sdk/format/coded_splats.h"
#include "sdk/format/splat_reach.h"
#include "sdk/math/camera.h"

namespace dpl {

constexpr uint32_t kMaxComponents = 32;  // of an avatar: one bit each; further components are merged into the last

/** Which component each triangle belongs to. A layer is one component; the body's layer has several: trunk, head, each hand and each leg,
 * chosen by the joints with most weight on the triangle. */
struct ComponentMap {
    uint32_t count = 0;
    std::vector<uint8_t> ofTriangle;  // one a triangle
    std::vector<uint32_t> ofLayer;    // one a layer: bits of its components, of which the last may be shared with other layers
    std::vector<uint32_t> ofVertex;   // one a vertex: bits of the components whose triangles use it; all bits where none does
};
/** The avatar's mesh must have passed checkMesh. */
ComponentMap componentsOf(const AvatarData& avatar);

/** Bounds of an avatar's components, made at load. Immutable afterwards; any thread. */
class Components {
public:
    Components() = default;
    /** reach: reachOfTriangles. If some skin or node weights do not sum to 255, vertices may lie outside the boxes; then there are no
     * components, and nothing is left out. */
    Components(const AvatarData& avatar, const ComponentMap& map, std::span<const TriangleReach> reach);

    uint32_t count() const { return uint32_t(components_.size()); }
    /** The bits of the components of layers; layers: a bit each. */
    uint32_t ofLayers(uint64_t layers) const {
        uint32_t bits = 0;
        for (size_t l = 0; l < ofLayer_.size() && l < 64; ++l)
            if (layers >> l & 1) bits |= ofLayer_[l];
        return bits;
    }
    /** The bits of all components. */
    uint32_t all() const { return count() == kMaxComponents ? ~0u : (1u << count()) - 1; }
    /** Bits of the components of which no view can show a splat or a vertex. Conservative: a component that shows is never among them
     * (tests/reference/components_test.cpp). worldFromRest: jointTransforms; coefficients: correctiveCoefficients, addExpression; kappaPx2:
     * of a pixel; growth: largest growth of a splat by level of detail, ≥ 1. The views are in the avatar's own space and metres; scale:
     * metres of the world that one of these takes. pushedM: by how much nodes differ from the sum of the modes at most (ClothLimits).
     * Numbers that are not finite leave nothing out. Allocates nothing. */
    uint32_t unseen(std::span<const Mat3x4f> worldFromRest, std::span<const float> coefficients, std::span<const Cameraf> views,
                    float kappaPx2, float growth, float scale = 1, float pushedM = 0) const;

private:
    struct Corners {  // box around the rest positions of the vertices that hang on a joint
        uint32_t joint = 0;
        Vec3d centre{0}, half{0};
    };
    /** Triangles on which the weight of joint `at.joint` differs between corners. `against` is the main joint of their first corner. Where
     * the two joints carry a point apart by x metres, the reach of the splats grows by at most reachPerM · x metres, and the size of
     * triangles with overshooting splats by overPerM · x metres. */
    struct Crease {
        Corners at;
        uint32_t against = 0;  // joint
        double reachPerM = 0, overPerM = 0;
    };
    /** The most that a mode of the pose correctives, or an expression, adds for a coefficient of 1: to positions of vertices, to the reach
     * of splats, and to the size of triangles with overshooting splats. */
    struct Mode {
        double offsetM = 0, reachM = 0, overM = 0;
    };
    struct Component {
        std::vector<Corners> boxes;
        std::vector<Crease> creases;
        std::vector<Mode> modes;
        Mode pushed;           // the same for nodes that are pushed by 1 m, each anywhere
        double reachM = 0;     // of its splats at rest
        double overM = 0;      // largest |e1| + |e2| of the triangles with splats that overshoot them (TriangleReach)
        double rootLevel = 0;  // TriangleReach
    };
    std::vector<Component> components_;
    std::vector<uint32_t> ofLayer_;  // ComponentMap::ofLayer
};

}  // namespace dpl
