// SPDX-License-Identifier: Apache-2.0
// Reads pixels and keypoints of one frame and removes lens distortion, so that every later stage works with a pinhole camera.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <map>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>

#include "reconstruction/base/image_codec.h"
#include "reconstruction/base/image_file.h"
#include "reconstruction/base/json_fields.h"
#include "reconstruction/base/models_folder.h"
#include "reconstruction/input/capture/frame_picture.h"
#include "reconstruction/input/capture/hand_keypoints.h"
#include "reconstruction/input/capture/scan_readers.h"

namespace dpl {

namespace fs = std::filesystem;
using nlohmann::json;

namespace {

// OpenCV's (0,0) is the centre of the first pixel, Doppel's is the corner of the image.
cv::Matx33d opencvIntrinsics(const Camerad& c) {
    return {c.fx, 0, c.cx - 0.5, 0, c.fy, c.cy - 0.5, 0, 0, 1};
}
cv::Vec4d opencvLens(const LensDistortion& d) {
    return {d.k1, d.k2, d.p1, d.p2};
}

Result<cv::Mat> decode(const fs::path& path, const ScanFrame& frame, PictureChannels channels) {
    DPL_TRY(const auto bytes, readCompleteImage(path));
    auto picture = decodePicture(bytes, channels);
    if (!picture) return fail(picture.error().code, "{}: {}; copy the image again", path.string(), picture.error().message);
    const cv::Mat image =
        cv::Mat(int(picture->heightPx), int(picture->widthPx), CV_8UC(int(picture->channels)), picture->pixels.data()).clone();
    if (uint32_t(image.cols) != frame.camera.widthPx || uint32_t(image.rows) != frame.camera.heightPx)
        return fail(Code::CorruptData, "frame '{}': {} is {} x {} pixels, its camera says {} x {}; resize it or correct the intrinsics",
                    frame.name, path.string(), image.cols, image.rows, frame.camera.widthPx, frame.camera.heightPx);
    return image;
}

void undistort(cv::Mat& image, const ScanFrame& frame, int interpolation) {
    if (!frame.lens.any()) return;
    cv::Mat mapX, mapY, out;
    const auto k = opencvIntrinsics(frame.camera);
    cv::initUndistortRectifyMap(k, opencvLens(frame.lens), cv::noArray(), k, image.size(), CV_32FC1, mapX, mapY);
    cv::remap(image, out, mapX, mapY, interpolation, cv::BORDER_CONSTANT, cv::Scalar::all(0));
    image = out;
}

template <class Image>
Image takePixels(const cv::Mat& image) {
    Image out{uint32_t(image.cols), uint32_t(image.rows), {}};
    const size_t rowBytes = size_t(image.cols) * image.elemSize();
    out.pixels.resize(rowBytes * image.rows);
    for (int y = 0; y < image.rows; ++y) std::memcpy(out.pixels.data() + rowBytes * y, image.ptr(y), rowBytes);
    return out;
}

}  // namespace

Result<ImageRgb8> readFrameImage(const ScanFrame& frame) {
    // EXIF rotation is ignored: intrinsics refer to the pixels as stored.
    DPL_TRY(cv::Mat image, decode(frame.imagePath, frame, PictureChannels::Rgb));
    undistort(image, frame, cv::INTER_LINEAR);
    return takePixels<ImageRgb8>(image);
}

Result<ImageGrey8> readFrameMask(const ScanFrame& frame) {
    if (frame.maskPath.empty()) return fail(Code::NotFound, "frame '{}' has no mask; add one to the scan", frame.name);
    DPL_TRY(cv::Mat image, decode(frame.maskPath, frame, PictureChannels::AsStored));
    if (image.channels() == 4) {  // alpha is the mask, unless the picture is opaque everywhere
        cv::Mat alpha;
        cv::extractChannel(image, alpha, 3);
        if (cv::countNonZero(alpha != 255) > 0)
            image = alpha;
        else
            cv::cvtColor(image, image, cv::COLOR_RGBA2GRAY);
    } else if (image.channels() == 3) {
        cv::cvtColor(image, image, cv::COLOR_RGB2GRAY);
    }
    double most = 0;
    cv::minMaxLoc(image, nullptr, &most);
    if (most == 1) image *= 255;  // a mask with the values 0 and 1
    undistort(image, frame, cv::INTER_LINEAR);
    return takePixels<ImageGrey8>(image);
}

Result<ImageGrey8> readFrameLabels(const ScanFrame& frame) {
    if (frame.labelsPath.empty()) return fail(Code::NotFound, "frame '{}' has no labels; add them to the scan", frame.name);
    DPL_TRY(cv::Mat image, decode(frame.labelsPath, frame, PictureChannels::AsStored));
    if (image.channels() != 1)
        return fail(Code::CorruptData, "{}: labels must be 8-bit grey, the value is the label; save without a palette",
                    frame.labelsPath.string());
    undistort(image, frame, cv::INTER_NEAREST);
    return takePixels<ImageGrey8>(image);
}

double maskIou(const ImageGrey8& a, const ImageGrey8& b) {
    size_t both = 0, either = 0;
    for (size_t i = 0; i < a.pixels.size(); ++i) {
        const bool inA = isPerson(a.pixels[i]), inB = isPerson(b.pixels[i]);
        both += inA && inB, either += inA || inB;
    }
    return either ? double(both) / double(either) : 0;
}

ImageGrey8 toStoredPixels(const ImageGrey8& mask, const ScanFrame& frame) {
    if (!frame.lens.any()) return mask;
    std::vector<cv::Point2f> stored, pinhole;
    for (uint32_t y = 0; y < mask.heightPx; ++y)
        for (uint32_t x = 0; x < mask.widthPx; ++x) stored.emplace_back(float(x), float(y));
    const auto k = opencvIntrinsics(frame.camera);
    cv::undistortPoints(stored, pinhole, k, opencvLens(frame.lens), cv::noArray(), k);
    const cv::Mat map(int(mask.heightPx), int(mask.widthPx), CV_32FC2, pinhole.data());
    const cv::Mat in(int(mask.heightPx), int(mask.widthPx), CV_8U, const_cast<uint8_t*>(mask.pixels.data()));
    cv::Mat out;
    cv::remap(in, out, map, cv::noArray(), cv::INTER_LINEAR, cv::BORDER_CONSTANT, cv::Scalar::all(0));
    return takePixels<ImageGrey8>(out);
}

Result<FramePicture> readFramePicture(const ScanFrame& frame) {
    if (frame.maskPath.empty())
        return fail(Code::NotFound, "frame '{}' has no mask; add masks/{}.png, or let networks find the person: {}", frame.name, frame.name,
                    howToGetNetworks());
    FramePicture picture;
    DPL_TRY(picture.image, readFrameImage(frame));
    DPL_TRY(picture.mask, readFrameMask(frame));
    picture.maskFound = frame.maskFound;
    if (!frame.labelsPath.empty()) {
        DPL_TRY(picture.labels, readFrameLabels(frame));
    }
    return picture;
}

namespace {

/** The keypoints of a frame's file in the order of `names`. `ordered`: a file without names holds just these; else it holds none. */
Result<std::vector<Keypoint>> readNamedKeypoints(const ScanFrame& frame, std::span<const std::string> names, bool ordered) {
    std::vector<Keypoint> keypoints(names.size());
    DPL_TRY(const json file, readJsonObject(frame.keypointsPath));
    const std::string where = frame.keypointsPath.string();
    JsonFields fields(file, where);
    // "xy_noisy" is the name of "detections" in older scans. "xy" holds the true positions of synthetic scans and is never read.
    const char* key = fields.has("xy_noisy") && !fields.has("detections") ? "xy_noisy" : "detections";
    DPL_TRY(const json* positions, fields.array(key));
    // The order is that of the file's own names, or of the scan when the file has none.
    std::vector<size_t> slot(positions->size(), SIZE_MAX);
    if (fields.has("names")) {
        DPL_TRY(const json* own, fields.array("names"));
        if (own->size() != positions->size())
            return fail(Code::CorruptData, "{}: {} names for {} keypoints; write the file again", where, own->size(), positions->size());
        std::map<std::string, size_t> order;
        for (size_t k = 0; k < names.size(); ++k) order[names[k]] = k;
        for (size_t i = 0; i < own->size(); ++i) {
            if (!(*own)[i].is_string()) return fail(Code::CorruptData, "{}: 'names' holds something that is not text; correct it", where);
            const auto found = order.find((*own)[i].get<std::string>());
            if (found != order.end()) slot[i] = found->second;
        }
    } else if (ordered) {
        if (positions->size() != names.size())
            return fail(Code::CorruptData, "{}: {} keypoints, the scan has {} names; write the file again", where, positions->size(),
                        names.size());
        for (size_t i = 0; i < slot.size(); ++i) slot[i] = i;
    }
    std::vector<double> confidence(positions->size(), 1.0);
    if (fields.has("confidence")) {
        DPL_TRY(confidence, fields.numbers("confidence", positions->size()));
    }
    for (size_t i = 0; i < positions->size(); ++i) {
        const json& p = (*positions)[i];
        if (slot[i] == SIZE_MAX || p.is_null()) continue;
        const bool good = p.is_array() && p.size() == 2 && p[0].is_number() && p[1].is_number();
        if (!good) return fail(Code::CorruptData, "{}: keypoint {} is not [x, y]; write the file again", where, i);
        Keypoint& k = keypoints[slot[i]];
        k.px = {p[0].get<double>(), p[1].get<double>()};
        k.confidence = std::clamp(confidence[i], 0.0, 1.0);
        if (!(std::abs(k.px.x) < 1e6 && std::abs(k.px.y) < 1e6)) k = {};  // a point this far out was projected from behind the camera
    }
    if (frame.lens.any()) {
        for (Keypoint& k : keypoints) {
            if (k.confidence <= 0) continue;
            std::vector<cv::Point2d> in{{k.px.x - 0.5, k.px.y - 0.5}}, out;
            const auto intrinsics = opencvIntrinsics(frame.camera);
            cv::undistortPoints(in, out, intrinsics, opencvLens(frame.lens), cv::noArray(), intrinsics);
            k.px = {out[0].x + 0.5, out[0].y + 0.5};
        }
    }
    return keypoints;
}

}  // namespace

Result<std::vector<Keypoint>> readKeypoints(const Scan& scan, const ScanFrame& frame) {
    if (frame.keypointsPath.empty() || scan.keypointNames.empty()) return std::vector<Keypoint>();
    return readNamedKeypoints(frame, scan.keypointNames, /*ordered=*/true);
}

std::span<const std::string_view> handKeypointNames() {
    static constexpr std::array<std::string_view, 2 * kHandPoints> kNames = {
        "thumb1_l",  "thumb2_l",  "thumb3_l", "thumb4_l", "index1_l", "index2_l", "index3_l", "index4_l", "middle1_l", "middle2_l",
        "middle3_l", "middle4_l", "ring1_l",  "ring2_l",  "ring3_l",  "ring4_l",  "pinky1_l", "pinky2_l", "pinky3_l",  "pinky4_l",
        "thumb1_r",  "thumb2_r",  "thumb3_r", "thumb4_r", "index1_r", "index2_r", "index3_r", "index4_r", "middle1_r", "middle2_r",
        "middle3_r", "middle4_r", "ring1_r",  "ring2_r",  "ring3_r",  "ring4_r",  "pinky1_r", "pinky2_r", "pinky3_r",  "pinky4_r"};
    return kNames;
}

int32_t handKeypointNamed(std::string_view name) {
    const auto names = handKeypointNames();
    const auto found = std::find(names.begin(), names.end(), name);
    return found == names.end() ? -1 : int32_t(found - names.begin());
}

Result<std::vector<Keypoint>> readHandKeypoints(const Scan& scan, const ScanFrame& frame) {
    if (frame.keypointsPath.empty() || scan.keypointNames.empty()) return std::vector<Keypoint>();
    const std::vector<std::string> names{handKeypointNames().begin(), handKeypointNames().end()};
    DPL_TRY(auto keypoints, readNamedKeypoints(frame, names, /*ordered=*/false));
    if (std::none_of(keypoints.begin(), keypoints.end(), [](const Keypoint& k) { return k.confidence > 0; })) keypoints.clear();
    return keypoints;
}

}  // namespace dpl
