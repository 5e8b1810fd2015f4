// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/run/train_frames.h"

namespace dpl {

const char* frameKindName(FrameKind kind) {
    return kind == FrameKind::Dynamic ? "dynamic" : kind == FrameKind::StaticCloseup ? "static_closeup" : "static_full";
}

const char* splitName(Split split) {
    return split == Split::Test ? "test" : split == Split::Validation ? "validation" : "train";
}

Result<std::shared_ptr<const FramePicture>> Pictures::of(size_t frame) {
    if (!pictures_[frame]) {
        DPL_TRY(FramePicture picture, readFramePicture(scan_.frames[frame]));
        pictures_[frame] = std::make_shared<const FramePicture>(std::move(picture));
    }
    return pictures_[frame];
}

Result<TrainFrame> frameAt(const IngestedScan& ingested, size_t index, const Camerad& camera, const Pose& pose, Pictures& pictures) {
    const ScanFrame& frame = ingested.scan.frames[index];
    TrainFrame out{frame.name, frame.kind, camera, pose, nullptr, nullptr};
    DPL_TRY(out.picture, pictures.of(index));
    return out;
}

Result<FrameSet> framesOf(const IngestedScan& ingested, Split split, std::span<const Camerad> cameras, std::span<const Pose> poses,
                          Pictures& pictures) {
    FrameSet set;
    for (size_t f = 0; f < ingested.scan.frames.size(); ++f) {
        const ScanFrame& scanned = ingested.scan.frames[f];
        if (split == Split::Train ? !isTrainingFrame(ingested, f) : scanned.split != split || scanned.maskPath.empty()) continue;
        DPL_TRY(TrainFrame frame, frameAt(ingested, f, cameras[f], poses[f], pictures));
        set.frames.push_back(std::move(frame));
        set.indices.push_back(f);
    }
    return set;
}

void setPrecisions(FrameSet& set, std::span<const std::shared_ptr<const PosePrecision>> precisions) {
    for (size_t i = 0; i < set.frames.size(); ++i) set.frames[i].precision = precisions[set.indices[i]];
}

std::vector<size_t> silhouetteFrames(const IngestedScan& ingested) {
    std::vector<size_t> frames;
    for (const FrameKind kind : {FrameKind::StaticFull, FrameKind::Dynamic}) {
        for (size_t f = 0; f < ingested.scan.frames.size(); ++f) {
            const ScanFrame& frame = ingested.scan.frames[f];
            if (isTrainingFrame(ingested, f) && frame.kind == kind && !frame.maskPath.empty()) frames.push_back(f);
        }
        if (!frames.empty()) break;
    }
    return frames;
}

}  // namespace dpl
