// SPDX-License-Identifier: Apache-2.0
// Runs one ONNX network with OpenCV's dnn module. Private to reconstruction/input/capture and its tests.
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "sdk/core/result.h"

namespace dpl {

struct Tensor {
    std::string name;
    std::vector<int> shape;
    std::vector<float> data;
};

/** One thread at a time may use a network. load() switches off OpenCV's own threads for the whole process, so that results repeat exactly.
 */
class OnnxNet {
public:
    static Result<OnnxNet> load(const std::filesystem::path& path);
    OnnxNet(OnnxNet&&) noexcept;
    OnnxNet& operator=(OnnxNet&&) noexcept;
    ~OnnxNet();

    /** Runs on a 1×3×side×side input and returns all graph outputs in the order of the file. */
    Result<std::vector<Tensor>> run(const std::vector<float>& chw, int side);

private:
    struct State;
    explicit OnnxNet(std::unique_ptr<State> state);
    std::unique_ptr<State> state_;
};

}  // namespace dpl
