// SPDX-License-Identifier: Apache-2.0
// OpenCV computes with the converted tiny model what the plain Python evaluation of the original gives. $DOPPEL_TINY_MODEL: the folder that
// converter_test.py wrote.
#include <gtest/gtest.h>

#include <cstdlib>
#include <fstream>
#include <nlohmann/json.hpp>

#include "reconstruction/input/observe/onnx_net.h"

namespace dpl {
namespace {

TEST(ConvertedNetwork, computesWhatTheOriginalDoes) {
    const char* given = std::getenv("DOPPEL_TINY_MODEL");
    ASSERT_TRUE(given) << "run it with ctest";
    const std::filesystem::path folder(given);
    auto net = OnnxNet::load(folder / "tiny.onnx");
    ASSERT_TRUE(net) << net.error().message;
    constexpr int kSide = 8;
    std::vector<float> picture(3 * kSide * kSide);
    for (size_t i = 0; i < picture.size(); ++i) picture[i] = float((i * 7919) % 1000) / 1000.0f;
    auto outputs = net->run(picture, kSide);
    ASSERT_TRUE(outputs) << outputs.error().message;
    std::ifstream in(folder / "expected.json");
    const auto expected = nlohmann::json::parse(in);
    ASSERT_EQ(outputs->size(), expected.size());
    for (const Tensor& output : *outputs) {
        const auto values = expected.at(output.name).get<std::vector<double>>();
        ASSERT_EQ(output.data.size(), values.size()) << output.name;
        double worst = 0;
        for (size_t i = 0; i < values.size(); ++i) worst = std::max(worst, std::abs(values[i] - double(output.data[i])));
        EXPECT_LT(worst, 1e-5) << output.name;  // values up to 13 in 32-bit sums of up to 72 products; 1.6e-6 measured
        std::printf("%s: %zu values, largest difference %.2g\n", output.name.c_str(), values.size(), worst);
    }
}

}  // namespace
}  // namespace dpl
