// Small line charts as inline SVG, for the report.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace dpl {

struct PlotSeries {
    std::string name;
    std::vector<double> x, y;   // same length; non-finite points break the line
};

struct PlotOptions {
    std::string title, xLabel, yLabel;
    bool logY = false;
    int widthPx = 560, heightPx = 260;
};

/** An <svg> element with axes, round tick values, one coloured line a series and a legend. Empty series give an empty frame. */
std::string svgLinePlot(const std::vector<PlotSeries>& series, const PlotOptions& options);

/** Escapes &, <, >, " for HTML text and attributes. */
std::string escapeHtml(std::string_view text);

}  // namespace dpl
