// SPDX-License-Identifier: Apache-2.0
// Body and fingers fitted to a sample scan whose hands move, against its truth.
#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <set>

#include "reconstruction/subject/body/body_tools.h"
#include "reconstruction/subject/body/body_truth.h"
#include "reconstruction/subject/hands/fit_fingers.h"
#include "reconstruction/subject/sample/builtin_body.h"
#include "reconstruction/subject/sample/scan_writer.h"
#include "tests/unit/must.h"

namespace dpl {
namespace {

namespace fs = std::filesystem;

/** A sample scan of fewer frames than usual, removed by the destructor. */
struct SampleScan {
    fs::path folder;
    explicit SampleScan(uint64_t seed) : folder(fs::temp_directory_path() / formatText("doppel_fingers_{}_{}", seed, ::getpid())) {
        fs::remove_all(folder);
        SampleScanOptions options;
        options.seed = seed, options.fingers = true, options.samplesPerPixel = 1;
        options.fullFrames = 16, options.closeupFrames = 12, options.dynamicFrames = 45;
        Jobs jobs(2);
        const Status made = makeSampleScan(folder, options, jobs);
        if (!made) throw std::runtime_error(made.error().message);
    }
    ~SampleScan() {
        std::error_code ignored;
        fs::remove_all(folder, ignored);
    }
};

void print(const char* what, const ErrorSpread& found, const ErrorSpread& atRest) {
    std::printf("%s: fingertips %.1f mm from the truth (95 %% %.1f), never fitted %.1f (%.1f), %zu tips\n", what, found.mean, found.p95,
                atRest.mean, atRest.p95, found.count);
}

TEST(SampleFingers, areFoundInStillAndMovingFrames) {
    const SampleScan sample(2);
    const Scan scan = must(readScan(sample.folder));
    std::multiset<std::string> heldOut;
    for (const ScanFrame& frame : scan.frames)
        if (frame.kind == FrameKind::StaticCloseup && frame.split == Split::Test) heldOut.insert(frame.closeupOf);
    EXPECT_EQ(heldOut, (std::multiset<std::string>{"hand_l", "hand_r"}));
    const BodyModel body = withBoneMorphs(makeBuiltinBody());
    BodyFitSettings settings;
    settings.useMasks = false;  // they tell of weight and build, and take a third of the time
    BodyFit fit = must(fitBody(body, scan, settings, 2));
    const std::vector<Pose> before = fit.poses;
    const std::vector<HandFit> hands = must(fitFingers(body, scan, fit));
    const FingerTruth truth = must(compareWithTruth(sample.folder, scan, shapedBody(body, fit.shape), fit)).fingers;
    print("still", truth.stillMm, truth.stillAtRestMm);
    print("moving", truth.movingMm, truth.movingAtRestMm);
    ASSERT_EQ(hands.size(), 2u);
    for (const HandFit& hand : hands)
        std::printf("%s: turned %d, still %zu, moving %zu, posed %zu, %.2f px\n", hand.left ? "left" : "right", hand.turned,
                    hand.stillFrames, hand.movingFrames, hand.posedFrames, hand.medianPx);
    ASSERT_GT(truth.stillMm.count, 100u);
    ASSERT_GT(truth.movingMm.count, 200u);
    EXPECT_LT(truth.stillMm.mean, 8);
    EXPECT_LT(truth.stillMm.mean, 0.5 * truth.stillAtRestMm.mean);
    EXPECT_LT(truth.movingMm.mean, 15);
    EXPECT_LT(truth.movingMm.mean, 0.5 * truth.movingAtRestMm.mean);
    for (size_t f = 0; f < before.size(); ++f)
        for (size_t j = 0; j < body.joints.size(); ++j) {
            const bool finger = body.joints[j].humanoidBone.find("Proximal") != std::string::npos ||
                                body.joints[j].humanoidBone.find("Intermediate") != std::string::npos ||
                                body.joints[j].humanoidBone.find("Distal") != std::string::npos ||
                                body.joints[j].humanoidBone.find("Metacarpal") != std::string::npos;
            if (!finger) {
                ASSERT_EQ(before[f].localRotations[j], fit.poses[f].localRotations[j]) << body.joints[j].name;
            }
        }
}

}  // namespace
}  // namespace dpl
