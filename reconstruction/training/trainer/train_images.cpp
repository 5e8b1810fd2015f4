// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/training/trainer/train_images.h"

#include <algorithm>
#include <cmath>

#include "reconstruction/training/trainer/priors.h"
#include "reconstruction/training/trainer/unsure_edge.h"
#include "sdk/math/projection.h"

namespace dpl {
namespace {

/** The input pixels that one output pixel covers along one axis, with their weights. */
struct Span1d {
    uint32_t first = 0;
    std::vector<float> weights;  // sum to 1
};

std::vector<Span1d> overlaps(uint32_t from, uint32_t to) {
    std::vector<Span1d> spans(to);
    const double step = double(from) / to;
    for (uint32_t o = 0; o < to; ++o) {
        const double begin = o * step, end = std::min(double(from), (o + 1) * step);
        spans[o].first = std::min(from - 1, uint32_t(begin));
        for (uint32_t i = spans[o].first; i < from && double(i) < end - 1e-9; ++i)
            spans[o].weights.push_back(float((std::min(end, i + 1.0) - std::max(begin, double(i))) / (end - begin)));
    }
    return spans;
}

/** Area average of one plane given as a function of (x, y). */
template <class Source>
std::vector<float> areaAverage(uint32_t width, uint32_t height, const std::vector<Span1d>& columns, const std::vector<Span1d>& rows,
                               Source&& at) {
    std::vector<float> narrow(columns.size() * height), out(columns.size() * rows.size());
    for (uint32_t y = 0; y < height; ++y)
        for (size_t o = 0; o < columns.size(); ++o) {
            float sum = 0;
            for (size_t k = 0; k < columns[o].weights.size(); ++k) sum += columns[o].weights[k] * at(columns[o].first + uint32_t(k), y);
            narrow[y * columns.size() + o] = sum;
        }
    for (size_t o = 0; o < rows.size(); ++o)
        for (size_t x = 0; x < columns.size(); ++x) {
            float sum = 0;
            for (size_t k = 0; k < rows[o].weights.size(); ++k)
                sum += rows[o].weights[k] * narrow[(rows[o].first + k) * columns.size() + x];
            out[o * columns.size() + x] = sum;
        }
    return out;
}

uint8_t toByte(float x) {
    return uint8_t(std::clamp(x + 0.5f, 0.0f, 255.0f));
}

std::vector<Pose> posesOf(std::span<const TrainFrame> frames, bool moving) {
    std::vector<Pose> poses;
    for (const TrainFrame& f : frames)
        if ((f.kind == FrameKind::Dynamic) == moving) poses.push_back(f.pose);
    return poses;
}

}  // namespace

std::vector<Pose> movingPoses(std::span<const TrainFrame> frames) {
    return posesOf(frames, true);
}

std::vector<Pose> stillPoses(std::span<const TrainFrame> frames) {
    return posesOf(frames, false);
}

Result<std::shared_ptr<const FramePicture>> checkedPicture(const TrainFrame& f) {
    const uint32_t w = f.camera.widthPx, h = f.camera.heightPx;
    if (w == 0 || h == 0 || !(f.camera.fx > 0) || !(f.camera.fy > 0))
        return fail(Code::InvalidArgument, "frame '{}': the camera has no size or focal length", f.name);
    const auto check = [&](const char* what, uint32_t iw, uint32_t ih, size_t bytes, size_t channels) -> Status {
        if (iw != w || ih != h || bytes != size_t(w) * h * channels)
            return fail(Code::InvalidArgument, "frame '{}': the {} is {}x{} with {} bytes, the camera says {}x{}", f.name, what, iw, ih,
                        bytes, w, h);
        return {};
    };
    if (!f.picture) return fail(Code::InvalidArgument, "frame '{}' has no picture", f.name);
    DPL_TRY(auto picture, f.picture.get());
    const ImageRgb8& image = picture->image;
    const ImageGrey8 &mask = picture->mask, &labels = picture->labels;
    DPL_RETURN_IF_ERROR(check("image", image.widthPx, image.heightPx, image.pixels.size(), 3));
    DPL_RETURN_IF_ERROR(check("mask", mask.widthPx, mask.heightPx, mask.pixels.size(), 1));
    if (!labels.pixels.empty()) DPL_RETURN_IF_ERROR(check("label image", labels.widthPx, labels.heightPx, labels.pixels.size(), 1));
    return picture;
}

Status checkPrecision(const TrainFrame& f, size_t jointCount) {
    if (!f.precision) return {};
    const PosePrecision& p = *f.precision;
    if (p.matrix.size() != p.size() * p.size() ||
        std::any_of(p.joints.begin(), p.joints.end(), [&](uint32_t j) { return j >= jointCount; }))
        return fail(Code::InvalidArgument, "frame '{}': the precision of its pose does not fit the rig", f.name);
    return {};
}

float coarsestScale(const TrainFrame& f) {
    return std::min(1.0f, std::max(0.1f, 160.0f / float(std::min(f.camera.widthPx, f.camera.heightPx))));
}

namespace {

/** [left, right) × [top, bottom) of a level; empty where nobody is in the mask. */
struct Crop {
    uint32_t left = 0, top = 0, right = 0, bottom = 0;
};

/** The person's box in a level of width × height, with a margin of 10 % of its longer side. */
Crop cropOf(const ImageGrey8& mask, uint32_t levelWidthPx, uint32_t levelHeightPx) {
    const uint32_t width = mask.widthPx, height = mask.heightPx;
    uint32_t x0 = width, x1 = 0, y0 = height, y1 = 0;
    for (uint32_t y = 0; y < height; ++y)
        for (uint32_t x = 0; x < width; ++x)
            if (isPerson(mask.pixels[size_t(y) * width + x]))
                x0 = std::min(x0, x), x1 = std::max(x1, x + 1), y0 = std::min(y0, y), y1 = std::max(y1, y + 1);
    if (x1 <= x0) return {};
    const double margin = 0.1 * std::max(x1 - x0, y1 - y0);
    const double sx = double(levelWidthPx) / width, sy = double(levelHeightPx) / height;
    return {uint32_t(std::max(0.0, std::floor((x0 - margin) * sx))), uint32_t(std::max(0.0, std::floor((y0 - margin) * sy))),
            uint32_t(std::min(double(levelWidthPx), std::ceil((x1 + margin) * sx))),
            uint32_t(std::min(double(levelHeightPx), std::ceil((y1 + margin) * sy)))};
}

}  // namespace

uint64_t cropPx(const FramePicture& picture) {
    const Crop crop = cropOf(picture.mask, picture.mask.widthPx, picture.mask.heightPx);
    return uint64_t(crop.right - crop.left) * (crop.bottom - crop.top);
}

LevelFrame makeLevelFrame(const TrainFrame& f, const FramePicture& picture, float scale, std::span<const uint8_t> clothLabels,
                          bool fullResolution) {
    const ImageRgb8& image = picture.image;
    const ImageGrey8 &mask = picture.mask, &labels = picture.labels;
    LevelFrame level;
    Camerad camera = f.camera.scaled(std::min(1.0f, scale));
    camera.widthPx = std::max(1u, camera.widthPx), camera.heightPx = std::max(1u, camera.heightPx);
    const uint32_t width = f.camera.widthPx, height = f.camera.heightPx;
    level.scale = float(camera.widthPx) / float(width);
    level.kappaPx2 = kTrainedKappaPx2;

    const auto [left, top, right, bottom] = cropOf(mask, camera.widthPx, camera.heightPx);
    if (right == 0) return level;
    level.used = true;
    level.leftPx = left, level.topPx = top;
    level.widthPx = right - left, level.heightPx = bottom - top;

    auto columns = overlaps(width, camera.widthPx), rows = overlaps(height, camera.heightPx);
    columns = {columns.begin() + left, columns.begin() + right};
    rows = {rows.begin() + top, rows.begin() + bottom};
    const size_t pixels = size_t(level.widthPx) * level.heightPx;
    level.rgb.resize(pixels * 3), level.mask.resize(pixels);
    const auto inside = [&](size_t at) { return isPerson(mask.pixels[at]); };
    /** Area average of value(pixel), 0 … 255, to `out`. */
    const auto reduce = [&](auto&& value, uint8_t* out) {
        const auto plane =
            areaAverage(width, height, columns, rows, [&](uint32_t x, uint32_t y) { return float(value(size_t(y) * width + x)); });
        std::transform(plane.begin(), plane.end(), out, toByte);
    };
    const bool found = picture.maskFound, hasEdge = found || fullResolution;
    const UnsureEdge edge = hasEdge ? unsureEdge(picture) : UnsureEdge{};
    const auto isUnsure = [&](size_t at) { return hasEdge && edge.unsure[at]; };
    const auto isShown = [&](size_t at) { return inside(at) || isUnsure(at); };
    for (size_t c = 0; c < 3; ++c) reduce([&](size_t at) { return isShown(at) ? image.pixels[at * 3 + c] : 0; }, &level.rgb[c * pixels]);
    reduce([&](size_t at) { return inside(at) ? 255 : 0; }, level.mask.data());
    for (const uint8_t value : level.mask) level.personPx += isPerson(value);
    if (!labels.pixels.empty()) {
        level.cloth.resize(pixels);
        reduce(
            [&](size_t at) { return std::find(clothLabels.begin(), clothLabels.end(), labels.pixels[at]) != clothLabels.end() ? 255 : 0; },
            level.cloth.data());
    }
    if (hasEdge) {
        level.shown.resize(pixels), level.unsure.resize(pixels), level.behind.resize(pixels * 3);
        reduce([&](size_t at) { return isShown(at) ? 255 : 0; }, level.shown.data());
        reduce([&](size_t at) { return isUnsure(at) ? 255 : 0; }, level.unsure.data());
        for (size_t c = 0; c < 3; ++c) reduce([&](size_t at) { return edge.behind[at * 3 + c]; }, &level.behind[c * pixels]);
        if (!found) level.edgeMaskWeight = float(priors::kGivenMaskEdgeWeight);
    }
    camera.cx -= left, camera.cy -= top;
    camera.widthPx = level.widthPx, camera.heightPx = level.heightPx;
    level.camera = camera.cast<float>();
    return level;
}

}  // namespace dpl
