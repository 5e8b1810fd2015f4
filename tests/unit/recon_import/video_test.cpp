// SPDX-License-Identifier: Apache-2.0
// Videos that ffmpeg makes here: rotation, variable frame rate, 10-bit HDR, damage, and files that only pretend to be videos.
#include "reconstruction/input/import/video.h"

#include <chrono>
#include <thread>
#include "reconstruction/base/program.h"
#include "reconstruction/input/import/folder_contents.h"
#include "reconstruction/input/import/import.h"
#include "tests/unit/recon_import/made_captures.h"
#include "tests/unit/shared_data.h"

namespace dpl {
namespace {

namespace fs = std::filesystem;

struct VideoFiles : ::testing::Test {
    TemporaryFolder folder;
    VideoWork work{folder.path / "work"};

    void SetUp() override {
        if (!findProgram("ffmpeg")) GTEST_SKIP() << "the program ffmpeg is not installed";
        fs::create_directories(work.folder);
    }

    /** Makes a video of two seconds, 24 frames a second: left half red, right half grey with a moving pattern. */
    fs::path make(const std::string& name, std::vector<std::string> coding, const std::string& filter = "", const char* size = "192x108") {
        const fs::path path = folder.path / name;
        std::vector<std::string> arguments = {"ffmpeg",
                                              "-loglevel",
                                              "error",
                                              "-nostdin",
                                              "-y",
                                              "-f",
                                              "lavfi",
                                              "-i",
                                              formatText("testsrc2=s={}:r=24:d=2", size),
                                              "-vf",
                                              "drawbox=x=0:y=0:w=iw/2:h=ih:color=0xc04020:t=fill" + filter};
        arguments.insert(arguments.end(), coding.begin(), coding.end());
        arguments.push_back(path.string());
        const Status made = runProgram({.arguments = arguments, .log = folder.path / "make.log"});
        EXPECT_TRUE(made) << made.error().message;
        return path;
    }
    static std::vector<std::string> h264() { return {"-c:v", "libx264", "-preset", "ultrafast", "-crf", "10", "-pix_fmt", "yuv420p"}; }

    /** The picture of the n-th analysed frame. */
    Picture frame(const VideoInfo& info, const VideoAnalysis& analysis, size_t n, uint32_t longSidePx = 1920) {
        const auto files = extractFrames(info, {analysis.frames.at(n).pts}, longSidePx, work);
        EXPECT_TRUE(files) << files.error().message;
        const auto bytes = readFile(files->at(0));
        return *decodePicture(*bytes, PictureChannels::Rgb);
    }
};

Vec3d meanColour(const Picture& p, uint32_t x0, uint32_t x1, uint32_t y0, uint32_t y1) {
    Vec3d sum(0);
    for (uint32_t y = y0; y < y1; ++y)
        for (uint32_t x = x0; x < x1; ++x)
            for (int c = 0; c < 3; ++c) sum[c] += p.pixels[(size_t(y) * p.widthPx + x) * 3 + size_t(c)];
    return sum / double((x1 - x0) * (y1 - y0));
}

/** Writes a display matrix of a quarter turn into an mp4, as phones do that are held upright. */
void turnMp4(const fs::path& path) {
    auto bytes = *readFile(path);
    const std::string text(bytes.begin(), bytes.end());
    const size_t at = text.find("tkhd");
    ASSERT_NE(at, std::string::npos);
    const uint32_t matrix[9] = {0, 0x00010000, 0, 0xffff0000, 0, 0, 108u << 16, 0, 0x40000000};
    for (size_t i = 0; i < 9; ++i)
        for (size_t b = 0; b < 4; ++b) bytes[at + 4 + 40 + 4 * i + b] = uint8_t(matrix[i] >> (24 - 8 * b));
    writeBytes(path, bytes);
}

TEST_F(VideoFiles, coloursSurviveWithinAFewLevels) {
    const fs::path path = make("plain.mp4", h264());
    const auto info = probeVideo(path, work);
    ASSERT_TRUE(info) << info.error().message;
    EXPECT_EQ(info->codec, "h264");
    EXPECT_EQ(info->widthPx, 192u);
    EXPECT_NEAR(info->durationS, 2, 0.05);
    const auto analysis = analyseVideo(*info, work);
    ASSERT_TRUE(analysis) << analysis.error().message;
    EXPECT_NEAR(double(analysis->frames.size()), 24, 1);  // 12 a second
    EXPECT_NEAR(analysis->frames[12].timeS, 1.0, 0.05);
    const Vec3d colour = meanColour(frame(*info, *analysis, 5), 8, 80, 8, 100);
    // ffmpeg's own rounding of YUV is 1 to 2 levels; a wrong matrix (601 for 709) moves green by 13.
    EXPECT_NEAR(colour.r, 0xc0, 4);
    EXPECT_NEAR(colour.g, 0x40, 4);
    EXPECT_NEAR(colour.b, 0x20, 4);
}

TEST_F(VideoFiles, aSampleIsSpreadOverTheVideoWithAndWithoutKeyFrames) {
    auto dense = h264(), sparse = h264();
    dense.insert(dense.end(), {"-g", "4"}), sparse.insert(sparse.end(), {"-g", "240"});
    for (const auto& coding : {dense, sparse}) {
        const auto info = probeVideo(make("sampled.mp4", coding), work);
        ASSERT_TRUE(info) << info.error().message;
        const auto frames = sampleFrames(*info, 6, 96, work);
        ASSERT_TRUE(frames) << frames.error().message;
        ASSERT_GE(frames->size(), 5u);
        ASSERT_LE(frames->size(), 6u);
        for (size_t i = 1; i < frames->size(); ++i) EXPECT_NEAR((*frames)[i].timeS - (*frames)[i - 1].timeS, 2.0 / 6, 0.1);
        const auto bytes = readFile(frames->back().file);
        ASSERT_TRUE(bytes) << bytes.error().message;
        EXPECT_EQ(decodePicture(*bytes, PictureChannels::Rgb)->widthPx, 96u);
    }
}

TEST_F(VideoFiles, theMatrixOfHdVideosIsRead) {
    auto coding = h264();
    coding.insert(coding.end(), {"-colorspace", "bt709", "-color_primaries", "bt709", "-color_trc", "bt709"});
    const fs::path path = make("hd.mp4", coding, ",scale=out_color_matrix=bt709");
    const auto info = probeVideo(path, work);
    ASSERT_TRUE(info) << info.error().message;
    EXPECT_EQ(info->colourMatrix, "bt709");
    const auto analysis = analyseVideo(*info, work);
    ASSERT_TRUE(analysis) << analysis.error().message;
    const Vec3d colour = meanColour(frame(*info, *analysis, 5), 8, 80, 8, 100);
    EXPECT_NEAR(colour.r, 0xc0, 4);
    EXPECT_NEAR(colour.g, 0x40, 4);
    EXPECT_NEAR(colour.b, 0x20, 4);
}

TEST_F(VideoFiles, phonesHeldUprightGiveUprightPictures) {
    const fs::path path = make("turned.mp4", h264());
    turnMp4(path);
    const auto info = probeVideo(path, work);
    ASSERT_TRUE(info) << info.error().message;
    EXPECT_EQ(info->widthPx, 108u);
    EXPECT_EQ(info->heightPx, 192u);
    const auto analysis = analyseVideo(*info, work);
    ASSERT_TRUE(analysis) << analysis.error().message;
    const Picture picture = frame(*info, *analysis, 5);
    ASSERT_EQ(picture.widthPx, 108u);
    ASSERT_EQ(picture.heightPx, 192u);
    EXPECT_NEAR(meanColour(picture, 8, 100, 8, 80).r, 0xc0, 4);  // the left half became the top: turned clockwise
}

TEST_F(VideoFiles, variableFrameRatesKeepTheirTimes) {
    // One second at 24 frames a second, then 24 frames at 6.
    auto coding = h264();
    coding.insert(coding.end(), {"-fps_mode", "vfr"});
    const fs::path path = make("vfr.mp4", coding, ",setpts='if(lt(N\\,24)\\,N/24\\,1+(N-24)/6)/TB'");
    const auto info = probeVideo(path, work);
    ASSERT_TRUE(info) << info.error().message;
    const auto analysis = analyseVideo(*info, work);
    ASSERT_TRUE(analysis) << analysis.error().message;
    size_t early = 0, late = 0;
    for (const VideoFrame& f : analysis->frames) (f.timeS < 0.99 ? early : late) += 1;
    EXPECT_NEAR(double(early), 12, 1);
    EXPECT_NEAR(double(late), 24, 1);  // all of them: they are slower than 12 a second
    EXPECT_NEAR(analysis->frames.back().timeS, 1 + 23 / 6.0, 0.05);
}

TEST_F(VideoFiles, tenBitHdrIsToneMapped) {
    const fs::path path =
        make("hdr.mp4", {"-c:v", "libx265", "-preset", "ultrafast", "-x265-params", "log-level=error", "-pix_fmt", "yuv420p10le",
                         "-color_trc", "arib-std-b67", "-color_primaries", "bt2020", "-colorspace", "bt2020nc"});
    const auto info = probeVideo(path, work);
    ASSERT_TRUE(info) << info.error().message;
    EXPECT_EQ(info->codec, "hevc");
    EXPECT_TRUE(info->hdr);
    const auto analysis = analyseVideo(*info, work);
    ASSERT_TRUE(analysis) << analysis.error().message;
    const Vec3d colour = meanColour(frame(*info, *analysis, 5), 8, 80, 8, 100);
    EXPECT_GT(colour.r, colour.g + 50);  // red stays red
    EXPECT_GT(colour.r, 60);             // and is neither crushed nor blown out
    EXPECT_LT(colour.r, 250);
}

TEST_F(VideoFiles, largeVideosAreReduced) {
    const fs::path path = make("large.mp4", h264(), "", "640x360");
    const auto info = probeVideo(path, work);
    const auto analysis = analyseVideo(*info, work);
    ASSERT_TRUE(analysis) << analysis.error().message;
    const Picture picture = frame(*info, *analysis, 0, 320);
    EXPECT_EQ(picture.widthPx, 320u);
    EXPECT_EQ(picture.heightPx, 180u);
}

TEST_F(VideoFiles, damageIsNamed) {
    const fs::path path = make("whole.mp4", h264());
    const auto bytes = *readFile(path);
    const auto refusal = [&](const char* name, std::vector<uint8_t> content) {
        writeBytes(folder.path / name, content);
        const auto info = probeVideo(folder.path / name, work);
        if (!info) return info.error().message;
        const auto analysis = analyseVideo(*info, work);
        return analysis ? std::string("was read") : analysis.error().message;
    };
    EXPECT_TRUE(mentions(refusal("cut.mp4", {bytes.begin(), bytes.begin() + ptrdiff_t(bytes.size() / 2)}),
                         {"cut.mp4", "cut off", "copy it again"}));
    EXPECT_TRUE(mentions(refusal("text.mp4", {'h', 'e', 'l', 'l', 'o', '\n'}), {"text.mp4", "is text, not a video"}));
    EXPECT_TRUE(mentions(refusal("empty.mp4", {}), {"empty.mp4 is empty"}));
    const auto none = probeVideo(folder.path / "none.mp4", work);
    ASSERT_FALSE(none);
    EXPECT_EQ(none.error().code, Code::NotFound);
}

TEST_F(VideoFiles, everyEndingOfAVideoIsRead) {
    for (const VideoEnding& ending : kVideoEndings) {
        const std::string name = "walk" + std::string(ending.extension);
        auto coding = h264();
        if (name == "walk.webm") coding = {"-c:v", "libvpx-vp9", "-deadline", "realtime"};
        const auto info = probeVideo(make(name, coding), work);
        ASSERT_TRUE(info) << info.error().message;
        const auto analysis = analyseVideo(*info, work);
        ASSERT_TRUE(analysis) << analysis.error().message;
        EXPECT_NEAR(double(analysis->frames.size()), 24, 1) << name;
        EXPECT_NEAR(analysis->frames.back().timeS, 2, 0.15) << name;
        EXPECT_NEAR(meanColour(frame(*info, *analysis, 5), 8, 80, 8, 100).r, 0xc0, 8) << name;
    }
}

TEST_F(VideoFiles, aVideoThatEndsEarlyIsRefused) {
    // The index comes first and promises two seconds; the pictures of the second half are gone.
    auto coding = h264();
    coding.insert(coding.end(), {"-movflags", "+faststart", "-g", "6"});
    const fs::path path = make("early.mp4", coding, ",setpts=3*PTS");
    auto bytes = *readFile(path);
    bytes.resize(bytes.size() / 2);
    writeBytes(path, bytes);
    const auto info = probeVideo(path, work);
    ASSERT_TRUE(info) << info.error().message;
    const auto analysis = analyseVideo(*info, work);
    ASSERT_FALSE(analysis);
    EXPECT_TRUE(mentions(analysis.error().message, {"early.mp4", "cut off"}));
}

TEST_F(VideoFiles, aPlaylistThatPretendsToBeAVideoOpensNothing) {
    const fs::path secret = make("secret.mp4", h264());
    writeText(folder.path / "list.mp4", "#EXTM3U\n#EXT-X-TARGETDURATION:2\n#EXTINF:2,\nsecret.mp4\n#EXT-X-ENDLIST\n");
    EXPECT_FALSE(probeVideo(folder.path / "list.mp4", work));
    writeText(folder.path / "concat.mp4", "ffconcat version 1.0\nfile secret.mp4\n");
    EXPECT_FALSE(probeVideo(folder.path / "concat.mp4", work));
}

TEST_F(VideoFiles, pixelsThatAreNotSquareAreStretched) {
    const struct {
        const char *aspect, *name;
        uint32_t widthPx, heightPx;
    } cases[] = {{"1/2", "tall.mp4", 192, 216},  {"4/3", "hdv.mov", 256, 108},          {"16/15", "pal.mkv", 205, 108},
                 {"2/1", "wide.avi", 384, 108},  {"1/2", "tall.ts", 192, 216},          {"4/3", "vp9.webm", 256, 108},
                 {"1/1", "plain.mp4", 192, 108}, {"1001/1000", "rounded.mp4", 192, 108}};
    for (const auto& made : cases) {
        SCOPED_TRACE(made.name);
        auto coding = h264();
        if (std::string(made.name).ends_with(".webm")) coding = {"-c:v", "libvpx-vp9", "-deadline", "realtime"};
        const auto info = probeVideo(make(made.name, coding, formatText(",setsar={}", made.aspect)), work);
        ASSERT_TRUE(info) << info.error().message;
        EXPECT_NEAR(double(info->widthPx), made.widthPx, 1);
        EXPECT_NEAR(double(info->heightPx), made.heightPx, 1);
        EXPECT_EQ(info->storedWidthPx, 192u);
        EXPECT_EQ(info->storedHeightPx, 108u);
        const auto analysis = analyseVideo(*info, work);
        ASSERT_TRUE(analysis) << analysis.error().message;
        const Picture picture = frame(*info, *analysis, 5);
        EXPECT_NEAR(double(picture.widthPx) / picture.heightPx, double(made.widthPx) / made.heightPx, 0.02);
        // The red half still ends in the middle.
        const uint32_t middle = picture.widthPx / 2;
        EXPECT_NEAR(meanColour(picture, middle - 12, middle - 6, 8, 60).r, 0xc0, 12);
        EXPECT_LT(meanColour(picture, middle - 12, middle - 6, 8, 60).g, 0x60);
    }
}

TEST_F(VideoFiles, aTurnedVideoOfPixelsThatAreNotSquareIsStretchedUpright) {
    const fs::path path = make("turned.mp4", h264(), ",setsar=4/3");
    turnMp4(path);
    const auto info = probeVideo(path, work);
    ASSERT_TRUE(info) << info.error().message;
    EXPECT_EQ(info->widthPx, 108u);
    EXPECT_EQ(info->heightPx, 256u);
}

TEST_F(VideoFiles, theImportSaysThatPixelsWereStretched) {
    ImportOptions options;
    options.videos.still = {make("sar.mp4", h264(), ",setsar=1/2")};
    options.out = folder.path / "scan";
    const auto done = importCapture(options, nullptr, {});
    ASSERT_TRUE(done) << done.error().message;
    EXPECT_TRUE(mentions(done->summary, {"sar.mp4 has 192 x 108 pixels that are not square", "192 x 216"}));
    const auto scan = readScan(options.out, ScanCameras::MayLack);
    ASSERT_TRUE(scan) << scan.error().message;
    EXPECT_EQ(scan->frames[0].camera.heightPx, 216u);
}

TEST_F(VideoFiles, aCalibrationOfStoredPixelsKeepsThem) {
    make("cam01.mp4", h264(), ",setsar=2/1", "96x128");
    writeText(folder.path / "Calib.qca.txt", qualisysText());
    ImportOptions options;
    options.source = folder.path / "Calib.qca.txt";
    options.out = folder.path / "scan";
    const auto done = importCapture(options, nullptr, {});
    ASSERT_TRUE(done) << done.error().message;
    const auto scan = readScan(options.out);
    ASSERT_TRUE(scan) << scan.error().message;
    EXPECT_EQ(scan->frames[0].camera.widthPx, 96u);
    EXPECT_EQ(scan->frames[0].camera.fx, 100);
}

TEST_F(VideoFiles, aCameraWithoutVideoAndAVideoWithoutCameraAreNamed) {
    std::string two = qualisysText();
    const size_t begin = two.find("<camera "), end = two.find("</cameras>");
    std::string second = two.substr(begin, end - begin);
    second.replace(second.find("cam01"), 5, "cam02");
    writeText(folder.path / "Calib.qca.txt", two.insert(end, second));
    ImportOptions options;
    options.source = folder.path / "Calib.qca.txt", options.out = folder.path / "scan";
    make("other.mp4", h264(), "", "96x128");
    const auto none = importCapture(options, nullptr, {});
    ASSERT_FALSE(none);
    EXPECT_TRUE(mentions(none.error().message, {"no video's name contains that of camera 'cam01'"}));
    make("cam02.mp4", h264(), "", "96x128");
    const auto done = importCapture(options, nullptr, {});
    ASSERT_TRUE(done) << done.error().message;
    EXPECT_TRUE(mentions(done->summary, {"1 of 2 cameras are left out: cam01", "other.mp4 is left out"}));
    const auto scan = readScan(options.out);
    ASSERT_TRUE(scan) << scan.error().message;
    for (const ScanFrame& frame : scan->frames) EXPECT_TRUE(frame.name.starts_with("dyn_cam02")) << frame.name;
}

TEST_F(VideoFiles, aVideoThatStartsLateIsRead) {
    for (const char* name : {"late.mkv", "late.mp4", "late.ts", "late.webm"}) {
        SCOPED_TRACE(name);
        auto coding = h264();
        if (std::string(name).ends_with(".webm")) coding = {"-c:v", "libvpx-vp9", "-deadline", "realtime"};
        coding.insert(coding.end(), {"-output_ts_offset", "100"});
        const auto info = probeVideo(make(name, coding), work);
        ASSERT_TRUE(info) << info.error().message;
        EXPECT_NEAR(info->durationS, 2, 0.1);
        const auto analysis = analyseVideo(*info, work);
        ASSERT_TRUE(analysis) << analysis.error().message;
        EXPECT_NEAR(double(analysis->frames.size()), 24, 1);
    }
}

TEST_F(VideoFiles, soundThatGoesOnIsNoDamage) {
    const fs::path path = make("plain.mkv", h264()), longer = folder.path / "sound.mkv";
    ASSERT_TRUE(runProgram({.arguments = {"ffmpeg", "-loglevel", "error", "-y", "-i", path.string(), "-f", "lavfi", "-i", "sine=d=9",
                                          "-map", "0:v", "-map", "1:a", "-c:v", "copy", longer.string()},
                            .log = folder.path / "make.log"}));
    const auto info = probeVideo(longer, work);
    ASSERT_TRUE(info) << info.error().message;
    EXPECT_NEAR(info->durationS, 2, 0.1);
    const auto analysis = analyseVideo(*info, work);
    EXPECT_TRUE(analysis) << analysis.error().message;
}

TEST_F(VideoFiles, aSecondVideoOfAFileIsSaidAndACoverIsNone) {
    const fs::path first = make("first.mp4", h264()), second = make("second.mp4", h264(), "", "96x96");
    const fs::path both = folder.path / "both.mkv", covered = folder.path / "covered.mp4", cover = folder.path / "cover.png";
    writeBytes(cover, pngOf(spotPicture(64, 64, {32, 32})));
    const auto mux = [&](std::vector<std::string> words) {
        words.insert(words.begin(), {"ffmpeg", "-loglevel", "error", "-y"});
        ASSERT_TRUE(runProgram({.arguments = words, .log = folder.path / "make.log"}));
    };
    mux({"-i", first.string(), "-i", second.string(), "-map", "0", "-map", "1", "-c", "copy", both.string()});
    mux({"-i", cover.string(), "-i", first.string(), "-map", "0", "-map", "1", "-c", "copy", "-disposition:v:0", "attached_pic",
         covered.string()});
    auto info = probeVideo(both, work);
    ASSERT_TRUE(info) << info.error().message;
    EXPECT_EQ(info->widthPx, 192u);
    EXPECT_EQ(info->otherStreams, 1u);
    ImportOptions options;
    options.videos.still = {both}, options.out = folder.path / "scan";
    const auto done = importCapture(options, nullptr, {});
    ASSERT_TRUE(done) << done.error().message;
    EXPECT_TRUE(mentions(done->summary, {"both.mkv holds 1 more video streams", "-map 0:V:1"}));
    info = probeVideo(covered, work);
    ASSERT_TRUE(info) << info.error().message;
    EXPECT_EQ(info->widthPx, 192u) << "the video, not the picture of its cover";
    EXPECT_EQ(info->otherStreams, 0u);
    const auto analysis = analyseVideo(*info, work);
    ASSERT_TRUE(analysis) << analysis.error().message;
    EXPECT_NEAR(meanColour(frame(*info, *analysis, 5), 8, 80, 8, 100).r, 0xc0, 8);
}

TEST_F(VideoFiles, soundAloneIsRefused) {
    const fs::path path = folder.path / "sound.mp4";
    ASSERT_TRUE(runProgram({.arguments = {"ffmpeg", "-loglevel", "error", "-y", "-f", "lavfi", "-i", "sine=d=1", path.string()},
                            .log = folder.path / "make.log"}));
    const auto info = probeVideo(path, work);
    ASSERT_FALSE(info);
    EXPECT_TRUE(mentions(info.error().message, {"sound.mp4", "no video"}));
}

TEST_F(VideoFiles, importOfNamedVideosKeepsKindsAndTimes) {
    const fs::path walk = make("walk one.mp4", h264()), moves = make("moves'.mp4", h264(), ",hue=h=10*t");
    ImportOptions options;
    options.videos.still = {walk};
    const fs::path again = folder.path / "again.mp4";
    fs::copy_file(moves, again);
    options.videos.moving = {moves, again};
    options.counts = {6, 3, 8};
    options.out = folder.path / "scan 100%d";
    const auto done = importCapture(options, nullptr, {});
    ASSERT_TRUE(done) << done.error().message;
    const auto scan = readScan(options.out, ScanCameras::MayLack);
    ASSERT_TRUE(scan) << scan.error().message;
    EXPECT_FALSE(scan->camerasKnown);
    std::vector<double> times;
    size_t still = 0;
    for (const ScanFrame& frame : scan->frames) {
        still += frame.kind == FrameKind::StaticFull;
        if (frame.kind == FrameKind::Dynamic) times.push_back(frame.timeS);
    }
    EXPECT_TRUE(still >= 4 && still <= 6) << still;
    EXPECT_TRUE(times.size() >= 5 && times.size() <= 8) << times.size();
    EXPECT_TRUE(std::is_sorted(times.begin(), times.end()));
    EXPECT_LT(times.front(), 1);
    EXPECT_GT(times.back(), 2.9);  // the second video goes on a second after the first one, which lasts two
}

TEST_F(VideoFiles, cancelActsInEveryPart) {
    const fs::path path = make("walk.mp4", h264(), "", "640x360");
    ImportOptions options;
    options.source = path;
    options.out = folder.path / "scan";
    const struct {
        const char* name;
        double from, atMost;  // of the progress: when it is cancelled, and what may still be reported
    } parts[] = {{"decode", 0, 0.288}, {"measure motion", 0.3, 0.31}, {"extract frames", 0.6, 0.8}, {"write pictures", 0.85, 0.86}};
    for (const auto& part : parts) {
        SCOPED_TRACE(part.name);
        std::atomic<bool> cancel{false};
        double last = 0;
        const auto done = importCapture(options, &cancel, [&](double share, const std::string&) {
            last = share;
            if (share >= part.from) cancel = true;
            return true;
        });
        ASSERT_FALSE(done);
        EXPECT_EQ(done.error().code, Code::Cancelled);
        EXPECT_LE(last, part.atMost);
        EXPECT_FALSE(fs::exists(options.out) || fs::exists(folder.path / "scan.partial"));
    }
}

TEST_F(VideoFiles, aFullDiskIsNotBlamedOnTheVideo) {
    if (!fs::exists("/dev/full")) GTEST_SKIP() << "there is no /dev/full";
    const auto info = probeVideo(make("plain.mp4", h264()), work);
    ASSERT_TRUE(info) << info.error().message;
    fs::create_symlink("/dev/full", work.folder / "small.raw");
    const auto analysis = analyseVideo(*info, work);
    ASSERT_FALSE(analysis);
    EXPECT_EQ(analysis.error().code, Code::Io);
    EXPECT_TRUE(mentions(analysis.error().message, {work.folder.c_str(), "disk is full", "-o"}));
}

TEST_F(VideoFiles, aPictureThatIsNamedAsAVideoIsNotCalledByFfmpegsWords) {
    const fs::path path = folder.path / "walk.mp4";
    writeBytes(path, jpegOf(spotPicture(96, 128, kMadePixel)));
    const auto info = probeVideo(path, work);
    ASSERT_FALSE(info);
    EXPECT_TRUE(mentions(info.error().message, {"walk.mp4", "not a kind of video that is read"}));
}

TEST_F(VideoFiles, calibratedVideosAloneLackAStillPart) {
    make("cam01.mp4", h264(), "", "96x128");
    writeText(folder.path / "Calib.qca.txt", qualisysText());
    ImportOptions options;
    options.source = folder.path / "Calib.qca.txt";
    options.out = folder.path / "scan";
    const auto done = importCapture(options, nullptr, {});
    ASSERT_TRUE(done) << done.error().message;
    EXPECT_TRUE(mentions(done->nextStep, {"only 0 full-body pictures of the still subject", "static_full", "scan.json"}));
    EXPECT_EQ(done->nextStep.find("doppel reconstruct"), std::string::npos) << "it would refuse: " << done->nextStep;
}

TEST_F(VideoFiles, fourRealCamerasAreCutAtTheSameMoments) {
    const auto data = sharedData("real-multiview-balance/Calib.qca.txt");
    if (!data) GTEST_SKIP() << "shared data (real-multiview-balance) is not on this machine";
    ImportOptions options;
    options.source = *data;
    options.out = folder.path / "scan";
    options.counts.moving = 8;
    const auto done = importCapture(options, nullptr, {});
    ASSERT_TRUE(done) << done.error().message;
    const auto scan = readScan(options.out);
    ASSERT_TRUE(scan) << scan.error().message;
    ASSERT_EQ(scan->frames.size(), 8u);
    EXPECT_EQ(scan->frames[0].camera.widthPx, 1080u);  // as on disk, though the calibration says 1088
    EXPECT_EQ(scan->frames[4].camera.widthPx, 1088u);
    for (size_t i = 0; i < 8; ++i) EXPECT_EQ(scan->frames[i].timeS, scan->frames[i % 2].timeS);
    EXPECT_TRUE(scan->frames[0].lens.any());
}

}  // namespace
}  // namespace dpl
