#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "reconstruction/splat/ssim.cpp"
#include "hwy/foreach_target.h"
#include "hwy/highway.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "reconstruction/splat/ssim.h"

#ifndef DPL_SSIM_ONCE
#define DPL_SSIM_ONCE
namespace dpl {

constexpr int kRadius = 5, kTaps = 2 * kRadius + 1;
constexpr size_t kPad = 16;  // zeros on both sides of a row: covers the window and the last partial vector
constexpr float kC1 = 0.01f * 0.01f, kC2 = 0.03f * 0.03f;

/** exp(−k²/2σ²) normalised to one. */
struct GaussWindow {
    float tap[kTaps];
    GaussWindow() {
        double sum = 0, raw[kTaps];
        for (int k = 0; k < kTaps; ++k) sum += raw[k] = std::exp(-0.5 * (k - kRadius) * (k - kRadius) / (1.5 * 1.5));
        for (int k = 0; k < kTaps; ++k) tap[k] = float(raw[k] / sum);
    }
};

/** Rows are `stride` floats apart and may be written up to the stride. */
struct SsimRow {
    size_t width, stride;
    int height;
    const float* window;
};

}  // namespace dpl
#endif

HWY_BEFORE_NAMESPACE();
namespace dpl {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;
using D = hn::CappedTag<float, 16>;
using V = hn::Vec<D>;

/** out[x] = Σ_k w_k in[x + k − 5]; `in` has kPad zeros on both sides. */
HWY_INLINE void blurRow(const SsimRow& r, const float* in, float* out) {
    const D d;
    for (size_t x = 0; x < r.width; x += hn::Lanes(d)) {
        V sum = hn::Mul(hn::Set(d, r.window[0]), hn::LoadU(d, in + x - kRadius));
        for (int k = 1; k < kTaps; ++k) sum = hn::MulAdd(hn::Set(d, r.window[k]), hn::LoadU(d, in + x + size_t(k) - kRadius), sum);
        hn::StoreU(sum, d, out + x);
    }
}

/** Five products of one row, blurred horizontally: x, y, x², y², xy -> out[0..5), planes `planeStride` apart. */
void blurProducts(const SsimRow& r, const float* x, const float* y, float* scratch, float* out, size_t planeStride) {
    float* line = scratch + kPad;
    for (int product = 0; product < 5; ++product) {
        for (size_t i = 0; i < r.width; ++i)
            line[i] = product == 0 ? x[i] : product == 1 ? y[i] : product == 2 ? x[i] * x[i] : product == 3 ? y[i] * y[i] : x[i] * y[i];
        blurRow(r, line, out + size_t(product) * planeStride);
    }
}

HWY_INLINE V blurColumn(const SsimRow& r, const float* plane, int y, size_t x) {
    const D d;
    V sum = hn::Zero(d);
    const int first = std::max(0, y - kRadius), last = std::min(r.height - 1, y + kRadius);
    for (int j = first; j <= last; ++j)
        sum = hn::MulAdd(hn::Set(d, r.window[j - y + kRadius]), hn::LoadU(d, plane + size_t(j) * r.stride + x), sum);
    return sum;
}

/** Row y of the similarity map: returns its sum; writes ∂S/∂(blurred x), ∂S/∂(blurred x²), ∂S/∂(blurred xy) of the row. */
double similarityRow(const SsimRow& r, const float* planes, size_t planeStride, int y, float* dMean, float* dSquare, float* dCross) {
    const D d;
    double total = 0;
    const V two = hn::Set(d, 2.0f), c1 = hn::Set(d, kC1), c2 = hn::Set(d, kC2);
    alignas(64) float lane[16];
    for (size_t x = 0; x < r.width; x += hn::Lanes(d)) {
        const V mx = blurColumn(r, planes, y, x), my = blurColumn(r, planes + planeStride, y, x);
        const V xx = blurColumn(r, planes + 2 * planeStride, y, x), yy = blurColumn(r, planes + 3 * planeStride, y, x);
        const V xy = blurColumn(r, planes + 4 * planeStride, y, x);
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

/** Three derivative rows blurred horizontally. */
void blurMaps(const SsimRow& r, const float* const maps[3], float* scratch, float* out, size_t planeStride) {
    float* line = scratch + kPad;
    for (int k = 0; k < 3; ++k) {
        std::memcpy(line, maps[k], r.width * sizeof(float));
        blurRow(r, line, out + size_t(k) * planeStride);
    }
}

/** gradient[x] += scale · (blur(dMean) + 2x·blur(dSquare) + y·blur(dCross)) for one row. */
void gradientRow(const SsimRow& r, const float* planes, size_t planeStride, int row, const float* x, const float* y, float scale, float* gradient) {
    const D d;
    alignas(64) float lane[16];
    for (size_t i = 0; i < r.width; i += hn::Lanes(d)) {
        const size_t count = std::min<size_t>(hn::Lanes(d), r.width - i);
        const V mean = blurColumn(r, planes, row, i), square = blurColumn(r, planes + planeStride, row, i), cross = blurColumn(r, planes + 2 * planeStride, row, i);
        alignas(64) float xs[16] = {}, ys[16] = {};
        std::memcpy(xs, x + i, count * sizeof(float));
        std::memcpy(ys, y + i, count * sizeof(float));
        const V xv = hn::Load(d, xs), yv = hn::Load(d, ys);
        hn::Store(hn::Mul(hn::Set(d, scale), hn::MulAdd(yv, cross, hn::MulAdd(hn::Add(xv, xv), square, mean))), d, lane);
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

double Ssim::run(const PlanarImage& x, const PlanarImage& y, PlanarImage* gradient, float weight) {
    static const GaussWindow window;
    const size_t width = x.widthPx, height = x.heightPx, rows = height * x.channels;
    if (rows == 0 || width == 0) return 1;
    const size_t stride = (width + 15) / 16 * 16, plane = stride * height;
    const SsimRow r{width, stride, int(height), window.tap};
    horizontal_.resize(plane * 5 * x.channels);
    maps_.resize(plane * 3 * x.channels);
    rowSums_.resize(rows);
    constexpr size_t kGrain = 8;
    const auto forRows = [&](auto&& body) {
        jobs_.forRange(rows, kGrain, [&](size_t begin, size_t end, uint32_t) {
            std::vector<float> scratch(stride + 2 * kPad + 16, 0.0f);
            for (size_t row = begin; row < end; ++row) body(row / height, row % height, row, scratch.data());
        });
    };
    forRows([&](size_t c, size_t at, size_t row, float* scratch) {
        HWY_DYNAMIC_DISPATCH(blurProducts)
        (r, x.values.data() + row * width, y.values.data() + row * width, scratch, horizontal_.data() + c * 5 * plane + at * stride, plane);
    });
    forRows([&](size_t c, size_t at, size_t row, float*) {
        float* maps = maps_.data() + c * 3 * plane + at * stride;
        rowSums_[row] = HWY_DYNAMIC_DISPATCH(similarityRow)(r, horizontal_.data() + c * 5 * plane, plane, int(at), maps, maps + plane, maps + 2 * plane);
    });
    double sum = 0;
    for (double s : rowSums_) sum += s;
    const double count = double(rows) * double(width);
    if (gradient) {
        mapsHorizontal_.resize(plane * 3 * x.channels);
        forRows([&](size_t c, size_t at, size_t, float* scratch) {
            const float* maps = maps_.data() + c * 3 * plane + at * stride;
            const float* three[3] = {maps, maps + plane, maps + 2 * plane};
            HWY_DYNAMIC_DISPATCH(blurMaps)(r, three, scratch, mapsHorizontal_.data() + c * 3 * plane + at * stride, plane);
        });
        const float scale = float(double(weight) / count);
        forRows([&](size_t c, size_t at, size_t row, float*) {
            HWY_DYNAMIC_DISPATCH(gradientRow)
            (r, mapsHorizontal_.data() + c * 3 * plane, plane, int(at), x.values.data() + row * width, y.values.data() + row * width, scale,
             gradient->values.data() + row * width);
        });
    }
    return sum / count;
}

}  // namespace dpl
#endif
