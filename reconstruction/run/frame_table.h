// SPDX-License-Identifier: Apache-2.0
// The scan as the stages use it: one row a frame, with its picture on demand, and columns of poses that stages add.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "reconstruction/input/capture/train_frame.h"
#include "reconstruction/run/picture_cache.h"

namespace dpl {

/** Content hashes of a frame's files. A file that the frame lacks has the hash "none". */
struct FrameHashes {
    std::string image, mask, labels, keypoints;
};

/** What made a pose. Later ones know more, and a stage says by the type of its input which one it takes. */
enum class PoseSource : uint8_t {
    BodyFit,     // keypoints of the frame
    Surface,     // the same; still frames also corrected for sway by their silhouettes
    Registered,  // pictures of training frames; other frames from their keypoints
};

/** Poses of a frame table's rows from one source. */
template <PoseSource source>
struct PoseColumn {
    std::vector<Pose> poses;
    const Pose& operator[](size_t row) const { return poses[row]; }
    Pose& operator[](size_t row) { return poses[row]; }
};

/** Frames of one split with their pictures. */
struct FrameSet {
    std::vector<TrainFrame> frames;
    std::vector<size_t> rows;  // of the frame table, one a frame
};

/** A scan that passed its check. Nothing after the ingest changes it. */
struct FrameTable {
    Scan scan;                        // its frames are the rows
    std::vector<bool> usable;         // of the rows; false: left out of training
    std::vector<FrameHashes> hashes;  // of the rows
    std::string scanHash;             // hashOfScan() of the scan as it was given
    std::string trainingHash;         // of the usable training frames, with their files and cameras
    std::string verdict;              // result of the check, several lines
    std::string validation;           // what was set aside for validation, one sentence
    std::string check;                // result of the check as a JSON object; empty: none
    bool camerasFound = false;        // the scan's cameras were found or repaired by this run
    std::shared_ptr<PictureCache> pictures = std::make_shared<PictureCache>();

    size_t rows() const { return scan.frames.size(); }

    /** Whether training may use the row's frame. */
    bool trains(size_t row) const { return scan.frames[row].split == Split::Train && usable[row]; }

    /** The row's picture, decoded on demand. */
    Result<std::shared_ptr<const FramePicture>> picture(size_t row) const { return pictures->of(scan.frames[row]); }

    /** The same for whoever asks later, for as long as it likes. */
    LazyPicture lazyPicture(size_t row) const;

    /** The row with its picture, a camera (metres) and a pose. */
    TrainFrame frame(size_t row, const Camerad& camera, const Pose& pose) const;

    /** All frames of a split; of the training split only usable ones, of the others those with a mask. cameras (metres) and poses: one a
     *  row. */
    FrameSet frames(Split split, std::span<const Camerad> cameras, std::span<const Pose> poses) const;

    /** Still training frames with a mask, without close-ups. Their silhouettes shape the surface and the garments. Where there are none,
     * the moving ones. */
    std::vector<size_t> silhouetteRows() const;
};

/** Sets TrainFrame::precision. precisions: one a row. */
void setPrecisions(FrameSet& set, std::span<const std::shared_ptr<const PosePrecision>> precisions);

}  // namespace dpl
