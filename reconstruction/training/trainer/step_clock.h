// SPDX-License-Identifier: Apache-2.0
// Times of the parts of training steps. Always on: a lap reads three clocks, and the laps of a step together take about 10 µs.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace dpl {

/** The parts of a training step, in the order in which it runs them. A polish and a pose fit run some of them. */
enum class StepPart : uint8_t {
    Picture,
    Pose,
    Project,
    Tiles,
    Blend,
    Loss,
    Pixels,
    Splats,
    Mesh,
    Adam,
    PoseStep,
    Collision,
    Offsets,
    Nodes,
    Density,
    Engine  // in place of Project to Splats, and of Adam
};
constexpr size_t kStepParts = 16;

/** For people: what the part does. */
const char* nameOf(StepPart part);

/** Milliseconds. */
struct PartTime {
    double wall = 0;
    double cpu = 0;     // of all threads of the process
    double caller = 0;  // CPU time of the thread that trains; what it computes alone is serial
};

using PartTimes = std::array<PartTime, kStepParts>;

class StepClock {
public:
    /** Starts a lap. */
    void start() { last_ = now(); }
    /** Adds the time since the last lap, or since start(), to the part, and starts another lap. */
    void lap(StepPart part) {
        const PartTime at = now();
        PartTime& sum = times[size_t(part)];
        sum.wall += at.wall - last_.wall, sum.cpu += at.cpu - last_.cpu, sum.caller += at.caller - last_.caller;
        last_ = at;
    }

    /** Says that one thread has computed for `cpuMs` of the time of `from` what belongs to `to`, beside other work of `from`. */
    void move(StepPart from, StepPart to, double cpuMs) { times[size_t(from)].cpu -= cpuMs, times[size_t(to)].cpu += cpuMs; }

    PartTimes times{};

    static PartTime now();

private:
    PartTime last_;
};

}  // namespace dpl
