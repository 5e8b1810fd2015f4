// SPDX-License-Identifier: Apache-2.0
// Decoded pictures of frames within a bound of memory.
#pragma once

#include <filesystem>
#include <list>
#include <memory>
#include <mutex>
#include <unordered_map>

#include "reconstruction/input/capture/frame_picture.h"

namespace dpl {

/** Decodes pictures on demand and keeps those that were asked for last. A picture that somebody still holds is not decoded again. From any
 *  thread. */
class PictureCache {
public:
    /** Pictures of up to so many bytes are kept: all of 174 pictures of 1080 x 1440. */
    static constexpr uint64_t kBoundBytes = uint64_t(3) << 29;

    explicit PictureCache(uint64_t boundBytes = kBoundBytes) : boundBytes_(boundBytes) {}

    /** The frame's picture. Errors as readFramePicture(). */
    Result<std::shared_ptr<const FramePicture>> of(const ScanFrame& frame);

    /** Bytes of the pictures that the cache itself keeps, at most the bound. */
    uint64_t keptBytes() const;

private:
    struct Kept {
        std::string key;
        std::shared_ptr<const FramePicture> picture;
        uint64_t bytes = 0;
    };
    /** Makes it the last one that was asked for, and drops others beyond the bound. The caller holds the mutex. */
    std::shared_ptr<const FramePicture> keep(const std::string& key, std::shared_ptr<const FramePicture> picture);

    const uint64_t boundBytes_;
    mutable std::mutex mutex_;  // of all below
    uint64_t keptBytes_ = 0;
    std::list<Kept> kept_;  // the last one that was asked for first
    std::unordered_map<std::string, std::list<Kept>::iterator> byKey_;
    std::unordered_map<std::string, std::weak_ptr<const FramePicture>> held_;
};

}  // namespace dpl
