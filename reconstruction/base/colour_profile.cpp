// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/base/colour_profile.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <vector>

namespace dpl {
namespace {

using Bytes = std::span<const uint8_t>;
using Curve = std::array<double, 256>;
using Columns = std::array<std::array<double, 3>, 3>;

constexpr int kSameLevels = 2;  // profiles of sRGB differ by rounding and by short tables of its curve
constexpr size_t kHeaderBytes = 128, kMaxNameBytes = 60;
constexpr uint32_t kMaxTags = 200, kMaxTableSize = 65536;
// IEC 61966-2-1, adapted to D50 by Bradford's matrix, as in the profiles of the ICC and of HP. Display P3 as Apple writes it.
constexpr Columns kSrgbXyz = {{{0.43607, 0.22249, 0.01392}, {0.38515, 0.71687, 0.09708}, {0.14307, 0.06061, 0.71410}}};
constexpr Columns kDisplayP3Xyz = {{{0.51512, 0.24120, -0.00105}, {0.29198, 0.69225, 0.04189}, {0.15710, 0.06657, 0.78407}}};

uint32_t u16(Bytes b, size_t at) {
    return uint32_t(b[at]) << 8 | b[at + 1];
}
uint32_t u32(Bytes b, size_t at) {
    return u16(b, at) << 16 | u16(b, at + 2);
}
double fixed(Bytes b, size_t at) {
    return double(int32_t(u32(b, at))) / 65536;
}
bool says(Bytes b, size_t at, const char (&four)[5]) {
    return at + 4 <= b.size() && std::equal(four, four + 4, b.begin() + std::ptrdiff_t(at));
}

double srgbLight(double v) {
    return v <= 0.04045 ? v / 12.92 : std::pow((v + 0.055) / 1.055, 2.4);
}
double srgbValue(double light) {
    return light <= 0.0031308 ? 12.92 * light : 1.055 * std::pow(light, 1 / 2.4) - 0.055;
}

/** 8-bit sRGB of linear light in steps of 1/65535, which is a twentieth of a level in the darkest part. */
const std::vector<uint8_t>& srgbLevels() {
    static const std::vector<uint8_t> levels = [] {
        std::vector<uint8_t> table(65536);
        for (size_t i = 0; i < table.size(); ++i) table[i] = uint8_t(std::lround(255 * srgbValue(double(i) / 65535)));
        return table;
    }();
    return levels;
}

/** Rows of the inverse of a matrix of columns. */
Columns inverseRows(const Columns& c) {
    const auto cross = [](const std::array<double, 3>& a, const std::array<double, 3>& b) {
        return std::array<double, 3>{a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
    };
    Columns rows = {cross(c[1], c[2]), cross(c[2], c[0]), cross(c[0], c[1])};
    const double determinant = c[0][0] * rows[0][0] + c[0][1] * rows[0][1] + c[0][2] * rows[0][2];
    for (auto& row : rows)
        for (double& v : row) v /= determinant;
    return rows;
}

/** Data of a tag, with its type signature; empty when there is none. */
Bytes tagOf(Bytes icc, const char (&name)[5]) {
    const uint32_t count = std::min(u32(icc, kHeaderBytes), kMaxTags);
    for (uint32_t i = 0; i < count; ++i) {
        const size_t entry = kHeaderBytes + 4 + 12 * size_t(i);
        if (entry + 12 > icc.size()) return {};
        if (!says(icc, entry, name)) continue;
        const size_t offset = u32(icc, entry + 4), bytes = u32(icc, entry + 8);
        if (offset > icc.size() || bytes > icc.size() - offset) return {};
        return icc.subspan(offset, bytes);
    }
    return {};
}

/** "curv": a gamma or a table. */
std::optional<Curve> sampledCurve(Bytes tag) {
    if (tag.size() < 12) return std::nullopt;
    const size_t count = u32(tag, 8);
    Curve curve{};
    if (count > kMaxTableSize || tag.size() < 12 + 2 * count) return std::nullopt;
    for (size_t i = 0; i < curve.size(); ++i) {
        const double x = double(i) / 255;
        if (count == 0) {
            curve[i] = x;
        } else if (count == 1) {
            curve[i] = std::pow(x, u16(tag, 12) / 256.0);
        } else {
            const double place = x * double(count - 1);
            const size_t below = std::min(size_t(place), count - 2);
            const double a = u16(tag, 12 + 2 * below), b = u16(tag, 12 + 2 * (below + 1));
            curve[i] = (a + (place - double(below)) * (b - a)) / 65535;
        }
    }
    return curve;
}

/** "para": the five functions of ICC.1:2022, table 68. */
std::optional<Curve> parametricCurve(Bytes tag) {
    constexpr size_t kCounts[] = {1, 3, 4, 5, 7};
    if (tag.size() < 12 || u16(tag, 8) > 4) return std::nullopt;
    const uint32_t kind = u16(tag, 8);
    if (tag.size() < 12 + 4 * kCounts[kind]) return std::nullopt;
    std::array<double, 7> p{1, 1, 0, 0, 0, 0, 0};  // g a b c d e f
    for (size_t i = 0; i < kCounts[kind]; ++i) p[i] = fixed(tag, 12 + 4 * i);
    const auto [g, a, b, c, d, e, f] = p;
    if (kind >= 1 && kind <= 2 && a == 0) return std::nullopt;
    Curve curve{};
    for (size_t i = 0; i < curve.size(); ++i) {
        const double x = double(i) / 255, power = std::pow(std::max(0.0, a * x + b), g);
        if (kind == 0) curve[i] = std::pow(x, g);
        if (kind == 1) curve[i] = x >= -b / a ? power : 0;
        if (kind == 2) curve[i] = (x >= -b / a ? power : 0) + c;  // for this kind c is the offset of both parts
        if (kind == 3) curve[i] = x >= d ? power : c * x;
        if (kind == 4) curve[i] = x >= d ? power + e : c * x + f;
    }
    return curve;
}

std::optional<Curve> curveOf(Bytes tag) {
    auto curve = says(tag, 0, "curv") ? sampledCurve(tag) : says(tag, 0, "para") ? parametricCurve(tag) : std::nullopt;
    if (curve && !std::all_of(curve->begin(), curve->end(), [](double v) { return std::isfinite(v) && std::abs(v) < 4; }))
        return std::nullopt;
    return curve;
}

std::optional<std::array<double, 3>> xyzOf(Bytes tag) {
    if (!says(tag, 0, "XYZ ") || tag.size() < 20) return std::nullopt;
    return std::array<double, 3>{fixed(tag, 8), fixed(tag, 12), fixed(tag, 16)};
}

/** The profile's description in ASCII; other characters become '?'. */
std::string nameOf(Bytes icc) {
    const Bytes tag = tagOf(icc, "desc");
    std::string name;
    const auto add = [&](uint32_t c) { name.push_back(c >= 0x20 && c < 0x7f ? char(c) : '?'); };
    if (says(tag, 0, "desc") && tag.size() >= 12) {
        const size_t count = std::min<size_t>({u32(tag, 8), tag.size() - 12, kMaxNameBytes});
        for (size_t i = 0; i < count && tag[12 + i] != 0; ++i) add(tag[12 + i]);
    } else if (says(tag, 0, "mluc") && tag.size() >= 28) {
        const size_t bytes = u32(tag, 20), offset = u32(tag, 24);
        if (offset <= tag.size())
            for (size_t i = 0; i + 1 < std::min<size_t>({bytes, tag.size() - offset, 2 * kMaxNameBytes}); i += 2) add(u16(tag, offset + i));
    }
    return name.empty() ? "an unnamed colour profile" : name;
}

}  // namespace

ToSrgb::ToSrgb(const std::array<Curve, 3>& linear, const Columns& xyz) {
    static const Columns linearFromXyz = inverseRows(kSrgbXyz);
    for (size_t c = 0; c < 3; ++c)
        for (size_t i = 0; i < 256; ++i) linear_[c][i] = float(linear[c][i]);
    for (size_t row = 0; row < 3; ++row)
        for (size_t c = 0; c < 3; ++c) {
            double sum = 0;
            for (size_t k = 0; k < 3; ++k) sum += linearFromXyz[row][k] * xyz[c][k];
            srgbFromLinear_[row][c] = float(sum);
        }
}

std::array<uint8_t, 3> ToSrgb::map(const uint8_t* rgb) const {
    static const std::vector<uint8_t>& levels = srgbLevels();
    const float r = linear_[0][rgb[0]], g = linear_[1][rgb[1]], b = linear_[2][rgb[2]];
    std::array<uint8_t, 3> out{};
    for (size_t row = 0; row < 3; ++row) {
        const auto& m = srgbFromLinear_[row];
        out[row] = levels[size_t(std::clamp(m[0] * r + m[1] * g + m[2] * b, 0.f, 1.f) * 65535 + 0.5f)];
    }
    return out;
}

bool ToSrgb::isSrgb() const {
    constexpr int kStep = 17;  // 0, 17 … 255
    for (int r = 0; r < 256; r += kStep)
        for (int g = 0; g < 256; g += kStep)
            for (int b = 0; b < 256; b += kStep) {
                const uint8_t rgb[3] = {uint8_t(r), uint8_t(g), uint8_t(b)};
                const auto mapped = map(rgb);
                for (size_t c = 0; c < 3; ++c)
                    if (std::abs(int(mapped[c]) - int(rgb[c])) > kSameLevels) return false;
            }
    return true;
}

void ToSrgb::apply(std::span<uint8_t> pixels, uint32_t channels) const {
    for (size_t at = 0; at + channels <= pixels.size(); at += channels) {
        const auto mapped = map(&pixels[at]);
        std::copy(mapped.begin(), mapped.end(), &pixels[at]);
    }
}

Result<ColourSpace> readColourProfile(Bytes icc) {
    if (icc.size() < kHeaderBytes + 4 || !says(icc, 36, "acsp")) return fail(Code::CorruptData, "its colour profile is damaged");
    ColourSpace space{nameOf(icc), std::nullopt};
    std::optional<std::array<double, 3>> xyz[3];
    std::optional<Curve> curves[3];
    if (says(icc, 16, "GRAY")) {
        for (size_t c = 0; c < 3; ++c) curves[c] = curveOf(tagOf(icc, "kTRC")), xyz[c] = kSrgbXyz[c];
    } else if (says(icc, 16, "RGB ")) {
        xyz[0] = xyzOf(tagOf(icc, "rXYZ")), xyz[1] = xyzOf(tagOf(icc, "gXYZ")), xyz[2] = xyzOf(tagOf(icc, "bXYZ"));
        curves[0] = curveOf(tagOf(icc, "rTRC")), curves[1] = curveOf(tagOf(icc, "gTRC")), curves[2] = curveOf(tagOf(icc, "bTRC"));
    }
    space.known = xyz[0] && xyz[1] && xyz[2] && curves[0] && curves[1] && curves[2];
    if (!space.known) return space;
    const ToSrgb toSrgb({*curves[0], *curves[1], *curves[2]}, {*xyz[0], *xyz[1], *xyz[2]});
    if (!toSrgb.isSrgb()) space.toSrgb = toSrgb;
    return space;
}

ColourSpace displayP3() {
    Curve curve{};
    for (size_t i = 0; i < curve.size(); ++i) curve[i] = srgbLight(double(i) / 255);
    return {"Display P3", ToSrgb({curve, curve, curve}, kDisplayP3Xyz)};
}

}  // namespace dpl
