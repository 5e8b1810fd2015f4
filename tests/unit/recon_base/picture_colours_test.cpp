// SPDX-License-Identifier: Apache-2.0
// What a picture states of its colours is heard: profiles, cICP and CMYK become sRGB. Damaged pixels of a JPEG are not a picture.
#include <gtest/gtest.h>
#include <turbojpeg.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <random>

#include "reconstruction/base/image_codec.h"
#include "tests/unit/must.h"
#include "tests/unit/recon_base/made_pictures.h"

namespace dpl {
namespace {

struct Rgb {
    int r, g, b;
};

std::vector<uint8_t> flat(Rgb colour, uint32_t channels = 3) {
    std::vector<uint8_t> pixels;
    for (int i = 0; i < 32 * 32; ++i) {
        for (int v : {colour.r, colour.g, colour.b}) pixels.push_back(uint8_t(v));
        if (channels == 4) pixels.push_back(uint8_t(i % 256));
    }
    return pixels;
}
MadeBytes flatPng(Rgb colour, uint32_t channels = 3) {
    return must(encodePng(flat(colour, channels), 32, 32, channels));
}
MadeBytes flatJpeg(Rgb colour) {
    return must(encodeJpeg(flat(colour), 32, 32, 3, 100));
}

/** Whether the first pixel has this colour to `tolerance` levels. */
::testing::AssertionResult shows(const Picture& picture, Rgb colour, int tolerance) {
    const uint8_t* p = picture.pixels.data();
    const int most = std::max({std::abs(p[0] - colour.r), std::abs(p[1] - colour.g), std::abs(p[2] - colour.b)});
    if (most <= tolerance) return ::testing::AssertionSuccess();
    return ::testing::AssertionFailure() << int(p[0]) << ' ' << int(p[1]) << ' ' << int(p[2]);
}

// A skin tone of Display P3 and the same colour in sRGB, computed with double matrices of the two standards (SMPTE EG 432-1, IEC
// 61966-2-1).
constexpr Rgb kSkinP3{200, 150, 120}, kSkinSrgb{209, 147, 115};
// The same numbers in Adobe RGB (1998), gamma 2.19921875.
constexpr Rgb kSkinAdobe{217, 151, 119};

TEST(PictureColours, displayP3BecomesSrgb) {
    const MadeBytes profile = displayP3Profile();
    PictureColours colours;
    const auto png = must(decodePicture(withChunk(flatPng(kSkinP3), "iCCP", profileChunk(profile)), PictureChannels::Rgb, &colours));
    EXPECT_TRUE(shows(png, kSkinSrgb, 1));
    EXPECT_EQ(colours.converted, "Display P3");
    for (size_t parts : {1, 3}) {
        const auto jpeg = must(decodePicture(withProfile(flatJpeg(kSkinP3), profile, parts), PictureChannels::Rgb, &colours));
        EXPECT_TRUE(shows(jpeg, kSkinSrgb, 2)) << parts;  // JPEG itself moves a level
        EXPECT_EQ(colours.converted, "Display P3");
    }
    const auto cicp = must(decodePicture(withChunk(flatPng(kSkinP3), "cICP", {12, 13, 0, 1}), PictureChannels::Rgb, &colours));
    EXPECT_TRUE(shows(cicp, kSkinSrgb, 1));
    EXPECT_EQ(colours.converted, "Display P3");
}

TEST(PictureColours, otherSpacesOfCurvesAndAMatrixBecomeSrgb) {
    PictureColours colours;
    const MadeBytes adobe = madeProfile("Adobe RGB (1998)", gammaCurve(2.19921875), kMadeAdobe);
    const auto picture = must(decodePicture(withProfile(flatJpeg(kSkinP3), adobe), PictureChannels::Rgb, &colours));
    EXPECT_TRUE(shows(picture, kSkinAdobe, 2));
    EXPECT_EQ(colours.converted, "Adobe RGB (1998)");
    const MadeBytes linear = madeProfile("linear", gammaCurve(1), kMadeSrgb);
    EXPECT_TRUE(shows(must(decodePicture(withChunk(flatPng({55, 55, 55}), "iCCP", profileChunk(linear)), PictureChannels::Rgb)),
                      {128, 128, 128}, 1));  // 55 / 255 of light
    const MadeBytes grey = madeProfile("Grey", gammaCurve(1), kMadeSrgb, "GRAY");
    const MadeBytes greyPng = must(encodePng(std::vector<uint8_t>(1024, 55), 32, 32, 1));
    EXPECT_TRUE(shows(must(decodePicture(withChunk(greyPng, "iCCP", profileChunk(grey)), PictureChannels::Rgb)), {128, 128, 128}, 1));
}

TEST(PictureColours, srgbKeepsEveryBit) {
    PictureColours colours;
    const MadeBytes srgb = madeProfile("sRGB IEC61966-2.1", srgbCurve(), kMadeSrgb);
    std::mt19937 random(3);
    std::vector<uint8_t> pixels(32 * 32 * 3);
    for (uint8_t& v : pixels) v = uint8_t(random());
    const MadeBytes png = must(encodePng(pixels, 32, 32, 3));
    for (const MadeBytes& file : {png, withChunk(png, "iCCP", profileChunk(srgb)), withChunk(png, "cICP", {1, 13, 0, 1})}) {
        EXPECT_EQ(must(decodePicture(file, PictureChannels::Rgb, &colours)).pixels, pixels);
        EXPECT_EQ(colours.converted + colours.unread, "");
    }
}

TEST(PictureColours, numbersOfMasksAndAlphaStay) {
    const MadeBytes profile = profileChunk(displayP3Profile());
    EXPECT_TRUE(shows(must(decodePicture(withChunk(flatPng(kSkinP3), "iCCP", profile), PictureChannels::AsStored)), kSkinP3, 0));
    const auto rgba = must(decodePicture(withChunk(flatPng(kSkinP3, 4), "iCCP", profile), PictureChannels::Rgba));
    ASSERT_EQ(rgba.channels, 4u);
    EXPECT_TRUE(shows(rgba, kSkinSrgb, 1));
    for (size_t i = 0; i < 1024; ++i) ASSERT_EQ(rgba.pixels[4 * i + 3], uint8_t(i % 256));
    const auto opaque = must(decodePicture(flatJpeg(kSkinP3), PictureChannels::Rgba));
    EXPECT_EQ(opaque.channels, 4u);
    EXPECT_EQ(opaque.pixels[3], 255);
}

TEST(PictureColours, profilesThatAreNotReadAreSaid) {
    PictureColours colours;
    MadeBytes tables = displayP3Profile();
    const std::string from = "rXYZ", to = "A2B0";
    std::copy(to.begin(), to.end(), std::search(tables.begin(), tables.end(), from.begin(), from.end()));
    EXPECT_TRUE(shows(must(decodePicture(withProfile(flatJpeg(kSkinP3), tables), PictureChannels::Rgb, &colours)), kSkinP3, 2));
    EXPECT_EQ(colours.unread, "Display P3");
    const MadeBytes whole = displayP3Profile();
    for (size_t bytes = 1; bytes < whole.size(); bytes += 5) {
        const auto cut = decodePicture(withProfile(flatJpeg(kSkinP3), {whole.begin(), whole.begin() + std::ptrdiff_t(bytes)}),
                                       PictureChannels::Rgb, &colours);
        ASSERT_TRUE(cut) << "a damaged profile makes no picture unreadable";
        EXPECT_NE(colours.unread + colours.converted, "") << bytes;
    }
}

/** A CMYK JPEG as libjpeg-turbo writes it, with Adobe's segment. cmyk: as stored, which for Adobe is the inverse of the inks. */
MadeBytes cmykJpeg(std::array<uint8_t, 4> stored) {
    std::vector<uint8_t> pixels;
    for (int i = 0; i < 1024; ++i) pixels.insert(pixels.end(), stored.begin(), stored.end());
    unsigned char* bytes = nullptr;
    unsigned long count = 0;
    tjhandle turbo = tjInitCompress();
    EXPECT_EQ(tjCompress2(turbo, pixels.data(), 32, 0, 32, TJPF_CMYK, &bytes, &count, TJSAMP_444, 100, 0), 0);
    MadeBytes file(bytes, bytes + count);
    tjFree(bytes);
    tjDestroy(turbo);
    return file;
}

TEST(PictureColours, cmykBecomesRgb) {
    PictureColours colours;
    const auto picture = must(decodePicture(cmykJpeg({255, 128, 0, 255}), PictureChannels::Rgb, &colours));  // yellow and half magenta
    EXPECT_EQ(picture.channels, 3u);
    EXPECT_TRUE(shows(picture, {255, 128, 0}, 2));
    EXPECT_EQ(colours.converted, "CMYK");
    EXPECT_TRUE(shows(must(decodePicture(cmykJpeg({255, 255, 255, 128}), PictureChannels::Rgb)), {128, 128, 128}, 2));  // half black
}

/** A JPEG of noise, so that its compressed pixels are most of it. */
MadeBytes noiseJpeg() {
    std::mt19937 random(5);
    std::vector<uint8_t> pixels(128 * 96 * 3);
    for (uint8_t& v : pixels) v = uint8_t(random());
    return must(encodeJpeg(pixels, 128, 96, 3, 90));
}

TEST(PictureColours, damagedPixelsOfAJpegAreNoPicture) {
    const MadeBytes good = noiseJpeg();
    ASSERT_TRUE(decodePicture(good, PictureChannels::Rgb));
    const size_t pixels = good.size() / 2;
    std::mt19937 random(9);
    size_t refused = 0;
    for (int trial = 0; trial < 50; ++trial) {
        MadeBytes bad = good;
        for (size_t i = 0; i < 200; ++i) bad[pixels + i] = uint8_t(random() % 255);  // never 255, which begins a marker
        const auto read = decodePicture(bad, PictureChannels::Rgb);
        refused += !read;
        if (!read) {
            EXPECT_NE(read.error().message.find("damaged JPEG"), std::string::npos) << read.error().message;
        }
    }
    EXPECT_EQ(refused, 50u);
    MadeBytes zeros = good, missing = good;
    std::fill_n(zeros.begin() + std::ptrdiff_t(pixels), 400, uint8_t(0));
    EXPECT_FALSE(decodePicture(zeros, PictureChannels::Rgb));
    missing.erase(missing.begin() + std::ptrdiff_t(pixels), missing.end() - 2);  // cut, but with an end marker
    EXPECT_FALSE(decodePicture(missing, PictureChannels::Rgb));
}

TEST(PictureColours, paddingBeforeTheEndOfAJpegIsNoDamage) {
    for (uint8_t fill : {0, 0x55}) {
        MadeBytes padded = noiseJpeg();
        padded.insert(padded.end() - 2, 24, fill);
        const auto read = decodePicture(padded, PictureChannels::Rgb);
        ASSERT_TRUE(read) << read.error().message;
        EXPECT_EQ(read->pixels, must(decodePicture(noiseJpeg(), PictureChannels::Rgb)).pixels);
    }
}

}  // namespace
}  // namespace dpl
