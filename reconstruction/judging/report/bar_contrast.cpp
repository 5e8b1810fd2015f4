// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/judging/report/bar_contrast.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <nlohmann/json.hpp>

#include "sdk/core/files.h"

namespace dpl {
namespace {

using nlohmann::json;

constexpr size_t kMostPlaces = 64, kMostFields = 64;  // along an edge; of a frame
constexpr size_t kMaxTruthFileBytes = size_t(1) << 28;
constexpr double kLeastContrast = 0.05;
constexpr double kTau = 6.283185307179586;

std::optional<std::vector<Vec2d>> edgeOf(const json& places) {
    if (!places.is_array() || places.size() < 2 || places.size() > kMostPlaces) return std::nullopt;
    std::vector<Vec2d> out;
    for (const json& p : places) {
        if (!p.is_array() || p.size() != 2 || !p[0].is_number() || !p[1].is_number()) return std::nullopt;
        const Vec2d at(p[0].get<double>(), p[1].get<double>());
        if (!(std::abs(at.x) < 1e5 && std::abs(at.y) < 1e5)) return std::nullopt;
        out.push_back(at);
    }
    return out;
}

std::optional<PrintedBars> barsOf(const json& field) {
    if (!field.is_object() || !field.contains("width_mm") || !field["width_mm"].is_number()) return std::nullopt;
    const double width = field["width_mm"].get<double>();
    const auto top = edgeOf(field.value("top_px", json())), bottom = edgeOf(field.value("bottom_px", json()));
    if (!(width > 0.01 && width < kBarFieldMm) || !top || !bottom || top->size() != bottom->size()) return std::nullopt;
    return PrintedBars{width, *top, *bottom};
}

/** Where p lies in a strip between its left and right side: 0 to 1 across and down, or outside of that. */
Vec2d placeIn(const Vec2d& p, const Vec2d& leftTop, const Vec2d& rightTop, const Vec2d& leftBottom, const Vec2d& rightBottom) {
    Vec2d at(0.5);
    for (int i = 0; i < 6; ++i) {  // Newton, on a field that is almost a parallelogram
        const Vec2d top = glm::mix(leftTop, rightTop, at.x), bottom = glm::mix(leftBottom, rightBottom, at.x);
        const Vec2d across = glm::mix(rightTop - leftTop, rightBottom - leftBottom, at.y), down = bottom - top;
        const double area = across.x * down.y - across.y * down.x;
        if (!(std::abs(area) > 1e-9)) return Vec2d(-1);
        const Vec2d miss = p - glm::mix(top, bottom, at.y);
        at += Vec2d(miss.x * down.y - miss.y * down.x, across.x * miss.y - across.y * miss.x) / area;
    }
    return at;
}

struct Pixel {
    size_t index;
    double across;  // of the field, 0 to 1
};

std::vector<Pixel> pixelsOf(const PrintedBars& bars, uint32_t widthPx, uint32_t heightPx) {
    std::vector<Pixel> out;
    const size_t strips = bars.topPx.size() - 1;
    for (size_t s = 0; s < strips; ++s) {
        const Vec2d corners[] = {bars.topPx[s], bars.topPx[s + 1], bars.bottomPx[s], bars.bottomPx[s + 1]};
        Vec2d low = corners[0], high = corners[0];
        for (const Vec2d& c : corners) low = glm::min(low, c), high = glm::max(high, c);
        low = glm::clamp(glm::floor(low), Vec2d(0), Vec2d(widthPx, heightPx));
        high = glm::clamp(glm::ceil(high), Vec2d(0), Vec2d(widthPx, heightPx));
        for (auto y = uint32_t(low.y); y < uint32_t(high.y); ++y)
            for (auto x = uint32_t(low.x); x < uint32_t(high.x); ++x) {
                const Vec2d at = placeIn({x + 0.5, y + 0.5}, corners[0], corners[1], corners[2], corners[3]);
                if (at.x >= 0 && at.x < 1 && at.y >= 0 && at.y < 1)
                    out.push_back({size_t(y) * widthPx + x, (double(s) + at.x) / double(strips)});
            }
    }
    return out;
}

struct Wave {
    std::complex<double> amplitude;
    double mean = 0;
};

/** The wave of the bars' period, under a window that fades to both ends of the field. */
Wave waveOf(std::span<const uint8_t> rgba, const std::vector<Pixel>& pixels, double periods) {
    Wave out;
    double weights = 0;
    const auto windowAt = [](double across) { return 0.5 - 0.5 * std::cos(kTau * across); };
    const auto luma = [&](size_t i) { return 0.299 * rgba[4 * i] + 0.587 * rgba[4 * i + 1] + 0.114 * rgba[4 * i + 2]; };
    for (const Pixel& p : pixels) out.mean += windowAt(p.across) * luma(p.index), weights += windowAt(p.across);
    out.mean /= weights;
    for (const Pixel& p : pixels)
        out.amplitude += windowAt(p.across) * (luma(p.index) - out.mean) * std::polar(1.0, -kTau * periods * p.across);
    out.amplitude *= 2 / weights;
    return out;
}

}  // namespace

Result<std::map<std::string, std::vector<PrintedBars>>> readPrintedBars(const std::filesystem::path& scan) {
    std::map<std::string, std::vector<PrintedBars>> out;
    const std::filesystem::path file = scan / "truth.json";
    std::error_code missing;
    if (!std::filesystem::is_regular_file(file, missing)) return out;
    DPL_TRY(const auto bytes, readFile(file, kMaxTruthFileBytes));
    const json truth = json::parse(bytes, nullptr, /*allow_exceptions=*/false);
    if (!truth.is_object() || !truth.contains("frames") || !truth["frames"].is_array())
        return fail(Code::CorruptData, "{} has no list of frames; copy it again", file.string());
    for (const json& frame : truth["frames"]) {
        if (!frame.is_object() || !frame.contains("bars")) continue;
        const std::string name = frame.contains("name") && frame["name"].is_string() ? frame["name"].get<std::string>() : "";
        const json& fields = frame["bars"];
        const auto wrong = [&] { return fail(Code::CorruptData, "{}: the bars of frame '{}' are no fields of bars", file.string(), name); };
        if (!fields.is_array() || fields.size() > kMostFields) return wrong();
        for (const json& field : fields) {
            auto bars = barsOf(field);
            if (!bars) return wrong();
            out[name].push_back(std::move(*bars));
        }
    }
    return out;
}

std::optional<double> barContrast(std::span<const uint8_t> drawn, std::span<const uint8_t> photograph, uint32_t widthPx, uint32_t heightPx,
                                  const PrintedBars& bars) {
    const size_t bytes = size_t(widthPx) * heightPx * 4;
    if (drawn.size() != bytes || photograph.size() != bytes || bars.topPx.size() < 2 || bars.topPx.size() != bars.bottomPx.size())
        return std::nullopt;
    const std::vector<Pixel> pixels = pixelsOf(bars, widthPx, heightPx);
    if (pixels.size() < 64) return std::nullopt;
    const double periods = kBarFieldMm / (2 * bars.widthMm);
    double lengthPx = 0;
    for (size_t k = 0; k + 1 < bars.topPx.size(); ++k)
        lengthPx += 0.5 * (glm::distance(bars.topPx[k], bars.topPx[k + 1]) + glm::distance(bars.bottomPx[k], bars.bottomPx[k + 1]));
    if (lengthPx < 2 * periods) return std::nullopt;
    const Wave truth = waveOf(photograph, pixels, periods), found = waveOf(drawn, pixels, periods);
    if (!(std::abs(truth.amplitude) > kLeastContrast * truth.mean)) return std::nullopt;
    return std::real(found.amplitude * std::conj(truth.amplitude)) / std::norm(truth.amplitude);
}

}  // namespace dpl
