// SPDX-License-Identifier: Apache-2.0
// A capture in memory, between the reader of its layout and the scan folder that is written from it.
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "reconstruction/input/capture/scan.h"

namespace dpl {

/** One picture that becomes a frame. */
struct CapturePicture {
    std::string name;  // of the frame; safe as a file name
    FrameKind kind = FrameKind::StaticFull;
    Split split = Split::Train;
    std::filesystem::path image;    // JPEG or PNG
    std::filesystem::path mask;     // empty: the alpha channel of `image`, if it has one
    std::optional<Camerad> camera;  // of the pixels as stored, world +Y up; nothing: unknown
    LensDistortion lens;
    double timeS = 0;                  // moving frames: since the first moving picture
    std::string closeupOf;             // close-ups: what they show, if known
    bool maskShowsBackground = false;  // the mask file is 255 where the person is not
    std::vector<Keypoint> keypoints;   // pixels of the stored picture, in the order of Capture::keypointNames; or empty
};

/** What a reader found. Either all pictures have a camera or none has. */
struct Capture {
    std::string what;         // for people: "Polycam raw data"
    bool metricWorld = true;  // false: scale, origin and up are arbitrary
    bool unitStated = true;   // as in Scan
    bool splitStated = false;
    std::string protocol;                    // of a published evaluation, kept in the scan; empty: none
    std::vector<std::string> keypointNames;  // empty: the capture has no keypoints
    double focalGuessPx = 0;                 // without cameras: from EXIF, in pixels of the frames; 0: unknown
    uint32_t longSidePx = 0;                 // pictures become frames of at most this longer side; 0: as large as they are
    std::vector<CapturePicture> pictures;
    std::vector<std::string> notes;  // sentences about what was left out or assumed
};

/** Called between pictures and during videos, on the calling thread. Return false to stop with Code::Cancelled. */
using ImportProgress = std::function<bool(double share, const std::string& what)>;

}  // namespace dpl
