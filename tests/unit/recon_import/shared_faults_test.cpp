// SPDX-License-Identifier: Apache-2.0
// The captures of shared/data/faults, rebuilt from public reports, give what people expect. Each kind also has made inputs in other tests.
#include "reconstruction/base/program.h"
#include "reconstruction/input/import/import.h"
#include "tests/unit/recon_import/made_captures.h"
#include "tests/unit/shared_data.h"

namespace dpl {
namespace {

namespace fs = std::filesystem;

struct Fault {
    const char* input;
    size_t frames;                          // 0: refused
    std::vector<std::string> said;          // by the summary, or by the refusal
    uint32_t widthPx = 96, heightPx = 128;  // of the first frame
};

class SharedFaults : public ::testing::TestWithParam<Fault> {};

TEST_P(SharedFaults, giveWhatIsRight) {
    const Fault& fault = GetParam();
    const auto data = sharedData(fs::path("faults") / fault.input);
    if (!data) GTEST_SKIP() << "shared data (faults/" << fault.input << ") is not on this machine";
    if (data->has_extension() && !(findProgram("ffmpeg") && findProgram("ffprobe"))) GTEST_SKIP() << "the program ffmpeg is not installed";
    TemporaryFolder folder;
    ImportOptions options;
    options.source = *data, options.out = folder.path / "scan";
    const auto done = importCapture(options, nullptr, {});
    const std::string text = done ? done->summary : done.error().message;
    for (const std::string& words : fault.said) EXPECT_NE(text.find(words), std::string::npos) << words << " is not in: " << text;
    ASSERT_EQ(bool(done), fault.frames > 0) << text;
    if (!done) return;
    const auto scan = readScan(options.out, ScanCameras::MayLack);
    ASSERT_TRUE(scan) << scan.error().message;
    EXPECT_TRUE(data->has_extension() || scan->frames.size() == fault.frames) << scan->frames.size();
    const auto image = readFrameImage(scan->frames[0]);
    ASSERT_TRUE(image) << image.error().message;
    EXPECT_EQ(image->widthPx, fault.widthPx);
    EXPECT_EQ(image->heightPx, fault.heightPx);
}

INSTANTIATE_TEST_SUITE_P(
    All, SharedFaults,
    ::testing::Values(Fault{"polycam-nosize", 9, {"corrected by Polycam"}},
                      Fault{"polycam-partly", 9, {"7 of 9 keyframes are taken uncorrected", "keyframes/corrected_cameras"}},
                      Fault{"colmap-two-models", 7, {"sparse/1 (7 images) is taken", "sparse/0 (2 images)"}},
                      Fault{"colmap-no-point-lines", 9, {}}, Fault{"colmap-missing-one", 8, {"1 of 9 pictures are left out: full_003.jpg"}},
                      Fault{"colmap-chinese", 9, {}}, Fault{"colmap-dense", 9, {}},
                      Fault{"colmap-half-size", 9, {"the camera is scaled"}, 48, 64},
                      Fault{"ns-is-fisheye", 0, {"'is_fisheye'", "colmap image_undistorter"}}, Fault{"ns-backslash", 9, {}},
                      Fault{"82-png-exif", 4, {}}, Fault{"84b-cmyk", 8, {"1 pictures are converted from CMYK to sRGB"}},
                      Fault{"86-alpha-palette", 4, {}}, Fault{"sar.mp4", 1, {"540 x 360 pixels that are not square"}, 540, 720},
                      Fault{"late.mkv", 1, {}, 270, 360}),
    [](const auto& info) {
        std::string name = info.param.input;
        for (char& c : name)
            if (!std::isalnum(static_cast<unsigned char>(c))) c = '_';
        return name;
    });

TEST(SharedFaultsOfPictures, palettesGiveMasks) {
    const auto data = sharedData("faults/86-alpha-palette");
    if (!data) GTEST_SKIP() << "shared data (faults/86-alpha-palette) is not on this machine";
    TemporaryFolder folder;
    ImportOptions options;
    options.source = *data, options.out = folder.path / "scan";
    ASSERT_TRUE(importCapture(options, nullptr, {}));
    const auto scan = readScan(options.out, ScanCameras::MayLack);
    ASSERT_TRUE(scan) << scan.error().message;
    for (const ScanFrame& frame : scan->frames) {
        const auto mask = readFrameMask(frame);
        ASSERT_TRUE(mask) << mask.error().message;
        const auto people = std::count_if(mask->pixels.begin(), mask->pixels.end(), [](uint8_t v) { return v >= 128; });
        EXPECT_GT(people, 96 * 128 / 20);
        EXPECT_LT(people, 96 * 128 / 2);
    }
}

}  // namespace
}  // namespace dpl
