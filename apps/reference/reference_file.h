// SPDX-License-Identifier: Apache-2.0
// The referee for programs: draws an avatar file or general splats in double precision with the conventions of doppel.h, and compares
// pictures with the result.
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

struct EarlierRotations {
    std::vector<float> rotations;  // as those of ReferenceFile::draw
    double secondsToNext = 0;      // at most 5: after longer gaps the SDK fades what was remembered
};

class ReferenceFile {
public:
    /** The bytes may be freed afterwards. Errors: those of readAvatar and readSplats. */
    static Result<ReferenceFile> read(std::span<const uint8_t> bytes);

    /** rotations: one xyzw quaternion per joint, as dplGetPose returns them. Their number is not checked; general splats ignore them. Slow:
     *  50,000 splats take about a second per megapixel. earlier: poses that were drawn before, oldest first, as by dplSetPoseAtTime. */
    ReferencePicture draw(std::span<const float> rotations, const Vec3f& rootTranslation, const Cameraf& camera,
                          std::span<const EarlierRotations> earlier = {}) const;

    bool hasPoseCorrectives() const;
    bool hasLight() const;
    /** Samples per pixel in the picture that draw() returns, 1 or 4. Every renderer takes as many, except on devices that support only one.
     */
    uint32_t samples(const Vec3f& rootTranslation, const Cameraf& camera) const;

private:
    std::shared_ptr<const AvatarData> avatar_;  // exactly one of the two is set
    std::shared_ptr<const StaticSplatData> splats_;
};

struct PictureError {
    double squares = 0, coveredSquares = 0;  // squared errors of the colour over mid grey, peak 1; this includes errors of alpha
    uint64_t values = 0, coveredValues = 0;  // covered: pixels where the referee or the picture has alpha > 0
    double maxLevels = 0;                    // largest error of one channel in 8-bit levels

    /** PSNR over all pixels (empty background raises it) and over the covered pixels only. Infinite for equal pictures. */
    double psnrDb() const;
    double coveredPsnrDb() const;
    PictureError& operator+=(const PictureError& other);
};

/** rgba: premultiplied, 4 values of 8 or 16 bits per pixel, same size as the reference. */
PictureError compareWith(const ReferencePicture& reference, std::span<const uint8_t> rgba);
PictureError compareWith(const ReferencePicture& reference, std::span<const uint16_t> rgba);

/** Mean FLIP (flip.h) over the covered pixels, both pictures over mid grey. 0 when nothing is covered, 1 when the sizes differ. */
double coveredFlip(const ReferencePicture& reference, std::span<const uint8_t> rgba);

}  // namespace dpl
