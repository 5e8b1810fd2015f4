// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/judging/report/report.h"

#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "reconstruction/base/image_codec.h"
#include "reconstruction/judging/report/provenance.h"

namespace {

using namespace dpl;

ReportData sample() {
    ReportData data;
    data.title = "A <b> & \"c\"";
    data.frames = {{.name = "full_001", .kind = FrameKind::StaticFull},
                   {.name = "dyn_002", .kind = FrameKind::Dynamic},
                   {.name = "full_003", .kind = FrameKind::StaticFull}};
    data.frames[0].withPoseFit.maskedPsnrDb = 20;
    data.frames[2].withPoseFit.maskedPsnrDb = 24;
    data.lossCurves = {{"total", {0, 1, 2}, {0.5, 0.1, 0.02}}};
    data.stages = {{"ingest", 1.5, 100 << 20, false}};
    return data;
}

TEST(Report, meansAreTakenPerKind) {
    const ReportData data = sample();
    EXPECT_DOUBLE_EQ(meanScore(data.frames, FrameKind::StaticFull, &HeldOutFrame::withPoseFit)->maskedPsnrDb, 22);
    EXPECT_FALSE(meanScore({}, FrameKind::StaticFull, &HeldOutFrame::withPoseFit));
    const auto json = nlohmann::json::parse(reportJson(data));
    EXPECT_DOUBLE_EQ(json["means"]["static"]["with_pose_fit"]["masked_psnr_db"], 22);
    EXPECT_EQ(json["frames"].size(), 3u);
}

TEST(Report, statesTheUnionAndTheOutlineForEachKind) {
    ReportData data = sample();
    data.frames[0].withPoseFit.unionPsnrDb = 18, data.frames[2].withPoseFit.unionPsnrDb = 19;
    data.frames[0].withPoseFit.unionSsim = 0.5, data.frames[2].withPoseFit.unionSsim = 0.7;
    data.frames[1].withPoseFit.uncovered = 0.0456, data.frames[1].withPoseFit.drawnOutside = 0.0123;
    data.frames[1].withPoseFit.lonePx = 17;
    const auto json = nlohmann::json::parse(reportJson(data));
    EXPECT_DOUBLE_EQ(json["means"]["static"]["with_pose_fit"]["union_psnr_db"], 18.5);
    EXPECT_DOUBLE_EQ(json["means"]["static"]["with_pose_fit"]["union_ssim"], 0.6);
    EXPECT_DOUBLE_EQ(json["means"]["dynamic"]["with_pose_fit"]["uncovered"], 0.0456);
    EXPECT_DOUBLE_EQ(json["frames"][1]["with_pose_fit"]["drawn_outside"], 0.0123);
    EXPECT_DOUBLE_EQ(json["means"]["dynamic"]["with_pose_fit"]["lone_px"], 17);
    const std::string html = reportHtml(data);
    for (const char* cell : {"<td>18.50</td>", "<td>0.6000</td>", "<td>4.56</td>", "<td>1.23</td>", "<td>17.0</td>"})
        EXPECT_NE(html.find(cell), std::string::npos) << cell;
}

TEST(Report, marksBarsAsMetOrMissed) {
    ReportData data = sample();
    for (HeldOutFrame& frame : data.frames) frame.labelFloor.maskedPsnrDb = 17, frame.meshFloor.maskedPsnrDb = 10;
    data.frames[1].withPoseFit.maskedPsnrDb = 20.5;
    data.figures = {{"truth.keypoints", "registration", "keypoints, mean", "mm", 16.1, ReportBar{15, false}},
                    {"truth.limbs", "registration", "limbs", "degrees", 2.5, ReportBar{3, false}},
                    {"truth.broken", "registration", "broken", "mm", std::nan(""), ReportBar{1, false}},
                    {"file.bytes", "sizes", "file", "bytes", 5000, {}}};
    const auto json = nlohmann::json::parse(reportJson(data));
    EXPECT_EQ(json["figures"][0]["key"], "truth.keypoints");
    EXPECT_EQ(json["above_floors"][1]["key"], "above_floor.dynamic");
    EXPECT_FALSE(json["figures"][0]["bar"]["met"]);
    EXPECT_EQ(json["figures"][0]["bar"]["at_most"], 15);
    EXPECT_TRUE(json["figures"][1]["bar"]["met"]);
    EXPECT_FALSE(json["figures"][2]["bar"]["met"]) << "not a number misses";
    EXPECT_FALSE(json["figures"][3].contains("bar"));
    EXPECT_TRUE(json["above_floors"][0]["bar"]["met"]) << "static: 22 dB, 5 above the better floor";
    EXPECT_FALSE(json["above_floors"][1]["bar"]["met"]) << "dynamic: 20.5 dB, 3.5 above";
    const std::string html = reportHtml(data);
    const auto marks = [&](const char* mark) {
        size_t count = 0;
        for (size_t at = html.find(mark); at != std::string::npos; at = html.find(mark, at + 1)) ++count;
        return count;
    };
    EXPECT_EQ(marks("<td class=met>met</td>"), 2u);
    EXPECT_EQ(marks("<td class=missed>missed</td>"), 3u);
    const std::string summary = barSummary(data);
    EXPECT_TRUE(summary.starts_with("2 of 5 bars met; missed: ")) << summary;
    EXPECT_NE(summary.find("keypoints, mean 16.1 mm (bar: at most 15)"), std::string::npos) << summary;
    EXPECT_EQ(barSummary({}), "");
}

TEST(Report, knowsTheDevelopmentSet) {
    for (const char* name : {"scan-a", "scan-c", "real-orbit-biker", "procedural-1", "procedural-2", "procedural-3"})
        EXPECT_TRUE(isDevelopmentScan(name)) << name;
    for (const char* name : {"procedural-4", "procedural-9", "procedural-10", "my-scan", ""}) EXPECT_FALSE(isDevelopmentScan(name)) << name;
    EXPECT_TRUE(provenanceOf("scan-a", false).at(0).starts_with("Development set:"));
    EXPECT_TRUE(provenanceOf("procedural-4", false).at(0).starts_with("Not of the development set, by its name."));
    EXPECT_EQ(provenanceOf("procedural-4", false).size(), 1u);
    EXPECT_NE(provenanceOf("procedural-1", true).at(1).find("same body model"), std::string::npos);
}

TEST(Report, saysWhatItsFiguresStandFor) {
    ReportData data = sample();
    data.provenance = provenanceOf("procedural-1", true);
    const std::string html = reportHtml(data);
    const size_t said = html.find(data.provenance[1]), scores = html.find("Quality on held-out frames");
    ASSERT_NE(said, std::string::npos);
    EXPECT_GT(said, scores);
    EXPECT_LT(said, html.find("masked PSNR", scores)) << "beside the headline figures, not below them";
    EXPECT_EQ(nlohmann::json::parse(reportJson(data))["provenance"][0], data.provenance[0]);
}

TEST(Report, textFromOutsideCannotBecomeMarkup) {
    const std::string html = reportHtml(sample());
    EXPECT_NE(html.find("A &lt;b&gt; &amp; &quot;c&quot;"), std::string::npos);
    EXPECT_EQ(html.find("A <b>"), std::string::npos);
    EXPECT_EQ(html.find("http://"), std::string::npos) << "self-contained: nothing is fetched";
}

TEST(Report, aPlotDrawsEveryFinitePoint) {
    const std::string svg = svgPlot({{"a", {0, 1, 2, 3}, {1, std::nan(""), 3, 4}}}, {.title = "t"});
    EXPECT_NE(svg.find("M58.0"), std::string::npos);
    size_t moves = 0;
    for (size_t at = svg.find("d=\""); at < svg.size(); ++at) moves += svg[at] == 'M';
    EXPECT_EQ(moves, 2u) << "a gap starts a new piece of line";

    const std::string file = svgFile(svgPlot({{"a", {0, 1, 2, 3}, {1, std::nan(""), 3, 4}}}, {.title = "t", .points = true}));
    EXPECT_TRUE(file.starts_with("<svg xmlns="));
    size_t circles = 0;
    for (size_t at = file.find("<circle"); at < file.size(); at = file.find("<circle", at + 1)) ++circles;
    EXPECT_EQ(circles, 3u);
}

TEST(Png, refusesSizesThatDoNotFit) {
    const std::vector<uint8_t> pixels(12);
    EXPECT_TRUE(encodePng(pixels, 2, 2, 3));
    EXPECT_FALSE(encodePng(pixels, 2, 2, 4));
    EXPECT_FALSE(encodePng({}, 0, 0, 3));
}

}  // namespace
