// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/report/png.h"

#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

namespace dpl {

Result<std::vector<uint8_t>> encodePng(std::span<const uint8_t> pixels, uint32_t widthPx, uint32_t heightPx, uint32_t channels) {
    if ((channels != 1 && channels != 3 && channels != 4) || pixels.size() != size_t(widthPx) * heightPx * channels || pixels.empty())
        return fail(Code::InvalidArgument, "{} bytes are not a {}×{} picture of {} channels", pixels.size(), widthPx, heightPx, channels);
    const cv::Mat in(int(heightPx), int(widthPx), CV_8UC(int(channels)), const_cast<uint8_t*>(pixels.data()));
    cv::Mat swapped = in;
    if (channels == 3) cv::cvtColor(in, swapped, cv::COLOR_RGB2BGR);
    if (channels == 4) cv::cvtColor(in, swapped, cv::COLOR_RGBA2BGRA);
    std::vector<uint8_t> png;
    if (!cv::imencode(".png", swapped, png, {cv::IMWRITE_PNG_COMPRESSION, 6})) return fail(Code::Internal, "OpenCV could not encode a PNG");
    return png;
}

}  // namespace dpl
