// SPDX-License-Identifier: Apache-2.0
// A part of a capture is never taken without a word, and one bad picture does not sink the rest: what is left out is counted and named.
#include <functional>

#include "reconstruction/input/import/import.h"
#include "tests/unit/made_zip.h"
#include "tests/unit/recon_base/made_pictures.h"
#include "tests/unit/recon_import/made_captures.h"

namespace dpl {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

struct Imported {
    Scan scan;
    std::string summary;
};

struct LeftOutOfImports : ::testing::Test {
    TemporaryFolder folder;
    int made = 0;

    Result<Imported> import(const fs::path& source) {
        ImportOptions options;
        options.source = source;
        options.out = folder.path / formatText("scan{}", made++);
        DPL_TRY(const ImportReport report, importCapture(options, nullptr, {}));
        DPL_TRY(Scan scan, readScan(options.out, ScanCameras::MayLack));
        return Imported{std::move(scan), report.summary};
    }
    void polycam(const fs::path& root, int from, int to, const char* prefix = "", double fx = 100) {
        json keyframe = polycamKeyframe();
        keyframe["fx"] = keyframe["fy"] = fx;
        for (int i = from; i < to; ++i) {
            writeBytes(root / formatText("keyframes/{}images/{}.jpg", prefix, i), jpegOf(spotPicture(128, 96, kMadeSensorPixel)));
            writeText(root / formatText("keyframes/{}cameras/{}.json", prefix, i), keyframe.dump());
        }
    }
};

TEST_F(LeftOutOfImports, keyframesThatPolycamDidNotCorrectAreTakenRaw) {
    const fs::path root = folder.path / "poly";
    polycam(root, 0, 9);
    polycam(root, 2, 4, "corrected_", 110);
    auto done = import(root);
    ASSERT_TRUE(done) << done.error().message;
    ASSERT_EQ(done->scan.frames.size(), 9u);
    for (size_t i = 0; i < 9; ++i) EXPECT_EQ(done->scan.frames[i].camera.fx, i == 2 || i == 3 ? 110 : 100) << i;
    EXPECT_TRUE(mentions(done->summary, {"partly corrected", "7 of 9 keyframes are taken uncorrected", "0.jpg, 1.jpg, 4.jpg",
                                         "keyframes/corrected_cameras"}));
    for (const char* part : {"corrected_cameras", "corrected_images"}) {
        done = import(root / "keyframes" / part);
        ASSERT_TRUE(done) << done.error().message;
        EXPECT_EQ(done->scan.frames.size(), 2u);
        EXPECT_TRUE(mentions(done->summary, {"corrected by Polycam"}));
    }
    done = import(root / "keyframes/cameras");
    ASSERT_TRUE(done) << done.error().message;
    EXPECT_EQ(done->scan.frames.size(), 9u);
    EXPECT_EQ(done->scan.frames[2].camera.fx, 100);
    // A corrected camera whose corrected picture is missing counts for nothing.
    fs::remove(root / "keyframes/corrected_images/2.jpg");
    done = import(root);
    ASSERT_TRUE(done) << done.error().message;
    EXPECT_EQ(done->scan.frames.size(), 9u);
    EXPECT_TRUE(mentions(done->summary, {"8 of 9 keyframes"}));
}

TEST_F(LeftOutOfImports, brokenKeyframesAreNamed) {
    const fs::path root = folder.path / "poly";
    polycam(root, 0, 6);
    writeText(root / "keyframes/cameras/1.json", "{\"fx\": 100");
    writeText(root / "keyframes/images/2.jpg", "");
    const fs::path cut = root / "keyframes/images/3.jpg";
    fs::resize_file(cut, fs::file_size(cut) / 2);
    fs::remove(root / "keyframes/images/4.jpg");
    auto done = import(root);
    ASSERT_TRUE(done) << done.error().message;
    EXPECT_EQ(done->scan.frames.size(), 2u);
    EXPECT_TRUE(mentions(done->summary, {"1 camera files without a picture", "2 of 6 keyframes are left out: 1.jpg, 2.jpg",
                                         "not valid JSON", "1 of 3 pictures are left out: 3.jpg", "truncated"}));
}

TEST_F(LeftOutOfImports, record3dPicturesWithoutPoseAndBrokenOnes) {
    const auto jpeg = jpegOf(spotPicture(128, 96, kMadeSensorPixel));
    writeText(folder.path / "rec/metadata.json", record3dMetadata(4).dump());
    for (int i = 0; i < 6; ++i) writeBytes(folder.path / formatText("rec/rgb/{}.jpg", i), jpeg);
    writeText(folder.path / "rec/rgb/1.jpg", "");
    const auto done = import(folder.path / "rec");
    ASSERT_TRUE(done) << done.error().message;
    EXPECT_EQ(done->scan.frames.size(), 3u);
    EXPECT_TRUE(mentions(done->summary, {"2 pictures without a pose are left out", "1 of 4 pictures are left out: 1.jpg"}));
}

TEST_F(LeftOutOfImports, aDamagedEntryOfARecordingIsNamed) {
    const std::string metadata = record3dMetadata(3).dump();
    const auto jpeg = jpegOf(spotPicture(128, 96, kMadeSensorPixel));
    auto bytes = zip({{"metadata", {metadata.begin(), metadata.end()}}, {"rgbd/0.jpg", jpeg}, {"rgbd/1.jpg", jpeg}, {"rgbd/2.jpg", jpeg}});
    const std::string name = "rgbd/0.jpg";  // stored, not deflated
    const auto at = std::search(bytes.begin(), bytes.end(), name.begin(), name.end());
    at[long(name.size() + jpeg.size() / 2)] ^= 1;
    writeBytes(folder.path / "rec.r3d", bytes);
    const auto done = import(folder.path / "rec.r3d");
    ASSERT_TRUE(done) << done.error().message;
    EXPECT_EQ(done->scan.frames.size(), 2u);
    EXPECT_TRUE(mentions(done->summary, {"1 of 3 pictures are left out: rgbd/0.jpg", "checksum"}));
}

/** Noise, so that most of the file is compressed pixels. */
std::vector<uint8_t> noisyJpeg() {
    Picture picture = spotPicture(96, 128, kMadePixel);
    uint32_t state = 1;
    for (uint8_t& v : picture.pixels) v = uint8_t(v / 2 + ((state = state * 1664525 + 1013904223) >> 25));
    return jpegOf(picture);
}

TEST_F(LeftOutOfImports, damagedPhotosAreNamed) {
    const auto good = noisyJpeg();
    auto bad = good;
    for (size_t i = 0; i < 100; ++i) bad[bad.size() / 2 + i] = uint8_t(7 * i % 251);
    for (int i = 0; i < 4; ++i) writeBytes(folder.path / formatText("p/{}.jpg", i), i == 2 ? bad : good);
    writeText(folder.path / "p/4.png", "\x89PNG\r\n\x1a\n");
    auto done = import(folder.path / "p");
    ASSERT_TRUE(done) << done.error().message;
    EXPECT_EQ(done->scan.frames.size(), 3u);
    EXPECT_TRUE(mentions(done->summary, {"1 of 5 pictures are left out: 4.png", "1 of 4 pictures are left out: 2.jpg", "damaged JPEG"}));
    for (int i = 0; i < 4; ++i) writeBytes(folder.path / formatText("p/{}.jpg", i), bad);
    done = import(folder.path / "p");
    ASSERT_FALSE(done);
    EXPECT_TRUE(mentions(done.error().message, {"0.jpg", "damaged JPEG", "copy or export the picture again"}));
    EXPECT_FALSE(fs::exists(folder.path / "scan1"));
}

TEST_F(LeftOutOfImports, aChosenColmapModelIsKept) {
    const fs::path root = folder.path / "colmap";
    for (int i = 0; i < 9; ++i) writeBytes(root / formatText("images/{}.jpg", i), jpegOf(spotPicture(96, 128, kMadePixel)));
    for (int model : {0, 1}) {
        std::string images;
        for (int i = model * 2; i < 2 + model * 7; ++i) images += formatText("{} 0 1 0 0 0 1 3 1 {}.jpg\n", i + 1, i);
        writeText(root / formatText("sparse/{}/cameras.txt", model), "1 PINHOLE 96 128 100 100 48 64\n");
        writeText(root / formatText("sparse/{}/images.txt", model), images);
    }
    auto done = import(root);
    ASSERT_TRUE(done) << done.error().message;
    EXPECT_EQ(done->scan.frames.size(), 7u);
    EXPECT_TRUE(mentions(done->summary, {"of 2 COLMAP models sparse/1 (7 images) is taken", "sparse/0 (2 images)"}));
    done = import(root / "sparse/0");
    ASSERT_TRUE(done) << done.error().message;
    EXPECT_EQ(done->scan.frames.size(), 2u);
}

TEST_F(LeftOutOfImports, namesOfAnyScriptAreKept) {
    const fs::path root = folder.path / "colmap";
    const char* const names[] = {"一", "丁", "Ümläut é", "a b", "a_b"};
    std::string images;
    for (size_t i = 0; i < std::size(names); ++i) {
        writeBytes(root / "images" / formatText("{}.jpg", names[i]), jpegOf(spotPicture(96, 128, kMadePixel)));
        images += formatText("{} 0 1 0 0 0 1 3 1 {}.jpg\n\n", i + 1, names[i]);
    }
    writeText(root / "sparse/0/cameras.txt", "1 PINHOLE 96 128 100 100 48 64\n");
    writeText(root / "sparse/0/images.txt", images);
    const auto done = import(root);
    ASSERT_TRUE(done) << done.error().message;
    ASSERT_EQ(done->scan.frames.size(), 5u);
    for (const ScanFrame& frame : done->scan.frames) {
        EXPECT_TRUE(seesMadePoint(frame)) << frame.name;
        EXPECT_TRUE(fs::exists(frame.imagePath.parent_path() / (frame.name + ".jpg")));
    }
}

TEST_F(LeftOutOfImports, whatAPngStatesIsHeard) {
    const Picture stored = spotPicture(128, 96, kMadeSensorPixel);
    const auto exif = withExif(jpegOf(stored), 6, 26);
    const std::vector<uint8_t> tiff(exif.begin() + 12, exif.begin() + 4 + (exif[4] << 8 | exif[5]));
    for (const bool atEnd : {false, true}) {
        for (int i = 0; i < 3; ++i)
            writeBytes(folder.path / formatText("png{}/{}.png", atEnd, i), withChunk(pngOf(stored), "eXIf", tiff, atEnd));
        const auto done = import(folder.path / formatText("png{}", atEnd));
        ASSERT_TRUE(done) << done.error().message;
        EXPECT_NEAR(done->scan.focalGuessPx, 26 * 160 / std::hypot(36.0, 24.0), 1e-9);
        for (const ScanFrame& frame : done->scan.frames) {
            const auto image = readFrameImage(frame);
            ASSERT_TRUE(image) << image.error().message;
            ASSERT_EQ(image->widthPx, 96u);
            EXPECT_LT(glm::length(spotIn(*image) - kMadePixel), 0.2);
        }
    }
}

/** A PNG of 96 × 128 pixels and eight bits, of one colour type; rows are filled with `row`. */
std::vector<uint8_t> rawPng(uint8_t colourType, const std::vector<uint8_t>& row) {
    std::vector<uint8_t> png = {0x89, 'P', 'N', 'G', '\r', '\n', 0x1a, '\n'}, header, rows, packed;
    appendBig(header, 96), appendBig(header, 128);
    for (uint8_t v : {uint8_t(8), colourType, uint8_t(0), uint8_t(0), uint8_t(0)}) header.push_back(v);
    for (int y = 0; y < 128; ++y) rows.push_back(0), rows.insert(rows.end(), row.begin(), row.end());
    packed.resize(compressBound(uLong(rows.size())));
    uLongf bytes = uLongf(packed.size());
    compress(packed.data(), &bytes, rows.data(), uLong(rows.size()));
    packed.resize(bytes);
    appendBig(png, 0), appendText(png, "IEND"), appendBig(png, 0xae426082);
    png = withChunk(png, "IDAT", packed, true);
    return withChunk(png, "IHDR", header, true);
}

TEST_F(LeftOutOfImports, transparentColoursAreMasks) {
    std::vector<uint8_t> palette(96), grey(96), rgb;
    for (size_t x = 0; x < 96; ++x) {
        palette[x] = x >= 48, grey[x] = x >= 48 ? 200 : 7;
        for (uint8_t v : {200, 100, 50}) rgb.push_back(x >= 48 ? v : 9);
    }
    const auto chunks = [](std::vector<uint8_t> png, const std::vector<std::pair<std::string, MadeBytes>>& added) {
        MadeBytes out(png.begin(), png.begin() + 8);  // IHDR was added last, before IEND: put everything into order
        const std::string types[] = {"IHDR", "IDAT", "IEND"};
        for (const std::string& type : types) {
            if (type == "IDAT")
                for (const auto& [name, data] : added) {
                    const MadeBytes chunk = withChunk(MadeBytes(33), name, data);
                    out.insert(out.end(), chunk.begin() + 33, chunk.end());
                }
            const auto at = std::search(png.begin(), png.end(), type.begin(), type.end()) - 4;
            const long length = long(at[0]) << 24 | long(at[1]) << 16 | long(at[2]) << 8 | at[3];
            out.insert(out.end(), at, at + 12 + length);
        }
        return out;
    };
    const std::pair<const char*, MadeBytes> pictures[] = {
        {"palette", chunks(rawPng(3, palette), {{"PLTE", {9, 9, 9, 200, 100, 50}}, {"tRNS", {0, 255}}})},
        {"grey", chunks(rawPng(0, grey), {{"tRNS", {0, 7}}})},
        {"rgb", chunks(rawPng(2, rgb), {{"tRNS", {0, 9, 0, 9, 0, 9}}})},
    };
    for (const auto& [name, png] : pictures) {
        SCOPED_TRACE(name);
        for (int i = 0; i < 3; ++i) writeBytes(folder.path / name / formatText("{}.png", i), png);
        const auto done = import(folder.path / name);
        ASSERT_TRUE(done) << done.error().message;
        ASSERT_FALSE(done->scan.frames[0].maskPath.empty());
        const auto mask = readFrameMask(done->scan.frames[0]);
        ASSERT_TRUE(mask) << mask.error().message;
        EXPECT_EQ(mask->pixels[0], 0);
        EXPECT_EQ(mask->pixels[95], 255);
        const auto image = readFrameImage(done->scan.frames[0]);
        ASSERT_TRUE(image);
        EXPECT_EQ(image->pixels[0], 128) << "grey where it is transparent";
        EXPECT_EQ(image->pixels[3 * 95], 200);
    }
}

TEST_F(LeftOutOfImports, picturesOfDisplayP3AreConverted) {
    // The skin tone of picture_colours_test.cpp.
    Picture skin{96, 128, 3, std::vector<uint8_t>(96 * 128 * 3)};
    for (size_t i = 0; i < skin.pixels.size(); ++i) skin.pixels[i] = std::array<uint8_t, 3>{200, 150, 120}[i % 3];
    for (int i = 0; i < 4; ++i)
        writeBytes(folder.path / formatText("p3/{}.jpg", i), i == 3 ? jpegOf(skin) : withProfile(jpegOf(skin), displayP3Profile()));
    const auto done = import(folder.path / "p3");
    ASSERT_TRUE(done) << done.error().message;
    EXPECT_TRUE(mentions(done->summary, {"3 pictures are converted from Display P3 to sRGB"}));
    for (size_t i = 0; i < 4; ++i) {
        const auto bytes = readFile(done->scan.frames[i].imagePath);
        const auto numbers = decodePicture(*bytes, PictureChannels::AsStored);  // as any program reads them
        ASSERT_TRUE(numbers);
        const int expected[3] = {i == 3 ? 200 : 209, i == 3 ? 150 : 147, i == 3 ? 120 : 115};
        for (size_t c = 0; c < 3; ++c) EXPECT_NEAR(int(numbers->pixels[c]), expected[c], 3) << i;
    }
    EXPECT_EQ(*readFile(done->scan.frames[3].imagePath), jpegOf(skin)) << "sRGB is copied as it is";
}

}  // namespace
}  // namespace dpl
