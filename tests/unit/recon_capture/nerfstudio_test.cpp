// SPDX-License-Identifier: Apache-2.0
// nerfstudio's transforms.json as a camera source.
#include <functional>

#include "reconstruction/input/capture/scan.h"
#include "reconstruction/input/capture/scan_check.h"
#include "tests/unit/recon_capture/scan_builder.h"
#include "tests/unit/shared_data.h"

namespace dpl {
namespace {

using nlohmann::json;

/** Two pictures of the builder, seen from +z (Doppel's front) at 1 m height, in OpenGL axes: identity rotation looks along −z. */
json transforms(const std::filesystem::path& root) {
    ScanBuilder builder(root, 2);
    json m = {{"camera_model", "OPENCV"}, {"w", 96}, {"h", 128}, {"fl_x", 100.0}, {"fl_y", 100.0}, {"cx", 48.0}, {"cy", 64.0},
              {"frames", json::array()}};
    for (const char* name : {"full_100", "full_101"})
        m["frames"].push_back({{"file_path", std::string("images/") + name + ".jpg"},
                               {"mask_path", std::string("masks/") + name + ".png"},
                               {"transform_matrix", {{1, 0, 0, 0}, {0, 1, 0, 1}, {0, 0, 1, 2.5}, {0, 0, 0, 1}}}});
    return m;
}

TEST(Nerfstudio, openglCameraBecomesOpencv) {
    TemporaryFolder folder;
    writeText(folder.path / "transforms.json", transforms(folder.path).dump());
    auto scan = readScan(folder.path);
    ASSERT_TRUE(scan) << scan.error().message;
    EXPECT_EQ(scan->source, ScanSource::Nerfstudio);
    const Camerad& c = scan->frames[0].camera;
    EXPECT_NEAR(glm::length(c.eye() - Vec3d(0, 1, 2.5)), 0, 1e-12);
    EXPECT_NEAR(c.toView({0, 1, 0}).z, 2.5, 1e-12);       // the subject is in front
    EXPECT_LT(c.pixelOf(c.toView({0, 1.5, 0})).y, c.cy);  // up is up
    EXPECT_GT(c.pixelOf(c.toView({0.5, 1, 0})).x, c.cx);  // the subject's left is on the right
    EXPECT_EQ(scan->frames[1].name, "full_101");
    EXPECT_FALSE(scan->frames[0].maskPath.empty());
}

TEST(Nerfstudio, zUpWorldsAreTurnedWhenStated) {
    TemporaryFolder folder;
    json m = transforms(folder.path);
    m["world_up"] = "z";
    // Eye at (0, −2.5, 1) looking along +y with z up.
    for (auto& f : m["frames"]) f["transform_matrix"] = {{1, 0, 0, 0}, {0, 0, -1, -2.5}, {0, 1, 0, 1}, {0, 0, 0, 1}};
    writeText(folder.path / "transforms.json", m.dump());
    auto scan = readScan(folder.path);
    ASSERT_TRUE(scan) << scan.error().message;
    EXPECT_NEAR(glm::length(scan->frames[0].camera.eye() - Vec3d(0, 1, 2.5)), 0, 1e-12);
}

Result<Scan> scanOf(const TemporaryFolder& folder, const json& manifest) {
    writeText(folder.path / "transforms.json", manifest.dump());
    return readScan(folder.path);
}

TEST(Nerfstudio, metresCountOnlyWhenStated) {
    TemporaryFolder folder;
    json m = transforms(folder.path);
    auto scan = scanOf(folder, m);
    ASSERT_TRUE(scan) << scan.error().message;
    EXPECT_FALSE(scan->metricWorld || scan->unitStated);
    EXPECT_TRUE(mentions(scan->assumed, {"transforms.json", "human size", "\"metric\": true", "\"world_up\""}));
    m["world_up"] = "z";
    EXPECT_FALSE(scanOf(folder, m)->metricWorld) << "a stated up is no unit";
    m["metric"] = true;
    scan = scanOf(folder, m);
    ASSERT_TRUE(scan) << scan.error().message;
    EXPECT_TRUE(scan->metricWorld);
    EXPECT_EQ(scan->assumed, "");
    m["metric"] = false;
    scan = scanOf(folder, m);
    EXPECT_TRUE(scan && !scan->metricWorld && scan->unitStated && scan->assumed.empty());
    m.erase("metric"), m["applied_scale"] = 0.4;
    scan = scanOf(folder, m);
    EXPECT_TRUE(scan && !scan->metricWorld && scan->unitStated) << "a scaled world is not in metres";
}

TEST(Nerfstudio, nerfCaptureWritesMetresAndYUp) {
    TemporaryFolder folder;
    json m = transforms(folder.path);
    m["depth_integer_scale"] = 1.0;
    const auto scan = scanOf(folder, m);
    ASSERT_TRUE(scan) << scan.error().message;
    EXPECT_TRUE(scan->metricWorld);
    EXPECT_TRUE(mentions(scan->assumed, {"NeRFCapture", "metres"}));
}

/** The builder's walk round the subject as transforms.json, its world as in scan.json: z up, `scale` units a metre. */
json walkOf(const ScanBuilder& builder, double scale) {
    json m = {{"fl_x", 100.0}, {"fl_y", 100.0}, {"frames", json::array()}};
    for (const json& frame : builder.manifest["frames"]) {
        const auto r = frame["camera"]["R"].get<std::vector<double>>(), t = frame["camera"]["t"].get<std::vector<double>>();
        json rows = json::array();
        for (size_t i = 0; i < 3; ++i) {
            const double eye = -(r[i] * t[0] + r[3 + i] * t[1] + r[6 + i] * t[2]);
            rows.push_back({r[i], -r[3 + i], -r[6 + i], scale * eye});
        }
        rows.push_back({0, 0, 0, 1});
        m["frames"].push_back({{"file_path", frame["image"]}, {"mask_path", frame["mask"]}, {"transform_matrix", rows}});
    }
    return m;
}

TEST(Nerfstudio, aWalkHasTheSameVerdictInAnyWorld) {
    TemporaryFolder folder;
    const ScanBuilder builder(folder.path, 20);
    Jobs jobs(2);
    json known = walkOf(builder, 1);
    known["world_up"] = "z", known["metric"] = true;
    const auto truth = checkScan(*scanOf(folder, known), jobs);
    ASSERT_TRUE(truth);
    EXPECT_EQ(truth->verdict, ScanVerdict::Usable) << "no dynamic pictures";
    for (const double scale : {1.0, 3.0}) {
        const auto foreign = checkScan(*scanOf(folder, walkOf(builder, scale)), jobs);
        ASSERT_TRUE(foreign);
        EXPECT_EQ(foreign->verdict, truth->verdict) << foreign->findings.front().sentence;
        EXPECT_NEAR(foreign->largestGapDeg, truth->largestGapDeg, 0.01);
        EXPECT_NEAR(foreign->silhouetteCoherence, truth->silhouetteCoherence, 0.01);
    }
}

TEST(Nerfstudio, refusals) {
    const auto expect = [](const std::function<void(json&)>& breakIt, std::initializer_list<const char*> words) {
        TemporaryFolder folder;
        json m = transforms(folder.path);
        breakIt(m);
        writeText(folder.path / "transforms.json", m.dump());
        auto scan = readScan(folder.path);
        ASSERT_FALSE(scan);
        EXPECT_TRUE(mentions(scan.error().message, words));
    };
    expect(
        [](json& m) {
            m.erase("fl_x");
            m.erase("fl_y");
        },
        {"fx"});
    expect([](json& m) { m["camera_model"] = "OPENCV_FISHEYE"; }, {"OPENCV_FISHEYE", "undistort"});
    expect([](json& m) { m["k3"] = 0.1; }, {"k3", "undistort"});
    expect([](json& m) { m["k1"] = -3.0; }, {"folds", "undistort"});
    expect(
        [](json& m) {
            for (json& f : m["frames"]) f["transform_matrix"] = {{1, 0, 0, 0}};
        },
        {"frame 0", "transform_matrix"});
    expect(
        [](json& m) {
            for (json& f : m["frames"]) f["transform_matrix"][0][0] = 2;
        },
        {"full_100", "not a rotation"});
    expect([](json& m) { m["frames"][0]["file_path"] = "../secret.jpg"; }, {"not allowed"});
    expect([](json& m) { m["frames"][1]["file_path"] = "images/full_100.jpg"; }, {"full_100", "twice"});
    expect([](json& m) { m["train_filenames"] = {"images/full_100.jpg"}; }, {"full_101", "none of"});
    expect([](json& m) { m["train_filenames"] = m["test_filenames"] = {"images/full_100.jpg", "images/full_101.jpg"}; }, {"both"});
    expect([](json& m) { m["metric"] = true; }, {"transforms.json", "\"world_up\": \"y\" or \"z\""});
    expect([](json& m) { m["metric"] = "yes"; }, {"'metric'", "neither true nor false"});
    expect([](json& m) { m["world_up"] = "x"; }, {"world_up 'x'"});
    expect([](json& m) { m["w"] = 97; }, {"97 x 128", "96 x 128"});
}

TEST(Nerfstudio, aLensThatIsNotBrownsIsRefusedWhereverItIsStated) {
    TemporaryFolder folder;
    const json good = transforms(folder.path);
    const std::pair<const char*, json> stated[] = {{"is_fisheye", true}, {"is_fisheye", 1},
                                                   {"latlong", true},    {"camera_model", "OPENCV_FISHEYE"},
                                                   {"ftheta_p1", 0.5},   {"camera_model", "EQUIRECTANGULAR"}};
    for (const auto& [key, value] : stated)
        for (const bool ofFrame : {false, true}) {
            json m = good;
            (ofFrame ? m["frames"][1] : m)[key] = value;
            const auto scan = scanOf(folder, m);
            ASSERT_EQ(bool(scan), ofFrame) << key;
            const std::string said = ofFrame ? scan->assumed : scan.error().message;
            EXPECT_TRUE(mentions(said, {"transforms.json", key, "image_undistorter"}));
            if (!ofFrame) continue;
            EXPECT_EQ(scan->frames.size(), 1u);
            EXPECT_TRUE(mentions(said, {"1 of 2 pictures are left out: images/full_101.jpg", "frame 1"}));
        }
    json m = good;
    m["is_fisheye"] = false, m["frames"][0]["camera_model"] = "PINHOLE";
    EXPECT_TRUE(scanOf(folder, m));
}

TEST(Nerfstudio, aFramesOwnFocalLengthWins) {
    TemporaryFolder folder;
    json m = transforms(folder.path);
    m["frames"][0]["camera_angle_x"] = 2 * std::atan(0.24);  // 96 px across: 200 px
    m["frames"][1]["fl_x"] = 150.0, m["frames"][1]["fl_y"] = 160.0;
    auto scan = scanOf(folder, m);
    ASSERT_TRUE(scan) << scan.error().message;
    EXPECT_NEAR(scan->frames[0].camera.fx, 200, 1e-9);
    EXPECT_NEAR(scan->frames[0].camera.fy, 200, 1e-9);
    EXPECT_EQ(scan->frames[1].camera.fx, 150);
    EXPECT_EQ(scan->frames[1].camera.fy, 160);
    m = transforms(folder.path);
    m.erase("fl_x"), m.erase("fl_y");
    m["camera_angle_x"] = 2 * std::atan(0.48), m["camera_angle_y"] = 2 * std::atan(0.5);  // 100 and 128 px
    scan = scanOf(folder, m);
    ASSERT_TRUE(scan) << scan.error().message;
    EXPECT_NEAR(scan->frames[0].camera.fx, 100, 1e-9);
    EXPECT_NEAR(scan->frames[0].camera.fy, 128, 1e-9);
}

TEST(Nerfstudio, pathsOfWindowsAreRead) {
    TemporaryFolder folder;
    json m = transforms(folder.path);
    for (auto& f : m["frames"])
        for (const char* key : {"file_path", "mask_path"}) {
            std::string path = f[key];
            path[path.find('/')] = '\\';
            f[key] = path;
        }
    m["train_filenames"] = {"images\\full_100.jpg"}, m["test_filenames"] = {"images/full_101.jpg"};
    const auto scan = scanOf(folder, m);
    ASSERT_TRUE(scan) << scan.error().message;
    EXPECT_EQ(scan->frames[0].name, "full_100");
    EXPECT_EQ(scan->frames[1].split, Split::Test);
    EXPECT_FALSE(scan->frames[1].maskPath.empty());
    m["frames"][0]["file_path"] = "..\\secret.jpg";
    m.erase("train_filenames"), m.erase("test_filenames");
    const auto refused = scanOf(folder, m);
    ASSERT_FALSE(refused);
    EXPECT_TRUE(mentions(refused.error().message, {"not allowed"}));
}

TEST(Nerfstudio, picturesThatCannotBeReadAreLeftOutByName) {
    TemporaryFolder folder;
    json m = transforms(folder.path);
    m["frames"].push_back(m["frames"][0]), m["frames"][2]["file_path"] = "images/gone.jpg";
    auto scan = scanOf(folder, m);
    ASSERT_TRUE(scan) << scan.error().message;
    EXPECT_EQ(scan->frames.size(), 2u);
    EXPECT_TRUE(mentions(scan->assumed, {"1 of 3 pictures are left out: images/gone.jpg", "is missing"}));
    writeText(folder.path / "masks/full_101.png", "");
    scan = scanOf(folder, m);
    ASSERT_TRUE(scan) << scan.error().message;
    EXPECT_EQ(scan->frames.size(), 1u);
    EXPECT_TRUE(mentions(scan->assumed, {"2 of 3 pictures are left out: images/full_101.jpg, images/gone.jpg", "masks/full_101.png"}));
    for (auto& f : m["frames"]) f["file_path"] = "images/gone.jpg";
    scan = scanOf(folder, m);
    ASSERT_FALSE(scan);
    EXPECT_TRUE(mentions(scan.error().message, {"gone.jpg is missing"}));
}

/** A frame without a usable camera costs that frame; only if none is left its reason is an error (see `refusals`). */
TEST(Nerfstudio, framesWithoutAUsableCameraAreLeftOutByName) {
    TemporaryFolder folder;
    const json good = transforms(folder.path);
    const std::tuple<const char*, json, const char*> broken[] = {{"transform_matrix", json(nullptr), "transform_matrix"},
                                                                 {"transform_matrix", {{1, 0, 0, 0}}, "transform_matrix"},
                                                                 {"fl_x", -5, "fx"},
                                                                 {"k1", 9e15, "k1"},
                                                                 {"k3", 0.1, "k3"},
                                                                 {"fl_x", json(nullptr), "fl_x"}};
    for (const auto& [key, value, why] : broken) {
        json m = good;
        m["frames"][0][key] = value;
        const auto scan = scanOf(folder, m);
        ASSERT_TRUE(scan) << key << ": " << scan.error().message;
        ASSERT_EQ(scan->frames.size(), 1u) << key;
        EXPECT_EQ(scan->frames[0].name, "full_101");
        EXPECT_TRUE(mentions(scan->assumed, {"1 of 2 pictures are left out: images/full_100.jpg", "frame 0", why}));
    }
}

/** Damage among the compressed pixels, which no header tells. */
TEST(Nerfstudio, picturesWithDamagedPixelsAreLeftOutByName) {
    TemporaryFolder folder;
    const json m = transforms(folder.path);
    damagePixels(folder.path / "images/full_100.jpg");
    auto scan = scanOf(folder, m);
    ASSERT_TRUE(scan) << scan.error().message;
    ASSERT_EQ(scan->frames.size(), 1u);
    EXPECT_EQ(scan->frames[0].name, "full_101");
    EXPECT_TRUE(mentions(scan->assumed, {"1 of 2 pictures are left out: images/full_100.jpg", "damaged JPEG"}));
    damagePixels(folder.path / "masks/full_101.png");
    scan = scanOf(folder, m);
    ASSERT_FALSE(scan) << "none is left";
    EXPECT_TRUE(mentions(scan.error().message, {"full_100.jpg", "damaged JPEG", "copy or export the picture again"}));
}

/** A HEIC photo is named with the command for it, and what the command makes is read under the name of the manifest. */
TEST(Nerfstudio, heicIsNamedUntilItIsConverted) {
    TemporaryFolder folder;
    json m = transforms(folder.path);
    m["frames"][0]["file_path"] = "images/full_100.HEIC";
    const auto picture = folder.path / "images/full_100.HEIC";
    writeText(picture, std::string("\0\0\0\x18"
                                   "ftypheic",
                                   12) +
                           std::string(100, '\0'));
    auto scan = scanOf(folder, m);
    ASSERT_TRUE(scan) << scan.error().message;
    EXPECT_EQ(scan->frames.size(), 1u);
    EXPECT_TRUE(mentions(scan->assumed, {"1 of 2 pictures are left out: images/full_100.HEIC", "HEIC is not read",
                                         ("heif-convert -q 95 " + picture.string() + " " + picture.string() + ".jpg").c_str()}));
    std::filesystem::copy_file(folder.path / "images/full_100.jpg", picture.string() + ".jpg");
    scan = scanOf(folder, m);
    ASSERT_TRUE(scan) << scan.error().message;
    EXPECT_EQ(scan->frames.size(), 2u);
    EXPECT_EQ(scan->assumed.find("HEIC"), std::string::npos) << scan->assumed;
}

TEST(Nerfstudio, numbersThatNoLensHasAreRefused) {
    TemporaryFolder folder;
    for (const json& value : {json(9e15), json(-2e9), json(9e15f), json(nullptr)})
        for (const char* key : {"k1", "k2"}) {
            json m = transforms(folder.path);
            m[key] = value;
            const auto scan = scanOf(folder, m);
            ASSERT_FALSE(scan) << key << ' ' << value;
            EXPECT_TRUE(mentions(scan.error().message, {"transforms.json", key}));
        }
    for (double k1 : {-0.3, 0.4}) {
        json m = transforms(folder.path);
        m["k1"] = k1;
        EXPECT_TRUE(scanOf(folder, m)) << k1;
    }
}

TEST(Nerfstudio, bikerStandsUprightInsideHisMasks) {
    const auto data = sharedData("real-orbit-biker/transforms.json");
    if (!data) GTEST_SKIP() << "shared data (real-orbit-biker) is not on this machine";
    auto scan = readScan(data->parent_path());
    ASSERT_TRUE(scan) << scan.error().message;
    ASSERT_EQ(scan->frames.size(), 72u);
    int held = 0;
    for (const auto& frame : scan->frames) {
        held += frame.split == Split::Test;
        const Vec2d px = frame.camera.pixelOf(frame.camera.toView({0, 1.2, 0}));  // the chest of a 1.80 m subject, feet at y = 0
        auto mask = readFrameMask(frame);
        ASSERT_TRUE(mask) << mask.error().message;
        EXPECT_GT(mask->pixels[size_t(px.y) * mask->widthPx + size_t(px.x)], 128) << frame.name;
    }
    EXPECT_EQ(held, 8);
    // The same cameras as cameras.json in OpenCV form: row 0 of frame 0.
    EXPECT_NEAR(scan->frames[0].camera.viewFromWorldRotation[1][0], 0.003313582, 1e-8);
    EXPECT_NEAR(scan->frames[0].camera.viewFromWorldTranslation.z, 2.745413772, 1e-6);
}

}  // namespace
}  // namespace dpl
