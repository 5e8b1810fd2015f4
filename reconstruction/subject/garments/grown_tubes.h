// SPDX-License-Identifier: Apache-2.0
// The body as tubes, grown to a garment at rest: where the garment may be seen in a pose. docs/reference/metrics.md, "Clothes in motion".
//
//   body layer at rest ─► one tube a joint ─► grown to the garment's clearance at rest ─► posed by the joints ─► outline in a picture
//
// The posed garment has no part in it. So cloth that stretches between joints, or stands away from them, shows.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "sdk/format/avatar_data.h"
#include "sdk/math/camera.h"

namespace dpl {

class GrownTubes {
public:
    /** Measures the body layer alone, then the clearance of one garment from it, by place along each tube and angle around it. A vertex of
     *  the garment counts for the nearest tube of those whose joints move a hundredth of the garment or more: an arm that hangs beside a
     *  skirt is none, and a vertex with wrong weights changes nothing. Empty without a body layer. */
    GrownTubes(std::span<const JointData> joints, const MeshData& mesh, const LayerData& garment);

    bool empty() const { return tubes_.empty(); }

    /** One byte a pixel: 1 inside the outline of the tubes. Pieces of tubes between which a triangle of the body or the garment spans at
     * rest are filled together, as the convex outline of both: a skirt between the legs may be seen there. worldFromRest: jointTransforms
     * of the pose. */
    std::vector<uint8_t> outline(std::span<const Mat3x4f> worldFromRest, const Camerad& camera) const;

private:
    static constexpr size_t kPieces = 8, kAround = 16;
    struct Place {
        float alongM, radiusM, angleRad;
    };
    /** Encloses points around an axis, from the first to the last along it. */
    struct Shell {
        float beginM = 0, endM = 0;
        std::array<float, kAround> radiiM{};
        bool empty = true;
        void enclose(const Place& place);
    };
    struct Tube {
        size_t joint = 0;
        Vec3f from{0}, along{0}, across{0}, third{0};  // axes at rest: unit, at right angles
        float beginM = 0, endM = 0;                    // along the axis
        std::array<Shell, kPieces> body, cloth;        // of pieces of equal length

        static Tube around(size_t joint, std::span<const Vec3f> points);
        Place placeOf(const Vec3f& p) const;
        size_t pieceAt(float alongM) const;
        void stretchTo(std::span<const Vec3f> points);
        void enclose(std::span<const Vec3f> points, std::array<Shell, kPieces>& shells) const;
        float distanceM(const Vec3f& p) const;  // of a point from the body; 0 inside
    };
    struct Piece {
        bool cloth;  // its shell of the garment; false: of the body
        uint32_t tube, piece;
        auto operator<=>(const Piece&) const = default;
    };
    /** Adds the pieces between which triangles of a layer span. */
    void join(const MeshData& mesh, const LayerData& layer, bool cloth, std::span<const uint32_t> tubeAt);

    std::vector<Tube> tubes_;
    std::vector<std::pair<Piece, Piece>> joined_;  // sorted, without repeats
};

}  // namespace dpl
