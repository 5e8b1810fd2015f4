// SPDX-License-Identifier: Apache-2.0
// The scan as the stages use it: which frames are usable, their pictures (decoded once), cameras and poses.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "reconstruction/input/capture/frame_picture.h"
#include "reconstruction/training/trainer/train_images.h"

namespace dpl {

/** Content hashes of a frame's files. A file that the frame lacks has the hash "none". */
struct FrameHashes {
    std::string image, mask, labels, keypoints;
};

/** A scan that passed its check. Nothing after ingest changes it. */
struct IngestedScan {
    Scan scan;
    std::vector<bool> usable;         // of Scan::frames; false: left out of training
    std::vector<FrameHashes> hashes;  // of Scan::frames
    std::string trainingHash;         // of the usable training frames, with their files and cameras
    std::string verdict;              // result of the check, several lines
    std::string validation;           // what was set aside for validation, one sentence
    std::string check;                // result of the check as a JSON object; empty: none
    bool camerasFound = false;        // the scan's cameras were found or repaired by this run
};

/** The kind's name in scan.json and poses.json. */
const char* frameKindName(FrameKind kind);
/** The split's name there. */
const char* splitName(Split split);

/** Whether training may use the frame. */
inline bool isTrainingFrame(const IngestedScan& ingested, size_t frame) {
    return ingested.scan.frames[frame].split == Split::Train && ingested.usable[frame];
}

/** Pictures of a scan's frames, decoded on first use and then kept. `scan` must outlive it. For use by one thread. */
class Pictures {
public:
    explicit Pictures(const Scan& scan) : scan_(scan), pictures_(scan.frames.size()) {}
    Pictures(const Pictures&) = delete;

    Result<std::shared_ptr<const FramePicture>> of(size_t frame);

private:
    const Scan& scan_;
    std::vector<std::shared_ptr<const FramePicture>> pictures_;
};

/** Frames of one split with their pictures. */
struct FrameSet {
    std::vector<TrainFrame> frames;
    std::vector<size_t> indices;  // into Scan::frames, one a frame
};

/** Frame `index` of the scan with its picture, and with the given camera (metres) and pose. */
Result<TrainFrame> frameAt(const IngestedScan& ingested, size_t index, const Camerad& camera, const Pose& pose, Pictures& pictures);

/** All frames of a split; of the training split only usable ones, of the others those with a mask. cameras (metres) and poses: one a frame
 * of the scan. */
Result<FrameSet> framesOf(const IngestedScan& ingested, Split split, std::span<const Camerad> cameras, std::span<const Pose> poses,
                          Pictures& pictures);

/** Sets TrainFrame::precision. precisions: one a frame of the scan. */
void setPrecisions(FrameSet& set, std::span<const std::shared_ptr<const PosePrecision>> precisions);

/** Still training frames with a mask, without close-ups. Their silhouettes shape the surface and the garments. Where there are none, the
 *  moving ones. Indices into Scan::frames. */
std::vector<size_t> silhouetteFrames(const IngestedScan& ingested);

}  // namespace dpl
