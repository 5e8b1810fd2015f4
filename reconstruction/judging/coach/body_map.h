// SPDX-License-Identifier: Apache-2.0
// The body map: how finely, how often and how sharply the still training pictures show each triangle of the fitted surface
// (docs/reference/body-map.md).
#pragma once

#include <span>
#include <vector>

#include "reconstruction/input/capture/train_frame.h"
#include "reconstruction/subject/surface/body_places.h"
#include "sdk/avatar/rig.h"
#include "sdk/core/jobs.h"

namespace dpl {

/** What the pictures tell of one triangle. Sizes are 0 when no picture shows it. */
struct SeenTriangle {
    uint32_t views = 0;  // pictures that look at it at less than 60° to its normal
    // Of the picture in which the finest detail is smallest:
    float pixelM = 0;   // size of a pixel on the surface, in the direction in which it is largest
    float blurPx = 0;   // standard deviation
    float detailM = 0;  // size of the finest detail that the picture shows: detailSizeM()

    bool seen() const { return detailM > 0; }
};

/** The finest detail in a picture whose pixels have this size on the surface. A blur of up to a pixel costs nothing: smooth skin looks as
 *  blurred as that in sharp pictures. */
inline float detailSizeM(float pixelM, float blurPx) {
    return pixelM * (blurPx > 1 ? blurPx : 1);
}

/** How one camera sees a triangle. */
struct Sight {
    float pixelM = 0;       // size of a pixel on it, metres, in the direction in which it is largest; 0: not seen
    bool straight = false;  // at less than 60° to its normal
};

/** How a camera sees each triangle. Seen is a triangle whose centroid lies in the picture and, with a mask, on the person; that faces the
 * camera at less than 76° to its normal; and that no nearer triangle hides. positions: V, world. Runs on one thread. */
std::vector<Sight> lookAt(std::span<const Vec3f> positions, std::span<const Triangle> triangles, const Camerad& camera,
                          const ImageGrey8* mask = nullptr);

/** Adds one picture. */
void addPicture(std::vector<SeenTriangle>& map, std::span<const Sight> sights, float blurPx);

/** One still picture. */
struct PosedPicture {
    LazyPicture picture;
    Camerad camera;  // metres
    Pose pose;
    bool closeUp = false;
};

/** The map of a surface at rest, F. Blur is measured on the whole person in each picture; a picture with too few edges takes the median of
 * the others. The result does not depend on the number of threads. Errors: a picture
 *  cannot be read; Cancelled. */
Result<std::vector<SeenTriangle>> mapBody(const MeshData& surface, std::span<const JointData> joints,
                                          std::span<const PosedPicture> pictures, Jobs& jobs);

}  // namespace dpl
