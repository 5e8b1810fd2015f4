// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/judging/report/svg_plot.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <limits>
#include <string_view>

#include "reconstruction/output/page/html_text.h"

namespace dpl {
namespace {

constexpr std::array<const char*, 6> kColours = {"#2563eb", "#dc2626", "#059669", "#d97706", "#7c3aed", "#475569"};
constexpr double kLeft = 58, kRight = 14, kTop = 30, kBottom = 42;

std::string shortNumber(double value) {
    char text[32];
    std::snprintf(text, sizeof text, std::abs(value) >= 1e5 || (value != 0 && std::abs(value) < 1e-3) ? "%.1e" : "%.4g", value);
    return text;
}

/** The range of all finite values. After settle() it is never empty. */
struct Range {
    double low = std::numeric_limits<double>::infinity(), high = -std::numeric_limits<double>::infinity();
    void include(double value) {
        if (std::isfinite(value)) low = std::min(low, value), high = std::max(high, value);
    }
    void settle() {
        if (!(low <= high)) low = 0, high = 1;
        if (high - low < 1e-12 * std::max(1.0, std::abs(high))) low -= 0.5, high += 0.5;
    }
    void widen(double share) {
        const double by = share * (high - low);
        low -= by, high += by;
    }
};

/** A round step (1, 2 or 5 times a power of ten) that gives about `wanted` ticks. */
double tickStep(double span, int wanted) {
    const double rough = span / wanted, power = std::pow(10.0, std::floor(std::log10(rough)));
    for (double factor : {1.0, 2.0, 5.0})
        if (factor * power >= rough) return factor * power;
    return 10 * power;
}

/** Round values inside a range of scaled values. On a logarithmic axis 1, 2 and 5 of each decade, or only powers of ten above three
 * decades. */
std::vector<double> ticks(const Range& range, int wanted, bool log) {
    std::vector<double> out;
    const auto even = [&](double low, double high) {
        const double step = tickStep(high - low, wanted);
        for (double v = std::ceil(low / step) * step; v <= high + step * 1e-6; v += step) out.push_back(v);
        return out;
    };
    if (!log) return even(range.low, range.high);
    if (range.high - range.low < 0.5) return even(std::pow(10.0, range.low), std::pow(10.0, range.high));
    const bool many = range.high - range.low > 3;
    for (double decade = std::floor(range.low); decade <= range.high; ++decade)
        for (double factor : {1.0, 2.0, 5.0}) {
            const double at = decade + std::log10(factor);
            if (at >= range.low && at <= range.high && (factor == 1 || !many)) out.push_back(factor * std::pow(10.0, decade));
        }
    return out;
}

std::string element(const char* format, double a, double b, double c, double d) {
    char text[200];
    std::snprintf(text, sizeof text, format, a, b, c, d);
    return text;
}

}  // namespace

std::string svgPlot(const std::vector<PlotSeries>& series, const PlotOptions& options) {
    const auto scaled = [](double v, bool log) { return log ? (v > 0 ? std::log10(v) : std::nan("")) : v; };
    const auto scaleX = [&](double x) { return scaled(x, options.logX); };
    const auto scaleY = [&](double y) { return scaled(y, options.logY); };
    const auto shown = [&](const PlotSeries& s, size_t i) { return std::isfinite(scaleX(s.x[i])) && std::isfinite(scaleY(s.y[i])); };
    Range rangeX, rangeY;
    for (const PlotSeries& s : series)
        for (size_t i = 0; i < std::min(s.x.size(), s.y.size()); ++i)
            if (shown(s, i)) rangeX.include(scaleX(s.x[i])), rangeY.include(scaleY(s.y[i]));
    rangeX.settle();
    rangeY.settle();
    if (options.points) rangeX.widen(0.09), rangeY.widen(0.08);
    const double width = options.widthPx, height = options.heightPx, plotWidth = width - kLeft - kRight,
                 plotHeight = height - kTop - kBottom;
    const auto toX = [&](double x) { return kLeft + (x - rangeX.low) / (rangeX.high - rangeX.low) * plotWidth; };  // takes scaled values
    const auto toY = [&](double y) { return kTop + plotHeight - (y - rangeY.low) / (rangeY.high - rangeY.low) * plotHeight; };

    std::string svg =
        element("<svg viewBox=\"0 0 %.0f %.0f\" width=\"%.0f\" height=\"%.0f\" class=\"plot\">", width, height, width, height);
    svg += element("<text x=\"%.0f\" y=\"%.0f\" class=\"title\">", kLeft, 18, 0, 0) + escapeHtml(options.title) + "</text>";
    for (const double x : ticks(rangeX, 6, options.logX)) {
        svg += element("<line x1=\"%.1f\" y1=\"%.1f\" x2=\"%.1f\" y2=\"%.1f\" class=\"grid\"/>", toX(scaleX(x)), kTop, toX(scaleX(x)),
                       kTop + plotHeight);
        svg += element("<text x=\"%.1f\" y=\"%.1f\" text-anchor=\"middle\">", toX(scaleX(x)), kTop + plotHeight + 15, 0, 0) +
               shortNumber(x) + "</text>";
    }
    for (const double y : ticks(rangeY, 5, options.logY)) {
        svg += element("<line x1=\"%.1f\" y1=\"%.1f\" x2=\"%.1f\" y2=\"%.1f\" class=\"grid\"/>", kLeft, toY(scaleY(y)), kLeft + plotWidth,
                       toY(scaleY(y)));
        svg +=
            element("<text x=\"%.1f\" y=\"%.1f\" text-anchor=\"end\">", kLeft - 6, toY(scaleY(y)) + 4, 0, 0) + shortNumber(y) + "</text>";
    }
    svg += element("<text x=\"%.1f\" y=\"%.1f\" text-anchor=\"middle\">", kLeft + plotWidth / 2, height - 8, 0, 0) +
           escapeHtml(options.xLabel) + "</text>";
    svg += element("<text transform=\"translate(13 %.1f) rotate(-90)\" text-anchor=\"middle\">", kTop + plotHeight / 2, 0, 0, 0) +
           escapeHtml(options.yLabel) + "</text>";
    double legendX = kLeft + plotWidth;
    for (size_t k = series.size(); k-- > 0;) {
        const PlotSeries& s = series[k];
        const std::string fill = "fill=\"" + std::string(kColours[k % kColours.size()]) + "\"";
        std::string path;
        bool penDown = false;
        for (size_t i = 0; i < std::min(s.x.size(), s.y.size()); ++i) {
            if (!shown(s, i)) {
                penDown = false;
                continue;
            }
            const double x = toX(scaleX(s.x[i])), y = toY(scaleY(s.y[i]));
            if (options.points) {
                svg += element("<circle cx=\"%.1f\" cy=\"%.1f\" r=\"3.5\" ", x, y, 0, 0) + fill + "/>";
                if (i < s.pointNames.size())
                    svg +=
                        element("<text x=\"%.1f\" y=\"%.1f\" ", x + 5, y - 4, 0, 0) + fill + ">" + escapeHtml(s.pointNames[i]) + "</text>";
            } else {
                path += element(penDown ? "L%.1f %.1f" : "M%.1f %.1f", x, y, 0, 0);
                penDown = true;
            }
        }
        if (!options.points)
            svg += "<path fill=\"none\" stroke-width=\"1.5\" stroke=\"" + std::string(kColours[k % kColours.size()]) + "\" d=\"" + path +
                   "\"/>";
        svg += element("<text x=\"%.1f\" y=\"%.1f\" text-anchor=\"end\" ", legendX - (options.points ? 8 : 0),
                       options.points ? kTop + 14 * double(k + 1) : 18, 0, 0) +
               fill + ">" + escapeHtml(s.name) + "</text>";
        if (!options.points) legendX -= 12 + 7.0 * double(s.name.size());
    }
    return svg + "</svg>";
}

std::string svgFile(const std::string& plot) {
    constexpr std::string_view kOpen = "<svg ";
    return "<svg xmlns=\"http://www.w3.org/2000/svg\" style=\"background:#fff\" " +
           plot.substr(kOpen.size(), plot.find('>') + 1 - kOpen.size()) +
           "<style>text{font:11px system-ui,sans-serif}text.title{font-size:13px;fill:#111}.grid{stroke:#e5e7eb}</style>" +
           plot.substr(plot.find('>') + 1) + "\n";
}

}  // namespace dpl
