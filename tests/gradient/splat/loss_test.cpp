// The losses' gradients against central differences of a double-precision restatement.
#include "reconstruction/splat/losses.h"

#include <random>

#include "tests/gradient/splat/finite_difference.h"

namespace dpl::test {
namespace {

double referenceSsim(const std::vector<double>& x, const std::vector<double>& y, int w, int h) {
    double window[11], sum = 0;
    for (int k = 0; k < 11; ++k) sum += window[k] = std::exp(-0.5 * (k - 5) * (k - 5) / 2.25);
    double total = 0;
    for (int c = 0; c < 3; ++c)
        for (int py = 0; py < h; ++py)
            for (int px = 0; px < w; ++px) {
                double m[5] = {};
                for (int j = -5; j <= 5; ++j)
                    for (int i = -5; i <= 5; ++i) {
                        if (px + i < 0 || px + i >= w || py + j < 0 || py + j >= h) continue;
                        const double g = window[i + 5] * window[j + 5] / (sum * sum);
                        const size_t at = size_t(c * w * h + (py + j) * w + px + i);
                        m[0] += g * x[at], m[1] += g * y[at], m[2] += g * x[at] * x[at], m[3] += g * y[at] * y[at], m[4] += g * x[at] * y[at];
                    }
                const double c1 = 1e-4, c2 = 9e-4, vx = m[2] - m[0] * m[0], vy = m[3] - m[1] * m[1], vxy = m[4] - m[0] * m[1];
                total += (2 * m[0] * m[1] + c1) * (2 * vxy + c2) / ((m[0] * m[0] + m[1] * m[1] + c1) * (vx + vy + c2));
            }
    return total / (3.0 * w * h);
}

constexpr int kWidth = 14, kHeight = 12, kPixels = kWidth * kHeight;

struct Scene {
    SplatImage image;
    PictureTarget target;
    Scene() {
        std::mt19937 random(11);
        std::uniform_real_distribution<float> u01(0.05f, 0.95f);
        image.widthPx = target.widthPx = kWidth, image.heightPx = target.heightPx = kHeight;
        for (int i = 0; i < kPixels; ++i) {
            for (int c = 0; c < 3; ++c) image.rgb.push_back(u01(random) * 0.8f);
            image.alpha.push_back(u01(random)), image.cloth.push_back(u01(random));
            target.red.push_back(u01(random)), target.green.push_back(u01(random)), target.blue.push_back(u01(random));
            target.mask.push_back(i % 3 ? 1.0f : 0.0f), target.cloth.push_back(i % 5 ? 0.0f : 1.0f), target.band.push_back(0);
        }
    }
};

double referenceLoss(const Scene& s, const std::vector<double>& image, const LossWeights& w, const Vec3d& background) {
    std::vector<double> drawn(3 * kPixels), wanted(3 * kPixels);
    double l1 = 0, mask = 0, cloth = 0;
    for (size_t i = 0; i < kPixels; ++i) {
        const double alpha = image[3 * kPixels + i], m = s.target.mask[i];
        const double goal[3] = {s.target.red[i], s.target.green[i], s.target.blue[i]};
        for (size_t c = 0; c < 3; ++c) {
            drawn[c * kPixels + i] = image[i * 3 + c] + (1 - alpha) * background[int(c)];
            wanted[c * kPixels + i] = goal[c] + (1 - m) * background[int(c)];
            l1 += std::abs(drawn[c * kPixels + i] - wanted[c * kPixels + i]);
        }
        mask += std::abs(alpha - m), cloth += std::abs(image[4 * kPixels + i] - s.target.cloth[i]);
    }
    return w.l1 * l1 / (3 * kPixels) + w.mask * mask / kPixels + w.cloth * cloth / kPixels + w.ssim * (1 - referenceSsim(drawn, wanted, kWidth, kHeight));
}

TEST(PictureLoss, gradientOfEveryTerm) {
    Jobs jobs(2);
    const Vec3f background(0.2f, 0.7f, 0.45f);
    const LossWeights cases[] = {{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}, {0, 0, 0, 1}, {0.8f, 0.2f, 1, 0.3f}};
    for (const LossWeights& w : cases) {
        Scene s;
        PictureLoss loss(jobs);
        ImageGradient g;
        const LossValues v = loss.run(s.image, s.target, w, background, g);
        std::vector<double> x(s.image.rgb.begin(), s.image.rgb.end());
        x.insert(x.end(), s.image.alpha.begin(), s.image.alpha.end());
        x.insert(x.end(), s.image.cloth.begin(), s.image.cloth.end());
        EXPECT_NEAR(v.total, referenceLoss(s, x, w, Vec3d(background)), 1e-5);
        const auto numeric = differences(x, [&](const auto& y) { return referenceLoss(s, y, w, Vec3d(background)); }, 1e-6);
        std::vector<double> analytic;
        for (size_t i = 0; i < kPixels; ++i) analytic.insert(analytic.end(), {g.red[i], g.green[i], g.blue[i]});
        analytic.insert(analytic.end(), g.alpha.begin(), g.alpha.end());
        if (g.cloth.empty()) analytic.insert(analytic.end(), size_t(kPixels), 0.0);
        else analytic.insert(analytic.end(), g.cloth.begin(), g.cloth.end());
        expectGradients(analytic, numeric, 2e-4, "image");  // float sums over 121 taps against double
    }
}

TEST(PictureLoss, bandHasNoColourGradient) {
    Jobs jobs(1);
    Scene s;
    for (size_t i = 0; i < kPixels; i += 4) s.target.band[i] = 1;
    PictureLoss loss(jobs);
    ImageGradient g;
    loss.run(s.image, s.target, {0.8f, 0.2f, 0, 0}, Vec3f(0.5f), g);
    double outside = 0;
    for (size_t i = 0; i < kPixels; ++i) {
        if (i % 4 == 0) EXPECT_EQ(g.red[i], 0) << i;
        else outside += std::abs(g.red[i]);
    }
    EXPECT_GT(outside, 0);
}

TEST(PictureLoss, identicalPicturesScorePerfectly) {
    Jobs jobs(1);
    Scene s;
    for (size_t i = 0; i < kPixels; ++i) {
        const float m = s.target.mask[i];
        s.image.alpha[i] = m;
        s.image.rgb[i * 3] = s.target.red[i], s.image.rgb[i * 3 + 1] = s.target.green[i], s.image.rgb[i * 3 + 2] = s.target.blue[i];
    }
    PictureLoss loss(jobs);
    ImageGradient g;
    const LossValues v = loss.run(s.image, s.target, {0.8f, 0.2f, 1, 0}, Vec3f(0.3f), g);
    EXPECT_NEAR(v.total, 0, 1e-5);
}

}  // namespace
}  // namespace dpl::test
