#include "reconstruction/splat/metrics.h"

#include <algorithm>
#include <cmath>

namespace dpl {
namespace {

double psnr(double squared, double count) {
    return squared > 0 && count > 0 ? std::min(kPerfectPsnr, -10 * std::log10(squared / count)) : kPerfectPsnr;
}

struct Box {
    uint32_t x0, y0, x1, y1;
};

Box personBox(std::span<const uint8_t> mask, uint32_t width, uint32_t height) {
    Box b{width, height, 0, 0};
    for (uint32_t y = 0; y < height; ++y)
        for (uint32_t x = 0; x < width; ++x)
            if (mask[size_t(y) * width + x] >= 128) b = {std::min(b.x0, x), std::min(b.y0, y), std::max(b.x1, x + 1), std::max(b.y1, y + 1)};
    if (b.x1 <= b.x0) return {0, 0, width, height};
    const uint32_t margin = std::max(b.x1 - b.x0, b.y1 - b.y0) / 10;
    return {b.x0 > margin ? b.x0 - margin : 0, b.y0 > margin ? b.y0 - margin : 0, std::min(width, b.x1 + margin), std::min(height, b.y1 + margin)};
}

PictureScore scoreOn(const ScoredRender& render, const ScoredTruth& truth, const Box& box, float background, Jobs& jobs) {
    PlanarImage drawn, wanted;
    drawn.resize(box.x1 - box.x0, box.y1 - box.y0, 3), wanted.resize(box.x1 - box.x0, box.y1 - box.y0, 3);
    double masked = 0, maskedCount = 0, inBox = 0, full = 0;
    for (uint32_t y = 0; y < render.heightPx; ++y)
        for (uint32_t x = 0; x < render.widthPx; ++x) {
            const size_t i = size_t(y) * render.widthPx + x;
            const float mask = float(truth.mask[i]) / 255.0f, alpha = render.alpha[i];
            const bool boxed = x >= box.x0 && x < box.x1 && y >= box.y0 && y < box.y1;
            for (uint32_t c = 0; c < 3; ++c) {
                const float a = std::clamp(render.rgb[i * 3 + c] + (1 - alpha) * background, 0.0f, 1.0f);
                const float b = mask * float(truth.rgb[i * 3 + c]) / 255.0f + (1 - mask) * background;
                const double error = double(a - b) * double(a - b);
                full += error;
                if (mask >= 0.5f) masked += error, maskedCount += 1;
                if (boxed) {
                    inBox += error;
                    const size_t at = size_t(y - box.y0) * drawn.widthPx + (x - box.x0);
                    drawn.plane(c)[at] = a, wanted.plane(c)[at] = b;
                }
            }
        }
    PictureScore s;
    s.psnrMasked = psnr(masked, maskedCount);
    s.psnrBox = psnr(inBox, double(drawn.values.size()));
    s.psnrFull = psnr(full, 3.0 * render.widthPx * render.heightPx);
    s.ssim = Ssim(jobs).run(drawn, wanted, nullptr, 0);
    return s;
}

}  // namespace

ImageScores scoreImage(const ScoredRender& render, const ScoredTruth& truth, Jobs& jobs) {
    ImageScores s;
    const Box box = personBox(truth.mask, render.widthPx, render.heightPx);
    s.white = scoreOn(render, truth, box, 1.0f, jobs);
    s.black = scoreOn(render, truth, box, 0.0f, jobs);
    s.grey = scoreOn(render, truth, box, 0.5f, jobs);
    const auto least = [&](double PictureScore::*field) { return std::min({s.white.*field, s.black.*field, s.grey.*field}); };
    s.worst = {least(&PictureScore::psnrMasked), least(&PictureScore::psnrBox), least(&PictureScore::psnrFull), least(&PictureScore::ssim)};
    size_t both = 0, either = 0, inside = 0;
    for (size_t i = 0; i < render.alpha.size(); ++i) {
        const bool a = render.alpha[i] >= 0.5f, m = truth.mask[i] >= 128;
        both += a && m, either += a || m, inside += m;
    }
    s.alphaIou = either ? double(both) / double(either) : 1;
    s.coverage = render.alpha.empty() ? 0 : double(inside) / double(render.alpha.size());
    return s;
}

void unpackPremultiplied(std::span<const uint8_t> rgba, std::vector<float>& rgb, std::vector<float>& alpha) {
    const size_t pixels = rgba.size() / 4;
    rgb.resize(pixels * 3), alpha.resize(pixels);
    for (size_t i = 0; i < pixels; ++i) {
        for (size_t c = 0; c < 3; ++c) rgb[i * 3 + c] = float(rgba[i * 4 + c]) / 255.0f;
        alpha[i] = float(rgba[i * 4 + 3]) / 255.0f;
    }
}

}  // namespace dpl
