// SPDX-License-Identifier: Apache-2.0
// A subject of the NeuMan data set. Follows github.com/apple/ml-neuman (data_io/neuman_helper.py, data_io/colmap_helper.py,
// preprocess/gen_run.py). One phone video; every tenth frame, undistorted: images/00000.png; a COLMAP model as text in sparse/;
// segmentations/00000.png, in which the person is 0 and everything else 255; keypoints/00000.png.npy, 17 rows (COCO's order) of x, y and
// confidence in pixels. Scale, origin and up of the world are COLMAP's.
//
// A fifth of the frames, evenly spaced, is not trained on: the first half of these is the test split, the second the validation split.
// train_split.txt and test_split.txt, where they exist, say the same with one file name a line.
#include "reconstruction/input/import/neuman.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "reconstruction/base/npz.h"
#include "reconstruction/input/cameras/colmap_model.h"
#include "reconstruction/input/capture/picture_size.h"
#include "reconstruction/input/capture/scan_readers.h"
#include "reconstruction/input/import/readers.h"
#include "sdk/core/files.h"

namespace dpl {

namespace fs = std::filesystem;

namespace {

constexpr double kFrameS = 1.0 / 3;  // every tenth frame of 30 a second
constexpr size_t kCocoKeypoints = 17;
constexpr uint64_t kMaxListBytes = 4u << 20;
constexpr uint64_t kMaxKeypointBytes = 1u << 20;

std::vector<std::string> cocoNames() {
    return {"nose",    "eye_l",   "eye_r", "ear_l", "ear_r",  "shoulder_l", "shoulder_r", "elbow_l", "elbow_r",
            "wrist_l", "wrist_r", "hip_l", "hip_r", "knee_l", "knee_r",     "ankle_l",    "ankle_r"};
}

/** The splits of the two lists in `root`, or of the published rule. Frames of neither list are missing in the result. */
Result<std::map<std::string, Split>> splitsOf(const fs::path& root, const std::vector<ColmapImage>& images) {
    std::map<std::string, Split> splits;
    std::error_code ignored;
    const fs::path train = root / "train_split.txt", test = root / "test_split.txt";
    if (!fs::exists(train, ignored) && !fs::exists(test, ignored)) {
        const std::vector<NeumanSplit> rule = neumanSplits(images.size());
        for (size_t i = 0; i < images.size(); ++i)
            if (rule[i] != NeumanSplit::Validation) splits[images[i].name] = rule[i] == NeumanSplit::Test ? Split::Test : Split::Train;
        return splits;
    }
    for (const auto& [list, split] : {std::pair{train, Split::Train}, {test, Split::Test}}) {
        DPL_TRY(const auto bytes, readFile(list, kMaxListBytes));
        DPL_TRY(const auto names, parseNeumanList({reinterpret_cast<const char*>(bytes.data()), bytes.size()}, list.string()));
        for (const std::string& name : names) {
            if (std::none_of(images.begin(), images.end(), [&](const ColmapImage& image) { return image.name == name; }))
                return fail(Code::CorruptData, "{}: '{}' is not a picture of the model in sparse/; correct the list", list.string(), name);
            if (!splits.emplace(name, split).second)
                return fail(Code::CorruptData, "{}: '{}' is listed twice, or in both splits; correct the list", list.string(), name);
        }
    }
    return splits;
}

Result<std::vector<Keypoint>> readCocoKeypoints(const fs::path& file) {
    DPL_TRY(const auto bytes, readFile(file, kMaxKeypointBytes));
    return parseNeumanKeypoints(bytes, file.string());
}

}  // namespace

std::vector<NeumanSplit> neumanSplits(size_t frames) {
    std::vector<NeumanSplit> splits(frames, NeumanSplit::Train);
    const size_t untrained = frames / 5;
    if (untrained == 0) return splits;
    const auto every = size_t(1.0 / double(untrained) * double(frames));  // as published, with its rounding
    std::vector<size_t> chosen;
    for (size_t i = every / 2; i < frames; i += every) chosen.push_back(i);
    for (size_t i = 0; i < chosen.size(); ++i) splits[chosen[i]] = i < chosen.size() / 2 ? NeumanSplit::Test : NeumanSplit::Validation;
    return splits;
}

Result<std::vector<std::string>> parseNeumanList(std::string_view text, const std::string& where) {
    std::vector<std::string> names;
    while (!text.empty()) {
        const size_t end = std::min(text.find('\n'), text.size());
        std::string_view line = text.substr(0, end);
        text.remove_prefix(std::min(end + 1, text.size()));
        while (!line.empty() && (line.back() == '\r' || line.back() == ' ')) line.remove_suffix(1);
        if (line.empty()) continue;
        if (!isSafeName(line))
            return fail(Code::CorruptData, "{}: line {} is not the name of a picture; write one file name a line", where, names.size() + 1);
        if (names.size() >= kMaxFrames) return fail(Code::Unsupported, "{}: more than {} names; remove some", where, kMaxFrames);
        names.emplace_back(line);
    }
    return names;
}

Result<std::vector<Keypoint>> parseNeumanKeypoints(std::span<const uint8_t> bytes, const std::string& where) {
    const auto array = parseNpy(bytes, 3 * kCocoKeypoints);
    if (!array) return fail(array.error().code, "{}: {}; save it again with numpy.save, 17 x 3 numbers", where, array.error().message);
    if (array->shape != std::vector<size_t>{kCocoKeypoints, 3})
        return fail(Code::CorruptData, "{}: {} numbers where 17 x 3 are wanted (x, y, confidence); remove the keypoints of other people",
                    where, array->values.size());
    std::vector<Keypoint> keypoints;
    for (size_t k = 0; k < kCocoKeypoints; ++k) {
        const double *row = &array->values[3 * k], limit = 1e6;
        if (!(std::abs(row[0]) <= limit && std::abs(row[1]) <= limit && row[2] >= 0 && row[2] <= limit))
            return fail(Code::CorruptData, "{}: keypoint {} is not a place in a picture with a confidence; detect it again", where, k);
        keypoints.push_back({{row[0], row[1]}, std::min(row[2], 1.0)});
    }
    return keypoints;
}

bool isNeuman(const fs::path& folder) {
    std::error_code ignored;
    return fs::is_directory(folder / "images", ignored) && fs::is_directory(folder / "segmentations", ignored) &&
           !findColmapModel(folder).empty();
}

Result<Capture> readNeuman(const fs::path& root) {
    DPL_TRY(const auto images, readColmapModel(findColmapModel(root)));
    DPL_TRY(const auto splits, splitsOf(root, images));
    Capture capture;
    capture.what = "NeuMan subject";
    capture.protocol = "neuman";
    capture.metricWorld = false;
    capture.splitStated = true;
    size_t withKeypoints = 0, left = 0;
    for (size_t i = 0; i < images.size(); ++i) {
        const ColmapImage& image = images[i];
        const auto split = splits.find(image.name);
        if (split == splits.end()) {
            ++left;
            continue;
        }
        if (!isSafeName(image.name))
            return fail(Code::CorruptData, "{}: '{}' is not the name of a picture in images/; export the model again",
                        (root / "sparse").string(), image.name.substr(0, 200));
        CapturePicture picture;
        picture.kind = FrameKind::Dynamic;
        picture.name = frameName(picture.kind, i);
        picture.split = split->second;
        picture.timeS = kFrameS * double(i);
        DPL_TRY(picture.image, fileInside(root / "images", image.name, "images.txt"));
        DPL_TRY(picture.mask, fileInside(root / "segmentations", image.name, "the mask of " + image.name));
        picture.maskShowsBackground = true;
        picture.camera = image.camera;
        picture.lens = image.lens;
        DPL_TRY(const ImageHeader header, probeImage(picture.image));
        DPL_RETURN_IF_ERROR(fitToPicture(*picture.camera, header, picture.image, (root / "sparse").string()));
        std::error_code ignored;
        if (const fs::path file = root / "keypoints" / (image.name + ".npy"); fs::exists(file, ignored)) {
            DPL_TRY(picture.keypoints, readCocoKeypoints(file));
            ++withKeypoints;
        }
        capture.pictures.push_back(std::move(picture));
    }
    const auto held = std::count_if(capture.pictures.begin(), capture.pictures.end(),
                                    [](const CapturePicture& picture) { return picture.split == Split::Test; });
    if (held == 0 || size_t(held) == capture.pictures.size())
        return fail(Code::CorruptData, "{}: {} of {} frames are for testing; the protocol needs some of both, from at least ten frames",
                    root.string(), held, capture.pictures.size());
    // All frames or none: networks find keypoints only for scans without any.
    if (withKeypoints == capture.pictures.size())
        capture.keypointNames = cocoNames();
    else
        for (CapturePicture& picture : capture.pictures) picture.keypoints.clear();
    capture.notes.push_back(formatText("{} frames are held out for the test, {} of the validation split are left out", held, left));
    capture.notes.push_back("frames are taken to be a third of a second apart, as in the published data");
    if (capture.keypointNames.empty()) capture.notes.push_back("not every frame has keypoints/NAME.npy; networks will find keypoints");
    return capture;
}

}  // namespace dpl
