// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/report/report.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "reconstruction/image/image_codec.h"

namespace {

using namespace dpl;

ReportData sample() {
    ReportData data;
    data.title = "A <b> & \"c\"";
    data.frames = {{.name = "full_001", .kind = "static"}, {.name = "dyn_002", .kind = "dynamic"}, {.name = "full_003", .kind = "static"}};
    data.frames[0].withPoseFit.maskedPsnrDb = 20;
    data.frames[2].withPoseFit.maskedPsnrDb = 24;
    data.lossCurves = {{"total", {0, 1, 2}, {0.5, 0.1, 0.02}}};
    data.stages = {{"ingest", 1.5, 100 << 20, false}};
    return data;
}

TEST(Report, meansAreTakenPerKind) {
    const ReportData data = sample();
    EXPECT_DOUBLE_EQ(meanScore(data.frames, "static", &HeldOutFrame::withPoseFit)->maskedPsnrDb, 22);
    EXPECT_FALSE(meanScore({}, "static", &HeldOutFrame::withPoseFit));
    const auto json = nlohmann::json::parse(reportJson(data));
    EXPECT_DOUBLE_EQ(json["means"]["static"]["with_pose_fit"]["masked_psnr_db"], 22);
    EXPECT_EQ(json["frames"].size(), 3u);
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
