// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/run/picture_cache.h"

namespace dpl {
namespace {

uint64_t bytesOf(const FramePicture& picture) {
    return picture.image.pixels.size() + picture.mask.pixels.size() + picture.labels.pixels.size();
}

/** Frames with the same picture may differ in their masks. */
std::string keyOf(const ScanFrame& frame) {
    return frame.imagePath.string() + '\n' + frame.maskPath.string() + '\n' + frame.labelsPath.string();
}

}  // namespace

uint64_t PictureCache::keptBytes() const {
    const std::lock_guard lock(mutex_);
    return keptBytes_;
}

Result<std::shared_ptr<const FramePicture>> PictureCache::of(const ScanFrame& frame) {
    const std::string key = keyOf(frame);
    {
        const std::lock_guard lock(mutex_);
        if (auto held = held_[key].lock()) return keep(key, std::move(held));
    }
    DPL_TRY(FramePicture decoded, readFramePicture(frame));  // without the lock: threads decode side by side
    auto picture = std::make_shared<const FramePicture>(std::move(decoded));
    const std::lock_guard lock(mutex_);
    if (auto held = held_[key].lock()) picture = std::move(held);  // another thread was faster
    held_[key] = picture;
    return keep(key, std::move(picture));
}

std::shared_ptr<const FramePicture> PictureCache::keep(const std::string& key, std::shared_ptr<const FramePicture> picture) {
    if (const auto found = byKey_.find(key); found != byKey_.end()) {
        kept_.splice(kept_.begin(), kept_, found->second);
        return picture;
    }
    kept_.push_front({key, picture, bytesOf(*picture)});
    byKey_[key] = kept_.begin();
    keptBytes_ += kept_.front().bytes;
    while (keptBytes_ > boundBytes_) {
        keptBytes_ -= kept_.back().bytes;
        byKey_.erase(kept_.back().key);
        kept_.pop_back();
    }
    return picture;
}

}  // namespace dpl
