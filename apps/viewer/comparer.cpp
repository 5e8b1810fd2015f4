// SPDX-License-Identifier: Apache-2.0
#include "apps/viewer/comparer.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "apps/shared/pictures.h"
#include "reconstruction/base/image_file.h"
#include "sdk/core/files.h"

namespace dpl {
namespace {

namespace fs = std::filesystem;

constexpr uint8_t kGround = 58;  // behind the avatar

/** Paths in frames.json are from the scan's folder, or absolute. */
Result<Picture> readPictureOf(const fs::path& path, PictureChannels channels, const ComparedFrame& frame) {
    DPL_TRY(const auto bytes, readCompleteImage(path));
    auto picture = decodePicture(bytes, channels);
    if (!picture) return fail(picture.error().code, "{}: {}", path.string(), picture.error().message);
    if (picture->widthPx != frame.camera.widthPx || picture->heightPx != frame.camera.heightPx)
        return fail(Code::CorruptData, "{}: {} x {} pixels, and its camera has {} x {}; it is another picture", path.string(),
                    picture->widthPx, picture->heightPx, frame.camera.widthPx, frame.camera.heightPx);
    return std::move(*picture);
}

/** Where the stored picture has what a pinhole camera sees at px, by Brown's model. */
Vec2d storedPx(const ComparedFrame& frame, const Vec2d& px) {
    const Camerad& c = frame.camera;
    const double x = (px.x - c.cx) / c.fx, y = (px.y - c.cy) / c.fy, r2 = x * x + y * y;
    const double radial = 1 + r2 * (frame.k1 + r2 * frame.k2);
    const double dx = x * radial + 2 * frame.p1 * x * y + frame.p2 * (r2 + 2 * x * x);
    const double dy = y * radial + frame.p1 * (r2 + 2 * y * y) + 2 * frame.p2 * x * y;
    return {c.cx + c.fx * dx, c.cy + c.fy * dy};
}

/** The stored picture at px, between its pixels; its border goes on outside. */
double sample(const Picture& picture, const Vec2d& px, uint32_t channel) {
    const double x = std::clamp(px.x - 0.5, 0.0, double(picture.widthPx - 1)),
                 y = std::clamp(px.y - 0.5, 0.0, double(picture.heightPx - 1));
    const auto x0 = uint32_t(x), y0 = uint32_t(y);
    const uint32_t x1 = std::min(x0 + 1, picture.widthPx - 1), y1 = std::min(y0 + 1, picture.heightPx - 1);
    const auto at = [&](uint32_t column, uint32_t row) {
        return double(picture.pixels[(size_t(row) * picture.widthPx + column) * picture.channels + channel]);
    };
    const double fx = x - x0, fy = y - y0;
    return (1 - fy) * ((1 - fx) * at(x0, y0) + fx * at(x1, y0)) + fy * ((1 - fx) * at(x0, y1) + fx * at(x1, y1));
}

/** Black, blue, red, yellow, white for 0 to 1. */
void paintError(double share, uint8_t* rgba) {
    static constexpr double kRamp[5][3] = {{0, 0, 0}, {0.1, 0.2, 0.9}, {0.9, 0.1, 0.2}, {1, 0.9, 0.1}, {1, 1, 1}};
    const double at = std::clamp(share, 0.0, 1.0) * 4;
    const auto i = std::min(size_t(at), size_t(3));
    for (size_t c = 0; c < 3; ++c) rgba[c] = uint8_t(std::lround(255 * (kRamp[i][c] + (at - double(i)) * (kRamp[i + 1][c] - kRamp[i][c]))));
    rgba[3] = 255;
}

}  // namespace

Picture pinholePicture(const Picture& stored, const ComparedFrame& frame, uint32_t n) {
    const bool straight = frame.k1 == 0 && frame.k2 == 0 && frame.p1 == 0 && frame.p2 == 0;
    Picture out{stored.widthPx / n, stored.heightPx / n, stored.channels, {}};
    out.pixels.resize(size_t(out.widthPx) * out.heightPx * out.channels);
    for (uint32_t y = 0; y < out.heightPx; ++y)
        for (uint32_t x = 0; x < out.widthPx; ++x)
            for (uint32_t c = 0; c < out.channels; ++c) {
                double sum = 0;
                for (uint32_t dy = 0; dy < n; ++dy)
                    for (uint32_t dx = 0; dx < n; ++dx) {
                        const uint32_t column = x * n + dx, row = y * n + dy;
                        sum += straight ? double(stored.pixels[(size_t(row) * stored.widthPx + column) * stored.channels + c])
                                        : sample(stored, storedPx(frame, {column + 0.5, row + 0.5}), c);
                    }
                out.pixels[(size_t(y) * out.widthPx + x) * out.channels + c] = uint8_t(std::lround(sum / (n * n)));
            }
    return out;
}

ComparedPictures comparedPictures(Picture photo, const Picture& mask, const std::vector<uint8_t>& rgba) {
    ComparedPictures out;
    out.masked = !mask.pixels.empty();
    out.avatar = out.error = {photo.widthPx, photo.heightPx, 4, {}};
    const size_t pixels = size_t(photo.widthPx) * photo.heightPx;
    out.avatar.pixels.resize(4 * pixels), out.error.pixels.resize(4 * pixels);
    double squares = 0;
    size_t count = 0;
    for (size_t i = 0; i < pixels; ++i) {
        const uint8_t *seen = &photo.pixels[4 * i], *drawn = &rgba[4 * i];
        const double alpha = drawn[3] / 255.0;
        const bool there = out.masked ? mask.pixels[i] >= 128 : drawn[3] >= 128;
        double square = 0;
        for (size_t c = 0; c < 3; ++c) {
            out.avatar.pixels[4 * i + c] = uint8_t(std::lround(alpha * drawn[c] + (1 - alpha) * kGround));
            const double difference = alpha * drawn[c] - (there ? seen[c] : 0);  // both over black
            square += difference * difference / 3;
        }
        out.avatar.pixels[4 * i + 3] = 255;
        const bool counts = there || drawn[3] >= 128;
        paintError(counts ? std::sqrt(square) / ComparedPictures::kWhiteLevels : 0, &out.error.pixels[4 * i]);
        if (counts) squares += square, ++count;
    }
    out.db = squares > 0 ? 10 * std::log10(255.0 * 255.0 * double(count) / squares) : std::numeric_limits<double>::infinity();
    out.photo = std::move(photo);
    return out;
}

Result<Comparer> Comparer::open(const fs::path& run, const fs::path& avatarFile, const fs::path& scan) {
    DPL_TRY(ScanFrames frames, readScanFrames(run));
    if (!scan.empty()) frames.scan = scan;
    std::error_code error;
    if (!fs::is_directory(frames.scan, error))
        return fail(Code::NotFound, "the scan {} is not there; drop its folder on the window", frames.scan.string());
    DPL_TRY(const auto bytes, readFile(avatarFile));
    auto context = doppel::Context::create(DPL_RENDERER_SOFTWARE);
    if (!context) return fromSdk(context.error());
    auto avatar = context->loadAvatar(bytes);
    if (!avatar) return fail(fromSdk(avatar.error()).code, "{}: {}", avatarFile.string(), avatar.error().message);
    const auto info = avatar->info();
    if (!info) return fromSdk(info.error());
    bool same = info->jointCount == frames.joints.size();
    for (uint32_t j = 0; same && j < info->jointCount; ++j) {
        const auto joint = avatar->joint(j);
        same = joint && frames.joints[j] == joint->name;
    }
    if (!same) return fail(Code::InvalidArgument, "{} has another skeleton than {}", avatarFile.string(), (run / "poses.json").string());
    return Comparer(std::move(frames), std::move(*context), std::move(*avatar));
}

Result<ComparedPictures> Comparer::compare(size_t index) {
    if (index >= frames_.frames.size()) return fail(Code::InvalidArgument, "there is no frame {}", index);
    const ComparedFrame& frame = frames_.frames[index];
    const uint32_t n = (frame.camera.heightPx + ComparedPictures::kRows - 1) / ComparedPictures::kRows;
    DPL_TRY(const Picture stored, readPictureOf(frames_.scan / frame.image, PictureChannels::Rgba, frame));
    Picture photo = pinholePicture(stored, frame, n), mask;
    if (!frame.mask.empty()) {
        DPL_TRY(const Picture storedMask, readPictureOf(frames_.scan / frame.mask, PictureChannels::AsStored, frame));
        if (storedMask.channels == 1) mask = pinholePicture(storedMask, frame, n);
    }
    Camerad camera = frame.camera;
    camera.widthPx = photo.widthPx, camera.heightPx = photo.heightPx;
    camera.fx /= n, camera.fy /= n, camera.cx /= n, camera.cy /= n;
    if (auto set = avatar_.setPose(frame.rotations, frame.root); !set)
        return fail(Code::CorruptData, "{}: {}", frame.name, set.error().message);
    const DplAvatar handle = avatar_.handle();
    const Cameraf view = camera.cast<float>();
    DPL_TRY(const auto drawn, drawViews(context_, {&handle, 1}, {&view, 1}));
    return comparedPictures(std::move(photo), mask, drawn[0]);
}

}  // namespace dpl
