// SPDX-License-Identifier: Apache-2.0
// The plain frame against the double-precision referee, at the bars it had when it was frozen, and that it stays frozen.
#include "tools/bench/baseline/plain_frame.h"

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "sdk/backend/shader_pack.h"
#include "sdk/format/avatar_file.h"
#include "tests/reference/random_avatar.h"
#include "tests/unit/format/sample_correctives.h"
#include "tests/unit/render/vulkan_image.h"
#include "tools/bench/baseline/plain_file.h"

namespace dpl {
namespace {

/** One plain frame, or the reason why there is none. Validation is on where the layer is installed. */
struct TestPlain {
    VulkanTestOptions options = testVulkanOptions();
    std::unique_ptr<plain::Frame> frame;
    std::string missing;

    explicit TestPlain(PlainFill fill = PlainFill::Quads) {
        auto backend = plain::createBackend(options.request());
        if (!backend && backend.error().code == Code::NotFound) {
            std::printf("[   NOTE   ] %s\n", backend.error().message.c_str());
            options.enableValidation = false;
            backend = plain::createBackend(options.request());
        }
        if (backend)
            frame = std::make_unique<plain::Frame>(std::move(*backend), fill);
        else
            missing = backend.error().message;
    }
    ~TestPlain() {
        frame.reset();
        EXPECT_EQ(options.validationMessages->load(), 0u) << "validation layer messages, see the log above";
    }
};

#define DPL_NEED_PLAIN(plain) \
    if (!(plain).frame) GTEST_SKIP() << (plain).missing

std::vector<RenderedView> draw(plain::Frame& frame, const Pose& pose, std::span<const Cameraf> views) {
    std::vector<RenderedView> pictures;
    const Status drawn = frame.draw(pose, views);
    EXPECT_TRUE(drawn) << (drawn ? "" : drawn.error().message);
    const auto read = frame.read();
    EXPECT_TRUE(read) << (read ? "" : read.error().message);
    for (size_t v = 0; read && v < read->size(); ++v)
        pictures.push_back({views[v].widthPx, views[v].heightPx, {(*read)[v].begin(), (*read)[v].end()}, {}});
    pictures.resize(views.size());
    return pictures;
}

void expectAgrees(const std::string& name, const RenderedView& picture, const ReferenceImage& want, double minCovered = 0.005) {
    const Difference d = compare(picture, want);
    std::printf("[  IMAGE   ] plain, %-20s: colour %.1f dB (max %.4f), alpha %.1f dB, covered %.1f %%\n", name.c_str(), d.psnrDb,
                d.maxError, d.alphaPsnrDb, d.covered * 100);
    dumpPicture(("plain_" + name).c_str(), picture);
    EXPECT_GT(d.covered, minCovered) << name;
    EXPECT_GE(d.psnrDb, kMinPsnrDb) << name;
    EXPECT_GE(d.alphaPsnrDb, kMinPsnrDb) << name;
}

/** The referee without bounds of stretch, which came after the plain frame was frozen. */
ReferenceImage unboundedReference(const AvatarData& avatar, const Pose& pose, const Cameraf& camera) {
    ReferenceScene scene = sceneOf(avatar, pose);
    scene.stretchIsBounded = false;
    const ReferenceCamera seen = referenceCamera(camera);
    return renderReference(
        scene, seen,
        {.kappaPx2 = avatar.kappaPx2, .compensated = avatar.compensated, .fourSamples = referenceFourSamples(avatar, pose, seen)});
}

void expectAvatarAgrees(const std::string& name, const std::shared_ptr<const AvatarData>& avatar, const Pose& pose, const Cameraf& camera) {
    const ReferenceImage want = unboundedReference(*avatar, pose, camera);
    for (const PlainFill fill : {PlainFill::Quads, PlainFill::Tiles}) {
        TestPlain plain(fill);
        DPL_NEED_PLAIN(plain);
        const Status loaded = plain.frame->load(avatar);
        ASSERT_TRUE(loaded) << loaded.error().message;
        expectAgrees(name + (fill == PlainFill::Tiles ? ", tiles" : ""), draw(*plain.frame, pose, {&camera, 1})[0], want);
    }
}

TEST(PlainFrame, equalsTheReferenceInSeveralPosesAndViews) {
    struct Case {
        const char* name;
        bool singleFace;
        uint32_t shDegree;
        float bend, turn, azimuth, distanceM;
    };
    const Case cases[] = {{"rest", true, 2, 0, 0, 0, 1.8f},
                          {"bent", true, 3, 1.1f, 0.4f, 0.7f, 1.8f},
                          {"bent_back", false, 2, -0.8f, 2, 2.5f, 1.8f},
                          {"close", true, 1, 0.5f, 0, -1.2f, 0.32f},
                          {"far", false, 0, 0.3f, 1, 3.1f, 8.0f}};
    for (const Case& c : cases)
        expectAvatarAgrees(c.name, std::make_shared<const AvatarData>(makeTube({.shDegree = c.shDegree, .singleFace = c.singleFace})),
                           tubePose(c.bend, c.turn), tubeCamera(160, 192, c.azimuth, c.distanceM));
}

TEST(PlainFrame, correctivesMoveAndLightTheSurfaceAsInTheReference) {
    struct Case {
        const char* name;
        test::CorrectiveOptions correctives;
        uint32_t shDegree;
        float bend, turn;
    };
    const Case cases[] = {{"moderate", {.light = 0.3f, .reach = 100}, 3, 1.1f, 0.4f},
                          {"clamped", {.modes = 5, .nodes = 40, .light = 2, .reach = 100}, 2, -0.8f, 2},
                          {"beyond", {.modes = 64, .nodes = 500, .offsetM = 0.05f, .light = 3, .reach = 0.8f}, 0, 0.9f, 1}};
    for (const Case& c : cases) {
        const AvatarData bare = makeTube({.shDegree = c.shDegree, .colourSpread = 0.3f});
        const auto avatar = std::make_shared<const AvatarData>(test::withCorrectives(bare, 6, c.correctives));
        const Pose pose = tubePose(c.bend, c.turn);
        const Cameraf camera = tubeCamera(160, 192, 0.7f, 1.6f);
        EXPECT_LT(compareImages(renderReference(bare, pose, referenceCamera(camera)).rgb,
                                renderReference(*avatar, pose, referenceCamera(camera)).rgb)
                      .psnrDb,
                  35)
            << c.name << ": this case tests nothing";
        expectAvatarAgrees(c.name, avatar, pose, camera);
    }
}

TEST(PlainFrame, generalSplatsEqualTheReferenceAtEveryShDegree) {
    for (uint32_t degree = 0; degree <= 3; ++degree) {
        TestPlain plain;
        DPL_NEED_PLAIN(plain);
        StaticSplatData splats = randomStaticSplats(degree + 1, 1500, degree);
        splats.compensated = degree % 2 == 1;
        const Status loaded = plain.frame->load(splats);
        ASSERT_TRUE(loaded) << loaded.error().message;
        const Cameraf camera = tubeCamera(160, 192, 0.7f, 2.2f);
        expectAgrees("general, SH " + std::to_string(degree), draw(*plain.frame, {}, {&camera, 1})[0],
                     renderReference(splats, referenceCamera(camera), {.compensated = splats.compensated}), 0.05);
    }
}

/** Two eyes, another size and back, general splats; and lists that are too small are an error, not an empty picture. */
TEST(PlainFrame, tilesDrawWhatQuadsDrawOrSayThatTheyCannot) {
    TestPlain tiles(PlainFill::Tiles), quads;
    DPL_NEED_PLAIN(tiles);
    const StaticSplatData splats = randomStaticSplats(5, 1500, 1, 0.5f);
    ASSERT_TRUE(tiles.frame->load(splats) && quads.frame->load(splats));
    const Cameraf far[2] = {tubeCamera(157, 139, 0.3f, 40, -0.03f), tubeCamera(157, 139, 0.3f, 40, 0.03f)},
                  near = tubeCamera(157, 139, 0.3f, 1.2f), small = tubeCamera(61, 45, 0.3f, 40);
    const std::vector<RenderedView> got = draw(*tiles.frame, {}, far);
    for (size_t v = 0; v < 2; ++v)
        expectAgrees("general, tiles, view " + std::to_string(v), got[v], renderReference(splats, referenceCamera(far[v])));
    ASSERT_TRUE(tiles.frame->draw({}, {&near, 1}));
    const auto refused = tiles.frame->read();
    ASSERT_FALSE(refused) << "lists of 1500 splats of half a metre seen from inside";
    EXPECT_EQ(refused.error().code, Code::Unsupported);
    EXPECT_GT(coverage(draw(*quads.frame, {}, {&near, 1})[0].rgba, 25.0), 0.5);
    expectAgrees("general, tiles, small", draw(*tiles.frame, {}, {&small, 1})[0], renderReference(splats, referenceCamera(small)));
    EXPECT_TRUE(draw(*tiles.frame, {}, far)[1].rgba == got[1].rgba);
}

TEST(PlainFrame, twoViewsAreTwoFramesAndAnotherSizeIsMadeAnew) {
    TestPlain plain;
    DPL_NEED_PLAIN(plain);
    ASSERT_TRUE(plain.frame->load(std::make_shared<const AvatarData>(test::withCorrectives(makeTube(), 3))));
    const Pose pose = tubePose(0.7f);
    const Cameraf views[2] = {tubeCamera(160, 144, 0.3f, 1.2f, -0.032f), tubeCamera(160, 144, 0.3f, 1.2f, 0.032f)};
    const std::vector<RenderedView> both = draw(*plain.frame, pose, views);
    const std::vector<PassTime> times = plain.frame->passTimes();
    draw(*plain.frame, tubePose(-0.3f), {views, 1});  // leaves nothing behind
    EXPECT_TRUE(draw(*plain.frame, pose, {views, 1})[0].rgba == both[0].rgba);
    EXPECT_TRUE(draw(*plain.frame, pose, {views + 1, 1})[0].rgba == both[1].rgba);
    EXPECT_FALSE(both[0].rgba == both[1].rgba);
    const Cameraf small = tubeCamera(64, 48, 0.3f, 1.2f);
    EXPECT_EQ(draw(*plain.frame, pose, {&small, 1})[0].rgba.size(), 64u * 48 * 4);
    EXPECT_TRUE(draw(*plain.frame, pose, {views, 1})[0].rgba == both[0].rgba);
    EXPECT_GT(plain.frame->splatsDrawn(), 1000u);
    if (times.empty()) GTEST_SKIP() << "the device has no timestamps";
    const auto count = [&](const char* label) {
        return std::count_if(times.begin(), times.end(), [&](const PassTime& t) { return t.label == label; });
    };
    EXPECT_EQ(count("pose.skin"), 2);
    EXPECT_EQ(count("sort.scatter"), 2 * 8) << "32-bit keys, four bits a round, each eye for itself";
    EXPECT_EQ(count("draw.splats"), 2);
    EXPECT_EQ(times.size(), 2 * (1 + 2 + 2 + 4 + 3 * 8 + 3u));
}

TEST(PlainFrame, drawsNothingForNoSplatsAndRefusesWhatItCannotDraw) {
    TestPlain plain;
    DPL_NEED_PLAIN(plain);
    EXPECT_FALSE(plain.frame->read());
    ASSERT_TRUE(plain.frame->load(std::make_shared<const AvatarData>(makeTube({.splatsPerTriangle = 0}))));
    const Cameraf views[3] = {tubeCamera(32, 32, 0), tubeCamera(32, 16, 0), tubeCamera(32, 32, 0)};
    EXPECT_FALSE(plain.frame->draw(tubePose(0), {}));
    EXPECT_FALSE(plain.frame->draw(tubePose(0), {views, 2}));
    EXPECT_FALSE(plain.frame->draw(tubePose(0), views));
    TestPlain tiles(PlainFill::Tiles);
    ASSERT_TRUE(tiles.frame->load(std::make_shared<const AvatarData>(makeTube({.splatsPerTriangle = 0}))));
    for (plain::Frame* frame : {plain.frame.get(), tiles.frame.get()}) {
        const RenderedView nothing = draw(*frame, tubePose(0), {views, 1})[0];
        for (const uint8_t byte : nothing.rgba) ASSERT_EQ(byte, 0);
    }
}

TEST(PlainFrame, aFileIsDrawnInThePoseThatItIsGiven) {
    AvatarData data = test::withCorrectives(makeTube({.shDegree = 1}), 3);
    sortSplats(data);
    const auto bytes = writeAvatar(data);
    ASSERT_TRUE(bytes) << bytes.error().message;
    const auto decoded = readAvatar(*bytes);
    ASSERT_TRUE(decoded) << decoded.error().message;
    auto file = PlainFile::open(*bytes);
    if (!file && file.error().code == Code::Unsupported) GTEST_SKIP() << file.error().message;
    ASSERT_TRUE(file) << file.error().message;
    Pose pose = tubePose(0.9f, 0.4f);
    pose.rootTranslation = {0.05f, -0.02f, 0.1f};
    std::vector<float> rotations;
    for (const Quatf& q : pose.localRotations) rotations.insert(rotations.end(), {q.x, q.y, q.z, q.w});
    const Cameraf views[2] = {tubeCamera(120, 144, 0.7f, 1.8f, -0.03f), tubeCamera(120, 144, 0.7f, 1.8f, 0.03f)};
    std::vector<std::vector<uint8_t>> pictures(2);
    EXPECT_FALSE(file->read(pictures)) << "nothing was drawn";
    EXPECT_FALSE(file->draw({}, pose.rootTranslation, views)) << "a pose without its joints";
    ASSERT_TRUE(file->draw(rotations, pose.rootTranslation, views));
    ASSERT_TRUE(file->read(pictures));
    for (size_t v = 0; v < 2; ++v)
        expectAgrees("a file, view " + std::to_string(v), {120, 144, pictures[v], {}}, unboundedReference(*decoded, pose, views[v]));
    const PlainStats stats = file->stats();
    EXPECT_GT(stats.splatsDrawn, 1000u);
    EXPECT_EQ(stats.splatBytes, decoded->splats.count() * (sizeof(plain::SplatRecord) + 12 * sizeof(float)));
    EXPECT_GT(stats.avatarBytes, stats.splatBytes);
    EXPECT_GT(stats.residentBytes, stats.splatBytes);
    EXPECT_FALSE(PlainFile::open(std::vector<uint8_t>(100, 7)));
}

TEST(PlainFrame, aPackOfAnotherInterfaceIsRefused) {
    const auto pack = readShaderPack(plain::embeddedShaderPack(), "the pack of frozen shaders", embeddedShaderInterface());
    ASSERT_FALSE(pack);
    EXPECT_EQ(pack.error().code, Code::Version);
}

/** Over all text of every file with its name, so that moving text between files shows too. */
TEST(PlainFrame, itsShadersAreFrozenAndIncludeNothingOfTodays) {
    const char* source = std::getenv("DOPPEL_SOURCE_DIR");
    if (!source) GTEST_SKIP() << "DOPPEL_SOURCE_DIR is not set";
    const std::filesystem::path root = std::filesystem::path(source) / "tools/bench/baseline/shaders";
    std::vector<std::filesystem::path> files;
    for (const auto& entry : std::filesystem::recursive_directory_iterator(root))
        if (entry.is_regular_file()) files.push_back(entry.path());
    std::sort(files.begin(), files.end());
    std::string all;
    for (const auto& file : files) {
        std::ifstream in(file, std::ios::binary);
        std::ostringstream text;
        text << in.rdbuf();
        all += file.lexically_relative(root).generic_string() + '\0' + text.str();
        std::istringstream lines(text.str());
        for (std::string line; std::getline(lines, line);)
            EXPECT_EQ(line.find("#include \""), line.find("#include \"tools/bench/baseline/shaders/")) << file << ": " << line;
    }
    EXPECT_EQ(files.size(), 35u);
    EXPECT_EQ(shaderHash({reinterpret_cast<const uint8_t*>(all.data()), all.size()}), 6498888829893031506u)
        << "a frozen shader was edited (tools/bench/baseline/README.md)";
}

}  // namespace
}  // namespace dpl
