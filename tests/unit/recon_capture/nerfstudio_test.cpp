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
    expect([](json& m) { m["frames"][0]["transform_matrix"] = {{1, 0, 0, 0}}; }, {"frame 0", "transform_matrix"});
    expect([](json& m) { m["frames"][0]["transform_matrix"][0][0] = 2; }, {"full_100", "not a rotation"});
    expect([](json& m) { m["frames"][0]["file_path"] = "../secret.jpg"; }, {"not allowed"});
    expect([](json& m) { m["frames"][1]["file_path"] = "images/full_100.jpg"; }, {"full_100", "twice"});
    expect([](json& m) { m["train_filenames"] = {"images/full_100.jpg"}; }, {"full_101", "none of"});
    expect([](json& m) { m["train_filenames"] = m["test_filenames"] = {"images/full_100.jpg", "images/full_101.jpg"}; }, {"both"});
    expect([](json& m) { m["metric"] = true; }, {"transforms.json", "\"world_up\": \"y\" or \"z\""});
    expect([](json& m) { m["metric"] = "yes"; }, {"'metric'", "neither true nor false"});
    expect([](json& m) { m["world_up"] = "x"; }, {"world_up 'x'"});
    expect([](json& m) { m["w"] = 97; }, {"97 x 128", "96 x 128"});
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
