// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/judging/report/lpips.h"

#include <algorithm>
#include <cmath>
#include <opencv2/core.hpp>

#include "reconstruction/base/npz.h"
#include "sdk/core/files.h"

namespace dpl {
namespace {

constexpr uint64_t kMaxWeightBytes = 64u << 20;                                                 // AlexNet's five layers take 10 MB
constexpr size_t kMaxChannels = 1024;                                                           // of a layer; AlexNet has at most 384
constexpr size_t kMaxColumnFloats = 4u << 20;                                                   // of the unfolded input of a strip of rows
constexpr float kShift[3] = {-0.030f, -0.088f, -0.188f}, kScale[3] = {0.458f, 0.448f, 0.450f};  // of LPIPS 0.1

/** A convolution of AlexNet. `pooled`: a maximum over 3 × 3 with stride 2 comes before it. `name`: in the file. */
struct LayerShape {
    const char* name;
    int kernel, stride, padding;
    bool pooled;
};
constexpr LayerShape kShapes[Lpips::kLayers] = {
    {"net.slice1.0", 11, 4, 2, false}, {"net.slice2.3", 5, 1, 2, true},   {"net.slice3.6", 3, 1, 1, true},
    {"net.slice4.8", 3, 1, 1, false},  {"net.slice5.10", 3, 1, 1, false},
};

/** Channels of one size, planes one after the other. */
struct Planes {
    size_t channels = 0;
    int width = 0, height = 0;
    std::vector<float> values;
};

Planes maxPooled(const Planes& in) {
    Planes out{in.channels, (in.width - 3) / 2 + 1, (in.height - 3) / 2 + 1, {}};
    out.values.resize(out.channels * size_t(out.width) * size_t(out.height));
    float* to = out.values.data();
    for (size_t c = 0; c < in.channels; ++c) {
        const float* plane = &in.values[c * size_t(in.width) * size_t(in.height)];
        for (int y = 0; y < out.height; ++y)
            for (int x = 0; x < out.width; ++x) {
                float most = plane[(2 * y) * in.width + 2 * x];
                for (int j = 0; j < 3; ++j)
                    for (int i = 0; i < 3; ++i) most = std::max(most, plane[(2 * y + j) * in.width + 2 * x + i]);
                *to++ = most;
            }
    }
    return out;
}

/** Convolution and ReLU. Strips of rows are unfolded into a matrix, so that memory does not grow with the picture. */
Planes convolved(const Planes& in, const LayerShape& shape, size_t outputs, const std::vector<float>& weights,
                 const std::vector<float>& biases) {
    Planes out{outputs,
               (in.width + 2 * shape.padding - shape.kernel) / shape.stride + 1,
               (in.height + 2 * shape.padding - shape.kernel) / shape.stride + 1,
               {}};
    const size_t taps = in.channels * size_t(shape.kernel * shape.kernel), outPlane = size_t(out.width) * size_t(out.height);
    out.values.resize(outputs * outPlane);
    const cv::Mat kernels(int(outputs), int(taps), CV_32F, const_cast<float*>(weights.data()));
    const int strip = int(std::clamp<size_t>(kMaxColumnFloats / (taps * size_t(out.width)), 1, size_t(out.height)));
    for (int top = 0; top < out.height; top += strip) {
        const int rows = std::min(strip, out.height - top);
        cv::Mat columns = cv::Mat::zeros(int(taps), rows * out.width, CV_32F), product;
        for (size_t t = 0; t < taps; ++t) {
            const int at = int(t % size_t(shape.kernel * shape.kernel)), dy = at / shape.kernel, dx = at % shape.kernel;
            const float* plane = &in.values[t / size_t(shape.kernel * shape.kernel) * size_t(in.width) * size_t(in.height)];
            float* to = columns.ptr<float>(int(t));
            for (int y = top; y < top + rows; ++y)
                for (int x = 0; x < out.width; ++x, ++to) {
                    const int sx = x * shape.stride + dx - shape.padding, sy = y * shape.stride + dy - shape.padding;
                    if (sx >= 0 && sy >= 0 && sx < in.width && sy < in.height) *to = plane[sy * in.width + sx];
                }
        }
        cv::gemm(kernels, columns, 1, cv::noArray(), 0, product);
        for (size_t o = 0; o < outputs; ++o) {
            const float* from = product.ptr<float>(int(o));
            float* to = &out.values[o * outPlane + size_t(top) * size_t(out.width)];
            for (int i = 0; i < rows * out.width; ++i) to[i] = std::max(0.0f, from[i] + biases[o]);
        }
    }
    return out;
}

/** Mean over the pixels of Σ importance · (unit(a) − unit(b))², with each pixel's channels as a vector of length 1. */
double layerDistance(const Planes& a, const Planes& b, const std::vector<float>& importance) {
    const size_t plane = size_t(a.width) * size_t(a.height);
    double sum = 0;
    for (size_t i = 0; i < plane; ++i) {
        double squaresA = 0, squaresB = 0, here = 0;
        for (size_t c = 0; c < a.channels; ++c) {
            squaresA += double(a.values[c * plane + i]) * a.values[c * plane + i];
            squaresB += double(b.values[c * plane + i]) * b.values[c * plane + i];
        }
        const double scaleA = 1 / (std::sqrt(squaresA) + 1e-10), scaleB = 1 / (std::sqrt(squaresB) + 1e-10);
        for (size_t c = 0; c < a.channels; ++c) {
            const double d = a.values[c * plane + i] * scaleA - b.values[c * plane + i] * scaleB;
            here += importance[c] * d * d;
        }
        sum += here;
    }
    return sum / double(plane);
}

Result<std::vector<float>> readWeights(NpzFile& file, const std::string& name, const std::vector<size_t>& shape) {
    DPL_TRY(const NpyArray array, file.read(name));
    if (array.shape != shape) return fail(Code::CorruptData, "array '{}' has another shape than AlexNet's layer", name);
    for (const double value : array.values)
        if (!std::isfinite(float(value))) return fail(Code::CorruptData, "array '{}' holds a number that is not finite", name);
    return std::vector<float>(array.values.begin(), array.values.end());
}

}  // namespace

Result<Lpips> Lpips::load(const std::filesystem::path& path) {
    DPL_TRY(const auto bytes, readFile(path, kMaxWeightBytes));
    const auto read = [&]() -> Result<Lpips> {
        DPL_TRY(NpzFile file, NpzFile::open(bytes));
        Lpips lpips;
        size_t inputs = 3;
        for (size_t i = 0; i < kLayers; ++i) {
            const LayerShape& shape = kShapes[i];
            const std::string name = shape.name;
            DPL_TRY(const NpyArray biases, file.read(name + ".bias"));
            const size_t outputs = biases.values.size(), kernel = size_t(shape.kernel);
            if (outputs == 0 || outputs > kMaxChannels)
                return fail(Code::CorruptData, "array '{}.bias' has {} values, 1 to {} are wanted", name, outputs, kMaxChannels);
            Layer& layer = lpips.layers_[i];
            layer.inputs = inputs, layer.outputs = outputs;
            DPL_TRY(layer.weights, readWeights(file, name + ".weight", {outputs, inputs, kernel, kernel}));
            DPL_TRY(layer.biases, readWeights(file, name + ".bias", {outputs}));
            DPL_TRY(layer.importance, readWeights(file, formatText("lin{}.model.1.weight", i), {1, outputs, 1, 1}));
            inputs = outputs;
        }
        return lpips;
    };
    auto lpips = read();
    if (!lpips)
        return fail(lpips.error().code, "{}: {}; save the weights as docs/reference/neuman.md says", path.string(), lpips.error().message);
    return lpips;
}

Result<double> Lpips::distance(std::span<const float> a, std::span<const float> b, uint32_t widthPx, uint32_t heightPx) const {
    const size_t pixels = size_t(widthPx) * heightPx;
    if (a.size() != 3 * pixels || b.size() != 3 * pixels)
        return fail(Code::InvalidArgument, "{} and {} values for three planes of {} x {}", a.size(), b.size(), widthPx, heightPx);
    if (widthPx < 31 || heightPx < 31)
        return fail(Code::InvalidArgument, "LPIPS needs pictures of at least 31 x 31 pixels, this one is {} x {}", widthPx, heightPx);
    Planes features[2];
    for (int which = 0; which < 2; ++which) {
        const std::span<const float> picture = which == 0 ? a : b;
        Planes& in = features[which];
        in = {3, int(widthPx), int(heightPx), std::vector<float>(3 * pixels)};
        for (size_t c = 0; c < 3; ++c)
            for (size_t i = 0; i < pixels; ++i) in.values[c * pixels + i] = (picture[c * pixels + i] - kShift[c]) / kScale[c];
    }
    double sum = 0;
    for (size_t i = 0; i < kLayers; ++i) {
        for (Planes& planes : features) {
            if (kShapes[i].pooled) planes = maxPooled(planes);
            planes = convolved(planes, kShapes[i], layers_[i].outputs, layers_[i].weights, layers_[i].biases);
        }
        sum += layerDistance(features[0], features[1], layers_[i].importance);
    }
    return sum;
}

}  // namespace dpl
