// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/run/training_device.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include "sdk/core/files.h"
#include "tests/unit/dying_engine.h"

namespace dpl::test {
namespace {

namespace fs = std::filesystem;

class TrainOnDevice : public testing::Test {
protected:
    TrainOnDevice() { fs::create_directories(folder_); }
    ~TrainOnDevice() override { fs::remove_all(folder_); }

    /** Trains with an engine that fails with `code`, after a checkpoint where asked for. */
    Status train(TrainingDevice::Kind kind, Code code, bool afterCheckpoint) {
        calls_.clear();
        return trainOnDevice({kind, {}}, &engine_, files_, progress_, [&](TrainingEngine* with) -> Status {
            calls_.push_back(with);
            if (!with) return {};
            if (afterCheckpoint) DPL_RETURN_IF_ERROR(writeFileAtomically(files_.checkpoint, std::string("steps")));
            return fail(code, "it failed");
        });
    }

    const fs::path folder_ = fs::temp_directory_path() / ("doppel_training_device_" + std::to_string(::getpid()));
    const TrainingFiles files_{folder_ / "checkpoint", folder_ / "engine.txt"};
    Progress progress_{Progress::Style::Quiet};
    DyingEngine engine_{0};
    std::vector<TrainingEngine*> calls_;
};

TEST_F(TrainOnDevice, aFailedDeviceIsFollowedByTheCpuWhereTheChoiceIsFree) {
    for (const Code code : {Code::Device, Code::OutOfMemory}) {
        EXPECT_TRUE(train(TrainingDevice::Kind::Auto, code, false));
        EXPECT_EQ(calls_, (std::vector<TrainingEngine*>{&engine_, nullptr}));
    }
    const Status asked = train(TrainingDevice::Kind::Gpu, Code::Device, false);
    ASSERT_FALSE(asked);
    EXPECT_EQ(asked.error().code, Code::Device);
    EXPECT_EQ(calls_.size(), 1u);
}

TEST_F(TrainOnDevice, whatIsNoFaultOfTheDeviceEndsTheTraining) {
    const Status stopped = train(TrainingDevice::Kind::Auto, Code::Cancelled, false);
    ASSERT_FALSE(stopped);
    EXPECT_EQ(stopped.error().code, Code::Cancelled);
    EXPECT_EQ(calls_.size(), 1u);
}

TEST_F(TrainOnDevice, theEngineIsNamedWhereStepsOfTheResultAreItsOwn) {
    EXPECT_TRUE(train(TrainingDevice::Kind::Auto, Code::Device, true));
    EXPECT_TRUE(fs::exists(files_.engine));
    fs::remove(files_.checkpoint);
    EXPECT_TRUE(train(TrainingDevice::Kind::Auto, Code::Device, false));
    EXPECT_FALSE(fs::exists(files_.engine));
}

TEST_F(TrainOnDevice, anEngineOfARunThatWasKilledBeforeItsFirstCheckpointIsForgotten) {
    ASSERT_TRUE(writeFileAtomically(files_.engine, std::string("a device")));
    const auto train = [&] {
        return trainOnDevice({TrainingDevice::Kind::Auto, {}}, nullptr, files_, progress_, [](TrainingEngine*) { return Status(); });
    };
    ASSERT_TRUE(writeFileAtomically(files_.checkpoint, std::string("steps")));
    EXPECT_TRUE(train());
    EXPECT_TRUE(fs::exists(files_.engine)) << "its steps are in the checkpoint";
    fs::remove(files_.checkpoint);
    EXPECT_TRUE(train());
    EXPECT_FALSE(fs::exists(files_.engine));
}

}  // namespace
}  // namespace dpl::test
