// SPDX-License-Identifier: Apache-2.0
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "reconstruction/training/trainer/adam.cpp"
#include "hwy/foreach_target.h"
#include "hwy/highway.h"

#include <algorithm>
#include <cmath>

#include "reconstruction/training/trainer/adam.h"

HWY_BEFORE_NAMESPACE();
namespace dpl {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

/** Updates the active rows of [begin, end). */
void adamRows(const AdamRange& r) {
    const hn::CappedTag<float, 8> d;
    const auto b1 = hn::Set(d, kAdamBeta1), b2 = hn::Set(d, kAdamBeta2), r1 = hn::Set(d, 1 - kAdamBeta1), r2 = hn::Set(d, 1 - kAdamBeta2);
    // Losses are means over a picture, so gradients are around 1e-7. ε must be far smaller.
    const auto epsilon = hn::Set(d, 1e-15f);
    for (size_t i = r.begin; i < r.end; ++i) {
        if (!r.active[i]) continue;
        const uint32_t step = std::min(++r.steps[i], kLastCorrection);
        const auto c1 = hn::Set(d, r.correction1[step]), c2 = hn::Set(d, r.correction2[step]);
        for (size_t at = i * r.stride; at < (i + 1) * r.stride; at += hn::Lanes(d)) {
            const auto g = hn::LoadU(d, r.gradients + at);
            const auto m = hn::MulAdd(b1, hn::LoadU(d, r.first + at), hn::Mul(r1, g));
            const auto v = hn::MulAdd(b2, hn::LoadU(d, r.second + at), hn::Mul(r2, hn::Mul(g, g)));
            hn::StoreU(m, d, r.first + at);
            hn::StoreU(v, d, r.second + at);
            const auto change = hn::Div(hn::Mul(m, c1), hn::Add(hn::Sqrt(hn::Mul(v, c2)), epsilon));
            hn::StoreU(hn::NegMulAdd(hn::LoadU(d, r.rate + at - i * r.stride), change, hn::LoadU(d, r.values + at)), d, r.values + at);
        }
    }
}

}  // namespace HWY_NAMESPACE
}  // namespace dpl
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace dpl {
HWY_EXPORT(adamRows);

namespace {

float correction(float beta, uint32_t steps) {
    return steps >= kLastCorrection ? 1.0f : float(1 / (1 - std::pow(double(beta), double(steps))));
}

/** By the number of steps. */
std::vector<float> corrections(float beta) {
    std::vector<float> table(kLastCorrection + 1, 1.0f);
    for (uint32_t n = 1; n <= kLastCorrection; ++n) table[n] = correction(beta, n);
    return table;
}

}  // namespace

void AdamRows::resize(size_t count, uint32_t rowStride) {
    stride = rowStride;
    first.assign(count * stride, 0.0f);
    second.assign(count * stride, 0.0f);
    steps.assign(count, 0);
}

void AdamRows::update(size_t begin, size_t end, std::span<const uint8_t> active, std::span<const float> gradients,
                      std::span<const float> rate, std::span<float> values) {
    static const std::vector<float> correction1 = corrections(kAdamBeta1), correction2 = corrections(kAdamBeta2);
    HWY_DYNAMIC_DISPATCH(adamRows)
    ({begin, end, stride, active.data(), gradients.data(), rate.data(), correction1.data(), correction2.data(), steps.data(), first.data(),
      second.data(), values.data()});
}

void AdamUniform::update(std::span<const Vec3f> gradient, float rate, std::span<Vec3f> value) {
    first.resize(gradient.size(), Vec3f(0)), second.resize(gradient.size(), Vec3f(0));
    ++steps;
    const float c1 = correction(beta1, steps), c2 = correction(beta2, steps);
    float largest = 0;
    for (size_t i = 0; i < gradient.size(); ++i) {
        first[i] = beta1 * first[i] + (1 - beta1) * gradient[i];
        second[i] = beta2 * second[i] + (1 - beta2) * gradient[i] * gradient[i];
        largest = std::max(largest, std::max(second[i].x, std::max(second[i].y, second[i].z)));
    }
    const float scale = rate * c1 / (1e-20f + std::sqrt(largest * c2));
    if (!(largest > 0) || !std::isfinite(scale)) return;
    for (size_t i = 0; i < gradient.size(); ++i) value[i] -= scale * first[i];
}

std::vector<double> AdamVector::step(std::span<const double> gradient, std::span<const double> rates) {
    first.resize(gradient.size(), 0.0), second.resize(gradient.size(), 0.0);
    ++steps;
    const double c1 = 1 / (1 - std::pow(beta1, double(steps))), c2 = 1 / (1 - std::pow(beta2, double(steps)));
    std::vector<double> out(gradient.size());
    for (size_t i = 0; i < gradient.size(); ++i) {
        first[i] = beta1 * first[i] + (1 - beta1) * gradient[i];
        second[i] = beta2 * second[i] + (1 - beta2) * gradient[i] * gradient[i];
        out[i] = rates[i] * first[i] * c1 / (std::sqrt(second[i] * c2) + 1e-20);
    }
    return out;
}

std::vector<double> AdamVector::spread() const {
    std::vector<double> out(second.size());
    for (size_t i = 0; i < out.size(); ++i) out[i] = std::sqrt(second[i] / (1 - std::pow(beta2, double(steps)))) + 1e-20;
    return out;
}

}  // namespace dpl
#endif
