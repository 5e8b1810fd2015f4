// SPDX-License-Identifier: Apache-2.0
// Scan folders whose frames have no camera are read only by those who ask for them.
#include "reconstruction/input/capture/scan.h"
#include "tests/unit/recon_capture/scan_builder.h"

namespace dpl {
namespace {

/** Writes a scan and takes the cameras from the first `without` frames. */
std::filesystem::path scanWithout(ScanBuilder& builder, size_t without) {
    for (size_t i = 0; i < std::min(without, builder.manifest["frames"].size()); ++i) builder.manifest["frames"][i].erase("camera");
    return builder.write();
}

TEST(UnknownCameras, scanIsReadOnlyWhenAskedFor) {
    TemporaryFolder folder;
    ScanBuilder builder(folder.path, 6, 3);
    builder.manifest["focal_px"] = 110.5;
    const auto root = scanWithout(builder, 9);
    const auto scan = readScan(root, ScanCameras::MayLack);
    ASSERT_TRUE(scan) << scan.error().message;
    EXPECT_FALSE(scan->camerasKnown);
    EXPECT_FALSE(scan->metricWorld);
    EXPECT_EQ(scan->focalGuessPx, 110.5);
    ASSERT_EQ(scan->frames.size(), 9u);
    EXPECT_EQ(scan->frames[0].camera.widthPx, uint32_t(ScanBuilder::kWidth));
    EXPECT_EQ(scan->frames[8].kind, FrameKind::Dynamic);
    EXPECT_TRUE(readFrameImage(scan->frames[0])) << "pictures can be read before the cameras are known";

    const auto refused = readScan(root);
    ASSERT_FALSE(refused);
    EXPECT_TRUE(mentions(refused.error().message, {"no frame has a camera", "doppel cameras"})) << refused.error().message;
}

TEST(UnknownCameras, aFewMissingCamerasAreRefused) {
    TemporaryFolder folder;
    ScanBuilder builder(folder.path, 6);
    const auto scan = readScan(scanWithout(builder, 1), ScanCameras::MayLack);
    ASSERT_FALSE(scan);
    EXPECT_TRUE(mentions(scan.error().message, {"frame 0", "'camera' is missing, while other frames have one"})) << scan.error().message;
}

TEST(UnknownCameras, knownCamerasStayKnown) {
    TemporaryFolder folder;
    ScanBuilder builder(folder.path, 6);
    const auto scan = readScan(builder.write(), ScanCameras::MayLack);
    ASSERT_TRUE(scan) << scan.error().message;
    EXPECT_TRUE(scan->camerasKnown);
    EXPECT_TRUE(scan->metricWorld);
}

TEST(UnknownCameras, focalGuessMustBePlausible) {
    for (const nlohmann::json& focal : {nlohmann::json(-5), nlohmann::json(1e9), nlohmann::json(0.01), nlohmann::json("26 mm")}) {
        TemporaryFolder folder;
        ScanBuilder builder(folder.path, 6);
        builder.manifest["focal_px"] = focal;
        const auto scan = readScan(scanWithout(builder, 6), ScanCameras::MayLack);
        ASSERT_FALSE(scan) << focal;
        EXPECT_TRUE(mentions(scan.error().message, {"focal_px"})) << scan.error().message;
    }
}

TEST(UnknownCameras, distortionBelongsToKnownCameras) {
    TemporaryFolder folder;
    ScanBuilder builder(folder.path, 6);
    builder.manifest["camera_model"] = "radial";
    builder.manifest["distortion"] = {0.1, 0.0};
    const auto scan = readScan(scanWithout(builder, 6), ScanCameras::MayLack);
    ASSERT_FALSE(scan);
    EXPECT_TRUE(mentions(scan.error().message, {"distortion"})) << scan.error().message;
}

}  // namespace
}  // namespace dpl
