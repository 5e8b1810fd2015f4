// SPDX-License-Identifier: Apache-2.0
// The referee for programs: draws an avatar file or general splats in double precision, as doppel.h would, and compares pictures with that.
//
//   auto avatar = ReferenceFile::read(bytes);
//   PictureError error = compareWith(avatar->draw(rotations, root, camera), rgba);
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "sdk/core/result.h"
#include "sdk/math/camera.h"

namespace dpl {

struct AvatarData;
struct StaticSplatData;

/** Premultiplied, display-referred, row-major, top row first. */
struct ReferencePicture {
    uint32_t widthPx = 0, heightPx = 0;
    std::vector<double> rgb, alpha;
};

class ReferenceFile {
public:
    /** The bytes may be freed afterwards. Errors: those of readAvatar and readSplats. */
    static Result<ReferenceFile> read(std::span<const uint8_t> bytes);

    /** rotations: xyzw a joint, as dplGetPose gives them; their number is not checked, and general splats ignore them. Slow: 50,000 splats
     *  take about a second a megapixel. */
    ReferencePicture draw(std::span<const float> rotations, const Vec3f& rootTranslation, const Cameraf& camera) const;

    bool hasPoseCorrectives() const;
    /** Samples of each pixel in that picture, 1 or 4. Every renderer takes as many, except devices that have only one. */
    uint32_t samples(const Vec3f& rootTranslation, const Cameraf& camera) const;

private:
    std::shared_ptr<const AvatarData> avatar_;  // one of the two is set
    std::shared_ptr<const StaticSplatData> splats_;
};

struct PictureError {
    double squares = 0, coveredSquares = 0;  // of colour over mid grey, peak 1: errors of alpha count too
    uint64_t values = 0, coveredValues = 0;  // covered: the pixels that the referee or the picture draws
    double maxLevels = 0;                    // largest error of one channel in 8-bit levels

    /** Of all pixels, which empty background flatters, and of the covered ones alone. Infinite for equal pictures. */
    double psnrDb() const;
    double coveredPsnrDb() const;
    PictureError& operator+=(const PictureError& other);
};

/** rgba: premultiplied, 4 values a pixel of 8 or 16 bits, of the referee's size. */
PictureError compareWith(const ReferencePicture& reference, std::span<const uint8_t> rgba);
PictureError compareWith(const ReferencePicture& reference, std::span<const uint16_t> rgba);

/** Mean FLIP (flip.h) over the covered pixels, both pictures over mid grey. 0 when nothing is covered, 1 for another size. */
double coveredFlip(const ReferencePicture& reference, std::span<const uint8_t> rgba);

}  // namespace dpl
