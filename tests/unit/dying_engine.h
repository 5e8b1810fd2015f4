// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "reconstruction/training/trainer/training_engine.h"

namespace dpl::test {

/** An engine whose device dies at a step. */
class DyingEngine final : public TrainingEngine {
public:
    explicit DyingEngine(uint32_t after) : left_(after) {}
    std::string name() const override { return "a device that dies"; }
    Status begin(const EngineRoom&) override { return {}; }
    Status setRest(std::span<const RestTriangle<float>>) override { return {}; }
    Status upload(const EngineState& state) override {
        vertices_.assign(state.incidence.offset.size() - 1, Vec4f(0));
        return {};
    }
    Result<LossValues> step(const EngineStep&) override {
        if (left_-- == 0) return fail(Code::Device, "the device was lost");
        LossValues v;
        v.total = 1;
        return v;
    }
    std::span<const Vec4f> vertexGradients() const override { return vertices_; }
    std::vector<PassTime> passTimes() override { return {}; }
    uint64_t takeCrossedBytes() override { return 0; }
    Status download(TrainableSplats&, AdamRows&, DensityStatistics&) override { return {}; }

private:
    uint32_t left_;
    std::vector<Vec4f> vertices_;
};

}  // namespace dpl::test
