// SPDX-License-Identifier: Apache-2.0
// Turns pictures and their cameras so that people stand upright in them.
#pragma once

#include "reconstruction/base/image_codec.h"
#include "reconstruction/input/capture/scan.h"

namespace dpl {

/** How a stored picture becomes upright: mirrored left to right first, then turned clockwise. */
struct Turn {
    bool mirror = false;
    int quarters = 0;  // clockwise, 0 … 3
    bool none() const { return !mirror && quarters == 0; }
};

/** The turn of an EXIF orientation, 1 … 8. */
Turn turnOfExif(int orientation);

/** The turn that brings the world's +Y nearest to the top of the picture. A scanner app holds its sensor in landscape, so its portrait
 *  pictures lie on their side. Pictures that look up or down by more than 60° are left as they are, because their top is arbitrary. */
Turn uprightTurn(const Camerad& camera);

/** Any number of channels. */
Picture turned(const Picture& picture, Turn turn);

/** Camera and lens of the turned picture. The turn must not mirror: no camera sees a mirrored picture. */
void turnCamera(Camerad& camera, LensDistortion& lens, Turn turn);

}  // namespace dpl
