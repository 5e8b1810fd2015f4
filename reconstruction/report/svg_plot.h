// SPDX-License-Identifier: Apache-2.0
// Small charts as SVG: lines for the report, points for the bench.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace dpl {

struct PlotSeries {
    std::string name;
    std::vector<double> x, y;                  // same length; non-finite points break the line
    std::vector<std::string> pointNames = {};  // beside the points, when there are any
};

struct PlotOptions {
    std::string title, xLabel, yLabel;
    bool logX = false, logY = false;
    int widthPx = 560, heightPx = 260;
    bool points = false;  // points and no lines; the series' names in a column inside the frame instead of a row above it
};

/** An <svg> element with axes, round tick values, one colour a series and a legend. Empty series give an empty frame. */
std::string svgPlot(const std::vector<PlotSeries>& series, const PlotOptions& options);

/** A plot as a file of its own, with the colours and fonts that a report's page would give it. */
std::string svgFile(const std::string& plot);

/** Escapes &, <, >, " for HTML text and attributes. */
std::string escapeHtml(std::string_view text);

}  // namespace dpl
