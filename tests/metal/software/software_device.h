// SPDX-License-Identifier: Apache-2.0
// A Metal device in software, behind the seam of the Metal backend. It runs the MSL of the shader pack that was compiled as C++
// (tests/metal/CMakeLists.txt lists it) and checks what Metal's validation checks, and more: see tests/metal/README.md.
//
// Command buffers run when the CPU waits for one, or looks at its status or at an event often enough: as late as on a real GPU, so that a
// missing wait shows. They run in the order of their commits, on the thread that waits or looks.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "sdk/backend/metal/mtl_seam.h"

namespace dpl::mtl {

/** What the device does with calls. */
enum class SoftwareWork {
    All,
    NoShaders,  // everything but dispatches and draws, which are checked when they are encoded
    Nothing,    // idle_seam.h
};

struct SoftwareOptions {
    bool layered = true;  // MTLGPUFamilyApple5: layered rendering
    bool msaa32 = true;   // supports32BitMSAA
    bool fourSamples = true;
    uint32_t looks = 1;  // at a status or event before one more command buffer runs; 0: they run when they are committed
    int laneOrder = 0;   // of threads in a threadgroup and of threadgroups: 0 forward, 1 backward, 2 shuffled
    SoftwareWork work = SoftwareWork::All;
};

class SoftwareDevice {
public:
    explicit SoftwareDevice(const SoftwareOptions& options = {});
    ~SoftwareDevice();
    SoftwareDevice(const SoftwareDevice&) = delete;
    SoftwareDevice& operator=(const SoftwareDevice&) = delete;

    /** The device of openSeam(). Lives as long as the process. */
    static SoftwareDevice& shared();

    /** A seam on this device and its only queue. May outlive this object. */
    std::unique_ptr<Seam> seam();
    /** What an app passes as its id<MTLDevice> and id<MTLCommandQueue>. Valid as long as this object. */
    void* device() const;
    void* queue() const;

    /** A sentence for each thing that was wrong so far, each once; forgets them. */
    std::vector<std::string> takeFaults();
    /** Kinds and labels of objects that were not released. */
    std::vector<std::string> alive() const;
    /** Runs the committed command buffers. */
    void finish();
    /** The next command buffer that is committed does not run, but ends with this error. */
    void failNext(CommandError error, std::string text);
    /** As an app sets MTLSharedEvent.signaledValue. */
    void signal(EventRef event, uint64_t value);

private:
    std::shared_ptr<struct DeviceState> state_;
};

}  // namespace dpl::mtl
