// SPDX-License-Identifier: Apache-2.0
// Draws an avatar as a frame's camera saw the person, in the pose that was found for it, and compares it with the photograph. On the CPU,
// in a context of its own: it belongs on the loader's thread.
#pragma once

#include <doppel/doppel.hpp>

#include "apps/viewer/scan_frames.h"
#include "reconstruction/base/image_codec.h"

namespace dpl {

/** A frame's photograph and the avatar in it; pictures of one size, RGBA. */
struct ComparedPictures {
    Picture photo;        // undistorted, at most kRows rows
    Picture avatar;       // over grey
    Picture error;        // difference in colour where one of both has the person: black, blue, red, yellow, white at kWhiteLevels
    double db = 0;        // PSNR on the same pixels; infinite if they are equal
    bool masked = false;  // the scan says where the person is; else only pixels of the avatar count
    static constexpr uint32_t kRows = 1080;
    static constexpr double kWhiteLevels = 64;
};

class Comparer {
public:
    /** Reads the frames of `run` and loads the avatar. scan: where the pictures are; empty: where frames.json says. Errors name the file:
     * no such folder; another skeleton. */
    static Result<Comparer> open(const std::filesystem::path& run, const std::filesystem::path& avatar, const std::filesystem::path& scan);

    const std::vector<ComparedFrame>& frames() const { return frames_.frames; }
    /** Errors name the frame or its file. */
    Result<ComparedPictures> compare(size_t frame);

private:
    Comparer(ScanFrames frames, doppel::Context context, doppel::Avatar avatar)
        : frames_(std::move(frames)), context_(std::move(context)), avatar_(std::move(avatar)) {}
    ScanFrames frames_;
    doppel::Context context_;
    doppel::Avatar avatar_;
};

/** The picture as a pinhole camera sees it, every n-th row and column averaged. channels: those of the picture. */
Picture pinholePicture(const Picture& stored, const ComparedFrame& frame, uint32_t n);

/** Compares a photograph with an avatar over nothing (straight alpha) of the same size. mask: one channel, or empty. */
ComparedPictures comparedPictures(Picture photo, const Picture& mask, const std::vector<uint8_t>& rgba);

}  // namespace dpl
