// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/input/observe/onnx_net.h"

#include <cmath>
#include <opencv2/core/utility.hpp>
#include <opencv2/dnn.hpp>

#include "reconstruction/base/models_folder.h"

namespace dpl {

namespace fs = std::filesystem;

struct OnnxNet::State {
    fs::path path;
    cv::dnn::Net net;
    std::vector<cv::String> outputs;
};

OnnxNet::OnnxNet(std::unique_ptr<State> state) : state_(std::move(state)) {}
OnnxNet::OnnxNet(OnnxNet&&) noexcept = default;
OnnxNet& OnnxNet::operator=(OnnxNet&&) noexcept = default;
OnnxNet::~OnnxNet() = default;

Result<OnnxNet> OnnxNet::load(const fs::path& path) {
    std::error_code error;
    if (!fs::is_regular_file(path, error)) return fail(Code::NotFound, "{}: not found; {}", path.string(), howToGetNetworks());
    if (fs::file_size(path, error) > (512u << 20)) return fail(Code::Unsupported, "{}: larger than 512 MiB", path.string());
    cv::setNumThreads(1);  // fixed order of sums: equal results on every run
    auto state = std::make_unique<State>();
    state->path = path;
    try {
        state->net = cv::dnn::readNetFromONNX(path.string());
        state->net.setPreferableBackend(cv::dnn::DNN_BACKEND_OPENCV);
        state->net.setPreferableTarget(cv::dnn::DNN_TARGET_CPU);
        state->outputs = state->net.getUnconnectedOutLayersNames();
    } catch (const std::exception& e) {
        return fail(Code::CorruptData, "{}: OpenCV cannot read this network ({}); download it again", path.string(), e.what());
    }
    if (state->net.empty() || state->outputs.empty())
        return fail(Code::CorruptData, "{}: the network is empty; download it again", path.string());
    return OnnxNet(std::move(state));
}

Result<std::vector<Tensor>> OnnxNet::run(const std::vector<float>& chw, int side) {
    if (chw.size() != size_t(3) * side * side)
        return fail(Code::InvalidArgument, "{}: input of {} numbers for side {}", state_->path.string(), chw.size(), side);
    std::vector<Tensor> tensors;
    try {
        const int shape[4] = {1, 3, side, side};
        cv::Mat input(4, shape, CV_32F);
        std::copy(chw.begin(), chw.end(), input.ptr<float>());
        state_->net.setInput(input);
        std::vector<cv::Mat> outputs;
        state_->net.forward(outputs, state_->outputs);
        for (size_t i = 0; i < outputs.size(); ++i) {
            Tensor t{state_->outputs[i], {}, {}};
            for (int d = 0; d < outputs[i].dims; ++d) t.shape.push_back(outputs[i].size[d]);
            const cv::Mat flat = outputs[i].reshape(1, 1);
            t.data.assign(flat.begin<float>(), flat.end<float>());
            for (float v : t.data)
                if (!std::isfinite(v))
                    return fail(Code::CorruptData, "{}: output '{}' is not finite; download the network again", state_->path.string(),
                                t.name);
            tensors.push_back(std::move(t));
        }
    } catch (const std::exception& e) {
        return fail(Code::Internal, "{}: the network failed ({})", state_->path.string(), e.what());
    }
    return tensors;
}

}  // namespace dpl
