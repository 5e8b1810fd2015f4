// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/run/frames_file.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

namespace {

using namespace dpl;
using nlohmann::json;

TEST(FramesFile, namesPicturesAndMetricCameras) {
    Scan scan;
    scan.root = "/out/scan";
    ScanFrame frame;
    frame.name = "dyn_003", frame.imagePath = "/out/scan/images/a b.jpg", frame.maskPath = "/out/scan/masks/a.png";
    scan.frames = {frame, frame};
    scan.frames[1].imagePath = "/elsewhere/b.jpg", scan.frames[1].maskFound = true, scan.frames[1].lens.k1 = -0.1;
    Camerad camera;
    camera.widthPx = 640, camera.heightPx = 480, camera.fx = 500, camera.fy = 501, camera.cx = 320, camera.cy = 240;
    camera.viewFromWorldRotation = Mat3d(0, 1, 0, -1, 0, 0, 0, 0, 1);
    camera.viewFromWorldTranslation = {0.5, 1, 2};
    const json file = json::parse(framesToJson(scan, std::vector{camera, camera}, "/out"));
    EXPECT_EQ(file["format"], "doppel-frames");
    EXPECT_EQ(file["scan"], "scan");
    EXPECT_EQ(file["frames"][0],
              (json{{"name", "dyn_003"},
                    {"image", "images/a b.jpg"},
                    {"mask", "masks/a.png"},
                    {"size", {640, 480}},
                    {"camera", {500.0, 501.0, 320.0, 240.0, 0.0, 1.0, 0.0, -1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.5, 1.0, 2.0}}}));
    EXPECT_EQ(file["frames"][1]["image"], "/elsewhere/b.jpg");
    EXPECT_EQ(file["frames"][1]["mask"], "") << "the run has found it and does not keep it";
    EXPECT_EQ(file["frames"][1]["distortion"], (json{-0.1, 0, 0, 0}));
    EXPECT_EQ(json::parse(framesToJson(scan, std::vector{camera, camera}, "/other"))["scan"], "/out/scan");
}

}  // namespace
