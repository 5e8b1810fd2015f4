#include "reconstruction/report/svg_plot.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <limits>

namespace dpl {
namespace {

constexpr std::array<const char*, 6> kColours = {"#2563eb", "#dc2626", "#059669", "#d97706", "#7c3aed", "#475569"};
constexpr double kLeft = 58, kRight = 14, kTop = 30, kBottom = 42;

std::string number(double value) {
    char text[32];
    std::snprintf(text, sizeof text, std::abs(value) >= 1e5 || (value != 0 && std::abs(value) < 1e-3) ? "%.1e" : "%.4g", value);
    return text;
}

/** A range that contains all finite values and is never empty. */
struct Range {
    double low = std::numeric_limits<double>::infinity(), high = -std::numeric_limits<double>::infinity();
    void include(double value) {
        if (std::isfinite(value)) low = std::min(low, value), high = std::max(high, value);
    }
    void settle() {
        if (!(low <= high)) low = 0, high = 1;
        if (high - low < 1e-12 * std::max(1.0, std::abs(high))) low -= 0.5, high += 0.5;
    }
};

/** Round step (1, 2 or 5 times a power of ten) that gives about `wanted` ticks. */
double tickStep(double span, int wanted) {
    const double rough = span / wanted, power = std::pow(10.0, std::floor(std::log10(rough)));
    for (double factor : {1.0, 2.0, 5.0})
        if (factor * power >= rough) return factor * power;
    return 10 * power;
}

std::string element(const char* format, double a, double b, double c, double d) {
    char text[200];
    std::snprintf(text, sizeof text, format, a, b, c, d);
    return text;
}

}  // namespace

std::string escapeHtml(std::string_view text) {
    std::string out;
    for (char c : text) {
        switch (c) {
            case '&': out += "&amp;"; break;
            case '<': out += "&lt;"; break;
            case '>': out += "&gt;"; break;
            case '"': out += "&quot;"; break;
            default: out += c;
        }
    }
    return out;
}

std::string svgLinePlot(const std::vector<PlotSeries>& series, const PlotOptions& options) {
    const auto scaleY = [&](double y) { return options.logY ? (y > 0 ? std::log10(y) : std::nan("")) : y; };
    Range rangeX, rangeY;
    for (const PlotSeries& s : series)
        for (size_t i = 0; i < std::min(s.x.size(), s.y.size()); ++i)
            if (std::isfinite(scaleY(s.y[i]))) rangeX.include(s.x[i]), rangeY.include(scaleY(s.y[i]));
    rangeX.settle();
    rangeY.settle();
    const double width = options.widthPx, height = options.heightPx, plotWidth = width - kLeft - kRight, plotHeight = height - kTop - kBottom;
    const auto toX = [&](double x) { return kLeft + (x - rangeX.low) / (rangeX.high - rangeX.low) * plotWidth; };
    const auto toY = [&](double y) { return kTop + plotHeight - (y - rangeY.low) / (rangeY.high - rangeY.low) * plotHeight; };

    std::string svg = element("<svg viewBox=\"0 0 %.0f %.0f\" width=\"%.0f\" height=\"%.0f\" class=\"plot\">", width, height, width, height);
    svg += element("<text x=\"%.0f\" y=\"%.0f\" class=\"title\">", kLeft, 18, 0, 0) + escapeHtml(options.title) + "</text>";
    const double stepX = tickStep(rangeX.high - rangeX.low, 6), stepY = tickStep(rangeY.high - rangeY.low, 5);
    for (double x = std::ceil(rangeX.low / stepX) * stepX; x <= rangeX.high + stepX * 1e-6; x += stepX) {
        svg += element("<line x1=\"%.1f\" y1=\"%.1f\" x2=\"%.1f\" y2=\"%.1f\" class=\"grid\"/>", toX(x), kTop, toX(x), kTop + plotHeight);
        svg += element("<text x=\"%.1f\" y=\"%.1f\" text-anchor=\"middle\">", toX(x), kTop + plotHeight + 15, 0, 0) + number(x) + "</text>";
    }
    for (double y = std::ceil(rangeY.low / stepY) * stepY; y <= rangeY.high + stepY * 1e-6; y += stepY) {
        svg += element("<line x1=\"%.1f\" y1=\"%.1f\" x2=\"%.1f\" y2=\"%.1f\" class=\"grid\"/>", kLeft, toY(y), kLeft + plotWidth, toY(y));
        svg += element("<text x=\"%.1f\" y=\"%.1f\" text-anchor=\"end\">", kLeft - 6, toY(y) + 4, 0, 0) + number(options.logY ? std::pow(10.0, y) : y) + "</text>";
    }
    svg += element("<text x=\"%.1f\" y=\"%.1f\" text-anchor=\"middle\">", kLeft + plotWidth / 2, height - 8, 0, 0) + escapeHtml(options.xLabel) + "</text>";
    svg += element("<text transform=\"translate(13 %.1f) rotate(-90)\" text-anchor=\"middle\">", kTop + plotHeight / 2, 0, 0, 0) + escapeHtml(options.yLabel) + "</text>";
    double legendX = kLeft + plotWidth;
    for (size_t k = series.size(); k-- > 0;) {
        const PlotSeries& s = series[k];
        const char* colour = kColours[k % kColours.size()];
        std::string path;
        bool penDown = false;
        for (size_t i = 0; i < std::min(s.x.size(), s.y.size()); ++i) {
            const double y = scaleY(s.y[i]);
            if (!std::isfinite(y) || !std::isfinite(s.x[i])) {
                penDown = false;
                continue;
            }
            path += element(penDown ? "L%.1f %.1f" : "M%.1f %.1f", toX(s.x[i]), toY(y), 0, 0);
            penDown = true;
        }
        svg += "<path fill=\"none\" stroke-width=\"1.5\" stroke=\"" + std::string(colour) + "\" d=\"" + path + "\"/>";
        if (options.points)
            for (size_t i = 0; i < std::min(s.x.size(), s.y.size()); ++i)
                if (std::isfinite(scaleY(s.y[i])) && std::isfinite(s.x[i])) svg += element("<circle cx=\"%.1f\" cy=\"%.1f\" r=\"3\" ", toX(s.x[i]), toY(scaleY(s.y[i])), 0, 0) + "fill=\"" + colour + "\"/>";
        svg += element("<text x=\"%.1f\" y=\"%.1f\" text-anchor=\"end\" ", legendX, options.points ? kTop + 14 * double(k + 1) : 18, 0, 0) + "fill=\"" + colour + "\">" + escapeHtml(s.name) + "</text>";
        if (!options.points) legendX -= 12 + 7.0 * double(s.name.size());
    }
    return svg + "</svg>";
}

std::string svgFile(const std::string& plot) {
    constexpr std::string_view kOpen = "<svg ";
    return "<svg xmlns=\"http://www.w3.org/2000/svg\" style=\"background:#fff\" " + plot.substr(kOpen.size(), plot.find('>') + 1 - kOpen.size()) +
           "<style>text{font:11px system-ui,sans-serif}text.title{font-size:13px;fill:#111}.grid{stroke:#e5e7eb}</style>" + plot.substr(plot.find('>') + 1) + "\n";
}

}  // namespace dpl
