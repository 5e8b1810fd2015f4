// SPDX-License-Identifier: Apache-2.0
// Found cameras survive their file, damaged files are refused, and errors against a truth are stated by kind.
#include "reconstruction/run/cameras_file.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <nlohmann/json.hpp>

#include "reconstruction/input/cameras/align_cameras.h"
#include "reconstruction/run/camera_errors.h"
#include "sdk/core/files.h"
#include "tests/unit/recon_cameras/made_cameras.h"

namespace dpl {
namespace {

struct File {
    std::filesystem::path path = std::filesystem::temp_directory_path() / ("dpl_cameras_" + std::to_string(::getpid()) + ".json");
    ~File() { std::filesystem::remove(path); }
};

FoundCameras someFound() {
    FoundCameras found;
    const auto cameras = orbit(3);
    for (size_t i = 0; i < 3; ++i) found.cameras.push_back({"full_" + std::to_string(i), cameras[i], 0.5, 120});
    found.lens = {-0.02, 0};
    found.metric = true;
    found.sentences = {"three", "of three"};
    found.gaps = {{"the left side", "film the left side again", {"full_7", "full_8"}}};
    return found;
}

TEST(CamerasFile, roundTrip) {
    const File file;
    const FoundCameras found = someFound();
    ASSERT_TRUE(writeFileAtomically(file.path, camerasToJson(found)));
    const auto read = readCamerasFile(file.path);
    ASSERT_TRUE(read) << read.error().message;
    ASSERT_EQ(read->cameras.size(), 3u);
    EXPECT_EQ(read->cameras[2].name, "full_2");
    EXPECT_EQ(read->cameras[2].matches, 120u);
    EXPECT_EQ(read->lens.k1, -0.02);
    EXPECT_TRUE(read->metric);
    EXPECT_FALSE(read->refused);
    EXPECT_EQ(read->sentences, found.sentences);
    ASSERT_EQ(read->gaps.size(), 1u);
    EXPECT_EQ(read->gaps[0].part, "the left side");
    EXPECT_EQ(read->gaps[0].sentence, "film the left side again");
    EXPECT_EQ(read->gaps[0].frames, found.gaps[0].frames);
    const CameraError error = cameraError(read->cameras[1].camera, found.cameras[1].camera, {});
    EXPECT_LT(error.eye + error.rotationRad, 1e-12);
}

TEST(CamerasFile, damagedFilesAreRefused) {
    const File file;
    const nlohmann::json good = nlohmann::json::parse(camerasToJson(someFound()));
    const auto refused = [&](const std::string& text) {
        EXPECT_TRUE(writeFileAtomically(file.path, text));
        const auto read = readCamerasFile(file.path);
        return !read && read.error().message.find(file.path.string()) != std::string::npos;
    };
    const std::string text = good.dump();
    for (size_t length = 0; length < text.size(); length += 7) EXPECT_TRUE(refused(text.substr(0, length))) << length;
    for (const char* key : {"lens", "metric", "refused", "sentences", "gaps", "frames"}) {
        nlohmann::json broken = good;
        broken.erase(key);
        EXPECT_TRUE(refused(broken.dump())) << key;
        broken[key] = "x";
        EXPECT_TRUE(refused(broken.dump())) << key;
    }
    for (const char* key : {"name", "camera", "size"}) {
        nlohmann::json broken = good;
        broken["frames"][1].erase(key);
        EXPECT_TRUE(refused(broken.dump())) << key;
    }
    nlohmann::json broken = good;
    broken["frames"][0]["camera"][4] = 7;  // no rotation
    EXPECT_TRUE(refused(broken.dump()));
    broken = good;
    broken["frames"][0]["size"] = {1e12, 5};
    EXPECT_TRUE(refused(broken.dump()));
}

Scan scanOf(const std::vector<Camerad>& cameras) {
    Scan scan;
    for (size_t i = 0; i < cameras.size(); ++i) {
        ScanFrame frame;
        frame.name = "f" + std::to_string(i);
        frame.camera = cameras[i];
        if (i % 4 == 3) frame.kind = FrameKind::Dynamic;
        if (i % 4 == 2) frame.kind = FrameKind::StaticCloseup;
        if (i == 0) frame.split = Split::Test;
        scan.frames.push_back(frame);
    }
    return scan;
}

TEST(CamerasFile, framesWithoutACameraAreDropped) {
    Scan scan = scanOf(orbit(4));
    scan.camerasKnown = false;
    FoundCameras found;
    found.cameras = {{"f1", orbit(4)[1]}, {"f3", orbit(4)[3]}};
    found.lens = {0.1, 0};
    const auto with = withCameras(scan, found);
    ASSERT_TRUE(with) << with.error().message;
    ASSERT_EQ(with->frames.size(), 2u);
    EXPECT_EQ(with->frames[1].name, "f3");
    EXPECT_EQ(with->frames[1].lens.k1, 0.1);
    EXPECT_TRUE(with->camerasKnown);
    EXPECT_FALSE(with->metricWorld);
    found.cameras[0].camera.widthPx = 99;
    EXPECT_FALSE(withCameras(scan, found));
}

TEST(CameraErrors, areStatedByKindAfterOneAlignment) {
    const auto cameras = orbit(16);
    const Scan truth = scanOf(cameras);
    const Similarity world{0.5, turnAbout({1, 2, 3}, 1), {1, 2, 3}};
    Scan found = truth;
    for (size_t i = 0; i < 16; ++i) {
        Camerad camera = cameras[i];
        if (i % 4 == 3) lookFrom(camera, camera.eye() + Vec3d(0.01, 0, 0), {0.01, 1, 0});  // moving ones: 10 mm off
        found.frames[i].camera = moved(camera, world);
    }
    found.frames.erase(found.frames.begin() + 7);  // a moving one
    found.metricWorld = false;
    const auto errors = compareCameras(found, truth);
    ASSERT_TRUE(errors) << errors.error().message;
    EXPECT_NEAR(errors->scale, 2, 1e-9);
    ASSERT_EQ(errors->rows.size(), 4u);
    EXPECT_EQ(errors->rows[0].kind, FrameKind::StaticFull);
    EXPECT_NEAR(errors->rows[0].eyeMmWorst, 0, 1e-6);
    EXPECT_EQ(errors->rows[2].kind, FrameKind::Dynamic);
    EXPECT_EQ(errors->rows[2].frames, 4u);
    EXPECT_EQ(errors->rows[2].missing, 1u);
    EXPECT_NEAR(errors->rows[2].eyeMmMedian, 10, 1e-6);
    EXPECT_EQ(errors->rows[3].frames, 1u);
    EXPECT_NE(describeCameraErrors(*errors).find("dynamic"), std::string::npos);
    Scan none = found;
    none.frames.clear();
    EXPECT_FALSE(compareCameras(none, truth));
}

}  // namespace
}  // namespace dpl
