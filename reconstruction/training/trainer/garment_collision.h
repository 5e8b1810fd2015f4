// SPDX-License-Identifier: Apache-2.0
// Keeps garments out of the body while they are trained (docs/reference/losses.md). Pictures do not: what lies inside is hidden.
//
//   E = Σ ½ (g / 1 cm) max(0, c − d)²    d: signed distance of a posed garment vertex from the posed body, c: clearance
//
// g is the root mean square of the picture's gradient over the garment vertices of the same step. So 1 cm of penetration pulls a vertex as
// hard as the picture does, whatever the scale of the loss.
#pragma once

#include <span>
#include <vector>

#include "reconstruction/subject/shape/closest_surface.h"
#include "sdk/avatar/posed_mesh.h"
#include "sdk/core/jobs.h"
#include "sdk/format/avatar_data.h"

namespace dpl {

class GarmentCollision {
public:
    /** Reads the layers with the roles "body" and "garment", and the body's triangles. */
    explicit GarmentCollision(const MeshData& mesh);

    /** True when there is no body or no garment. Then pull() adds nothing. */
    bool empty() const { return garmentVertices_.empty(); }

    /** Gradient of E on the rest positions of garment vertices of the posed mesh, `factor` times; all other entries are zero. Body and pose
     *  are held. pictureGradient: V, of the same step, on posed.rest(); when it is zero on all garments, so is the result. Returns E,
     * `factor` times. Deterministic for any number of threads. */
    double pull(const MeshData& mesh, const PosedMesh& posed, std::span<const Vec3f> pictureGradient, float factor, Jobs& jobs,
                std::vector<Vec3f>& gradient);

private:
    std::vector<uint32_t> garmentVertices_;
    ClosestSurface body_;
};

}  // namespace dpl
