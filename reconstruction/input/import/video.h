// SPDX-License-Identifier: Apache-2.0
// Reads videos with the programs ffprobe and ffmpeg: H.264, HEVC, VP9 and others, with variable frame rate, rotation and 10-bit HDR.
#pragma once

#include <atomic>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "reconstruction/input/import/frame_motion.h"
#include "sdk/core/result.h"

namespace dpl {

struct VideoInfo {
    std::filesystem::path path;
    std::string codec;
    uint32_t widthPx = 0, heightPx = 0;              // of its frames: upright, after the rotation that the file states, with square pixels
    uint32_t storedWidthPx = 0, storedHeightPx = 0;  // upright, of the pixels as stored, which need not be square
    double durationS = 0;                            // from its first frame on; 0: not stated
    size_t otherStreams = 0;                         // video streams beside the first, which is read; pictures of a cover do not count
    bool hdr = false;                                // HLG or PQ; tone-mapped to sRGB
    std::string colourMatrix;                        // "bt709", "smpte170m", ...; guessed from the size where the file says nothing
    double focalLength35Mm = 0;                      // newer iPhones state it; 0: unknown
};

/** A frame that was analysed; ffmpeg finds it again by `pts`. */
struct VideoFrame {
    long long pts = 0;  // in the stream's own unit
    double timeS = 0;   // since the start of the video
};

struct VideoAnalysis {
    std::vector<VideoFrame> frames;
    std::vector<FrameMotion> motion;  // one for each frame
};

/** What every call needs: a folder for temporary files and the log, and how to stop. */
struct VideoWork {
    std::filesystem::path folder;                     // exists; its files are removed by the caller
    const std::atomic<bool>* cancel = nullptr;        // may be null
    std::function<bool(double share)> progress = {};  // false: stop
};

/** Reads the header. Unsupported: no picture stream, or a codec that the installed ffmpeg lacks. CorruptData: cut or damaged. */
Result<VideoInfo> probeVideo(const std::filesystem::path& path, const VideoWork& work);

/** Decodes the video small and grey, at most 12 frames a second and 1500 in all, and measures each frame. CorruptData when it ends long
 *  before its stated duration. */
Result<VideoAnalysis> analyseVideo(const VideoInfo& video, const VideoWork& work);

/** A frame of a sample. */
struct SampledFrame {
    std::filesystem::path file;  // JPEG, as of extractFrames()
    double timeS = 0;
};

/** At most `count` frames, evenly over the video, without decoding all of it: its key frames where it has enough of them, else one seek for
 *  each. A second of work for a minute of video. Errors as of extractFrames(). */
Result<std::vector<SampledFrame>> sampleFrames(const VideoInfo& video, size_t count, uint32_t longSidePx, const VideoWork& work);

/** Writes the frames with the given pts as upright 8-bit sRGB JPEG files of the video's size and returns their paths, in order. Sides are
 * at most `longSidePx`. */
Result<std::vector<std::filesystem::path>> extractFrames(const VideoInfo& video, const std::vector<long long>& pts, uint32_t longSidePx,
                                                         const VideoWork& work);

}  // namespace dpl
