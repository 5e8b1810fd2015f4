// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/training/trainer/step_clock.h"

#include <ctime>

namespace dpl {
namespace {

double millisecondsOf(clockid_t clock) {
    timespec time{};
    clock_gettime(clock, &time);
    return double(time.tv_sec) * 1e3 + double(time.tv_nsec) * 1e-6;
}

}  // namespace

const char* nameOf(StepPart part) {
    static constexpr const char* kNames[kStepParts] = {"picture of the frame",
                                                       "pose: skin, triangle frames",
                                                       "project splats",
                                                       "sort, tile lists",
                                                       "blend",
                                                       "loss with SSIM, and its gradient",
                                                       "backward: pixels to splats",
                                                       "backward: splats to parameters",
                                                       "backward: mesh, nodes, pose",
                                                       "splats: regularisers, Adam",
                                                       "pose: Adam, registration",
                                                       "garment collision",
                                                       "offsets: LargeSteps",
                                                       "corrective nodes",
                                                       "density",
                                                       "engine: project to Adam"};
    return kNames[size_t(part)];
}

PartTime StepClock::now() {
    return {millisecondsOf(CLOCK_MONOTONIC), millisecondsOf(CLOCK_PROCESS_CPUTIME_ID), millisecondsOf(CLOCK_THREAD_CPUTIME_ID)};
}

}  // namespace dpl
