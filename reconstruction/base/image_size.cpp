// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/base/image_size.h"

namespace dpl {

Status checkImageSize(uint64_t widthPx, uint64_t heightPx, std::string_view where) {
    if (widthPx == 0 || heightPx == 0)
        return fail(Code::CorruptData, "{}: image size {} x {}; give the size in pixels", where, widthPx, heightPx);
    if (widthPx > kMaxImagePixels || heightPx > kMaxImagePixels || widthPx * heightPx > kMaxImagePixels)
        return fail(Code::Unsupported, "{}: {} x {} pixels, at most 64 million are read; scale the images (and the intrinsics) down", where,
                    widthPx, heightPx);
    return {};
}

}  // namespace dpl
