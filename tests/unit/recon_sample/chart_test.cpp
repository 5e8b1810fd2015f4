// SPDX-License-Identifier: Apache-2.0
// The test chart of a sample's shirt: a picture shows its bars where the truth says, with less contrast the finer they are.
#include "reconstruction/subject/sample/chart.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "reconstruction/judging/report/bar_contrast.h"
#include "reconstruction/subject/sample/raycast.h"

namespace dpl {
namespace {

TEST(Chart, bearsBarsOfEachWidthThatFadeWhereTheyAreTooFine) {
    for (const BarField& field : kBarFields) {
        const Vec2f left = field.centre - Vec2f(0.5f * kBarFieldM.x, 0);
        EXPECT_EQ(chartInk(left + Vec2f(0.5f * field.barM, 0), 1e-5f).ink, 1) << field.barM;
        EXPECT_EQ(chartInk(left + Vec2f(1.5f * field.barM, 0), 1e-5f).ink, 0) << field.barM;
        EXPECT_NEAR(chartInk(left + Vec2f(0.5f * field.barM, 0), 3 * field.barM).ink, 0.5, 1e-6) << field.barM;
    }
    EXPECT_EQ(chartInk({0.2f, 0}, 1e-4f).panel, 0);
}

TEST(Chart, isSeenInAPictureWhereTheTruthSaysSo) {
    Jobs jobs(2);
    Subject subject = makeSubject(6, jobs);
    subject.look.chart = true;
    SampleScanOptions options;
    options.seed = 6, options.widthPx = 1080, options.heightPx = 1440, options.chart = true;
    const std::vector<PlannedFrame> frames = planScan(subject, options);
    std::vector<const PlannedFrame*> heldOut;
    for (const PlannedFrame& f : frames)
        if (f.closeupOf == "logo" && f.split == Split::Test) heldOut.push_back(&f);
    ASSERT_EQ(heldOut.size(), 1u);
    const PlannedFrame& frame = *heldOut.front();
    const auto vertices = poseSubject(subject, frame.pose, nullptr);
    const std::vector<BarsSeen> fields = seeBars(subject, vertices, frame.camera);
    ASSERT_EQ(fields.size(), kBarFields.size());

    PersonTracer tracer(subject);
    tracer.setVertices(vertices);
    const RaycastFrame picture = tracer.render(frame.camera, {.samplesPerPixel = 4});
    const auto level = [&](const Vec2d& px) { return int(picture.rgb[(size_t(px.y) * options.widthPx + size_t(px.x)) * 3 + 1]); };
    // The widest bars, one by one: dark where the field begins, light after each.
    const BarsSeen& widest = fields.front();
    ASSERT_EQ(widest.barMm, 3);
    const auto middleAt = [&](double across) {
        const double place = across * double(widest.topPx.size() - 1);
        const auto k = std::min(size_t(place), widest.topPx.size() - 2);
        const double t = place - double(k);
        return 0.5 * (glm::mix(widest.topPx[k], widest.topPx[k + 1], t) + glm::mix(widest.bottomPx[k], widest.bottomPx[k + 1], t));
    };
    for (int bar = 0; bar < 5; ++bar) EXPECT_LT(level(middleAt((bar + 0.25) / 5)) + 60, level(middleAt((bar + 0.75) / 5))) << "bar " << bar;

    std::vector<uint8_t> rgba(picture.rgb.size() / 3 * 4, 255);
    for (size_t i = 0; i < picture.rgb.size() / 3; ++i)
        for (size_t c = 0; c < 3; ++c) rgba[4 * i + c] = picture.rgb[3 * i + c];
    for (const BarsSeen& seen : fields) {
        const auto kept = barContrast(rgba, rgba, options.widthPx, options.heightPx, {seen.barMm, seen.topPx, seen.bottomPx});
        EXPECT_EQ(kept.has_value(), seen.barMm >= 0.8) << seen.barMm << " mm; a pixel is 0.8 mm wide";
    }
}

}  // namespace
}  // namespace dpl
