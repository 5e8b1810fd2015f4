// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/input/capture/validation.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace dpl {
namespace {

/** Still frames around the subject, close-ups, then moving frames, whose order in the list is not that of time. One still and one moving
 *  frame in ten are held out. */
Scan scanOf(size_t stills, size_t moving, double turnRad = 2 * std::numbers::pi) {
    Scan scan;
    const auto add = [&](FrameKind kind, Split split, double azimuth, double timeS) {
        ScanFrame frame;
        frame.name = "frame_" + std::to_string(scan.frames.size());
        frame.kind = kind, frame.split = split, frame.timeS = timeS;
        const double s = std::sin(azimuth), c = std::cos(azimuth);
        frame.camera.viewFromWorldRotation = glm::transpose(Mat3d(Vec3d(c, 0, -s), Vec3d(0, -1, 0), Vec3d(-s, 0, -c)));
        scan.frames.push_back(frame);
    };
    for (size_t i = 0; i < stills; ++i)
        add(FrameKind::StaticFull, i % 10 == 5 ? Split::Test : Split::Train, turnRad * double(i) / double(stills), 0);
    for (size_t i = 0; i < 24; ++i) add(FrameKind::StaticCloseup, Split::Train, 0, 0);
    for (size_t i = 0; i < moving; ++i) add(FrameKind::Dynamic, i % 10 == 4 ? Split::Test : Split::Train, 0, double(i * 7 % moving));
    return scan;
}

std::vector<bool> all(const Scan& scan) {
    return std::vector<bool>(scan.frames.size(), true);
}

size_t countOf(const Scan& scan, FrameKind kind, Split split) {
    return size_t(
        std::count_if(scan.frames.begin(), scan.frames.end(), [&](const ScanFrame& f) { return f.kind == kind && f.split == split; }));
}

TEST(Validation, setsAFewFramesOfEachKindAside) {
    Scan scan = scanOf(60, 90);
    const Scan before = scan;
    const std::string said = setValidationAside(scan, all(scan));
    EXPECT_EQ(countOf(scan, FrameKind::Dynamic, Split::Validation), 6u) << "8 % of 81";
    EXPECT_EQ(countOf(scan, FrameKind::StaticFull, Split::Validation), 3u) << "5 % of 54";
    EXPECT_EQ(countOf(scan, FrameKind::StaticCloseup, Split::Validation), 2u) << "8 % of 24";
    for (size_t f = 0; f < scan.frames.size(); ++f)
        EXPECT_EQ(scan.frames[f].split == Split::Test, before.frames[f].split == Split::Test) << "held-out frames stay held out";
    EXPECT_NE(said.find("6 of 81 moving, 3 of 54 still and 2 of 24 close-up"), std::string::npos) << said;
}

TEST(Validation, movingFramesAreAloneAndInARowOfTime) {
    Scan scan = scanOf(0, 90);
    setValidationAside(scan, all(scan));
    std::vector<const ScanFrame*> order;
    for (const ScanFrame& f : scan.frames)
        if (f.kind == FrameKind::Dynamic && f.split != Split::Test) order.push_back(&f);
    std::sort(order.begin(), order.end(), [](const ScanFrame* a, const ScanFrame* b) { return a->timeS < b->timeS; });
    std::vector<size_t> runs;
    for (size_t i = 0; i < order.size(); ++i) {
        if (order[i]->split != Split::Validation) continue;
        if (i > 0 && order[i - 1]->split == Split::Validation)
            ++runs.back();
        else
            runs.push_back(1);
    }
    std::sort(runs.begin(), runs.end());
    EXPECT_EQ(runs, (std::vector<size_t>{1, 1, 1, 3}));
}

TEST(Validation, tooFewFramesGiveNone) {
    Scan scan = scanOf(20, 20);  // 18 of each train
    std::erase_if(scan.frames, [n = 0](const ScanFrame& f) mutable { return f.kind == FrameKind::StaticCloseup && ++n > 19; });
    const std::string said = setValidationAside(scan, all(scan));
    for (const FrameKind kind : {FrameKind::Dynamic, FrameKind::StaticFull, FrameKind::StaticCloseup})
        EXPECT_EQ(countOf(scan, kind, Split::Validation), 0u);
    EXPECT_NE(said.find("too few"), std::string::npos) << said;
}

TEST(Validation, theOnlyStillFrameOfASideStays) {
    Scan scan = scanOf(22, 0, 0.1);  // 20 train, all from nearly one side; the one in the middle would go
    Scan alone = scan;
    setValidationAside(scan, all(scan));
    size_t chosen = 0;
    for (size_t f = 0; f < 22; ++f)
        if (scan.frames[f].split == Split::Validation) chosen = f;
    ASSERT_EQ(countOf(scan, FrameKind::StaticFull, Split::Validation), 1u);
    Mat3d& rotation = alone.frames[chosen].camera.viewFromWorldRotation;
    rotation = rotation * Mat3d(-1, 0, 0, 0, 1, 0, 0, 0, -1);  // from the other side
    setValidationAside(alone, all(alone));
    EXPECT_EQ(countOf(alone, FrameKind::StaticFull, Split::Validation), 0u);
}

TEST(Validation, unusableFramesNeitherGoNorCount) {
    Scan scan = scanOf(60, 90);
    std::vector<bool> usable = all(scan);
    for (size_t f = 0; f < scan.frames.size(); ++f)
        if (scan.frames[f].kind == FrameKind::Dynamic && scan.frames[f].timeS >= 15) usable[f] = false;
    setValidationAside(scan, usable);
    EXPECT_EQ(countOf(scan, FrameKind::Dynamic, Split::Validation), 0u) << "15 usable moving frames are too few";
    EXPECT_EQ(countOf(scan, FrameKind::StaticFull, Split::Validation), 3u);
}

}  // namespace
}  // namespace dpl
