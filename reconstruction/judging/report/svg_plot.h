// SPDX-License-Identifier: Apache-2.0
// Small SVG charts: lines for the report, points for the benchmarks.
#pragma once

#include <string>
#include <vector>

namespace dpl {

struct PlotSeries {
    std::string name;
    std::vector<double> x, y;                  // same length; non-finite points break the line
    std::vector<std::string> pointNames = {};  // optional labels beside the points
};

struct PlotOptions {
    std::string title, xLabel, yLabel;
    bool logX = false, logY = false;
    int widthPx = 560, heightPx = 260;
    bool points = false;  // draw points instead of lines, and the legend as a column inside the frame instead of a row above it
};

/** An <svg> element with axes, round tick values, one colour per series and a legend. Without series the frame is empty. */
std::string svgPlot(const std::vector<PlotSeries>& series, const PlotOptions& options);

/** Makes a standalone SVG file of a plot, with the colours and fonts of the report's page. */
std::string svgFile(const std::string& plot);

}  // namespace dpl
