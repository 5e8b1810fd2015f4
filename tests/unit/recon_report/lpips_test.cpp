// SPDX-License-Identifier: Apache-2.0
// LPIPS against its definition in double precision, with weights of our own: AlexNet's are not free to ship.
#include "reconstruction/judging/report/lpips.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <fstream>
#include <map>
#include <random>

#include "tests/unit/made_zip.h"

namespace dpl {
namespace {

namespace fs = std::filesystem;

constexpr uint32_t kPictureW = 67, kPictureH = 47;
constexpr size_t kChannels[6] = {3, 5, 7, 6, 4, 3};  // fewer than AlexNet's
constexpr int kKernel[5] = {11, 5, 3, 3, 3}, kStride[5] = {4, 1, 1, 1, 1}, kPadding[5] = {2, 2, 1, 1, 1};
constexpr const char* kNames[5] = {"net.slice1.0", "net.slice2.3", "net.slice3.6", "net.slice4.8", "net.slice5.10"};

struct Array {
    std::string shape;
    std::vector<float> values;
};

std::vector<uint8_t> npyOf(const Array& array) {
    std::string header = "{'descr': '<f4', 'fortran_order': False, 'shape': (" + array.shape + "), }";
    header.append(63 - (10 + header.size()) % 64, ' ');
    header += '\n';
    std::vector<uint8_t> bytes = {0x93, 'N', 'U', 'M', 'P', 'Y', 1, 0, uint8_t(header.size() & 255), uint8_t(header.size() >> 8)};
    bytes.insert(bytes.end(), header.begin(), header.end());
    const auto* raw = reinterpret_cast<const uint8_t*>(array.values.data());
    bytes.insert(bytes.end(), raw, raw + array.values.size() * sizeof(float));
    return bytes;
}

std::map<std::string, Array> madeWeights() {
    std::mt19937 random(11);
    std::normal_distribution<float> normal;
    const auto draw = [&](size_t count, float scale) {
        std::vector<float> values(count);
        for (float& v : values) v = scale * normal(random);
        return values;
    };
    std::map<std::string, Array> arrays;
    for (int i = 0; i < 5; ++i) {
        const size_t in = kChannels[i], out = kChannels[i + 1], k = size_t(kKernel[i]), taps = in * k * k;
        const std::string name = kNames[i];
        arrays[name + ".weight"] = {formatText("{}, {}, {}, {}", out, in, k, k), draw(out * taps, 1 / std::sqrt(float(taps)))};
        arrays[name + ".bias"] = {formatText("{},", out), draw(out, 0.1f)};
        Array lin{formatText("1, {}, 1, 1", out), draw(out, 0.3f)};
        for (float& v : lin.values) v = std::abs(v);
        arrays[formatText("lin{}.model.1.weight", i)] = lin;
    }
    arrays["scaling_layer.shift"] = {"1, 3, 1, 1", {0, 0, 0}};  // saved with the rest, not read
    return arrays;
}

class LpipsFile {
public:
    explicit LpipsFile(const std::map<std::string, Array>& arrays) {
        std::vector<std::pair<std::string, std::vector<uint8_t>>> entries;
        for (const auto& [name, array] : arrays) entries.push_back({name + ".npy", npyOf(array)});
        write(zip(entries));
    }
    ~LpipsFile() { fs::remove(path); }
    void write(const std::vector<uint8_t>& bytes) const {
        std::ofstream(path, std::ios::binary).write(reinterpret_cast<const char*>(bytes.data()), std::streamsize(bytes.size()));
    }
    const fs::path path = fs::temp_directory_path() / ("dpl_lpips_" + std::to_string(::getpid()) + ".npz");
};

std::vector<float> madePicture(unsigned seed) {
    std::mt19937 random(seed);
    std::vector<float> values(3 * kPictureW * kPictureH);
    for (size_t i = 0; i < values.size(); ++i)
        values[i] = float(0.6 * std::sin(0.02 * double(i % kPictureW) * double(seed)) + 0.4 * double(random() % 1000) / 1000 - 0.2);
    return values;
}

/** A stack of planes, and its value with zeros around it. */
struct Stack {
    int channels, width, height;
    std::vector<double> values;
    double at(int c, int x, int y) const {
        return x < 0 || y < 0 || x >= width || y >= height ? 0 : values[size_t((c * height + y) * width + x)];
    }
};

/** All five layers of the definition. */
std::vector<Stack> naiveFeatures(const std::vector<float>& picture, const std::map<std::string, Array>& weights) {
    const double shift[3] = {-0.030, -0.088, -0.188}, scale[3] = {0.458, 0.448, 0.450};
    Stack now{3, int(kPictureW), int(kPictureH), {}};
    for (size_t i = 0; i < picture.size(); ++i)
        now.values.push_back((picture[i] - shift[i / (kPictureW * kPictureH)]) / scale[i / (kPictureW * kPictureH)]);
    std::vector<Stack> features;
    for (int layer = 0; layer < 5; ++layer) {
        if (layer == 1 || layer == 2) {
            Stack pooled{now.channels, (now.width - 3) / 2 + 1, (now.height - 3) / 2 + 1, {}};
            for (int c = 0; c < pooled.channels; ++c)
                for (int y = 0; y < pooled.height; ++y)
                    for (int x = 0; x < pooled.width; ++x) {
                        double most = -1e300;
                        for (int k = 0; k < 9; ++k) most = std::max(most, now.at(c, 2 * x + k % 3, 2 * y + k / 3));
                        pooled.values.push_back(most);
                    }
            now = pooled;
        }
        const auto& w = weights.at(std::string(kNames[layer]) + ".weight").values;
        const auto& b = weights.at(std::string(kNames[layer]) + ".bias").values;
        const int k = kKernel[layer], s = kStride[layer], p = kPadding[layer];
        Stack next{int(kChannels[layer + 1]), (now.width + 2 * p - k) / s + 1, (now.height + 2 * p - k) / s + 1, {}};
        for (int o = 0; o < next.channels; ++o)
            for (int y = 0; y < next.height; ++y)
                for (int x = 0; x < next.width; ++x) {
                    double sum = b[size_t(o)];
                    for (int c = 0; c < now.channels; ++c)
                        for (int j = 0; j < k; ++j)
                            for (int i = 0; i < k; ++i)
                                sum += w[size_t(((o * now.channels + c) * k + j) * k + i)] * now.at(c, x * s + i - p, y * s + j - p);
                    next.values.push_back(std::max(0.0, sum));
                }
        now = next;
        features.push_back(now);
    }
    return features;
}

double naiveLpips(const std::vector<float>& a, const std::vector<float>& b, const std::map<std::string, Array>& weights) {
    const auto fa = naiveFeatures(a, weights), fb = naiveFeatures(b, weights);
    double total = 0;
    for (size_t layer = 0; layer < 5; ++layer) {
        const Stack &x = fa[layer], &y = fb[layer];
        const auto& lin = weights.at(formatText("lin{}.model.1.weight", layer)).values;
        double sum = 0;
        for (int v = 0; v < x.height; ++v)
            for (int u = 0; u < x.width; ++u) {
                double nx = 0, ny = 0;
                for (int c = 0; c < x.channels; ++c) nx += x.at(c, u, v) * x.at(c, u, v), ny += y.at(c, u, v) * y.at(c, u, v);
                nx = std::sqrt(nx) + 1e-10, ny = std::sqrt(ny) + 1e-10;
                for (int c = 0; c < x.channels; ++c) sum += lin[size_t(c)] * std::pow(x.at(c, u, v) / nx - y.at(c, u, v) / ny, 2);
            }
        total += sum / (x.width * x.height);
    }
    return total;
}

TEST(Lpips, equalsItsDefinition) {
    const auto weights = madeWeights();
    const LpipsFile file(weights);
    const auto lpips = Lpips::load(file.path);
    ASSERT_TRUE(lpips) << lpips.error().message;
    const auto a = madePicture(1), b = madePicture(2);
    const auto distance = lpips->distance(a, b, kPictureW, kPictureH);
    ASSERT_TRUE(distance) << distance.error().message;
    const double expected = naiveLpips(a, b, weights);
    EXPECT_GT(expected, 0.01);
    EXPECT_NEAR(*distance, expected, 1e-5 * expected);  // features are floats: measured 2e-7
    EXPECT_EQ(*lpips->distance(a, a, kPictureW, kPictureH), 0);
    EXPECT_EQ(*lpips->distance(b, a, kPictureW, kPictureH), *distance);
}

TEST(Lpips, sizesThatDoNotFitAreRefused) {
    const LpipsFile file(madeWeights());
    const auto lpips = Lpips::load(file.path);
    ASSERT_TRUE(lpips);
    const std::vector<float> picture(3 * 30 * 40);
    EXPECT_FALSE(lpips->distance(picture, picture, 40, 30));
    EXPECT_FALSE(lpips->distance(picture, picture, 40, 31));
}

TEST(Lpips, damagedWeightsAreRefusedByName) {
    const auto refuse = [](const std::function<void(std::map<std::string, Array>&)>& breakIt, const char* word) {
        auto weights = madeWeights();
        breakIt(weights);
        const LpipsFile file(weights);
        const auto lpips = Lpips::load(file.path);
        ASSERT_FALSE(lpips);
        EXPECT_NE(lpips.error().message.find(word), std::string::npos) << lpips.error().message;
        EXPECT_NE(lpips.error().message.find(".npz"), std::string::npos);
    };
    refuse([](auto& w) { w.erase("net.slice3.6.weight"); }, "net.slice3.6.weight");
    refuse([](auto& w) { w.erase("lin4.model.1.weight"); }, "lin4.model.1.weight");
    refuse([](auto& w) { w["net.slice2.3.bias"] = {"0,", {}}; }, "net.slice2.3.bias");
    refuse([](auto& w) { w["net.slice2.3.bias"] = {"2000,", std::vector<float>(2000)}; }, "1 to 1024");
    refuse([](auto& w) { w["net.slice1.0.weight"].shape = "3, 5, 11, 11"; }, "another shape");
    refuse([](auto& w) { w["lin0.model.1.weight"].values[2] = INFINITY; }, "not finite");
}

TEST(Lpips, everyTruncationIsRefused) {
    const LpipsFile file(madeWeights());
    std::ifstream in(file.path, std::ios::binary);
    const std::vector<uint8_t> bytes((std::istreambuf_iterator<char>(in)), std::istreambuf_iterator<char>());
    for (size_t length = 0; length < bytes.size(); length += length < 400 ? 1 : 97) {
        file.write({bytes.begin(), bytes.begin() + std::ptrdiff_t(length)});
        EXPECT_FALSE(Lpips::load(file.path)) << length;
    }
}

}  // namespace
}  // namespace dpl
