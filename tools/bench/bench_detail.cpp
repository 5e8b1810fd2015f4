// SPDX-License-Identifier: Apache-2.0
// bench_detail AVATAR|SPLATS [SPLATS A PIXEL] [FRAMES] [software|quads|tiles] [SHEET.png | -] [--json FILE]
//
// Measures level of detail at several distances: time, splats and error of the full and of the reduced subject, posed in the middle of its
// first clip. For avatars it also measures the loss from leaving out SH above degree 0 or pose correctives.
// The ground truth at each distance is the full subject, drawn on the CPU at four times the size and averaged. Errors are taken over mid
// grey, over pixels that either picture covers. The sheet has one row per distance: full, reduced and ground truth side by side, enlarged
// without smoothing.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <optional>
#include <string>
#include <vector>

#include "apps/bench/json_row.h"
#include "reconstruction/base/image_codec.h"
#include "sdk/avatar/humanoid.h"
#include "sdk/avatar/pose_correctives.h"
#include "sdk/core/files.h"
#include "sdk/format/avatar_file.h"
#include "sdk/include/doppel/doppel.hpp"
#include "sdk/math/sh.h"
#include "tools/bench/arguments.h"

namespace {

using Pixels = std::vector<uint8_t>;  // premultiplied RGBA8
constexpr uint32_t kWidthPx = 512, kHeightPx = 768, kFiner = 4;
constexpr double kDistances[] = {1, 1.5, 2, 3, 4, 6, 8, 12, 16, 24};  // multiples of the distance at which the avatar fills the picture

int failed(const std::string& why) {
    return std::fprintf(stderr, "bench_detail: %s\n", why.c_str()), 1;
}

DplCamera cameraAt(const DplAvatarInfo& info, double times, uint32_t finer, double azimuthRad) {
    DplCamera c{};
    c.structSize = sizeof c;
    c.widthPx = kWidthPx * finer, c.heightPx = kHeightPx * finer;
    c.fx = c.fy = float(1.2 * c.heightPx);
    c.cx = float(c.widthPx) / 2, c.cy = float(c.heightPx) / 2;
    double middle[3], tall = info.restMax[1] - info.restMin[1];
    for (int k = 0; k < 3; ++k) middle[k] = 0.5 * (info.restMin[k] + info.restMax[k]);
    for (int k = 0; k < 3 && info.jointCount == 0; ++k)
        tall = std::max(tall,
                        double(info.restMax[k] - info.restMin[k]));  // general splats may have another up axis, so use their largest extent
    const double distance = 1.25 * 1.2 * tall * times, s = std::sin(azimuthRad), co = std::cos(azimuthRad);
    // Rows: the right, down and forward axes of a camera at middle + distance·(s, 0, co) that looks at the middle.
    const double rows[3][3] = {{co, 0, -s}, {0, -1, 0}, {-s, 0, -co}};
    for (int r = 0; r < 3; ++r) {
        double t = r == 2 ? distance : 0;
        for (int k = 0; k < 3; ++k) t -= rows[r][k] * middle[k], c.viewFromWorld[4 * r + k] = float(rows[r][k]);
        c.viewFromWorld[4 * r + 3] = float(t);
    }
    return c;
}

struct Drawn {
    Pixels pixels;
    double ms = 0;
    uint32_t splats = 0, allowed = 0;
    uint64_t decoded = 0;
};

doppel::Result<Drawn> draw(const doppel::Avatar& avatar, const DplCamera& camera, int frames) {
    Drawn out;
    out.pixels.resize(size_t(camera.widthPx) * camera.heightPx * 4);
    DplImage image{};
    image.structSize = sizeof image, image.rgba = out.pixels.data(), image.rgbaBytes = out.pixels.size();
    std::vector<double> times;
    for (int f = 0; f < frames + (frames > 1 ? 2 : 0); ++f) {
        const auto begin = std::chrono::steady_clock::now();
        if (auto status = avatar.render({&camera, 1}, {&image, 1}); !status) return status.error();
        times.push_back(std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - begin).count());
    }
    if (frames > 1) times.erase(times.begin(), times.begin() + 2);
    std::nth_element(times.begin(), times.begin() + ptrdiff_t(times.size() / 2), times.end());
    out.ms = times[times.size() / 2];
    auto stats = avatar.frameStats();
    if (!stats) return stats.error();
    out.splats = stats->splatsDrawn, out.allowed = stats->splatsAllowed, out.decoded = stats->bytesDecided + stats->bytesDecoded;
    return out;
}

/** The middle of the first clip, if there is one. */
doppel::Status poseInClip(doppel::Avatar& avatar) {
    auto info = avatar.info();
    if (!info) return info.error();
    if (info->clipCount == 0) return {};
    auto clip = avatar.clip(0);
    if (!clip) return clip.error();
    return avatar.setPoseFromClip(0, clip->durationS / 2);
}

/** The file with only the splats of the face or of the hands visible. Its picture marks that region. */
dpl::Result<std::vector<uint8_t>> regionAlone(const std::vector<uint8_t>& bytes, bool hands) {
    DPL_TRY(dpl::AvatarData avatar, dpl::readAvatar(bytes));
    std::vector<bool> wanted;
    for (const std::string& bone : dpl::humanoidBones(avatar.joints)) {
        const bool face = bone == "head" || bone == "jaw" || bone.ends_with("Eye");
        bool hand = bone.ends_with("Hand");
        for (const char* finger : {"Thumb", "Index", "Middle", "Ring", "Little"}) hand |= bone.find(finger) != bone.npos;
        wanted.push_back(hands ? hand : face);
    }
    for (size_t t = 0; t < avatar.mesh.triangles.size(); ++t) {
        uint32_t on = 0;
        for (int c = 0; c < 3; ++c)
            for (int k = 0; k < 4; ++k)
                if (const auto v = avatar.mesh.triangles[t][c]; wanted[avatar.mesh.jointIndices[v][k]])
                    on += avatar.mesh.jointWeights[v][k];
        for (uint32_t i = avatar.splats.triangleStart[t]; i < avatar.splats.triangleStart[t + 1] && 2 * on < 3 * 255; ++i)
            avatar.splats.opacity[i] = 0;
    }
    return dpl::writeAvatar(avatar);
}

/** The file without pose correctives, or without SH beyond coefficient 0. */
dpl::Result<std::vector<uint8_t>> without(const std::vector<uint8_t>& bytes, bool correctives) {
    DPL_TRY(dpl::AvatarData avatar, dpl::readAvatar(bytes));
    if (correctives) {
        avatar.correctives = {};
    } else {
        const size_t from = size_t(dpl::shCoefficientCount(avatar.splats.shDegree)) * 3;
        std::vector<float> sh;
        for (size_t i = 0; i < avatar.splats.count(); ++i)
            sh.insert(sh.end(), avatar.splats.sh.begin() + ptrdiff_t(i * from), avatar.splats.sh.begin() + ptrdiff_t(i * from + 3));
        avatar.splats.sh = std::move(sh), avatar.splats.shDegree = 0;
    }
    return dpl::writeAvatar(avatar);
}

/** Time of the CPU's part of pose correctives, microseconds a frame, fastest of 200. */
doppel::Result<double> correctivesUs(const std::vector<uint8_t>& bytes) {
    const auto avatar = dpl::readAvatar(bytes);
    if (!avatar) return doppel::Error{DPL_ERROR_CORRUPT_DATA, avatar.error().message};
    const dpl::Pose pose = dpl::Pose::rest(avatar->joints.size());
    std::vector<float> coefficients;
    std::vector<dpl::Vec4f> nodes;
    double best = 1e9;
    for (int round = 0; round < 200; ++round) {
        const auto begin = std::chrono::steady_clock::now();
        dpl::correctiveCoefficients(avatar->correctives, pose, coefficients);
        dpl::correctiveNodes(avatar->correctives, coefficients, nodes);
        best = std::min(best, std::chrono::duration<double, std::micro>(std::chrono::steady_clock::now() - begin).count());
    }
    return best;
}

std::vector<float> averaged(const Pixels& fine) {
    std::vector<float> out(size_t(kWidthPx) * kHeightPx * 4, 0);
    for (size_t y = 0; y < kHeightPx * kFiner; ++y)
        for (size_t x = 0; x < kWidthPx * kFiner; ++x)
            for (size_t c = 0; c < 4; ++c)
                out[(y / kFiner * kWidthPx + x / kFiner) * 4 + c] += float(fine[(y * kWidthPx * kFiner + x) * 4 + c]) / (kFiner * kFiner);
    return out;
}

std::vector<float> floatOf(const Pixels& p) {
    return {p.begin(), p.end()};
}

/** PSNR in dB over mid grey, over pixels that either picture covers and, with a region, that the region covers by half or more. */
double psnr(const std::vector<float>& a, const std::vector<float>& b, const std::vector<float>* region = nullptr) {
    double sum = 0;
    size_t count = 0;
    for (size_t i = 0; i < a.size(); i += 4) {
        if ((a[i + 3] < 1 && b[i + 3] < 1) || (region && (*region)[i + 3] < 128)) continue;
        for (size_t c = 0; c < 3; ++c) {
            const double d = double(a[i + c]) - double(b[i + c]) - 0.5 * (double(a[i + 3]) - double(b[i + 3]));
            sum += d * d, ++count;
        }
    }
    return count == 0 || sum == 0 ? 99 : 10 * std::log10(255.0 * 255.0 * double(count) / sum);
}

/** Sum of alpha compared with the truth's, in percent. Above 0 when outlines are swollen. */
double swelling(const std::vector<float>& a, const std::vector<float>& truth) {
    double x = 0, y = 0;
    for (size_t i = 3; i < a.size(); i += 4) x += double(a[i]), y += double(truth[i]);
    return 100 * (x / y - 1);
}

class Sheet {
public:
    void addRow(const std::vector<float>& full, const std::vector<float>& reduced, const std::vector<float>& truth, double times) {
        const uint32_t side =
                           std::min<uint32_t>(kWidthPx, uint32_t(kCellPx / std::max(1.0, std::floor(kCellPx / (kHeightPx * 0.9 / times))))),
                       zoom = kCellPx / side;
        const size_t top = pixels_.size() / 3 / kAcross;
        pixels_.resize((top + kCellPx) * kAcross * 3, 40);
        const std::vector<float>* cells[3] = {&full, &reduced, &truth};
        for (uint32_t k = 0; k < 3; ++k)
            for (uint32_t y = 0; y < side * zoom; ++y)
                for (uint32_t x = 0; x < side * zoom; ++x) {
                    const size_t fromX = (kWidthPx - side) / 2 + x / zoom, fromY = (kHeightPx - side) / 2 + y / zoom;
                    const float* p = cells[k]->data() + (fromY * kWidthPx + fromX) * 4;
                    for (size_t c = 0; c < 3; ++c)
                        pixels_[((top + y) * kAcross + k * kCellPx + x) * 3 + c] =
                            uint8_t(std::clamp(p[c] + 235 * (1 - p[3] / 255), 0.0f, 255.0f));
                }
    }
    bool write(const std::string& path) const {
        auto png = dpl::encodePng(pixels_, uint32_t(kAcross), uint32_t(pixels_.size() / 3 / kAcross), 3);
        return png && dpl::writeFileAtomically(path, *png);
    }

private:
    static constexpr uint32_t kCellPx = 512;
    static constexpr size_t kAcross = 3 * kCellPx;
    std::vector<uint8_t> pixels_;
};

}  // namespace

int main(int argc, char** argv) {
    const dpl::BenchArguments arguments(argc, argv);
    if (arguments.count() < 1)
        return std::fprintf(stderr,
                            "usage: bench_detail AVATAR|SPLATS [SPLATS A PIXEL] [FRAMES] [software|quads|tiles] [SHEET.png | -] "
                            "[--json FILE]\n"),
               2;
    const float perPixel = float(arguments.number(1, double(DPL_DETAIL_USUAL)));
    const int frames = std::max(1, int(arguments.number(2, 5)));
    const std::string kind = arguments.text(3, "software"), sheetFile = arguments.text(4, "-");
    const auto bytes = dpl::readFile(arguments.text(0));
    if (!bytes) return failed(bytes.error().message);
    auto context = kind == "software"
                       ? doppel::Context::create(DPL_RENDERER_SOFTWARE)
                       : doppel::Context::create(DPL_RENDERER_VULKAN, 0, 0, kind == "tiles" ? DPL_FILL_TILES : DPL_FILL_QUADS);
    auto judge = doppel::Context::create(DPL_RENDERER_SOFTWARE);
    if (!context || !judge) return failed(context ? judge.error().message : context.error().message);
    auto avatar = context->loadAvatar(*bytes);
    auto finest = judge->loadAvatar(*bytes);
    if (!avatar || !finest) return failed(avatar ? finest.error().message : avatar.error().message);
    const auto info = avatar->info();
    if (!info) return failed(info.error().message);
    const bool posable = info->jointCount > 0;
    std::vector<doppel::Avatar> lesser, regions;  // lesser: without SH, without correctives; regions: face, hands
    const auto loadPosed = [&](std::vector<doppel::Avatar>& into, const auto& file) -> std::optional<std::string> {
        if (!file) return file.error().message;
        auto loaded = judge->loadAvatar(*file);
        if (!loaded) return loaded.error().message;
        into.push_back(std::move(*loaded));
        if (auto posed = poseInClip(into.back()); !posed) return posed.error().message;
        return std::nullopt;
    };
    for (const bool second : {false, true}) {
        if (!posable) break;
        if (const auto why = loadPosed(lesser, without(*bytes, second))) return failed(*why);
        if (const auto why = loadPosed(regions, regionAlone(*bytes, second))) return failed(*why);
    }
    for (doppel::Avatar* a : {&*avatar, &*finest})
        if (auto posed = poseInClip(*a); !posed) return failed(posed.error().message);
    std::printf("%s, %u splats, %s, %g splats a pixel, %ux%u px, median of %d", arguments.text(0).c_str(), info->splatCount,
                context->rendererName().c_str(), double(perPixel), kWidthPx, kHeightPx, frames);
    if (posable) {
        const auto us = correctivesUs(*bytes);
        if (!us) return failed(us.error().message);
        std::printf("; pose correctives take %.1f us of the CPU a frame", *us);
    }
    std::printf(
        "\n\n| tall, px | full: ms | splats drawn | MB read | dB to truth | alpha %% | reduced: ms | splats allowed | drawn | MB read | dB "
        "to truth | alpha %% | dB to full |%s\n|---|---|---|---|---|---|---|---|---|---|---|---|---|%s\n",
        posable ? " all splats: without SH, dB to truth | without correctives | face, full: dB to truth | reduced | hands, full | reduced |"
                : "",
        posable ? "---|---|---|---|---|---|" : "");
    Sheet sheet;
    std::string json;
    for (const double times : kDistances) {
        const DplCamera camera = cameraAt(*info, times, 1, 0.4), fineCamera = cameraAt(*info, times, kFiner, 0.4);
        (void)context->setDetail(0);
        const auto full = draw(*avatar, camera, frames);
        if (auto set = context->setDetail(perPixel); !set) return failed(set.error().message);
        const auto reduced = draw(*avatar, camera, frames);
        const auto fine = draw(*finest, fineCamera, 1);
        for (const auto* drawn : {&full, &reduced, &fine})
            if (!*drawn) return failed(drawn->error().message);
        const std::vector<float> truth = averaged(fine->pixels), a = floatOf(full->pixels), b = floatOf(reduced->pixels);
        std::printf("| %.0f | %.1f | %u | %.2f | %.2f | %+.2f | %.1f | %u | %u | %.2f | %.2f | %+.2f | %.2f |", kHeightPx * 0.8 / times,
                    full->ms, full->splats, double(full->decoded) / 1e6, psnr(a, truth), swelling(a, truth), reduced->ms, reduced->allowed,
                    reduced->splats, double(reduced->decoded) / 1e6, psnr(b, truth), swelling(b, truth), psnr(b, a));
        dpl::JsonRow row;
        row.add("device", context->rendererName()).add("splats", info->splatCount).add("tall_px", kHeightPx * 0.8 / times);
        row.add("full_ms", full->ms).add("full_drawn", full->splats).add("full_bytes_read", full->decoded);
        row.add("full_db", psnr(a, truth)).add("full_alpha_percent", swelling(a, truth));
        row.add("reduced_ms", reduced->ms).add("reduced_allowed", reduced->allowed).add("reduced_drawn", reduced->splats);
        row.add("reduced_bytes_read", reduced->decoded).add("reduced_db", psnr(b, truth));
        row.add("reduced_alpha_percent", swelling(b, truth)).add("reduced_to_full_db", psnr(b, a));
        for (size_t i = 0; i < lesser.size(); ++i) {
            const auto drawn = draw(lesser[i], camera, 1);
            if (!drawn) return failed(drawn.error().message);
            const double db = psnr(floatOf(drawn->pixels), truth);
            std::printf(" %.2f |", db);
            row.add(i == 0 ? "without_sh_db" : "without_correctives_db", db);
        }
        for (size_t i = 0; i < regions.size(); ++i) {
            const auto drawn = draw(regions[i], camera, 1);
            if (!drawn) return failed(drawn.error().message);
            const std::vector<float> where = floatOf(drawn->pixels);
            const double of = psnr(a, truth, &where), reducedOf = psnr(b, truth, &where);
            std::printf(" %.2f | %.2f |", of, reducedOf);
            row.add(i == 0 ? "face_full_db" : "hands_full_db", of).add(i == 0 ? "face_reduced_db" : "hands_reduced_db", reducedOf);
        }
        json += row.line();
        std::printf("\n");
        std::fflush(stdout);
        sheet.addRow(a, b, truth, times);
    }
    if (sheetFile != "-" && !sheet.write(sheetFile)) return failed("cannot write " + sheetFile);
    const dpl::Status written = arguments.writeJson(json);
    return written ? 0 : failed(written.error().message);
}
