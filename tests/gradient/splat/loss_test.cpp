// SPDX-License-Identifier: Apache-2.0
// Gradients of the losses against central differences of the same losses written in double precision.
#include "reconstruction/training/trainer/losses.h"

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
                        m[0] += g * x[at], m[1] += g * y[at], m[2] += g * x[at] * x[at], m[3] += g * y[at] * y[at],
                            m[4] += g * x[at] * y[at];
                    }
                const double c1 = 1e-4, c2 = 9e-4, vx = m[2] - m[0] * m[0], vy = m[3] - m[1] * m[1], vxy = m[4] - m[0] * m[1];
                total += (2 * m[0] * m[1] + c1) * (2 * vxy + c2) / ((m[0] * m[0] + m[1] * m[1] + c1) * (vx + vy + c2));
            }
    return total / (3.0 * w * h);
}

constexpr int kWidth = 14, kHeight = 12, kPixels = kWidth * kHeight;

/** A picture of kWidth × kHeight random pixels, surrounded by `marginPx` pixels that neither the drawn picture nor the target covers. */
struct Scene {
    int width, height;
    SplatImage image;
    std::vector<uint8_t> rgb, mask, cloth, shown, unsure, behind;
    float edgeMaskWeight = 1;
    explicit Scene(int marginPx = 0) : width(kWidth + 2 * marginPx), height(kHeight + 2 * marginPx) {
        std::mt19937 random(11);
        std::uniform_real_distribution<float> u01(0.05f, 0.95f);
        image.widthPx = uint32_t(width), image.heightPx = uint32_t(height);
        const size_t pixels = count();
        image.rgb.assign(pixels * 3, 0.0f), image.alpha.assign(pixels, 0.0f), image.cloth.assign(pixels, 0.0f);
        rgb.assign(pixels * 3, 0), mask.assign(pixels, 0), cloth.assign(pixels, 0);
        for (int k = 0; k < kPixels; ++k) {
            const size_t i = size_t((k / kWidth + marginPx) * width + k % kWidth + marginPx);
            for (size_t c = 0; c < 3; ++c) image.rgb[i * 3 + c] = u01(random) * 0.8f;
            image.alpha[i] = u01(random), image.cloth[i] = u01(random);
            for (size_t c = 0; c < 3; ++c) rgb[c * pixels + i] = uint8_t(255 * u01(random));
            mask[i] = k % 3 ? 255 : 0, cloth[i] = k % 5 ? 0 : 255;
        }
    }
    size_t count() const { return size_t(width) * size_t(height); }
    PictureTarget target() const { return {uint32_t(width), uint32_t(height), rgb, mask, cloth, shown, unsure, behind, edgeMaskWeight}; }
    /** Makes every fourth pixel edge, some of them in part. */
    void addUnsureEdge() {
        std::mt19937 random(12);
        edgeMaskWeight = 2.5f;
        shown = mask, unsure.assign(count(), 0), behind.assign(count() * 3, 0);
        for (size_t i = 0; i < count(); i += 4) {
            unsure[i] = i % 8 ? 255 : 150, shown[i] = std::max(mask[i], unsure[i]);
            for (size_t c = 0; c < 3; ++c) behind[c * count() + i] = uint8_t(random() % (unsure[i] + 1u));
        }
    }
    /** Colour, alpha and cloth of the drawn picture, concatenated as referenceLoss() takes them. */
    std::vector<double> drawn() const {
        std::vector<double> x(image.rgb.begin(), image.rgb.end());
        x.insert(x.end(), image.alpha.begin(), image.alpha.end());
        x.insert(x.end(), image.cloth.begin(), image.cloth.end());
        return x;
    }
};

double referenceLoss(const Scene& s, const std::vector<double>& image, const LossWeights& w, const Vec3d& background) {
    const size_t n = s.count();
    std::vector<double> drawn(3 * n), wanted(3 * n);
    double l1 = 0, mask = 0, cloth = 0;
    for (size_t i = 0; i < n; ++i) {
        const double alpha = image[3 * n + i], m = s.mask[i] / 255.0, unsure = s.unsure.empty() ? 0 : s.unsure[i] / 255.0;
        for (size_t c = 0; c < 3; ++c) {
            const double known = s.behind.empty() ? 0 : s.behind[c * n + i] / 255.0;
            drawn[c * n + i] = image[i * 3 + c] + (1 - alpha) * (known + (1 - unsure) * background[int(c)]);
            wanted[c * n + i] = s.rgb[c * n + i] / 255.0 + (1 - (s.shown.empty() ? m : s.shown[i] / 255.0)) * background[int(c)];
            l1 += std::abs(drawn[c * n + i] - wanted[c * n + i]);
        }
        mask += (1 + (s.edgeMaskWeight - 1) * unsure) * std::abs(alpha - m), cloth += std::abs(image[4 * n + i] - s.cloth[i] / 255.0);
    }
    const double count = double(n);
    return w.l1 * l1 / (3 * count) + w.mask * mask / count + w.cloth * cloth / count +
           w.ssim * (1 - referenceSsim(drawn, wanted, s.width, s.height));
}

TEST(PictureLoss, gradientOfEveryTerm) {
    Jobs jobs(2);
    const Vec3f background(0.2f, 0.7f, 0.45f);
    const LossWeights cases[] = {{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}, {0, 0, 0, 1}, {0.8f, 0.2f, 1, 0.3f}};
    const auto check = [&](const LossWeights& w, bool withEdge) {
        Scene s;
        if (withEdge) s.addUnsureEdge();
        PictureLoss loss(jobs);
        ImageGradient g;
        const LossValues v = loss.run(s.image, s.target(), w, background, g);
        const std::vector<double> x = s.drawn();
        EXPECT_NEAR(v.total, referenceLoss(s, x, w, Vec3d(background)), 1e-5);
        const auto numeric = differences(
            x, [&](const auto& y) { return referenceLoss(s, y, w, Vec3d(background)); }, 1e-6);
        std::vector<double> analytic;
        for (size_t i = 0; i < kPixels; ++i) analytic.insert(analytic.end(), {g.red[i], g.green[i], g.blue[i]});
        analytic.insert(analytic.end(), g.alpha.begin(), g.alpha.end());
        if (g.cloth.empty())
            analytic.insert(analytic.end(), size_t(kPixels), 0.0);
        else
            analytic.insert(analytic.end(), g.cloth.begin(), g.cloth.end());
        expectGradients(analytic, numeric, 2e-4, "image");  // tolerance of float sums over the window's 121 pixels
    };
    for (const LossWeights& w : cases) check(w, false), check(w, true);
}

TEST(PictureLoss, emptyMarginsChangeNothingButTheMean) {
    Jobs jobs(2);
    const Vec3f background(0.2f, 0.7f, 0.45f);
    const LossWeights w{0.8f, 0.2f, 1, 0.3f};
    constexpr int kMarginPx = 13;  // the gradient of SSIM reaches 10 pixels far
    const Scene s(kMarginPx);
    PictureLoss loss(jobs);
    ImageGradient g;
    const LossValues v = loss.run(s.image, s.target(), w, background, g);
    const std::vector<double> x = s.drawn();
    EXPECT_NEAR(v.total, referenceLoss(s, x, w, Vec3d(background)), 1e-6);
    // Compare gradients of red along the diagonal through the picture's corner, from margin to inside.
    double largest = 0;
    for (int k = -3; k < 8; ++k) {
        const size_t i = size_t((kMarginPx + k) * s.width + kMarginPx + k);
        const double step = 1e-6;
        auto more = x, less = x;
        more[i * 3] += step, less[i * 3] -= step;
        const double slope = (referenceLoss(s, more, w, Vec3d(background)) - referenceLoss(s, less, w, Vec3d(background))) / (2 * step);
        EXPECT_NEAR(g.red[i], slope, 1e-7) << "pixel " << k << " from the corner";
        largest = std::max(largest, std::abs(slope));
    }
    EXPECT_GT(largest, 1e-5);
    EXPECT_EQ(g.red[0], 0);
    EXPECT_EQ(g.alpha[0], 0);
    EXPECT_EQ(g.cloth.back(), 0);
}

TEST(PictureLoss, coloursAnswerForPixelsOfTheirOwnKind) {
    Jobs jobs(1);
    Scene s;
    for (size_t i = 0; i < kPixels; ++i) s.mask[i] = i % 3 ? 255 : 0, s.cloth[i] = i % 3 == 1 ? 255 : 0;  // background, cloth, body
    PictureLoss loss(jobs);
    ImageGradient g;
    loss.run(s.image, s.target(), {0.8f, 0.2f, 1, 0.3f}, Vec3f(0.3f), g);
    ASSERT_EQ(g.colourShare[0].size(), size_t(kPixels));
    for (size_t i = 0; i < kPixels; ++i) {
        EXPECT_EQ(g.colourShare[0][i], i % 3 == 1 ? 0 : 1) << "splats of the body learn nothing from cloth";
        EXPECT_EQ(g.colourShare[1][i], i % 3 == 2 ? 0 : 1) << "splats of cloth learn nothing from skin";
    }
    s.cloth.clear();
    loss.run(s.image, s.target(), {0.8f, 0.2f, 1, 0.3f}, Vec3f(0.3f), g);
    EXPECT_TRUE(g.colourShare[0].empty()) << "without labels all pixels teach all splats";
}

/** At an unsure edge the picture decides: both a person and the background that is drawn where it lies have no loss. */
TEST(PictureLoss, unsurePixelsTakeThePictureAsItIs) {
    Jobs jobs(1);
    for (const bool isPerson : {false, true}) {
        Scene s;
        for (size_t i = 0; i < kPixels; ++i) {
            s.mask[i] = i % 2 ? 255 : 0;  // wrong in half the pixels, in either case
            s.image.alpha[i] = isPerson ? 1.0f : 0.0f;
            for (size_t c = 0; c < 3; ++c) s.image.rgb[i * 3 + c] = isPerson ? float(s.rgb[c * kPixels + i]) / 255 : 0;
        }
        s.shown.assign(kPixels, 255), s.unsure.assign(kPixels, 255), s.behind = s.rgb;
        PictureLoss loss(jobs);
        ImageGradient g;
        const LossValues v = loss.run(s.image, s.target(), {0.8f, 0.2f, 0, 0}, Vec3f(0.3f), g);
        EXPECT_NEAR(v.total, 0, 1e-5) << isPerson;
        s.behind.assign(kPixels * 3, 0);
        const double overBlack = loss.run(s.image, s.target(), {0.8f, 0.2f, 0, 0}, Vec3f(0.3f), g).total;
        EXPECT_EQ(overBlack > 0.1, !isPerson) << "what lies behind shows only where nobody is drawn";
    }
}

TEST(PictureLoss, identicalPicturesScorePerfectly) {
    Jobs jobs(1);
    Scene s;
    for (size_t i = 0; i < kPixels; ++i) {
        s.image.alpha[i] = float(s.mask[i]) / 255;
        for (size_t c = 0; c < 3; ++c) s.image.rgb[i * 3 + c] = float(s.rgb[c * kPixels + i]) / 255;
    }
    PictureLoss loss(jobs);
    ImageGradient g;
    const LossValues v = loss.run(s.image, s.target(), {0.8f, 0.2f, 1, 0}, Vec3f(0.3f), g);
    EXPECT_NEAR(v.total, 0, 1e-5);
}

}  // namespace
}  // namespace dpl::test
