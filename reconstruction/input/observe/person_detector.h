// SPDX-License-Identifier: Apache-2.0
// Finds where people may be in a picture, with the detector of BlazePose. Private to reconstruction/input/capture.
#pragma once

#include <vector>

#include "reconstruction/input/observe/observations.h"
#include "reconstruction/input/observe/onnx_net.h"

namespace dpl {

/** A place where the detector sees a person. `crop` is the square that the pose network should get. */
struct DetectedPerson {
    PersonCrop crop;
    double score = 0;  // 0 … 1; some are wrong, so the pose network has to confirm them
};

/** Best first, at most `most`. The detector sees 224 × 224 pixels, so it looks at the whole picture and at squares of its shorter side;
 *  where it finds nobody there, at squares of half that side. */
Result<std::vector<DetectedPerson>> detectPeople(OnnxNet& detector, const ImageRgb8& image, size_t most);

}  // namespace dpl
