// SPDX-License-Identifier: Apache-2.0
// One ONNX network through OpenCV's dnn module, on one thread. Private to the capture room and its tests.
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

/** A network is used by one thread at a time. Results are the same on every run: OpenCV's own threads are switched off in load(). */
class OnnxNet {
public:
    static Result<OnnxNet> load(const std::filesystem::path& path);
    OnnxNet(OnnxNet&&) noexcept;
    OnnxNet& operator=(OnnxNet&&) noexcept;
    ~OnnxNet();

    /** Runs a 1×3×S×S input; all graph outputs in the order of the file. */
    Result<std::vector<Tensor>> run(const std::vector<float>& chw, int side);

private:
    struct State;
    explicit OnnxNet(std::unique_ptr<State> state);
    std::unique_ptr<State> state_;
};

}  // namespace dpl
