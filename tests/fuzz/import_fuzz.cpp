// SPDX-License-Identifier: Apache-2.0
// Fuzz target of the readers of captures: transforms.json, Polycam, Record3D, zip and npz archives, NumPy arrays, lists of NeuMan, pictures
// with their EXIF, Qualisys and Pose2Sim calibrations. No input may crash, and none may take more than 64 times its size and 64 MiB. The
// first bytes choose the reader, so that mutations of one kind of file mostly reach its reader.
#include <cstdio>
#include <cstdlib>
#include <nlohmann/json.hpp>
#include <string_view>

#include "reconstruction/base/image_file.h"
#include "reconstruction/base/npz.h"
#include "reconstruction/input/capture/scan_readers.h"
#include "reconstruction/input/import/calibration.h"
#include "reconstruction/input/import/exif.h"
#include "reconstruction/input/import/neuman.h"
#include "reconstruction/input/import/readers.h"
#include "tests/fuzz/memory_watch.h"

namespace {

void mustHold(bool condition, const char* what) {
    if (condition) return;
    std::fprintf(stderr, "fuzz: %s\n", what);
    std::abort();
}

template <class T>
void checkEnd(const dpl::Result<T>& result, size_t size) {
    mustHold(dpl::test::peakMemoryBytes() <= (64ull << 20) + 64 * uint64_t(size), "a reader took more than 64 times its input and 64 MiB");
    mustHold(result || !result.error().message.empty(), "an error without a sentence");
}

/** All cameras of an accepted input are usable. */
void mustBeUsable(const dpl::Camerad& camera) {
    mustHold(camera.fx > 0 && camera.fy > 0 && camera.widthPx > 0 && camera.heightPx > 0, "an accepted camera has no focal length or size");
    const dpl::Vec3d eye = camera.eye();
    mustHold(eye.x == eye.x && eye.y == eye.y && eye.z == eye.z, "an accepted camera is nowhere");
}

void fuzzJson(std::string_view text) {
    dpl::test::startMemoryWatch();
    const auto value = dpl::parseJsonObject(text, "fuzz.json");
    checkEnd(value, text.size());
    if (!value) return;
    dpl::test::startMemoryWatch();
    const auto polycam = dpl::parsePolycamCamera(*value, {96, 128}, "fuzz.json");
    checkEnd(polycam, text.size());
    if (polycam) mustBeUsable(*polycam);
    dpl::test::startMemoryWatch();
    const auto record3d = dpl::parseRecord3d(*value, {96, 128}, "fuzz.json");
    checkEnd(record3d, text.size());
    if (record3d)
        for (const dpl::Camerad& camera : record3d->cameras) mustBeUsable(camera);
    dpl::test::startMemoryWatch();
    dpl::NerfstudioFiles files;
    files.picture = files.mask = [](const std::string& name, const std::string&) -> dpl::Result<std::filesystem::path> {
        return std::filesystem::path(name);
    };
    files.header = [](const std::filesystem::path&) -> dpl::Result<dpl::ImageHeader> { return dpl::ImageHeader{96, 128}; };
    files.decode = false;
    const auto transforms = dpl::parseNerfstudio(*value, "fuzz.json", files);
    checkEnd(transforms, text.size());
    if (transforms)
        for (const dpl::ScanFrame& frame : transforms->frames) mustBeUsable(frame.camera);
}

void fuzzArchive(std::span<const uint8_t> bytes) {
    dpl::test::startMemoryWatch();
    auto npz = dpl::NpzFile::open(bytes);
    checkEnd(npz, bytes.size());
    if (!npz) return;
    std::vector<dpl::NpyArray> arrays;
    for (const char* name : {"a", "b", "c"})
        if (auto array = npz->read(name)) arrays.push_back(std::move(*array));
    checkEnd(npz, bytes.size());
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
    const std::span<const uint8_t> bytes(data, size);
    const std::string_view text(reinterpret_cast<const char*>(data), size);
    dpl::test::startMemoryWatch();
    if (text.starts_with("{")) {
        fuzzJson(text);
    } else if (text.starts_with("PK")) {
        fuzzArchive(bytes);
    } else if (text.starts_with("\x93NUMPY")) {
        const auto keypoints = dpl::parseNeumanKeypoints(bytes, "fuzz.npy");
        checkEnd(keypoints, size);
        if (keypoints) mustHold(keypoints->size() == 17, "another number of keypoints");
    } else if (text.starts_with("0")) {
        const auto names = dpl::parseNeumanList(text, "fuzz.txt");
        checkEnd(names, size);
        if (names)
            for (const std::string& name : *names) mustHold(name.find('/') == std::string::npos, "an accepted name leaves its folder");
    } else if (text.starts_with("<")) {
        const auto cameras = dpl::parseQualisys(text, "fuzz.qca.txt");
        checkEnd(cameras, size);
        if (cameras)
            for (const auto& camera : *cameras) mustBeUsable(camera.camera);
    } else if (text.starts_with("\xff\xd8") || text.starts_with("\x89PNG")) {
        const dpl::ExifFields exif = dpl::readExif(bytes);
        mustHold(exif.orientation >= 1 && exif.orientation <= 8, "an orientation out of range");
        checkEnd(dpl::checkCompleteImage(bytes, "fuzz.jpg"), size);
    } else {
        const auto cameras = dpl::parsePose2sim(text, "fuzz.toml");
        checkEnd(cameras, size);
        if (cameras)
            for (const auto& camera : *cameras) mustBeUsable(camera.camera);
    }
    return 0;
}
