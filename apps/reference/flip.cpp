// SPDX-License-Identifier: Apache-2.0
#include "apps/reference/flip.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <numbers>

namespace dpl {
namespace {

using Colour = std::array<double, 3>;
using Plane = std::vector<double>;

struct Size {
    int width, height;
    size_t count() const { return size_t(width) * size_t(height); }
};

// ---- colour spaces ----

double toLinear(double s) {
    return s <= 0.04045 ? s / 12.92 : std::pow((s + 0.055) / 1.055, 2.4);
}

Colour toXyz(const Colour& c) {
    return {(10135552.0 * c[0] + 8788810.0 * c[1] + 4435075.0 * c[2]) / 24577794.0,
            (2613072.0 * c[0] + 8788810.0 * c[1] + 887015.0 * c[2]) / 12288897.0,
            (1425312.0 * c[0] + 8788810.0 * c[1] + 70074185.0 * c[2]) / 73733382.0};
}

Colour toRgb(const Colour& c) {
    return {3.241003275 * c[0] - 1.537398934 * c[1] - 0.498615861 * c[2], -0.969224334 * c[0] + 1.875930071 * c[1] + 0.041554224 * c[2],
            0.055639423 * c[0] - 0.204011202 * c[1] + 1.057148933 * c[2]};
}

const Colour& white() {
    static const Colour w = toXyz({1, 1, 1});
    return w;
}

/** The linear opponent space in which contrast sensitivity is filtered: achromatic, red-green, blue-yellow. */
Colour toOpponent(const Colour& linear) {
    const Colour xyz = toXyz(linear), w = white();
    const double x = xyz[0] / w[0], y = xyz[1] / w[1], z = xyz[2] / w[2];
    return {116 * y - 16, 500 * (x - y), 200 * (y - z)};
}

Colour fromOpponent(const Colour& c) {
    const Colour w = white();
    const double y = (c[0] + 16) / 116, x = y + c[1] / 500, z = y - c[2] / 200;
    return toRgb({x * w[0], y * w[1], z * w[2]});
}

/** CIELAB with the Hunt effect: chroma counts less in dark colours. */
Colour toHuntLab(const Colour& linear) {
    const Colour xyz = toXyz(linear), w = white();
    const auto f = [](double t) {
        constexpr double kDelta = 6.0 / 29;
        return t > kDelta * kDelta * kDelta ? std::cbrt(t) : t / (3 * kDelta * kDelta) + 4.0 / 29;
    };
    const double x = f(xyz[0] / w[0]), y = f(xyz[1] / w[1]), z = f(xyz[2] / w[2]);
    const double lightness = 116 * y - 16;
    return {lightness, 0.01 * lightness * 500 * (x - y), 0.01 * lightness * 200 * (y - z)};
}

double hyAb(const Colour& a, const Colour& b) {
    return std::abs(a[0] - b[0]) + std::hypot(a[1] - b[1], a[2] - b[2]);
}

// ---- filters ----

struct Taps {
    int radius;
    std::vector<double> weight;  // 2·radius + 1

    Taps(int r, const std::function<double(double)>& f) : radius(r) {
        for (int k = -r; k <= r; ++k) weight.push_back(f(double(k)));
    }
    double sum() const {
        double total = 0;
        for (double w : weight) total += w;
        return total;
    }
    void scale(double by) {
        for (double& w : weight) w *= by;
    }
    /** Positive weights sum to 1 and negative ones to −1. */
    void balance() {
        double up = 0, down = 0;
        for (double w : weight) (w > 0 ? up : down) += w;
        for (double& w : weight) w /= w > 0 ? up : -down;
    }
};

/** Filters rows by `across`, then columns by `down`. Beyond the border, its pixels repeat. */
Plane filtered(const Plane& in, Size size, const Taps& across, const Taps& down) {
    Plane rows(size.count()), out(size.count());
    for (int y = 0; y < size.height; ++y)
        for (int x = 0; x < size.width; ++x) {
            double sum = 0;
            for (int k = -across.radius; k <= across.radius; ++k)
                sum += across.weight[size_t(k + across.radius)] * in[size_t(y * size.width + std::clamp(x + k, 0, size.width - 1))];
            rows[size_t(y * size.width + x)] = sum;
        }
    for (int y = 0; y < size.height; ++y)
        for (int x = 0; x < size.width; ++x) {
            double sum = 0;
            for (int k = -down.radius; k <= down.radius; ++k)
                sum += down.weight[size_t(k + down.radius)] * rows[size_t(std::clamp(y + k, 0, size.height - 1) * size.width + x)];
            out[size_t(y * size.width + x)] = sum;
        }
    return out;
}

/** A term a·√(π/b)·exp(−π²x²/b) of a contrast sensitivity function, x in degrees. */
struct Sensitivity {
    double a, b;
};

/** The plane filtered by the sum of one or two Gaussians whose weights sum to 1. */
Plane seenThrough(const Plane& in, Size size, std::span<const Sensitivity> terms, double pixelsPerDegree) {
    constexpr double kWidest = 0.04;  // largest b of all terms; all filters use the radius that it needs
    const int radius = int(std::ceil(3 * std::sqrt(kWidest / (2 * std::numbers::pi * std::numbers::pi)) * pixelsPerDegree));
    Plane out(size.count(), 0.0);
    double total = 0;
    for (const Sensitivity& term : terms) {
        Taps taps(radius, [&](double k) {
            return std::exp(-std::numbers::pi * std::numbers::pi * (k / pixelsPerDegree) * (k / pixelsPerDegree) / term.b);
        });
        const double share = term.a * std::sqrt(std::numbers::pi / term.b) * taps.sum() * taps.sum();
        taps.scale(1 / taps.sum());
        const Plane part = filtered(in, size, taps, taps);
        for (size_t i = 0; i < out.size(); ++i) out[i] += share * part[i];
        total += share;
    }
    for (double& v : out) v /= total;
    return out;
}

/** Of an achromatic plane in [0,1]: magnitudes of the gradient (edges) and of the second derivative (points). */
struct Features {
    Plane edges, points;

    Features(const Plane& luma, Size size, double pixelsPerDegree) {
        constexpr double kWidthDegrees = 0.082;
        const double sigma = 0.5 * kWidthDegrees * pixelsPerDegree;
        const int radius = int(std::ceil(3 * sigma));
        const auto gauss = [&](double k) { return std::exp(-k * k / (2 * sigma * sigma)); };
        Taps smooth(radius, gauss), slope(radius, [&](double k) { return -k * gauss(k); }),
            bend(radius, [&](double k) { return (k * k / (sigma * sigma) - 1) * gauss(k); });
        smooth.scale(1 / smooth.sum());
        slope.balance(), bend.balance();
        edges = lengths(filtered(luma, size, slope, smooth), filtered(luma, size, smooth, slope));
        points = lengths(filtered(luma, size, bend, smooth), filtered(luma, size, smooth, bend));
    }

private:
    static Plane lengths(const Plane& x, const Plane& y) {
        Plane out(x.size());
        for (size_t i = 0; i < x.size(); ++i) out[i] = std::hypot(x[i], y[i]);
        return out;
    }
};

/** A picture after FLIP's filters. */
struct Seen {
    std::vector<Colour> lab;
    Features features;
};

Seen see(std::span<const double> rgb, Size size, double pixelsPerDegree) {
    constexpr Sensitivity kAchromatic[] = {{1, 0.0047}}, kRedGreen[] = {{1, 0.0053}}, kBlueYellow[] = {{34.1, 0.04}, {13.5, 0.025}};
    Plane planes[3];
    for (Plane& p : planes) p.resize(size.count());
    Plane luma(size.count());
    for (size_t i = 0; i < size.count(); ++i) {
        Colour linear;
        for (size_t c = 0; c < 3; ++c) linear[c] = toLinear(std::clamp(rgb[i * 3 + c], 0.0, 1.0));
        const Colour opponent = toOpponent(linear);
        for (size_t c = 0; c < 3; ++c) planes[c][i] = opponent[c];
        luma[i] = (opponent[0] + 16) / 116;
    }
    planes[0] = seenThrough(planes[0], size, kAchromatic, pixelsPerDegree);
    planes[1] = seenThrough(planes[1], size, kRedGreen, pixelsPerDegree);
    planes[2] = seenThrough(planes[2], size, kBlueYellow, pixelsPerDegree);
    Seen seen{std::vector<Colour>(size.count()), Features(luma, size, pixelsPerDegree)};
    for (size_t i = 0; i < size.count(); ++i) {
        Colour linear = fromOpponent({planes[0][i], planes[1][i], planes[2][i]});
        for (double& v : linear) v = std::clamp(v, 0.0, 1.0);
        seen.lab[i] = toHuntLab(linear);
    }
    return seen;
}

/** Maps a colour distance to [0,1]. The lower 40 % of possible errors take 95 % of the range. */
double spread(double distance) {
    constexpr double kPower = 0.7, kShare = 0.4, kTarget = 0.95;
    static const double largest = std::pow(hyAb(toHuntLab({0, 1, 0}), toHuntLab({0, 0, 1})), kPower);
    const double error = std::pow(distance, kPower), knee = kShare * largest;
    return error < knee ? error * kTarget / knee : kTarget + (error - knee) / (largest - knee) * (1 - kTarget);
}

}  // namespace

std::vector<double> flipMap(std::span<const double> reference, std::span<const double> test, uint32_t widthPx, uint32_t heightPx,
                            double pixelsPerDegree) {
    const Size size{int(widthPx), int(heightPx)};
    if (size.count() == 0 || reference.size() != size.count() * 3 || test.size() != reference.size()) return {};
    const Seen want = see(reference, size, pixelsPerDegree), have = see(test, size, pixelsPerDegree);
    std::vector<double> out(size.count());
    for (size_t i = 0; i < out.size(); ++i) {
        const double colour = std::min(1.0, spread(hyAb(want.lab[i], have.lab[i])));
        const double edge = std::abs(want.features.edges[i] - have.features.edges[i]),
                     point = std::abs(want.features.points[i] - have.features.points[i]);
        const double feature = std::min(1.0, std::sqrt(std::max(edge, point) / std::numbers::sqrt2));
        out[i] = std::pow(colour, 1 - feature);
    }
    return out;
}

}  // namespace dpl
