// SPDX-License-Identifier: Apache-2.0
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "reconstruction/training/trainer/ssim.cpp"
#include "hwy/foreach_target.h"
#include "hwy/highway.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "reconstruction/training/trainer/ssim.h"

#ifndef DPL_SSIM_ONCE
#define DPL_SSIM_ONCE
namespace dpl {

constexpr int kRadius = 5, kTaps = 2 * kRadius + 1;
constexpr size_t kPad = 16;  // zeros on both sides of a row, for the window and the last partial vector
constexpr float kC1 = 0.01f * 0.01f, kC2 = 0.03f * 0.03f;

/** Taps exp(−k²/2σ²), normalised to the sum 1. */
struct GaussWindow {
    float tap[kTaps];
    GaussWindow() {
        double sum = 0, raw[kTaps];
        for (int k = 0; k < kTaps; ++k) sum += raw[k] = std::exp(-0.5 * (k - kRadius) * (k - kRadius) / (1.5 * 1.5));
        for (int k = 0; k < kTaps; ++k) tap[k] = float(raw[k] / sum);
    }
};

/** Size of an image row. Rows are `stride` floats apart, and code may write the floats between width and stride. */
struct SsimRow {
    size_t width, stride;
    const float* window;
};

/** Planes of kTaps rows each. Row j of the image lies in slot j mod kTaps. */
struct Ring {
    float* rows;
    size_t stride;
    float* row(uint32_t plane, int j) const { return rows + (plane * kTaps + size_t(j % kTaps)) * stride; }
};

/** The vertical window around one row: offset into a plane of the ring, and weight, of each row of the window that is inside the image. */
struct ColumnWindow {
    int count = 0;
    size_t offset[kTaps];
    float weight[kTaps];

    ColumnWindow(const Ring& ring, const float* taps, int row, int height) {
        for (int j = std::max(0, row - kRadius); j <= std::min(height - 1, row + kRadius); ++j) {
            offset[count] = size_t(j % kTaps) * ring.stride;
            weight[count++] = taps[j - row + kRadius];
        }
    }
};

}  // namespace dpl
#endif

HWY_BEFORE_NAMESPACE();
namespace dpl {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;
using D = hn::CappedTag<float, 16>;
using V = hn::Vec<D>;

/** out[x] = Σ_k w_k in[x + k − 5]. `in` has kPad zeros on both sides. Four vectors at a time, because additions to one sum depend on each
 *  other. */
HWY_INLINE void blurRow(const SsimRow& r, const float* HWY_RESTRICT in, float* HWY_RESTRICT out) {
    const D d;
    const size_t lanes = hn::Lanes(d);
    size_t x = 0;
    for (; x + 3 * lanes < r.width; x += 4 * lanes) {
        V s0 = hn::Zero(d), s1 = s0, s2 = s0, s3 = s0;
        for (size_t k = 0; k < size_t(kTaps); ++k) {
            const V w = hn::Set(d, r.window[k]);
            const float* at = in + x + k - kRadius;
            s0 = hn::MulAdd(w, hn::LoadU(d, at), s0), s1 = hn::MulAdd(w, hn::LoadU(d, at + lanes), s1);
            s2 = hn::MulAdd(w, hn::LoadU(d, at + 2 * lanes), s2), s3 = hn::MulAdd(w, hn::LoadU(d, at + 3 * lanes), s3);
        }
        hn::StoreU(s0, d, out + x), hn::StoreU(s1, d, out + x + lanes), hn::StoreU(s2, d, out + x + 2 * lanes),
            hn::StoreU(s3, d, out + x + 3 * lanes);
    }
    for (; x < r.width; x += lanes) {
        V sum = hn::Zero(d);
        for (size_t k = 0; k < size_t(kTaps); ++k) sum = hn::MulAdd(hn::Set(d, r.window[k]), hn::LoadU(d, in + x + k - kRadius), sum);
        hn::StoreU(sum, d, out + x);
    }
}

/** line[i] = a[i]·b[i]. */
HWY_INLINE void multiplyRow(size_t width, const float* a, const float* b, float* HWY_RESTRICT line) {
    const D d;
    const size_t lanes = hn::Lanes(d), whole = width / lanes * lanes;
    for (size_t i = 0; i < whole; i += lanes) hn::StoreU(hn::Mul(hn::LoadU(d, a + i), hn::LoadU(d, b + i)), d, line + i);
    for (size_t i = whole; i < width; ++i) line[i] = a[i] * b[i];
}

/** Blurs x, y, x², y² and xy of row `at` horizontally, each into a plane of `out`. */
void blurProducts(const SsimRow& r, const float* x, const float* y, float* scratch, const Ring& out, int at) {
    float* line = scratch + kPad;
    std::memcpy(line, x, r.width * sizeof(float)), blurRow(r, line, out.row(0, at));
    std::memcpy(line, y, r.width * sizeof(float)), blurRow(r, line, out.row(1, at));
    multiplyRow(r.width, x, x, line), blurRow(r, line, out.row(2, at));
    multiplyRow(r.width, y, y, line), blurRow(r, line, out.row(3, at));
    multiplyRow(r.width, x, y, line), blurRow(r, line, out.row(4, at));
}

/** The window's weighted sums at columns x … of `kPlanes` planes. Several planes at once give independent chains of additions. */
template <uint32_t kPlanes>
HWY_INLINE void blurColumns(const ColumnWindow& w, const Ring& ring, size_t x, V (&sum)[kPlanes]) {
    const D d;
    const float* first = ring.rows + x;
    const size_t planeStride = kTaps * ring.stride;
    for (V& s : sum) s = hn::Zero(d);
    for (int k = 0; k < w.count; ++k) {
        const V weight = hn::Set(d, w.weight[k]);
        const float* at = first + w.offset[k];
        sum[0] = hn::MulAdd(weight, hn::LoadU(d, at), sum[0]), sum[1] = hn::MulAdd(weight, hn::LoadU(d, at + planeStride), sum[1]);
        sum[2] = hn::MulAdd(weight, hn::LoadU(d, at + 2 * planeStride), sum[2]);
        if constexpr (kPlanes > 3)
            sum[3] = hn::MulAdd(weight, hn::LoadU(d, at + 3 * planeStride), sum[3]),
            sum[4] = hn::MulAdd(weight, hn::LoadU(d, at + 4 * planeStride), sum[4]);
    }
}

/** One row of the similarity map S, from the blurred products around it. Returns the row's sum of S and writes ∂S/∂(blurred x),
 *  ∂S/∂(blurred x²) and ∂S/∂(blurred xy). */
double similarityRow(const SsimRow& r, const Ring& products, const ColumnWindow& window, float* dMean, float* dSquare, float* dCross) {
    const D d;
    double total = 0;
    const V two = hn::Set(d, 2.0f), c1 = hn::Set(d, kC1), c2 = hn::Set(d, kC2);
    alignas(64) float lane[16];
    for (size_t x = 0; x < r.width; x += hn::Lanes(d)) {
        V blurred[5];
        blurColumns(window, products, x, blurred);
        const V mx = blurred[0], my = blurred[1], xx = blurred[2], yy = blurred[3], xy = blurred[4];
        const V mxmy = hn::Mul(mx, my), mx2 = hn::Mul(mx, mx), my2 = hn::Mul(my, my);
        const V n1 = hn::MulAdd(two, mxmy, c1), n2 = hn::MulAdd(two, hn::Sub(xy, mxmy), c2);
        const V d1 = hn::Add(hn::Add(mx2, my2), c1), d2 = hn::Add(hn::Sub(hn::Add(xx, yy), hn::Add(mx2, my2)), c2);
        const V inv = hn::Div(hn::Set(d, 1.0f), hn::Mul(d1, d2));
        const V s = hn::Mul(hn::Mul(n1, n2), inv);
        const V square = hn::Neg(hn::Div(s, d2)), cross = hn::Mul(two, hn::Mul(n1, inv));
        V mean = hn::Mul(two, hn::Sub(hn::Mul(my, hn::Mul(n2, inv)), hn::Mul(mx, hn::Div(s, d1))));
        mean = hn::Sub(mean, hn::MulAdd(hn::Mul(two, mx), square, hn::Mul(my, cross)));
        hn::StoreU(mean, d, dMean + x), hn::StoreU(square, d, dSquare + x), hn::StoreU(cross, d, dCross + x);
        hn::StoreU(s, d, lane);
        for (size_t i = 0; i < std::min<size_t>(hn::Lanes(d), r.width - x); ++i) total += lane[i];
    }
    return total;
}

/** Blurs three derivative rows horizontally into row `at` of `out`. They begin at scratch + kPad and lie `lineStride` floats apart. */
void blurMaps(const SsimRow& r, const float* scratch, size_t lineStride, const Ring& out, int at) {
    for (uint32_t k = 0; k < 3; ++k) blurRow(r, scratch + k * lineStride + kPad, out.row(k, at));
}

/** gradient[x] += scale · (blur(dMean) + 2x·blur(dSquare) + y·blur(dCross)) for one row. */
void gradientRow(const SsimRow& r, const Ring& maps, const ColumnWindow& window, const float* x, const float* y, float scale,
                 float* gradient) {
    const D d;
    alignas(64) float lane[16];
    for (size_t i = 0; i < r.width; i += hn::Lanes(d)) {
        const size_t count = std::min<size_t>(hn::Lanes(d), r.width - i);
        V blurred[3];  // mean, square, cross
        blurColumns(window, maps, i, blurred);
        alignas(64) float xs[16] = {}, ys[16] = {};
        std::memcpy(xs, x + i, count * sizeof(float));
        std::memcpy(ys, y + i, count * sizeof(float));
        const V xv = hn::Load(d, xs), yv = hn::Load(d, ys);
        hn::Store(hn::Mul(hn::Set(d, scale), hn::MulAdd(yv, blurred[2], hn::MulAdd(hn::Add(xv, xv), blurred[1], blurred[0]))), d, lane);
        for (size_t k = 0; k < count; ++k) gradient[i + k] += lane[k];
    }
}

}  // namespace HWY_NAMESPACE
}  // namespace dpl
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace dpl {
HWY_EXPORT(blurProducts);
HWY_EXPORT(similarityRow);
HWY_EXPORT(blurMaps);
HWY_EXPORT(gradientRow);

double Ssim::run(const PlanarImage& x, const PlanarImage& y, PlanarImage* gradient, float weight, size_t equalPixels) {
    static const GaussWindow window;
    const size_t width = x.widthPx, rows = size_t(x.heightPx) * x.channels, equal = equalPixels * x.channels;
    const int height = int(x.heightPx);
    if (rows == 0 || width == 0) return 1;
    const size_t stride = (width + 15) / 16 * 16, line = stride + 2 * kPad + 16;
    const SsimRow r{width, stride, window.tap};
    const double count = double(rows) * double(width) + double(equal);
    const float scale = float(double(weight) / count);
    rowSums_.resize(rows);
    // Rows are processed in bands. The number of bands depends on the picture alone, so the sums do not depend on threads.
    constexpr int kBandRows = 128, kHalo = 2 * kRadius;
    const size_t bands = size_t(std::max(2, height / kBandRows));
    const size_t ringFloats = (5 + 3) * kTaps * stride + 4 * line;
    rings_.assign(ringFloats * jobs_.threadCount(), 0.0f);
    jobs_.forBlocks(bands * x.channels, [&](size_t block, uint32_t worker) {
        const size_t channel = block / bands, band = block % bands, plane = channel * x.planeSize();
        const int begin = int(size_t(height) * band / bands), end = int(size_t(height) * (band + 1) / bands);
        const float* const xs = x.values.data() + plane;
        const float* const ys = y.values.data() + plane;
        const Ring products{rings_.data() + ringFloats * worker, stride}, maps{products.rows + 5 * kTaps * stride, stride};
        float* const scratch = maps.rows + 3 * kTaps * stride;  // four padded lines: one of products, three of derivatives
        float* const derivatives = scratch + line;
        for (int ahead = std::max(0, begin - kHalo); ahead < end + kHalo; ++ahead) {
            if (ahead < height)
                HWY_DYNAMIC_DISPATCH(blurProducts)(r, xs + size_t(ahead) * width, ys + size_t(ahead) * width, scratch, products, ahead);
            const int at = ahead - kRadius, done = ahead - kHalo;
            const int firstMap = gradient ? std::max(0, begin - kRadius) : begin,
                      lastMap = gradient ? std::min(height, end + kRadius) : end;
            if (at >= firstMap && at < lastMap) {
                float* const row = derivatives + kPad;
                const double sum = HWY_DYNAMIC_DISPATCH(similarityRow)(r, products, ColumnWindow(products, window.tap, at, height), row,
                                                                       row + line, row + 2 * line);
                if (at >= begin && at < end) rowSums_[channel * size_t(height) + size_t(at)] = sum;
                for (int k = 0; k < 3; ++k)
                    std::fill(row + size_t(k) * line + width, row + size_t(k) * line + stride, 0.0f);  // beyond the picture
                if (gradient) HWY_DYNAMIC_DISPATCH(blurMaps)(r, derivatives, line, maps, at);
            }
            if (gradient && done >= begin && done < end) HWY_DYNAMIC_DISPATCH(gradientRow)
            (r, maps, ColumnWindow(maps, window.tap, done, height), xs + size_t(done) * width, ys + size_t(done) * width, scale,
             gradient->values.data() + plane + size_t(done) * width);
        }
    });
    double sum = double(equal);
    for (double s : rowSums_) sum += s;
    return sum / count;
}

}  // namespace dpl
#endif
