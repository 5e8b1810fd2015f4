// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/input/import/write_scan.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <opencv2/imgproc.hpp>

#include "reconstruction/base/image_file.h"
#include "reconstruction/input/capture/scan_readers.h"
#include "reconstruction/input/import/exif.h"
#include "reconstruction/input/import/turn.h"
#include "sdk/core/files.h"

namespace dpl {

namespace fs = std::filesystem;
using nlohmann::json;

namespace {

constexpr int kJpegQuality = 95;             // of pictures that had to be turned or reduced
constexpr uint8_t kGrey = 128;               // behind pixels that alpha makes fully transparent
using Size = std::pair<uint32_t, uint32_t>;  // width and height, px

bool isJpeg(const std::vector<uint8_t>& bytes) {
    return bytes.size() >= 2 && bytes[0] == 0xff && bytes[1] == 0xd8;
}
/** Whether a PNG has an alpha channel (byte 25 is the colour type) or transparent colours. */
bool hasAlpha(const std::vector<uint8_t>& bytes) {
    return !isJpeg(bytes) && bytes.size() > 25 && (bytes[25] == 4 || bytes[25] == 6 || !pngChunk(bytes, "tRNS").empty());
}

template <class T>
Result<T> naming(const fs::path& path, Result<T> result) {
    if (result) return result;
    return fail(result.error().code, "{}: {}; copy or export the picture again", path.string(), result.error().message);
}

/** Colour over grey where it is fully transparent, and alpha as a mask of one channel. Half-transparent pixels keep their own colour, so
 *  that no background is mixed into the outline. */
void splitAlpha(const Picture& rgba, Picture& colour, Picture& mask) {
    colour = {rgba.widthPx, rgba.heightPx, 3, std::vector<uint8_t>(rgba.pixels.size() / 4 * 3)};
    mask = {rgba.widthPx, rgba.heightPx, 1, std::vector<uint8_t>(rgba.pixels.size() / 4)};
    for (size_t i = 0; i < mask.pixels.size(); ++i) {
        const uint8_t alpha = mask.pixels[i] = rgba.pixels[4 * i + 3];
        for (size_t c = 0; c < 3; ++c) colour.pixels[3 * i + c] = alpha == 0 ? kGrey : rgba.pixels[4 * i + c];
    }
}

json cameraJson(const Camerad& camera, const LensDistortion& lens) {
    // The file's world is z-up and faces −y: P_file = (x, −z, y), so the columns of R are x, −z, y.
    const Mat3d& r = camera.viewFromWorldRotation;
    const Vec3d columns[3] = {r[0], -r[2], r[1]};
    json rotation = json::array(), out;
    for (int row = 0; row < 3; ++row)
        for (const Vec3d& column : columns) rotation.push_back(column[row]);
    const Vec3d& t = camera.viewFromWorldTranslation;
    out = {{"fx", camera.fx}, {"fy", camera.fy}, {"cx", camera.cx}, {"cy", camera.cy}, {"R", rotation}, {"t", {t.x, t.y, t.z}}};
    if (lens.any()) out["distortion"] = {lens.k1, lens.k2, lens.p1, lens.p2};
    return out;
}

/** The mask of a picture that shows the background: its first channel, inverted. */
Picture invertedMask(const Picture& stored) {
    Picture mask{stored.widthPx, stored.heightPx, 1, std::vector<uint8_t>(size_t(stored.widthPx) * stored.heightPx)};
    for (size_t i = 0; i < mask.pixels.size(); ++i) mask.pixels[i] = uint8_t(255 - stored.pixels[i * stored.channels]);
    return mask;
}

json keypointsJson(const std::vector<std::string>& names, const std::vector<Keypoint>& keypoints) {
    json detections = json::array(), confidence = json::array();
    for (const Keypoint& k : keypoints) detections.push_back({k.px.x, k.px.y}), confidence.push_back(k.confidence);
    return {{"names", names}, {"detections", detections}, {"confidence", confidence}};
}

/** The turn that makes a picture upright. Where the world's up is arbitrary, pictures with a camera stay as they are. */
Turn turnOf(const Capture& capture, const CapturePicture& picture, const std::vector<uint8_t>& bytes) {
    if (!picture.camera) return turnOfExif(readExif(bytes).orientation);
    return capture.metricWorld ? uprightTurn(*picture.camera) : Turn{};
}

/** The size that a picture of this size has as a frame. */
Size reducedSize(const Capture& capture, Size size) {
    const uint32_t longSide = std::max(size.first, size.second);
    if (capture.longSidePx == 0 || longSide <= capture.longSidePx) return size;
    const auto shrink = [&](uint32_t side) {
        return std::max<uint32_t>(1, uint32_t(std::lround(double(side) * capture.longSidePx / longSide)));
    };
    return {shrink(size.first), shrink(size.second)};
}

Picture reduced(Picture picture, Size size) {
    if (Size{picture.widthPx, picture.heightPx} == size) return picture;
    Picture out{size.first, size.second, picture.channels, std::vector<uint8_t>(size_t(size.first) * size.second * picture.channels)};
    const int type = CV_8UC(int(picture.channels));
    cv::Mat small(int(size.second), int(size.first), type, out.pixels.data());
    cv::resize(cv::Mat(int(picture.heightPx), int(picture.widthPx), type, picture.pixels.data()), small, small.size(), 0, 0,
               cv::INTER_AREA);
    return out;
}

/** Size of the picture as a frame: upright, and reduced where it is too large. */
Result<Size> frameSize(const Capture& capture, const CapturePicture& picture) {
    DPL_TRY(const ImageHeader header, probeImage(picture.image));
    std::vector<uint8_t> bytes;
    if (!picture.camera) {
        DPL_TRY(bytes, readFile(picture.image, kMaxFileBytes));
    }
    const Turn turn = turnOf(capture, picture, bytes);
    return reducedSize(capture, turn.quarters % 2 == 0 ? Size{header.widthPx, header.heightPx} : Size{header.heightPx, header.widthPx});
}

/** A file of the scan folder. */
struct FrameFile {
    const char *folder, *key;  // "images", and its key in the frame's entry
    std::string name;
    std::vector<uint8_t> bytes;
};

class ScanWriter {
public:
    ScanWriter(const Capture& capture, const fs::path& folder, Size shared) : capture_(capture), folder_(folder), shared_(shared) {}

    /** Reads a picture with all that belongs to it and makes the files of its frame. Errors are the picture's. */
    Status prepare(const CapturePicture& picture) {
        files_.clear();
        DPL_TRY(const auto bytes, readCompleteImage(picture.image));
        const Turn turn = turnOf(capture_, picture, bytes);
        entry_ = {{"name", picture.name}, {"kind", frameKindName(picture.kind)}};
        DPL_RETURN_IF_ERROR(preparePicture(picture, bytes, turn));
        if (!picture.mask.empty()) DPL_RETURN_IF_ERROR(prepareMask(picture, turn));
        if (!picture.keypoints.empty()) DPL_RETURN_IF_ERROR(prepareKeypoints(picture, turn));
        if (picture.kind == FrameKind::Dynamic || picture.timeS != 0) entry_["time"] = picture.timeS;
        if (!picture.closeupOf.empty()) entry_["closeup_of"] = picture.closeupOf;
        if (picture.camera) {
            Camerad camera = *picture.camera;
            LensDistortion lens = picture.lens;
            turnCamera(camera, lens, turn);
            entry_["camera"] = cameraJson(camera, lens);
            if (Size{camera.widthPx, camera.heightPx} != shared_) entry_["image_size"] = {camera.widthPx, camera.heightPx};
        }
        return {};
    }

    /** Writes the files of the prepared frame. */
    Result<json> write() {
        for (const FrameFile& file : files_) {
            std::error_code error;
            fs::create_directories(folder_ / file.folder, error);
            entry_[file.key] = std::string(file.folder) + "/" + file.name;
            DPL_RETURN_IF_ERROR(writeFileAtomically(folder_ / file.folder / file.name, file.bytes));
        }
        entry_["id"] = next_++;
        if (!colours_.converted.empty()) ++converted_[colours_.converted];
        if (!colours_.unread.empty()) ++unread_[colours_.unread];
        return std::move(entry_);
    }

    /** What was done to the colours of the written pictures. */
    void noteColours(std::vector<std::string>& notes) const {
        for (const auto& [space, count] : converted_)
            notes.push_back(formatText("{} pictures are converted from {} to sRGB{}", count, space,
                                       space == "CMYK" ? ", without a profile: their colours are near, not exact" : ""));
        for (const auto& [space, count] : unread_)
            notes.push_back(formatText("{} pictures state {}, which is not read: their colours are taken for sRGB", count, space));
    }

private:
    Status preparePicture(const CapturePicture& picture, const std::vector<uint8_t>& bytes, Turn turn) {
        const bool jpeg = isJpeg(bytes), alpha = hasAlpha(bytes) && picture.mask.empty();
        DPL_TRY(Picture stored,
                naming(picture.image, decodePicture(bytes, alpha ? PictureChannels::Rgba : PictureChannels::Rgb, &colours_)));
        const Size asStored = {stored.widthPx, stored.heightPx};
        const std::string file = picture.name + (jpeg ? ".jpg" : ".png");
        if (turn.none() && !alpha && colours_.converted.empty() && reducedSize(capture_, asStored) == asStored) {
            files_.push_back({"images", "image", file, bytes});
            return {};
        }
        Picture upright = turned(stored, turn);
        const Size size = reducedSize(capture_, {upright.widthPx, upright.heightPx});
        if (upright.channels == 4) {
            Picture colour, mask;
            splitAlpha(upright, colour, mask);
            upright = std::move(colour), mask = reduced(std::move(mask), size);
            if (std::any_of(mask.pixels.begin(), mask.pixels.end(), [](uint8_t value) { return value != 255; })) {
                DPL_TRY(auto maskBytes, encodePng(mask.pixels, mask.widthPx, mask.heightPx, 1));
                files_.push_back({"masks", "mask", picture.name + ".png", std::move(maskBytes)});
            }
        }
        upright = reduced(std::move(upright), size);
        DPL_TRY(auto encoded, jpeg ? encodeJpeg(upright.pixels, upright.widthPx, upright.heightPx, upright.channels, kJpegQuality)
                                   : encodePng(upright.pixels, upright.widthPx, upright.heightPx, upright.channels));
        files_.push_back({"images", "image", file, std::move(encoded)});
        return {};
    }

    Status prepareMask(const CapturePicture& picture, Turn turn) {
        DPL_TRY(auto bytes, readCompleteImage(picture.mask));
        DPL_TRY(Picture stored, naming(picture.mask, decodePicture(bytes, PictureChannels::AsStored)));
        if (turn.none() && !picture.maskShowsBackground) {
            files_.push_back({"masks", "mask", picture.name + (isJpeg(bytes) ? ".jpg" : ".png"), std::move(bytes)});
            return {};
        }
        if (picture.maskShowsBackground) stored = invertedMask(stored);
        const Picture upright = turned(stored, turn);
        DPL_TRY(auto encoded, encodePng(upright.pixels, upright.widthPx, upright.heightPx, upright.channels));
        files_.push_back({"masks", "mask", picture.name + ".png", std::move(encoded)});
        return {};
    }

    Status prepareKeypoints(const CapturePicture& picture, Turn turn) {
        if (!turn.none()) return fail(Code::Unsupported, "{}: keypoints of turned pictures are not read", picture.image.string());
        const std::string text = keypointsJson(capture_.keypointNames, picture.keypoints).dump();
        files_.push_back({"keypoints", "keypoints", picture.name + ".json", {text.begin(), text.end()}});
        return {};
    }

    const Capture& capture_;
    fs::path folder_;
    Size shared_;
    size_t next_ = 0;
    json entry_;  // of the prepared frame
    std::vector<FrameFile> files_;
    PictureColours colours_;
    std::map<std::string, size_t> converted_, unread_;  // colour space -> pictures
};

/** Without cameras: leaves out pictures of another size than most. A kind of which nothing remains is refused. */
Status keepOneSize(Capture& capture, const std::vector<Size>& sizes, Size shared) {
    std::map<FrameKind, Size> lost;
    std::map<FrameKind, size_t> kept;
    std::vector<CapturePicture> remaining;
    for (size_t i = 0; i < sizes.size(); ++i) {
        if (sizes[i] == shared) {
            ++kept[capture.pictures[i].kind];
            remaining.push_back(std::move(capture.pictures[i]));
        } else {
            lost.emplace(capture.pictures[i].kind, sizes[i]);
        }
    }
    for (const auto& [kind, size] : lost)
        if (kept[kind] == 0)
            return fail(
                Code::InvalidArgument,
                "pictures of the {} are {} x {} pixels and all others {} x {}; film everything with one lens, in one resolution and the "
                "phone held the same way",
                kind == FrameKind::StaticFull      ? "walk round the subject"
                : kind == FrameKind::StaticCloseup ? "close-ups"
                                                   : "motion",
                size.first, size.second, shared.first, shared.second);
    if (const size_t left = sizes.size() - remaining.size(); left > 0)
        capture.notes.push_back(formatText("{} of {} pictures are not {} x {} pixels as most are, and are left out", left, sizes.size(),
                                           shared.first, shared.second));
    capture.pictures = std::move(remaining);
    return {};
}

Status checkProgress(const ImportProgress& progress, double share, const std::string& what) {
    if (progress && !progress(share, what)) return fail(Code::Cancelled, "stopped; nothing was written");
    return {};
}

}  // namespace

Status writeScan(Capture& capture, const std::string& name, double heightM, const fs::path& folder, const ImportProgress& progress) {
    const size_t all = capture.pictures.size();
    LeftOut left;
    // A published protocol compares scores of its own frames, so none of them may be missing.
    const auto leaveOut = [&](const CapturePicture& picture, const Error& why) -> Status {
        if (!capture.protocol.empty() || why.code == Code::Io || why.code == Code::OutOfMemory) return why;
        left.add(picture.image.filename(), why);
        return {};
    };
    std::vector<Size> sizes;
    std::map<Size, size_t> counts;
    std::vector<CapturePicture> readable;
    for (CapturePicture& picture : capture.pictures) {
        DPL_RETURN_IF_ERROR(checkProgress(progress, 0, "looking at the pictures"));
        const auto size = frameSize(capture, picture);
        if (!size) {
            DPL_RETURN_IF_ERROR(leaveOut(picture, size.error()));
            continue;
        }
        sizes.push_back(*size);
        ++counts[*size];
        readable.push_back(std::move(picture));
    }
    capture.pictures = std::move(readable);
    DPL_RETURN_IF_ERROR(left.check(sizes.size()));
    if (sizes.empty()) return fail(Code::CorruptData, "the capture has no picture");
    const Size shared =
        std::max_element(counts.begin(), counts.end(), [](const auto& a, const auto& b) { return a.second < b.second; })->first;
    const bool known = capture.pictures.front().camera.has_value();
    if (!known) DPL_RETURN_IF_ERROR(keepOneSize(capture, sizes, shared));

    ScanWriter writer(capture, folder, shared);
    json frames = json::array();
    std::vector<CapturePicture> written;
    for (size_t i = 0; i < capture.pictures.size(); ++i) {
        CapturePicture& picture = capture.pictures[i];
        const double share = double(i) / double(capture.pictures.size());
        DPL_RETURN_IF_ERROR(checkProgress(progress, share, formatText("picture {} of {}", i + 1, capture.pictures.size())));
        if (const Status prepared = writer.prepare(picture); !prepared) {
            DPL_RETURN_IF_ERROR(leaveOut(picture, prepared.error()));
            continue;
        }
        DPL_TRY(json entry, writer.write());
        if (capture.splitStated) entry["split"] = splitName(picture.split);
        frames.push_back(std::move(entry));
        written.push_back(std::move(picture));
    }
    capture.pictures = std::move(written);
    DPL_RETURN_IF_ERROR(left.check(capture.pictures.size()));
    if (!left.empty()) capture.notes.push_back(left.sentence(all));
    writer.noteColours(capture.notes);
    json manifest = {{"format", "avatar-scan"},   {"version", 1},      {"name", name},
                     {"source", capture.what},    {"units", "metres"}, {"image_size", {shared.first, shared.second}},
                     {"camera_model", "pinhole"}, {"frames", frames}};
    if (known && !capture.metricWorld) manifest["metric"] = capture.unitStated ? json(false) : json(), manifest["units"] = "arbitrary";
    if (!known && capture.focalGuessPx > 0) manifest["focal_px"] = capture.focalGuessPx;
    if (!capture.protocol.empty()) manifest["protocol"] = capture.protocol;
    if (!capture.keypointNames.empty()) manifest["keypoint_names"] = capture.keypointNames;
    if (heightM > 0) manifest["subject_height"] = heightM;
    return writeFileAtomically(folder / "scan.json", manifest.dump(1));
}

}  // namespace dpl
