// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/input/capture/picture_size.h"

#include <cmath>

namespace dpl {

namespace {

constexpr double kMaxSidePx = 65536;
constexpr double kShapeTolerance = 0.005;  // rounding of a resized picture's sides
// Share of a side. Principal points of phones lie within 3 % of the middle; intrinsics of a picture that was turned by a quarter (4:3) are
// 17 % off, those of a picture of twice the size 50 %.
constexpr double kOffCentre = 0.1;

}  // namespace

Status takeSize(Camerad& camera, const JsonFields& fields, const char* widthKey, const char* heightKey, const ImageHeader& picture) {
    const double shape = double(picture.widthPx) / std::max(1.0, double(picture.heightPx));
    const bool stated = fields.has(widthKey) || fields.has(heightKey);
    DPL_TRY(double width, fields.number(widthKey, 0));
    DPL_TRY(double height, fields.number(heightKey, 0));
    if (!fields.has(widthKey)) width = stated ? std::round(height * shape) : picture.widthPx;
    if (!fields.has(heightKey)) height = stated ? std::round(width / shape) : picture.heightPx;
    if (!(width >= 1 && height >= 1 && width <= kMaxSidePx && height <= kMaxSidePx))
        return fail(Code::CorruptData, "{}: {}, {} = {}, {} is not a size in pixels; export the capture again", fields.where(), widthKey,
                    heightKey, width, height);
    camera.widthPx = uint32_t(width), camera.heightPx = uint32_t(height);
    if (!stated && !(std::abs(camera.cx / width - 0.5) <= kOffCentre && std::abs(camera.cy / height - 0.5) <= kOffCentre))
        return fail(
            Code::CorruptData,
            "{}: the principal point ({}, {}) is not near the middle of the {} x {} picture, and no '{}' and '{}' say for which size "
            "it holds; use the pictures as they were exported, or add the size",
            fields.where(), camera.cx, camera.cy, width, height, widthKey, heightKey);
    return {};
}

Result<bool> fitToPicture(Camerad& camera, const ImageHeader& picture, const std::filesystem::path& image, const std::string& where) {
    if (camera.widthPx == picture.widthPx && camera.heightPx == picture.heightPx) return false;
    const double sx = double(picture.widthPx) / double(camera.widthPx), sy = double(picture.heightPx) / double(camera.heightPx);
    if (!(std::abs(sx / sy - 1) < kShapeTolerance))
        return fail(Code::CorruptData,
                    "{}: {} is {} x {} pixels, its camera says {} x {}, which is another shape; export the capture again, or give the "
                    "pictures of that camera",
                    where, image.string(), picture.widthPx, picture.heightPx, camera.widthPx, camera.heightPx);
    camera.widthPx = picture.widthPx, camera.heightPx = picture.heightPx;
    camera.fx *= sx, camera.cx *= sx, camera.fy *= sy, camera.cy *= sy;
    return true;
}

Result<bool> fitToPictureFile(Camerad& camera, const std::filesystem::path& image, const std::string& where) {
    DPL_TRY(const ImageHeader header, probeImage(image));
    return fitToPicture(camera, header, image, where);
}

Status checkMaskSize(const ImageHeader& mask, const ImageHeader& picture, const std::filesystem::path& file) {
    if (mask.widthPx == picture.widthPx && mask.heightPx == picture.heightPx) return {};
    return fail(Code::CorruptData, "{} is {} x {} pixels, its picture {} x {}; give the mask the size of the picture", file.string(),
                mask.widthPx, mask.heightPx, picture.widthPx, picture.heightPx);
}

void addAssumption(Scan& scan, const std::string& sentence) {
    if (sentence.empty()) return;
    if (!scan.assumed.empty()) scan.assumed += "; ";
    scan.assumed += sentence;
}

void noteScaledCameras(Scan& scan, size_t frames) {
    if (frames == 0) return;
    addAssumption(scan, formatText("{} of {} pictures have another size than their camera states, and the same shape: the camera is scaled",
                                   frames, scan.frames.size()));
}

}  // namespace dpl
