// SPDX-License-Identifier: Apache-2.0
// The splats before training: spread over the mesh by area and coloured from the training pictures.
#pragma once

#include <vector>

#include "reconstruction/training/trainer/train_images.h"
#include "reconstruction/training/trainer/trainable.h"

namespace dpl {

struct InitSettings {
    uint32_t splatCount = 60000;
    uint32_t shDegree = 1;
    std::vector<uint8_t> clothLabels{2, 3};  // values of the scan's labels
    std::vector<uint8_t> openLabels{4};      // triangles with these labels are drawn from both sides (hair)
};

/** The flags kSplatSingleFace and kSplatCloth of every triangle (docs/reference/gate.md). Triangles with open labels, and those within two
 *  rings of a boundary edge or of a triangle whose back shows (seenBacks), are not single-face. Vertices at equal positions count as one,
 * so a seam is no boundary. labels: one a triangle, or empty (all body). backs: one a triangle, or empty (none shows). */
std::vector<uint8_t> triangleFlags(std::span<const Vec3f> restPositions, std::span<const Triangle> triangles,
                                   std::span<const uint8_t> labels, std::span<const uint8_t> backs, const InitSettings& settings);

/** The body below clothes has splats up to so many rings of triangles from what is seen: a few centimetres, what a swinging hem or sleeve
 *  may uncover. Training leaves them as they start, in the colours of their neighbours. */
constexpr int kRingsBelowClothes = 5;

/** The triangles that share a merged vertex with each triangle, without itself. Ascending. */
std::vector<std::vector<uint32_t>> triangleNeighbours(const MeshData& mesh);

/** Mean colour of each triangle from (colour times weight, weight); a triangle of weight 0 takes the mean of its neighbours, ring by ring
 *  from the seen ones. Parts that nobody sees take the mean of all. */
std::vector<Vec3f> spreadColours(const std::vector<Vec4f>& weighted, const std::vector<std::vector<uint32_t>>& neighbours);

/** What the frames show of each triangle. */
struct TriangleSight {
    std::vector<float> sizeFloorM;  // in-plane size floor of a splat: 0.35/ν, with ν the highest resolution in px/m at which a frame shows
                                    // the triangle. Triangles that no frame shows take the median.
    std::vector<uint8_t> seen;  // 1: seen enough to learn its looks from the frames
};

/** A mesh, and the frames that show it. Borrowed. */
struct SeenMesh {
    std::span<const JointData> joints;
    const MeshData& mesh;
    std::span<const uint8_t> labels;  // one a triangle, or empty
    std::span<const TrainFrame> frames;
};

/** A frame shows a triangle where the triangle is in front, the person is, and, if both have labels, the picture does not show another part
 *  of the mesh: a leg below a skirt is not seen where the posed skirt lies elsewhere than the true one. A triangle is seen when the frames
 * show of it and its neighbours, in shares of their area, more than priors::kSeenShare of what they show of the median triangle: pictures
 * that meet it by a pixel here and there, where layers cut into each other, do not tell its colour. Errors: a picture
 * cannot be read. */
Result<TriangleSight> triangleSight(const SeenMesh& seen, Jobs& jobs);

/** Splats before the first step. Each valid triangle has at least one; the rest are spread by area. The body below clothes has none,
 *  except near what is seen: no picture could tell its colour. Scale is 0.8·spacing, opacity 0.8.
 *  SH coefficient 0 is the mean colour in the frames that show the splat's triangle there, weighted by cos²θ, with θ the angle
 *  between its normal and the direction to the camera. Moving frames weigh a fifth of still ones. Splats that no frame shows take the
 *  mean of their neighbours along the surface. Errors: a picture cannot be read. */
Result<TrainableSplats> initialSplats(const SeenMesh& seen, std::span<const uint8_t> flags, const TriangleSight& sight,
                                      const InitSettings& settings, uint64_t seed, Jobs& jobs);

}  // namespace dpl
