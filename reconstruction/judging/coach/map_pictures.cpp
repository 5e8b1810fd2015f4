// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/judging/coach/map_pictures.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <opencv2/imgproc.hpp>

#include "reconstruction/base/image_codec.h"
#include "reconstruction/subject/surface/mesh_raster.h"
#include "reconstruction/subject/surface/orbit_camera.h"

namespace dpl {
namespace {

constexpr int kViewWidthPx = 230, kViewHeightPx = 330, kHeadPx = 26, kScalePx = 56;
const cv::Scalar kPaper(255, 255, 255), kInk(40, 40, 40), kUnseen(176, 176, 176);

/** 0: worst, 1: best. */
double goodness(const MapScale& scale, double value) {
    const double low = std::log2(std::min(scale.marks.front(), scale.marks.back())),
                 high = std::log2(std::max(scale.marks.front(), scale.marks.back()));
    const double share = std::clamp((std::log2(std::max(value, 1e-9)) - low) / (high - low), 0.0, 1.0);
    return scale.smallIsGood ? 1 - share : share;
}

/** Colours of increasing lightness from dark blue to yellow, which people with colour-blindness tell apart too. */
cv::Vec3b colourOf(double good) {
    static const cv::Mat table = [] {
        cv::Mat grey(1, 256, CV_8U), bgr, rgb;
        for (int i = 0; i < 256; ++i) grey.at<uint8_t>(0, i) = uint8_t(i);
        cv::applyColorMap(grey, bgr, cv::COLORMAP_VIRIDIS);
        cv::cvtColor(bgr, rgb, cv::COLOR_BGR2RGB);
        return rgb;
    }();
    return table.at<cv::Vec3b>(0, int(std::lround(std::clamp(good, 0.0, 1.0) * 255)));
}

void write(cv::Mat& picture, const std::string& text, cv::Point at, double size = 0.42) {
    cv::putText(picture, text, at, cv::FONT_HERSHEY_SIMPLEX, size, kInk, 1, cv::LINE_AA);
}

std::string markText(double value) {
    return formatText("{}", std::round(value * 10) / 10);
}

/** Both views, rasterised once for all scales. */
struct BodyViews {
    MeshRaster raster[2];
    std::vector<float> light[2];  // by triangle
};

BodyViews lookAt(const MeshData& surface) {
    BodyViews views;
    Vec3d low(surface.restPositions.front()), high(low);
    for (const Vec3f& p : surface.restPositions) low = glm::min(low, Vec3d(p)), high = glm::max(high, Vec3d(p));
    const double distance = 12;  // nearly parallel rays
    const double focal = 0.97 * distance * std::min(kViewHeightPx / (high.y - low.y), kViewWidthPx / (high.x - low.x));
    const std::vector<Vec3f> normals = restNormals(surface);
    for (int back = 0; back < 2; ++back) {
        const double azimuth = back ? std::numbers::pi : 0;
        const Camerad camera = orbitCamera(0.5 * (low + high), distance, azimuth, 0, focal, kViewWidthPx, kViewHeightPx);
        views.raster[back] = rasteriseMesh(surface.restPositions, surface.triangles, camera);
        for (const Vec3f& n : normals) views.light[back].push_back(0.72f + 0.28f * std::max(0.0f, back ? -n.z : n.z));
    }
    return views;
}

Result<std::vector<uint8_t>> draw(const MapScale& scale, const BodyViews& views, std::span<const double> values) {
    cv::Mat picture(kHeadPx + kViewHeightPx + kScalePx, 2 * kViewWidthPx, CV_8UC3, kPaper);
    write(picture, scale.heading, {6, 17}, 0.46);
    for (int back = 0; back < 2; ++back) {
        const MeshRaster& raster = views.raster[back];
        for (int y = 0; y < kViewHeightPx; ++y)
            for (int x = 0; x < kViewWidthPx; ++x) {
                const uint32_t t = raster.triangle[size_t(y) * kViewWidthPx + size_t(x)];
                if (t == kNoTriangle) continue;
                cv::Vec3b& px = picture.at<cv::Vec3b>(kHeadPx + y, back * kViewWidthPx + x);
                px = values[t] >= 0 ? colourOf(goodness(scale, values[t]))
                                    : cv::Vec3b(uint8_t(kUnseen[0]), uint8_t(kUnseen[1]), uint8_t(kUnseen[2]));
                for (int c = 0; c < 3; ++c) px[c] = uint8_t(std::lround(float(px[c]) * views.light[back][t]));
            }
        write(picture, back ? "back" : "front", {back * kViewWidthPx + 6, kHeadPx + 14});
    }
    const int left = 24, width = 2 * kViewWidthPx - 150, top = kHeadPx + kViewHeightPx + 10;
    for (int x = 0; x < width; ++x) {
        const double share = double(x) / (width - 1);
        const double value = scale.marks.front() * std::pow(scale.marks.back() / scale.marks.front(), share);
        cv::line(picture, {left + x, top}, {left + x, top + 14}, cv::Scalar(colourOf(goodness(scale, value))));
    }
    for (const double mark : scale.marks) {
        const double share = std::log(mark / scale.marks.front()) / std::log(scale.marks.back() / scale.marks.front());
        const std::string text = markText(mark);
        const int x = left + int(std::lround(share * (width - 1)));
        cv::line(picture, {x, top + 14}, {x, top + 18}, kInk);
        write(picture, text, {x - 4 * int(text.size()), top + 33});
    }
    const int grey = left + width + 26;
    cv::rectangle(picture, {grey, top, 16, 14}, kUnseen, cv::FILLED);
    write(picture, "not seen", {grey + 22, top + 12});
    const std::vector<uint8_t> pixels(picture.data, picture.data + picture.total() * 3);
    return encodePng(pixels, uint32_t(picture.cols), uint32_t(picture.rows), 3);
}

Status checkValues(const MeshData& surface, size_t values) {
    if (!surface.triangles.empty() && values == surface.triangles.size()) return {};
    return fail(Code::InvalidArgument, "a map of {} triangles for a surface of {}", values, surface.triangles.size());
}

}  // namespace

Result<std::vector<uint8_t>> drawOnSurface(const MeshData& surface, const MapScale& scale, std::span<const double> values) {
    DPL_RETURN_IF_ERROR(checkValues(surface, values.size()));
    return draw(scale, lookAt(surface), values);
}

Result<std::vector<MapPicture>> drawMap(const MeshData& surface, std::span<const SeenTriangle> map) {
    DPL_RETURN_IF_ERROR(checkValues(surface, map.size()));
    struct Kind {
        const char* title;
        MapScale scale;
        double (*value)(const SeenTriangle&);
    };
    const Kind kinds[] = {
        {"mm a pixel",
         {"size of a pixel, mm (best picture of each place)", {0.5, 1, 2, 4, 8, 16}, true},
         [](const SeenTriangle& t) { return 1000.0 * double(t.pixelM); }},
        {"pictures", {"still pictures that show it", {1, 2, 4, 8, 16, 32}, false}, [](const SeenTriangle& t) { return double(t.views); }},
        {"blur", {"blur of the best picture, px", {0.5, 1, 2, 4}, true}, [](const SeenTriangle& t) { return double(t.blurPx); }},
    };
    const BodyViews views = lookAt(surface);
    std::vector<MapPicture> out;
    for (const Kind& kind : kinds) {
        std::vector<double> values;
        for (const SeenTriangle& t : map) values.push_back(t.seen() ? kind.value(t) : -1.0);
        DPL_TRY(auto png, draw(kind.scale, views, values));
        out.push_back({kind.title, std::move(png)});
    }
    return out;
}

}  // namespace dpl
