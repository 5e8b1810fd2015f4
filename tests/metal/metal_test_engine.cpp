// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "reconstruction/training/gpu/metal_engine.h"
#include "tests/metal/software/software_device.h"
#include "tests/unit/recon_gpu_training/test_engine.h"

namespace dpl::test {

GpuEngine* testEngine() {
    static const auto made = [] {
        auto engine = createMetalEngine(mtl::SoftwareDevice::shared().seam());
        if (!engine) std::printf("[   NOTE   ] %s\n", engine.error().message.c_str());
        return engine ? std::move(*engine) : nullptr;
    }();
    EXPECT_EQ(mtl::SoftwareDevice::shared().takeFaults(), std::vector<std::string>());
    return made.get();
}

}  // namespace dpl::test
