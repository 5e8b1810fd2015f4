// SPDX-License-Identifier: Apache-2.0
// A subject of the NeuMan layout becomes a scan with the published split. The folder is made of the procedural subject.
#include "reconstruction/input/import/neuman.h"

#include "reconstruction/input/import/import.h"
#include "reconstruction/input/import/layout.h"
#include "tests/unit/recon_import/made_neuman.h"

namespace dpl {
namespace {

namespace fs = std::filesystem;

/** The made scan, once for all tests. */
const Scan& madeScan() {
    struct Made {
        fs::path folder = fs::temp_directory_path() / ("dpl_neuman_" + std::to_string(::getpid()));
        Scan scan;
        Made() {
            SampleScanOptions options;
            options.widthPx = 48, options.heightPx = 64;
            options.fullFrames = 4, options.closeupFrames = 0, options.dynamicFrames = 20;
            options.samplesPerPixel = 1;
            Jobs jobs(2);
            fs::remove_all(folder);
            if (const Status done = makeSampleScan(folder, options, jobs); !done) throw std::runtime_error(done.error().message);
            scan = must(readScan(folder));
        }
        ~Made() { fs::remove_all(folder); }
    };
    static const Made made;
    return made.scan;
}

ImportOptions importOf(const fs::path& source, const fs::path& out) {
    ImportOptions options;
    options.source = source, options.out = out;
    return options;
}

/** What the import says of a broken folder. */
std::string neumanRefusal(const fs::path& source) {
    const auto done = importCapture(importOf(source, source.parent_path() / "refused"), nullptr, {});
    EXPECT_FALSE(fs::exists(source.parent_path() / "refused"));
    return done ? "accepted: " + done->summary : done.error().message;
}

class Neuman : public testing::Test {
protected:
    TemporaryFolder folder;
    fs::path root = folder.path / "bike";
    Neuman() { writeNeuman(madeScan(), root); }
};

TEST_F(Neuman, becomesAScanOfMovingFramesInTheVideosOrder) {
    EXPECT_EQ(must(recogniseCapture(root)).kind, CaptureKind::Neuman);
    const std::string summary = must(importCapture(importOf(root, folder.path / "scan"), nullptr, {})).summary;
    EXPECT_TRUE(mentions(summary, {"NeuMan", "2 frames are held out", "2 of the validation split"}));
    const Scan scan = must(readScan(folder.path / "scan"));
    const std::vector<ScanFrame> truth = movingFrames(madeScan());
    EXPECT_EQ(scan.protocol, "neuman");
    EXPECT_FALSE(scan.metricWorld);
    EXPECT_TRUE(scan.splitStated);
    ASSERT_EQ(truth.size(), 20u);
    ASSERT_EQ(scan.frames.size(), 18u);
    size_t i = 0;
    for (const ScanFrame& frame : scan.frames) {
        if (i == 12 || i == 17) ++i;  // validation
        EXPECT_EQ(frame.kind, FrameKind::Dynamic);
        EXPECT_EQ(frame.split, i == 2 || i == 7 ? Split::Test : Split::Train) << frame.name;
        EXPECT_NEAR(frame.timeS, double(i) / 3, 1e-9);
        // The same picture and mask, and a camera that sees each point where the made scan's sees it.
        EXPECT_EQ(must(readFrameImage(frame)).pixels, must(readFrameImage(truth[i])).pixels) << frame.name;
        ImageGrey8 mask = must(readFrameMask(truth[i]));
        for (uint8_t& value : mask.pixels) value = value >= 128 ? 255 : 0;
        EXPECT_EQ(must(readFrameMask(frame)).pixels, mask.pixels) << frame.name;
        for (const Vec3d& point : {Vec3d(0.1, 1.2, 0), Vec3d(-0.4, 0.3, 0.2)}) {
            const Vec3d moved = kNeumanScale * kNeumanTurn * point + kNeumanShift;
            // 1e-6 px: the file holds every digit, rotations go through quaternions.
            EXPECT_LT(
                glm::length(frame.camera.pixelOf(frame.camera.toView(moved)) - truth[i].camera.pixelOf(truth[i].camera.toView(point))),
                1e-6);
        }
        const std::vector<Keypoint> seen = must(readKeypoints(scan, frame)), given = must(readKeypoints(madeScan(), truth[i]));
        ASSERT_EQ(seen.size(), kCocoOrder.size());
        for (size_t k = 0; k < seen.size(); ++k) {
            const auto at = std::find(madeScan().keypointNames.begin(), madeScan().keypointNames.end(), scan.keypointNames[k]);
            const Keypoint& expected = given.at(size_t(at - madeScan().keypointNames.begin()));
            if (expected.confidence > 0) {
                EXPECT_LT(glm::length(seen[k].px - expected.px), 1e-4) << scan.keypointNames[k];  // floats
            }
            EXPECT_NEAR(seen[k].confidence, expected.confidence, 1e-6);
        }
        ++i;
    }
}

TEST(NeumanSplit, isAsPublished) {
    // By hand from the published rule: n/5 frames, every int(n / (n/5)) from half of that on; their first half is the test.
    const auto chosen = [](size_t n, NeumanSplit which) {
        std::vector<size_t> out;
        const auto splits = neumanSplits(n);
        for (size_t i = 0; i < splits.size(); ++i)
            if (splits[i] == which) out.push_back(i);
        return out;
    };
    EXPECT_EQ(chosen(20, NeumanSplit::Test), (std::vector<size_t>{2, 7}));
    EXPECT_EQ(chosen(20, NeumanSplit::Validation), (std::vector<size_t>{12, 17}));
    // 104 / 20 = 5.2, so every fifth: 2, 7, … 102, which are 21; 10 are for the test.
    EXPECT_EQ(chosen(104, NeumanSplit::Test), (std::vector<size_t>{2, 7, 12, 17, 22, 27, 32, 37, 42, 47}));
    EXPECT_EQ(chosen(104, NeumanSplit::Validation).size(), 11u);
    EXPECT_EQ(chosen(104, NeumanSplit::Train).size(), 83u);
    EXPECT_EQ(chosen(39, NeumanSplit::Test), (std::vector<size_t>{2, 7, 12, 17}));  // 39 / 7 = 5.57
    EXPECT_EQ(chosen(4, NeumanSplit::Train).size(), 4u);
}

TEST_F(Neuman, listsOfTheFolderWinOverTheRule) {
    writeText(root / "train_split.txt", neumanName(0) + "\n" + neumanName(4) + "\r\n" + neumanName(5) + "\n\n");
    writeText(root / "test_split.txt", neumanName(3) + "\n");
    writeText(root / "val_split.txt", neumanName(9) + "\n");
    const std::string summary = must(importCapture(importOf(root, folder.path / "scan"), nullptr, {})).summary;
    EXPECT_TRUE(mentions(summary, {"1 frames are held out", "16 of the validation split"}));
    const Scan scan = must(readScan(folder.path / "scan"));
    ASSERT_EQ(scan.frames.size(), 4u);
    EXPECT_EQ(scan.frames[1].name, "dyn_0003");
    EXPECT_EQ(scan.frames[1].split, Split::Test);
    EXPECT_EQ(scan.frames[2].split, Split::Train);
}

TEST_F(Neuman, keypointsOfSomeFramesAreNotUsed) {
    fs::remove(root / "keypoints" / (neumanName(4) + ".npy"));
    EXPECT_TRUE(mentions(must(importCapture(importOf(root, folder.path / "scan"), nullptr, {})).summary, {"networks will find keypoints"}));
    EXPECT_TRUE(must(readScan(folder.path / "scan")).keypointNames.empty());
}

TEST_F(Neuman, whatIsWrongIsNamed) {
    const auto refuse = [&](const std::function<void()>& breakIt, std::initializer_list<const char*> words) {
        fs::remove_all(root);
        writeNeuman(madeScan(), root);
        breakIt();
        EXPECT_TRUE(mentions(neumanRefusal(root), words));
    };
    const auto keypoints = root / "keypoints" / (neumanName(4) + ".npy");
    refuse([&] { fs::remove(root / "segmentations" / neumanName(4)); }, {"00004.png", "mask"});
    refuse([&] { fs::remove(root / "images" / neumanName(4)); }, {"00004.png"});
    refuse([&] { writeText(root / "test_split.txt", neumanName(3)); }, {"train_split.txt"});
    refuse(
        [&] {
            writeText(root / "train_split.txt", neumanName(3));
            writeText(root / "test_split.txt", "00099.png");
        },
        {"test_split.txt", "00099.png", "not a picture"});
    refuse(
        [&] {
            writeText(root / "train_split.txt", neumanName(3));
            writeText(root / "test_split.txt", neumanName(3));
        },
        {"test_split.txt", "listed twice"});
    refuse(
        [&] {
            writeText(root / "train_split.txt", "../../etc/passwd");
            writeText(root / "test_split.txt", neumanName(3));
        },
        {"train_split.txt", "line 1"});
    refuse(
        [&] {
            writeText(root / "train_split.txt", "\n");
            writeText(root / "test_split.txt", neumanName(3));
        },
        {"1 of 1 frames are for testing"});
    refuse([&] { writeBytes(keypoints, npyOf("(2, 17, 3)", std::vector<float>(102))); }, {"00004.png.npy", "at most 51"});
    refuse([&] { writeBytes(keypoints, npyOf("(3, 17)", std::vector<float>(51))); }, {"00004.png.npy", "17 x 3"});
    refuse([&] { writeBytes(keypoints, npyOf("(17, 3)", std::vector<float>(51, -1))); }, {"00004.png.npy", "keypoint 0"});
    refuse([&] { writeBytes(keypoints, npyOf("(17, 3)", std::vector<float>(51, NAN))); }, {"00004.png.npy", "keypoint 0"});
    refuse([&] { writeBytes(root / "segmentations" / neumanName(4), must(encodePng(std::vector<uint8_t>(16), 4, 4, 1))); },
           {"mask", "4 x 4"});
}

TEST(NeumanKeypoints, everyTruncationIsRefused) {
    const auto bytes = npyOf("(17, 3)", std::vector<float>(51, 1));
    ASSERT_TRUE(parseNeumanKeypoints(bytes, "k.npy"));
    for (size_t length = 0; length < bytes.size(); ++length) EXPECT_FALSE(parseNeumanKeypoints({bytes.data(), length}, "k.npy")) << length;
}

}  // namespace
}  // namespace dpl
