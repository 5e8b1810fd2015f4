// SPDX-License-Identifier: Apache-2.0
// Decoded pictures of frames within a bound of memory.
#pragma once

#include <filesystem>
#include <list>
#include <memory>
#include <unordered_map>

#include "reconstruction/input/capture/frame_picture.h"

namespace dpl {

/** Decodes pictures on demand and keeps those that were asked for last. A picture that somebody still holds is never decoded twice. For use
 *  by one thread. */
class PictureCache {
public:
    /** Pictures of up to so many bytes are kept for the next stage: all of 174 pictures of 1080 x 1440. */
    static constexpr uint64_t kBoundBytes = uint64_t(3) << 29;

    explicit PictureCache(uint64_t boundBytes = kBoundBytes) : boundBytes_(boundBytes) {}

    /** The frame's picture. Errors as readFramePicture(). */
    Result<std::shared_ptr<const FramePicture>> of(const ScanFrame& frame);

    /** Bytes of the pictures that the cache itself keeps, at most the bound. */
    uint64_t keptBytes() const { return keptBytes_; }

private:
    struct Kept {
        std::string key;
        std::shared_ptr<const FramePicture> picture;
        uint64_t bytes = 0;
    };
    uint64_t boundBytes_, keptBytes_ = 0;
    std::list<Kept> kept_;  // the last one that was asked for first
    std::unordered_map<std::string, std::list<Kept>::iterator> byKey_;
    std::unordered_map<std::string, std::weak_ptr<const FramePicture>> held_;
};

}  // namespace dpl
