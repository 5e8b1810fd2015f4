// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/run/frame_table.h"

namespace dpl {

LazyPicture FrameTable::lazyPicture(size_t row) const {
    return LazyPicture([cache = pictures, frame = scan.frames[row]] { return cache->of(frame); });
}

TrainFrame FrameTable::frame(size_t row, const Camerad& camera, const Pose& pose) const {
    return {scan.frames[row].name, scan.frames[row].kind, camera, pose, lazyPicture(row), nullptr};
}

FrameSet FrameTable::frames(Split split, std::span<const Camerad> cameras, std::span<const Pose> poses) const {
    FrameSet set;
    for (size_t row = 0; row < rows(); ++row) {
        const ScanFrame& scanned = scan.frames[row];
        if (split == Split::Train ? !trains(row) : scanned.split != split || scanned.maskPath.empty()) continue;
        set.frames.push_back(frame(row, cameras[row], poses[row]));
        set.rows.push_back(row);
    }
    return set;
}

std::vector<size_t> FrameTable::silhouetteRows() const {
    std::vector<size_t> found;
    for (const FrameKind kind : {FrameKind::StaticFull, FrameKind::Dynamic}) {
        for (size_t row = 0; row < rows(); ++row)
            if (trains(row) && scan.frames[row].kind == kind && !scan.frames[row].maskPath.empty()) found.push_back(row);
        if (!found.empty()) break;
    }
    return found;
}

void setPrecisions(FrameSet& set, std::span<const std::shared_ptr<const PosePrecision>> precisions) {
    for (size_t i = 0; i < set.frames.size(); ++i) set.frames[i].precision = precisions[set.rows[i]];
}

}  // namespace dpl
