// SPDX-License-Identifier: Apache-2.0
// Pictures and cameras for tests of the import: one world point whose place in every picture is known.
#pragma once

#include <cmath>

#include "reconstruction/base/image_codec.h"
#include "reconstruction/input/capture/scan.h"
#include "sdk/core/files.h"
#include "tests/unit/recon_capture/scan_builder.h"

namespace dpl {

/** The camera of all made captures: upright 96 × 128, at (0, 1, 3), looking along −z, world +Y up. */
inline const Vec3d kMadeEye(0, 1, 3);
/** A point half a metre to the right and above of the axis, and its pixel: 48 + 100 · 0.5 / 3 and 64 − 100 · 0.5 / 3. */
inline const Vec3d kMadePoint(0.5, 1.5, 0);
inline const Vec2d kMadePixel(48 + 50 / 3.0, 64 - 50 / 3.0);
/** The same point in the sensor's landscape picture, 128 × 96, which a clockwise quarter turn makes upright: u = 96 − V, v = U. */
inline const Vec2d kMadeSensorPixel(64 - 50 / 3.0, 48 - 50 / 3.0);

/** Mid-grey with a bright spot at `spot`. channels 4: transparent away from it. */
inline Picture spotPicture(uint32_t widthPx, uint32_t heightPx, Vec2d spot, uint32_t channels = 3) {
    Picture picture{widthPx, heightPx, channels, std::vector<uint8_t>(size_t(widthPx) * heightPx * channels)};
    for (uint32_t y = 0; y < heightPx; ++y)
        for (uint32_t x = 0; x < widthPx; ++x) {
            const double dx = x + 0.5 - spot.x, dy = y + 0.5 - spot.y, distance2 = dx * dx + dy * dy;
            uint8_t* pixel = &picture.pixels[(size_t(y) * widthPx + x) * channels];
            for (uint32_t c = 0; c < 3; ++c) pixel[c] = uint8_t(60 + 180 * std::exp(-distance2 / 18));
            if (channels == 4) pixel[3] = distance2 < 400 ? 255 : 0;
        }
    return picture;
}

inline std::vector<uint8_t> jpegOf(const Picture& picture) {
    return *encodeJpeg(picture.pixels, picture.widthPx, picture.heightPx, picture.channels, 95);
}
inline std::vector<uint8_t> pngOf(const Picture& picture) {
    return *encodePng(picture.pixels, picture.widthPx, picture.heightPx, picture.channels);
}

inline void writeBytes(const std::filesystem::path& path, const std::vector<uint8_t>& bytes) {
    std::filesystem::create_directories(path.parent_path());
    std::ofstream(path, std::ios::binary).write(reinterpret_cast<const char*>(bytes.data()), std::streamsize(bytes.size()));
}

/** Where the bright spot of a picture lies. */
inline Vec2d spotIn(const ImageRgb8& image) {
    Vec2d sum(0);
    double weight = 0;
    for (uint32_t y = 0; y < image.heightPx; ++y)
        for (uint32_t x = 0; x < image.widthPx; ++x) {
            const double w = std::max(0.0, double(image.pixels[(size_t(y) * image.widthPx + x) * 3]) - 150);
            sum += w * Vec2d(x + 0.5, y + 0.5);
            weight += w;
        }
    return sum / weight;
}

/** Whether a frame has the made camera, and its picture shows the point there. */
inline ::testing::AssertionResult seesMadePoint(const ScanFrame& frame) {
    const Camerad& c = frame.camera;
    if (c.widthPx != 96 || c.heightPx != 128) return ::testing::AssertionFailure() << c.widthPx << " x " << c.heightPx << " pixels";
    const Vec3d eye = c.eye();
    if (glm::length(eye - kMadeEye) > 1e-9) return ::testing::AssertionFailure() << "eye " << eye.x << ' ' << eye.y << ' ' << eye.z;
    const Vec2d pixel = c.pixelOf(c.toView(kMadePoint));
    if (glm::length(pixel - kMadePixel) > 1e-6) return ::testing::AssertionFailure() << "projects to " << pixel.x << ' ' << pixel.y;
    const auto image = readFrameImage(frame);
    if (!image) return ::testing::AssertionFailure() << image.error().message;
    const Vec2d spot = spotIn(*image);
    // JPEG moves the centroid of the spot by up to 0.03 px here; a turn by one pixel moves it by 1.
    if (glm::length(spot - kMadePixel) > 0.2) return ::testing::AssertionFailure() << "spot at " << spot.x << ' ' << spot.y;
    return ::testing::AssertionSuccess();
}

/** `jpeg` with an EXIF segment after its start. */
inline std::vector<uint8_t> withExif(const std::vector<uint8_t>& jpeg, int orientation, int focal35Mm, bool little = true) {
    std::vector<uint8_t> tiff;
    const auto u16 = [&](uint32_t v) {
        const uint8_t low = uint8_t(v), high = uint8_t(v >> 8);
        tiff.push_back(little ? low : high), tiff.push_back(little ? high : low);
    };
    const auto u32 = [&](uint32_t v) {
        if (little)
            u16(v & 0xffff), u16(v >> 16);
        else
            u16(v >> 16), u16(v & 0xffff);
    };
    const auto entry = [&](uint32_t tag, uint32_t type, uint32_t value) {
        u16(tag), u16(type), u32(1);
        if (type == 3)
            u16(value), u16(0);
        else
            u32(value);
    };
    tiff.insert(tiff.end(), 2, little ? 'I' : 'M');
    u16(42), u32(8);
    u16(2), entry(274, 3, uint32_t(orientation)), entry(34665, 4, 8 + 2 + 24 + 4), u32(0);
    u16(1), entry(41989, 3, uint32_t(focal35Mm)), u32(0);
    std::vector<uint8_t> out(jpeg.begin(), jpeg.begin() + 2);
    const size_t length = 2 + 6 + tiff.size();
    for (uint8_t b : {uint8_t(0xff), uint8_t(0xe1), uint8_t(length >> 8), uint8_t(length), uint8_t('E'), uint8_t('x'), uint8_t('i'),
                      uint8_t('f'), uint8_t(0), uint8_t(0)})
        out.push_back(b);
    out.insert(out.end(), tiff.begin(), tiff.end());
    out.insert(out.end(), jpeg.begin() + 2, jpeg.end());
    return out;
}

/** The sensor camera's JSON of one Polycam keyframe. */
inline nlohmann::json polycamKeyframe() {
    return {{"fx", 100.0}, {"fy", 100.0}, {"cx", 64.0},  {"cy", 48.0},  {"width", 128}, {"height", 96}, {"timestamp", 1442008525605},
            {"t_00", 0.0}, {"t_01", 1.0}, {"t_02", 0.0}, {"t_03", 0.0}, {"t_10", -1.0}, {"t_11", 0.0},  {"t_12", 0.0},
            {"t_13", 1.0}, {"t_20", 0.0}, {"t_21", 0.0}, {"t_22", 1.0}, {"t_23", 3.0}};
}

/** metadata of a Record3D recording of `frames` frames by the same sensor camera: a turn about z by −90°. */
inline nlohmann::json record3dMetadata(int frames) {
    const double half = std::sqrt(0.5);
    nlohmann::json poses = nlohmann::json::array();
    for (int i = 0; i < frames; ++i) poses.push_back({0.0, 0.0, -half, half, 0.0, 1.0, 3.0});
    return {{"w", 128}, {"h", 96}, {"fps", 60}, {"K", {100.0, 0.0, 0.0, 0.0, 100.0, 0.0, 64.0, 48.0, 1.0}}, {"poses", poses}};
}

/** One Qualisys camera: the made camera in millimetres and z-up, (x, −z, y). */
inline std::string qualisysText() {
    return R"(<?xml version="1.0"?>
<calibration><cameras><camera serial="cam01" model="none">
<fov_video left="0" right="95" top="0" bottom="127"/>
<transform x="0" y="-3000" z="1000" r11="1" r12="0" r13="0" r21="0" r22="0" r23="1" r31="0" r32="-1" r33="0"/>
<intrinsic focalLengthU="6400" focalLengthV="6400" centerPointU="3072" centerPointV="4096" radialDistortion1="0" radialDistortion2="0" tangentalDistortion1="0" tangentalDistortion2="0"/>
</camera></cameras></calibration>
)";
}

/** The same camera for Pose2Sim: a turn about x by 90° takes z-up to OpenCV's y down. */
inline std::string pose2simText() {
    return R"([cam_01]
name = "cam01"
size = [ 96.0, 128.0]
matrix = [ [ 100.0, 0.0, 48.0], [ 0.0, 100.0, 64.0], [ 0.0, 0.0, 1.0]]
distortions = [ 0.0, 0.0, 0.0, 0.0]
rotation = [ 1.5707963267948966, 0.0, 0.0]
translation = [ 0.0, 1.0, 3.0]
fisheye = false

[metadata]
adjusted = false
error = 0.0
)";
}

}  // namespace dpl
