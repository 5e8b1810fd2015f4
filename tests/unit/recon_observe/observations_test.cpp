// SPDX-License-Identifier: Apache-2.0
// Observations by networks: outputs match reference values, landmarks become keypoints, real pictures give plausible results.
#include "reconstruction/input/observe/observations.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>

#include "reconstruction/base/models_folder.h"
#include "reconstruction/input/capture/frame_picture.h"
#include "reconstruction/input/capture/hand_keypoints.h"
#include "reconstruction/input/capture/scan_check.h"
#include "reconstruction/input/observe/onnx_net.h"
#include "tests/unit/must.h"
#include "tests/unit/recon_capture/scan_builder.h"
#include "tests/unit/recon_observe/biker.h"
#include "tests/unit/shared_data.h"

namespace dpl {
namespace {

/** The made-up picture of golden.json. */
std::vector<float> madeUpPicture(int side) {
    std::vector<float> input(size_t(3) * size_t(side) * size_t(side));
    for (size_t i = 0; i < input.size(); ++i) input[i] = float((i * 7919) % 1000) / 1000.0f;
    return input;
}

TEST(OnnxNet, agreesWithTheGoldenValuesOfAnotherRuntime) {
    const auto models = sharedData("models");
    if (!models) GTEST_SKIP() << "shared data (models) is not on this machine";
    std::ifstream in(*models / "golden.json");
    const auto golden = nlohmann::json::parse(in);
    for (const auto& [file, side] : {std::pair{"blazepose_full.onnx", 256},
                                     {"blazepose_lite.onnx", 256},
                                     {"selfie_seg.onnx", 256},
                                     {"skin_clothes_hair_pan.onnx", 512}}) {
        auto net = OnnxNet::load(*models / file);
        ASSERT_TRUE(net) << net.error().message;
        auto outputs = net->run(madeUpPicture(side), side);
        ASSERT_TRUE(outputs) << outputs.error().message;
        const auto& want = golden.at(file);
        // The golden file holds the first output in onnxruntime's order. It is found by its length.
        const size_t count = want.at("first_output_count");
        const auto found = std::find_if(outputs->begin(), outputs->end(), [&](const Tensor& t) { return t.data.size() == count; });
        ASSERT_NE(found, outputs->end()) << file;
        for (size_t i = 0; i < want.at("first8").size(); ++i)
            EXPECT_NEAR(found->data[i], want.at("first8")[i].get<double>(), 2e-5)
                << file;  // golden.json states 4e-6; five times that allows for other CPUs
    }
}

/** What the network of a file gives for an input of side × side; empty, with a failure, where it cannot be run. */
std::vector<Tensor> outputsOf(const std::filesystem::path& file, const std::vector<float>& input, int side) {
    auto net = OnnxNet::load(file);
    EXPECT_TRUE(net) << net.error().message;
    if (!net) return {};
    auto outputs = net->run(input, side);
    EXPECT_TRUE(outputs) << outputs.error().message;
    return outputs ? *outputs : std::vector<Tensor>();
}

/** The output of this name; an empty one, with a failure, where there is none. */
Tensor named(const std::vector<Tensor>& outputs, std::string_view name) {
    const auto found = std::find_if(outputs.begin(), outputs.end(), [&](const Tensor& t) { return t.name == name; });
    EXPECT_NE(found, outputs.end()) << name;
    return found == outputs.end() ? Tensor() : *found;
}

TEST(OnnxNet, installedNetworksGiveThePinnedValues) {
    const auto models = installedModels();
    if (models.empty()) GTEST_SKIP() << "tools/models has not installed networks";
    const auto pose = outputsOf(models / "blazepose_full.onnx", madeUpPicture(256), 256);
    ASSERT_EQ(named(pose, "output_poseflag").data.size(), 1u);
    EXPECT_NEAR(named(pose, "output_poseflag").data[0], 0.002842336893081665, 2e-5);  // golden.json: onnxruntime on another conversion
    const Tensor landmarks = named(pose, "ld_3d");
    ASSERT_EQ(landmarks.data.size(), 195u);
    const double first[] = {147.6309, 65.68425, -55.39031};  // of OpenCV 4.6, equal for both conversions
    for (size_t i = 0; i < 3; ++i) EXPECT_NEAR(landmarks.data[i], first[i], 1e-3);
    const auto people = outputsOf(models / "blazepose_detector.onnx", madeUpPicture(224), 224);
    ASSERT_FALSE(people.empty());
    EXPECT_EQ(people[0].shape, (std::vector<int>{1, 2254, 13}));
}

TEST(OnnxNet, installedHeavyNetworkGivesThePinnedLandmarks) {
    const auto path = installedModels() / "blazepose_heavy.onnx";
    if (!std::filesystem::exists(path))
        GTEST_SKIP() << "tools/models has not installed blazepose_heavy.onnx; installs of before the evening of 25 November lack it";
    const Tensor landmarks = named(outputsOf(path, madeUpPicture(256), 256), "ld_3d");
    ASSERT_EQ(landmarks.data.size(), 195u);
    const double first[] = {124.62334, 56.20997, -57.22068};  // of OpenCV 4.6, our conversion alone
    for (size_t i = 0; i < 3; ++i) EXPECT_NEAR(landmarks.data[i], first[i], 1e-3);
}

TEST(OnnxNet, installedNetworksOfHandsGiveThePinnedValues) {
    const auto folder = installedModels();
    if (folder.empty() || !std::filesystem::exists(folder / "hand_landmarks.onnx"))
        GTEST_SKIP() << "tools/models has not installed hand_landmarks.onnx; installs of before the evening of 29 November lack it";
    const auto hand = outputsOf(folder / "hand_landmarks.onnx", madeUpPicture(224), 224);
    ASSERT_EQ(hand.size(), 4u);
    ASSERT_EQ(hand[0].data.size(), 63u);
    const double first[] = {111.41124, 180.26859, 0.0000767};  // of OpenCV 4.6; NumPy agrees (tests/models/compare_with_numpy.py)
    for (size_t i = 0; i < 3; ++i) EXPECT_NEAR(hand[0].data[i], first[i], 1e-3);
    EXPECT_LT(hand[1].data[0], 0.1) << "noise is no hand";
    const auto palms = outputsOf(folder / "palm_detector.onnx", madeUpPicture(256), 256);
    ASSERT_EQ(palms.size(), 1u);
    EXPECT_EQ(palms[0].shape, (std::vector<int>{1, 2944, 19}));
}

TEST(OnnxNet, installedSelfieSegmentationGivesThePinnedMask) {
    const auto path = installedModels() / "selfie_seg.onnx";
    if (!std::filesystem::exists(path))
        GTEST_SKIP() << "tools/models has not installed selfie_seg.onnx; installs of before 25 November lack it";
    // A black head and shoulders before white: in the noise of madeUpPicture() the network sees nobody.
    constexpr int kSide = 256;
    std::vector<float> picture;
    for (int c = 0; c < 3; ++c)
        for (int y = 0; y < kSide; ++y)
            for (int x = 0; x < kSide; ++x) {
                const auto inside = [&](double centreY, double width, double height) {
                    return std::pow((x - 128) / width, 2) + std::pow((y - centreY) / height, 2) < 1;
                };
                picture.push_back(inside(90, 45, 60) || inside(256, 100, 110) ? 0.0f : 1.0f);
            }
    for (const auto& [input, mean] :
         {std::pair{picture, 0.389988}, {madeUpPicture(kSide), 0.0}}) {  // of OpenCV 4.6, equal for both conversions
        const auto outputs = outputsOf(path, input, kSide);
        ASSERT_EQ(outputs.size(), 1u);
        const Tensor& mask = outputs.front();
        EXPECT_EQ(mask.shape, (std::vector<int>{1, 1, kSide, kSide}));
        double sum = 0;
        for (const float v : mask.data) sum += v;
        EXPECT_NEAR(sum / double(mask.data.size()), mean, 2e-5);
    }
}

TEST(ModelsFolder, followsTheXdgSpecification) {
    const char* before = std::getenv("XDG_DATA_HOME");
    const std::string kept = before ? before : "";
    TemporaryFolder folder;
    ::setenv("XDG_DATA_HOME", folder.path.c_str(), 1);
    EXPECT_EQ(userModelsFolder(), folder.path / "doppel" / "models");
    EXPECT_TRUE(installedModels().empty());
    std::filesystem::create_directories(userModelsFolder());
    writeText(userModelsFolder() / "blazepose_full.onnx", "a network");
    EXPECT_EQ(installedModels(), userModelsFolder());
    ::setenv("XDG_DATA_HOME", "relative", 1);
    EXPECT_EQ(userModelsFolder(), std::filesystem::path(std::getenv("HOME")) / ".local/share/doppel/models");
    before ? ::setenv("XDG_DATA_HOME", kept.c_str(), 1) : ::unsetenv("XDG_DATA_HOME");
}

TEST(OnnxNet, aDamagedNetworkIsAnError) {
    TemporaryFolder folder;
    writeText(folder.path / "blazepose_full.onnx", "not a network");
    auto net = OnnxNet::load(folder.path / "blazepose_full.onnx");
    ASSERT_FALSE(net);
    EXPECT_TRUE(mentions(net.error().message, {"blazepose_full.onnx", "download"}));
    EXPECT_FALSE(Observer::load(folder.path / "nowhere"));
}

TEST(Landmarks, becomeTheTwentyFourNames) {
    // Hand-made landmarks of a front view: the subject's left is on the right of the picture.
    std::vector<Vec2d> p(33, Vec2d(50, 50));
    std::vector<double> confidence(33, 0.9);
    p[0] = {50, 20}, p[7] = {55, 20}, p[8] = {45, 20};
    p[11] = {65, 40}, p[12] = {35, 40}, p[23] = {58, 90}, p[24] = {42, 90};
    p[25] = {58, 140}, p[26] = {42, 140};
    p[17] = {90, 90}, p[19] = {86, 92};
    p[29] = {58, 160}, p[31] = {62, 170};
    confidence[16] = 0.01;
    ImageGrey8 mask{100, 200, std::vector<uint8_t>(100 * 200, 0)};
    for (uint32_t y = 10; y < 180; ++y)
        for (uint32_t x = 30; x < 70; ++x) mask.pixels[y * 100 + x] = 255;
    const auto names = observedKeypointNames();
    const auto k = keypointsFromLandmarks(p, confidence, &mask);
    ASSERT_EQ(k.size(), names.size());
    const auto at = [&](const char* name) { return k[size_t(std::find(names.begin(), names.end(), name) - names.begin())]; };
    EXPECT_EQ(at("nose").px, Vec2d(50, 20));
    EXPECT_EQ(at("knuckle_l").px, Vec2d(88, 91));
    EXPECT_NEAR(at("pelvis").px.x, 50, 1e-12);
    EXPECT_NEAR(at("pelvis").px.y, 84, 1e-9) << "raised by 12 % of a trunk of 50";
    EXPECT_NEAR(at("shoulder_l").px.y, 43, 1e-9);
    EXPECT_NEAR(at("knee_l").px.y, 137, 1e-9) << "raised by 6 % of a thigh of 50, which begins where the network marks the hip";
    EXPECT_GT(at("neck").px.y, at("nose").px.y);
    EXPECT_LT(at("neck").px.y, at("shoulder_l").px.y);
    EXPECT_NEAR(at("head_top").px.y, 10, 0.5) << "where the mask ends above the ears";
    EXPECT_EQ(at("wrist_r").confidence, 0) << "an unseen point is missing, not uncertain";
    EXPECT_LT(at("neck").confidence, 0.9);
    EXPECT_EQ(keypointsFromLandmarks(std::span(p).first(10), confidence, nullptr)[0].confidence, 0);
}

TEST(Observations, bikerIsSeenTheSameOnOneThreadAndTwo) {
    const auto models = sharedData("models"), biker = sharedData("real-orbit-biker");
    if (!models || !biker) GTEST_SKIP() << "shared data (models, real-orbit-biker) is not on this machine";
    auto all = readScan(*biker);
    ASSERT_TRUE(all) << all.error().message;
    Scan scan = *all;
    scan.frames.clear();
    for (size_t i = 0; i < all->frames.size(); i += 24) scan.frames.push_back(all->frames[i]);
    TemporaryFolder folder;
    std::vector<std::string> bytes;
    for (const uint32_t threads : {1u, 2u}) {
        Jobs jobs(threads);
        const auto output = folder.path / std::to_string(threads);
        std::string notes;
        const Status status = observeScan(scan, {*models, output, {}, [&](const std::string& text) { notes += text; }}, jobs);
        ASSERT_TRUE(status) << status.error().message;
        EXPECT_NE(notes.find("hand_landmarks.onnx, so fingers stay"), std::string::npos) << "the shared networks do not see hands";
        const Scan observed = withObservations(scan, output);
        ASSERT_EQ(observed.keypointNames.size(), 24u);
        std::string everything;
        size_t hair = 0;
        for (const auto& frame : observed.frames) {
            EXPECT_EQ(frame.maskPath.parent_path().filename(), "masks") << "a mask that the scan brings is kept";
            EXPECT_FALSE(frame.maskFound);
            EXPECT_TRUE(must(readHandKeypoints(observed, frame)).empty());
            for (const auto& path : {frame.keypointsPath, frame.labelsPath}) {
                std::ifstream in(path, std::ios::binary);
                everything += std::string{std::istreambuf_iterator<char>(in), {}};
            }
            auto points = readKeypoints(observed, frame);
            ASSERT_TRUE(points) << points.error().message;
            auto mask = readFrameMask(frame);
            auto labels = readFrameLabels(frame);
            ASSERT_TRUE(mask && labels);
            int confident = 0, on = 0;
            for (const auto& k : *points) {
                if (k.confidence < 0.5) continue;
                ++confident;
                on += mask->pixels[size_t(k.px.y) * mask->widthPx + size_t(k.px.x)] >= 128;
            }
            EXPECT_GE(confident, 10) << frame.name;
            EXPECT_GE(on, confident - 3) << frame.name;
            std::array<size_t, 256> histogram{};
            for (const uint8_t v : labels->pixels) ++histogram[v];
            EXPECT_GT(histogram[2] + histogram[3], 3 * histogram[1]) << "he wears leather from neck to foot; 7 to 9 times measured";
            hair += histogram[4];
        }
        EXPECT_GT(hair, 0u);
        bytes.push_back(everything);
    }
    EXPECT_TRUE(bytes[0] == bytes[1]);
}

TEST(Observations, bikersMaskIsFoundWithoutHisMask) {
    auto biker = loadBiker();
    if (!biker) GTEST_SKIP() << kNoBiker;
    const auto [image, truth] = biker->view(10);
    const Observation seen = biker->observe(image);
    EXPECT_GT(seen.personScore, 0.9);
    EXPECT_GT(maskIou(truth, seen.mask), 0.9);  // the PROVENANCE file of the pictures states 0.93 to 0.98
}

TEST(Observations, aScanKnowsWhichMasksWereFound) {
    TemporaryFolder folder;
    std::filesystem::create_directories(folder.path / "masks");
    for (const char* name : {"bare", "masked"}) std::ofstream(folder.path / "masks" / (std::string(name) + ".png")) << "found";
    Scan scan;
    scan.keypointNames = {"nose"};
    for (const char* name : {"bare", "masked", "unseen"}) scan.frames.emplace_back().name = name;
    scan.frames[1].maskPath = "own.png";
    const Scan observed = withObservations(scan, folder.path);
    EXPECT_TRUE(observed.frames[0].maskFound);
    EXPECT_FALSE(observed.frames[1].maskFound);
    EXPECT_EQ(observed.frames[1].maskPath, "own.png");
    EXPECT_FALSE(observed.frames[2].maskFound) << "nothing was found";
}

TEST(Observations, aMirroredPictureHasTheMirroredPerson) {
    auto biker = loadBiker();
    if (!biker) GTEST_SKIP() << kNoBiker;
    const ImageRgb8 image = biker->view(10).image;  // he is seen from behind
    ImageRgb8 mirrored = image;
    for (uint32_t y = 0; y < image.heightPx; ++y)
        for (uint32_t x = 0; x < image.widthPx; ++x)
            for (size_t c = 0; c < 3; ++c)
                mirrored.pixels[3 * (size_t(y) * image.widthPx + x) + c] =
                    image.pixels[3 * (size_t(y) * image.widthPx + image.widthPx - 1 - x) + c];
    const Observation seen = biker->observe(image), other = biker->observe(mirrored);
    const auto names = observedKeypointNames();
    const auto at = [&](const Observation& o, std::string name) {
        return o.keypoints[size_t(std::find(names.begin(), names.end(), name) - names.begin())].px;
    };
    const double trunk = glm::length(at(seen, "neck") - at(seen, "pelvis"));
    for (const std::string joint : {"shoulder_", "elbow_", "hip_", "knee_", "ankle_"}) {
        for (const auto& [side, otherSide] : {std::pair{"l", "r"}, {"r", "l"}}) {
            Vec2d there = at(other, joint + otherSide);
            there.x = image.widthPx - there.x;
            EXPECT_LT(glm::length(there - at(seen, joint + side)), 0.1 * trunk) << joint << side;
        }
        // Landmarks of one side that were averaged with those of the other would meet in the middle.
        EXPECT_GT(at(seen, joint + "r").x - at(seen, joint + "l").x, 0.15 * trunk) << joint;
    }
}

TEST(Observations, handsAreFoundAtTheWristsOfTheirArms) {
    const auto pictures = sharedData("scan-a");
    const auto models = installedModels();
    if (!pictures || models.empty() || !std::filesystem::exists(models / "hand_landmarks.onnx"))
        GTEST_SKIP() << "shared data (scan-a) is not on this machine, or tools/models has not installed hand_landmarks.onnx";
    const Scan scan = must(readScan(*pictures));
    Observer observer = must(Observer::load(models));
    ASSERT_TRUE(observer.hasHands());
    size_t found = 0;
    for (const char* name : {"full_000", "full_004", "full_026"}) {  // from in front, from both sides
        const auto frame = std::find_if(scan.frames.begin(), scan.frames.end(), [&](const ScanFrame& f) { return f.name == name; });
        ASSERT_NE(frame, scan.frames.end());
        const ImageRgb8 image = must(readFrameImage(*frame));
        const ImageGrey8 mask = must(readFrameMask(*frame));
        const Observation seen = must(observer.observe(image, &mask));
        if (seen.hands.empty()) continue;
        ASSERT_EQ(seen.hands.size(), 2 * kHandPoints);
        const std::vector<Keypoint> body = must(readKeypoints(scan, *frame));
        for (size_t side = 0; side < 2; ++side) {
            const Keypoint* hand = &seen.hands[side * kHandPoints];
            if (!(hand[0].confidence > 0)) continue;
            ++found;
            const auto wrist = std::find(scan.keypointNames.begin(), scan.keypointNames.end(), side == 0 ? "wrist_l" : "wrist_r");
            const Vec2d at = body[size_t(wrist - scan.keypointNames.begin())].px, base = hand[2 * kFingerPoints].px,
                        tip = hand[3 * kFingerPoints - 1].px;
            EXPECT_LT(glm::length(base - at), 30) << name;  // a hand is 45 to 70 px long
            EXPECT_GT(glm::length(tip - at), glm::length(base - at)) << name;
        }
    }
    EXPECT_GE(found, 4u);
}

TEST(Observations, anEmptyPictureHasNobody) {
    const auto models = sharedData("models");
    if (!models) GTEST_SKIP() << "shared data (models) is not on this machine";
    auto observer = Observer::load(*models);
    ASSERT_TRUE(observer) << observer.error().message;
    const ImageRgb8 grey{64, 48, std::vector<uint8_t>(64 * 48 * 3, 128)};
    auto seen = observer->observe(grey, nullptr);
    ASSERT_TRUE(seen) << seen.error().message;
    EXPECT_LT(seen->personScore, 0.5);
    for (const auto& k : seen->keypoints) EXPECT_EQ(k.confidence, 0);
    EXPECT_EQ(*std::max_element(seen->mask.pixels.begin(), seen->mask.pixels.end()), 0);
    const ImageGrey8 wrong{2, 2, {0, 0, 0, 0}};
    EXPECT_FALSE(observer->observe(grey, &wrong));
}

}  // namespace
}  // namespace dpl
