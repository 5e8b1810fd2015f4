// SPDX-License-Identifier: Apache-2.0
// Damaged and hostile files of scanner apps: every one is refused by a sentence that names the file.
#include <functional>

#include "reconstruction/base/zip_file.h"
#include "reconstruction/input/import/import.h"
#include "reconstruction/input/import/readers.h"
#include "tests/unit/made_zip.h"
#include "tests/unit/recon_import/made_captures.h"

namespace dpl {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

std::string refusal(const fs::path& source) {
    ImportOptions options;
    options.source = source;
    options.out = source.string() + "-scan";
    const auto done = importCapture(options, nullptr, {});
    EXPECT_FALSE(fs::exists(options.out.string() + ".partial"));
    return done ? "was imported" : done.error().message;
}

void writePolycam(const fs::path& root, const json& keyframe) {
    for (int i = 0; i < 3; ++i) {
        writeBytes(root / formatText("keyframes/images/{}.jpg", i), jpegOf(spotPicture(128, 96, {64, 48})));
        writeText(root / formatText("keyframes/cameras/{}.json", i), keyframe.dump());
    }
}

TEST(HostilePolycam, refusals) {
    const auto refuse = [](const std::function<void(json&)>& breakIt, std::initializer_list<const char*> words) {
        TemporaryFolder folder;
        json keyframe = polycamKeyframe();
        breakIt(keyframe);
        writePolycam(folder.path / "poly", keyframe);
        const std::string message = refusal(folder.path / "poly");
        EXPECT_TRUE(mentions(message, words));
        EXPECT_TRUE(mentions(message, {"cameras/0.json"}));
    };
    refuse([](json& k) { k.erase("fx"); }, {"'fx'", "missing"});
    refuse([](json& k) { k["fx"] = "100"; }, {"'fx'", "not a finite number"});
    refuse([](json& k) { k["fx"] = 1e9; }, {"field of view"});
    refuse([](json& k) { k["t_12"] = nullptr; }, {"'t_12'"});
    refuse([](json& k) { k["t_01"] = 3; }, {"not a rotation"});
    refuse([](json& k) { k["t_13"] = 1e9; }, {"0.json"});
    refuse([](json& k) { k["width"] = -128; }, {"not a size"});
    refuse([](json& k) { k["width"] = 200; }, {"another shape"});
    refuse([](json& k) { k["width"] = "wide"; }, {"'width'", "not a finite number"});
    refuse([](json& k) { k["height"] = 1e300; }, {"not a size"});
    refuse([](json& k) { k.erase("width"), k["height"] = 70000; }, {"not a size"});
    const auto withoutSize = [](json& k) { k.erase("width"), k.erase("height"); };
    refuse([&](json& k) { withoutSize(k), k["cx"] = 128, k["cy"] = 96; }, {"principal point (128, 96)", "128 x 96", "add the size"});
    refuse([&](json& k) { withoutSize(k), k["cx"] = 48, k["cy"] = 64; }, {"principal point (48, 64)"});
}

TEST(HostilePolycam, foldersWithoutPairs) {
    TemporaryFolder folder;
    writePolycam(folder.path / "poly", polycamKeyframe());
    fs::remove(folder.path / "poly/keyframes/cameras/1.json");
    ImportOptions options;
    options.source = folder.path / "poly";
    options.out = folder.path / "scan";
    const auto done = importCapture(options, nullptr, {});
    ASSERT_TRUE(done) << done.error().message;
    EXPECT_TRUE(mentions(done->summary, {"1 pictures without a camera"}));
    for (const char* name : {"0.json", "2.json"}) fs::remove(folder.path / "poly/keyframes/cameras" / name);
    EXPECT_TRUE(mentions(refusal(folder.path / "poly"), {"no picture has a camera", "developer mode"}));
}

TEST(HostilePolycam, everyTruncationIsRefused) {
    const std::string text = polycamKeyframe().dump();
    for (size_t length = 0; length < text.size(); ++length) EXPECT_TRUE(json::parse(text.substr(0, length), nullptr, false).is_discarded());
    TemporaryFolder folder;
    writePolycam(folder.path / "poly", polycamKeyframe());
    for (int i = 0; i < 3; ++i) writeText(folder.path / formatText("poly/keyframes/cameras/{}.json", i), text.substr(0, text.size() / 2));
    EXPECT_TRUE(mentions(refusal(folder.path / "poly"), {"0.json", "not valid JSON"}));
}

TEST(HostilePolycam, cutPicturesAreRefused) {
    TemporaryFolder folder;
    writePolycam(folder.path / "poly", polycamKeyframe());
    for (int i = 0; i < 3; ++i) {
        const fs::path image = folder.path / formatText("poly/keyframes/images/{}.jpg", i);
        fs::resize_file(image, fs::file_size(image) / 2);
    }
    EXPECT_TRUE(mentions(refusal(folder.path / "poly"), {"0.jpg", "truncated"}));
}

TEST(HostileRecord3d, refusals) {
    const auto refuse = [](const std::function<void(json&)>& breakIt, std::initializer_list<const char*> words) {
        json metadata = record3dMetadata(2);
        breakIt(metadata);
        const auto frames = parseRecord3d(metadata, {128, 96}, "metadata.json");
        ASSERT_FALSE(frames);
        EXPECT_TRUE(mentions(frames.error().message, words));
        EXPECT_TRUE(mentions(frames.error().message, {"metadata.json"}));
    };
    refuse([](json& m) { m["K"].erase(8); }, {"'K'", "8 numbers"});
    refuse([](json& m) { m["K"][0] = 0; }, {"fx"});
    refuse([](json& m) { m["w"] = 0; }, {"not a size"});
    refuse([](json& m) { m["poses"] = 3; }, {"'poses'", "not a list"});
    refuse([](json& m) { m["poses"][1] = {0, 0, 0, 1}; }, {"frame 1", "7 numbers"});
    refuse([](json& m) { m["poses"][1] = {0, 0, 0, 0, 0, 0, 0}; }, {"frame 1"});
    refuse([](json& m) { m["perFrameIntrinsicCoeffs"] = {{100, 100, 64, 48}}; }, {"1 intrinsics for 2 poses"});
    refuse([](json& m) { m["perFrameIntrinsicCoeffs"] = {{100, 100, 64, 48}, {"a"}}; }, {"frame 1", "4 numbers"});
    refuse([](json& m) { m["poses"] = json(std::vector<int>(20001, 0)); }, {"20001 frames"});
}

TEST(HostileRecord3d, everyTruncationOfAFileIsRefused) {
    TemporaryFolder folder;
    const std::string metadata = record3dMetadata(1).dump();
    const auto bytes = zip({{"metadata", {metadata.begin(), metadata.end()}}, {"rgbd/0.jpg", jpegOf(spotPicture(128, 96, {64, 48}))}});
    for (size_t length = 0; length < bytes.size(); ++length) EXPECT_FALSE(ZipFile::open({bytes.data(), length})) << length;
    writeBytes(folder.path / "cut.r3d", {bytes.begin(), bytes.end() - 10});
    EXPECT_TRUE(mentions(refusal(folder.path / "cut.r3d"), {"cut.r3d", "export the recording again"}));
    writeBytes(folder.path / "other.r3d", zip({{"readme", {'x'}}}));
    EXPECT_TRUE(mentions(refusal(folder.path / "other.r3d"), {"other.r3d", "'metadata'"}));
}

TEST(HostileRecord3d, archivesThatUnpackToTooMuchAreRefused) {
    TemporaryFolder folder;
    auto bytes = zip({{"metadata", std::vector<uint8_t>(80 << 20, ' ')}});  // 80 MiB of spaces in 80 KB
    EXPECT_LT(bytes.size(), 200000u);
    writeBytes(folder.path / "bomb.r3d", bytes);
    EXPECT_TRUE(mentions(refusal(folder.path / "bomb.r3d"), {"bomb.r3d", "limit"}));
}

TEST(HostileScan, fieldsOfImportedScans) {
    const auto refuse = [](const std::function<void(json&)>& breakIt, std::initializer_list<const char*> words) {
        TemporaryFolder folder;
        ScanBuilder builder(folder.path, 2);
        breakIt(builder.manifest);
        const auto scan = readScan(builder.write());
        ASSERT_FALSE(scan);
        EXPECT_TRUE(mentions(scan.error().message, words));
    };
    refuse([](json& m) { m["metric"] = 1; }, {"'metric'"});
    refuse([](json& m) { m["protocol"] = "other"; }, {"protocol 'other'", "'neuman'"});
    refuse([](json& m) { m["subject_height"] = 174; }, {"subject_height", "between 0.3 and 2.8 m"});
    refuse([](json& m) { m["subject_height"] = 2.9; }, {"subject_height", "between 0.3 and 2.8 m"});
    refuse([](json& m) { m["frames"][0]["image_size"] = {96}; }, {"image_size"});
    refuse([](json& m) { m["frames"][0]["image_size"] = {95, 128}; }, {"96 x 128", "95 x 128"});
    refuse([](json& m) { m["frames"][0]["camera"]["distortion"] = {0.1, 0.2}; }, {"distortion", "4 are needed"});
    refuse([](json& m) { m["frames"][0]["camera"]["distortion"] = {-3.0, 0.0, 0.0, 0.0}; }, {"full_100"});
}

}  // namespace
}  // namespace dpl
