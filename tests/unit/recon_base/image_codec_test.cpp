// SPDX-License-Identifier: Apache-2.0
// The JPEG and PNG codec against OpenCV's.
#include "reconstruction/base/image_codec.h"

#include <gtest/gtest.h>

#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <random>

namespace dpl {
namespace {

/** A smooth picture with noise, so that a swapped channel, a shifted row or a lost bit shows. */
cv::Mat picture(int channels, int depth = CV_8U, int widthPx = 61, int heightPx = 47) {
    std::mt19937 random(7);
    cv::Mat out(heightPx, widthPx, CV_MAKETYPE(depth, channels));
    const int most = depth == CV_8U ? 255 : 65535;
    for (int y = 0; y < heightPx; ++y)
        for (int x = 0; x < widthPx; ++x)
            for (int c = 0; c < channels; ++c) {
                const int value = (most * (x * (c + 1) + y * (channels - c)) / ((widthPx + heightPx) * 4) + int(random() % 9)) % (most + 1);
                if (depth == CV_8U)
                    out.ptr<uint8_t>(y)[x * channels + c] = uint8_t(value);
                else
                    out.ptr<uint16_t>(y)[x * channels + c] = uint16_t(value);
            }
    return out;
}

std::vector<uint8_t> encoded(const cv::Mat& image, const char* extension, const std::vector<int>& settings = {}) {
    std::vector<uint8_t> bytes;
    EXPECT_TRUE(cv::imencode(extension, image, bytes, settings));
    return bytes;
}

/** Pixels of an OpenCV image in RGB order, 8 bits. */
std::vector<uint8_t> rgbBytes(const cv::Mat& in) {
    cv::Mat image = in.clone();
    if (image.depth() == CV_16U) image.convertTo(image, CV_8U, 1.0 / 257);
    if (image.channels() == 3) cv::cvtColor(image, image, cv::COLOR_BGR2RGB);
    if (image.channels() == 4) cv::cvtColor(image, image, cv::COLOR_BGRA2RGBA);
    return {image.data, image.data + image.total() * image.elemSize()};
}

TEST(ImageCodec, readsEveryPngThatOpenCvWrites) {
    for (int channels : {1, 3, 4})
        for (int depth : {CV_8U, CV_16U}) {
            const cv::Mat in = picture(channels, depth);
            const auto out = decodePicture(encoded(in, ".png"), PictureChannels::AsStored);
            ASSERT_TRUE(out) << out.error().message;
            EXPECT_EQ(out->channels, uint32_t(channels));
            EXPECT_EQ(out->pixels, rgbBytes(in)) << channels << " channels, depth " << depth;
        }
}

TEST(ImageCodec, readsJpegsBitForBitLikeOpenCv) {
    for (int channels : {1, 3})
        for (int progressive : {0, 1}) {
            const auto file = encoded(picture(channels), ".jpg", {cv::IMWRITE_JPEG_QUALITY, 90, cv::IMWRITE_JPEG_PROGRESSIVE, progressive});
            const auto out = decodePicture(file, PictureChannels::AsStored);
            ASSERT_TRUE(out) << out.error().message;
            EXPECT_EQ(out->pixels, rgbBytes(cv::imdecode(file, cv::IMREAD_UNCHANGED)));
        }
}

TEST(ImageCodec, rgbRepeatsGreyAndDropsAlpha) {
    for (int channels : {1, 3, 4}) {
        const auto file = encoded(picture(channels), ".png");
        const auto out = decodePicture(file, PictureChannels::Rgb);
        ASSERT_TRUE(out) << out.error().message;
        EXPECT_EQ(out->channels, 3u);
        EXPECT_EQ(out->pixels, rgbBytes(cv::imdecode(file, cv::IMREAD_COLOR)));
    }
}

TEST(ImageCodec, aPngComesBackAsItWas) {
    for (int channels : {1, 3, 4}) {
        const std::vector<uint8_t> pixels = rgbBytes(picture(channels));
        const auto file = encodePng(pixels, 61, 47, uint32_t(channels));
        ASSERT_TRUE(file) << file.error().message;
        EXPECT_EQ(rgbBytes(cv::imdecode(*file, cv::IMREAD_UNCHANGED)), pixels);
    }
}

TEST(ImageCodec, writesJpegsByteForByteLikeOpenCv) {
    const cv::Mat in = picture(3);
    const auto file = encodeJpeg(rgbBytes(in), 61, 47, 3, 92);
    ASSERT_TRUE(file) << file.error().message;
    EXPECT_EQ(*file, encoded(in, ".jpg", {cv::IMWRITE_JPEG_QUALITY, 92}));
}

TEST(ImageCodec, refusesWhatIsNoPicture) {
    EXPECT_EQ(decodePicture({}, PictureChannels::Rgb).error().code, Code::Unsupported);
    const std::vector<uint8_t> bmp = encoded(picture(3), ".bmp");
    EXPECT_EQ(decodePicture(bmp, PictureChannels::Rgb).error().code, Code::Unsupported);
    EXPECT_FALSE(encodePng(std::vector<uint8_t>(5), 2, 2, 3));
    EXPECT_FALSE(encodePng({}, 0, 0, 3));
    EXPECT_FALSE(encodePng(std::vector<uint8_t>(8), 2, 2, 2));
    EXPECT_FALSE(encodeJpeg(std::vector<uint8_t>(12), 2, 2, 3, 0));
}

TEST(ImageCodec, everyTruncationOfAPngIsRefused) {
    const std::vector<uint8_t> file = encoded(picture(3), ".png");
    for (size_t bytes = 0; bytes + 12 < file.size(); bytes += 7)  // the last 12 bytes are the end marker
        EXPECT_FALSE(decodePicture(std::span(file).first(bytes), PictureChannels::Rgb)) << bytes;
}

TEST(ImageCodec, flippedBitsGiveAPictureOrAnErrorOfTheFile) {
    std::mt19937 random(11);
    for (const char* extension : {".png", ".jpg"}) {
        const std::vector<uint8_t> good = encoded(picture(3), extension);
        size_t refused = 0;
        for (int trial = 0; trial < 300; ++trial) {
            std::vector<uint8_t> bad = good;
            // The bytes of the size are not damaged: readCompleteImage limits sizes before anything is decoded.
            const size_t after = extension[1] == 'p' ? 33 : 200;
            for (int k = 0; k < 3; ++k) bad[after + random() % (bad.size() - after)] ^= uint8_t(1u << random() % 8);
            const auto out = decodePicture(bad, PictureChannels::Rgb);
            if (!out) {
                ++refused;
                EXPECT_TRUE(out.error().code == Code::CorruptData || out.error().code == Code::Unsupported) << out.error().message;
            } else {
                EXPECT_EQ(out->pixels.size(), size_t(61) * 47 * 3);
            }
        }
        if (extension[1] == 'p') {
            EXPECT_GT(refused, 250u) << "checksums of a PNG find nearly every change";
        }
    }
}

}  // namespace
}  // namespace dpl
