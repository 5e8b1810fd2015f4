// SPDX-License-Identifier: Apache-2.0
// Who races in a bench: renderers that hold the same subject and draw the same views in turns, so that other work on the machine slows all
// of them alike. `doppel bench` races what users can choose; tools/bench/frames adds renderers with something switched off.
#pragma once

#include <doppel/doppel.hpp>

#include <chrono>
#include <filesystem>
#include <functional>
#include <memory>

#include "apps/reference/reference_file.h"
#include "sdk/core/result.h"
#include "sdk/math/camera.h"

namespace dpl {

struct BenchOptions {
    std::filesystem::path avatar, jsonFile, plotFile;
    std::vector<std::string> renderers;
    std::string fill = "auto";  // of the renderer "vulkan"
    std::string clip;
    double timeS = 0;
    uint32_t repeats = 11, threadCount = 0;
    std::string axes = "y-up";
    bool withoutReference = false;
};

struct BenchCase {
    const char* name;
    uint32_t widthPx, heightPx, viewCount;
    bool portrait = false;  // head and shoulders only
};

/** The avatar, its pose and its sizes. It has a context of its own, so that every contestant gets the same pose. */
struct BenchSubject {
    std::vector<uint8_t> bytes;
    doppel::Context context;
    doppel::Avatar avatar;
    DplAvatarInfo info;  // its name lives as long as the avatar
    std::vector<float> rotations;
    Vec3f root{0};

    static Result<BenchSubject> load(const BenchOptions& options);
    std::vector<Cameraf> views(const BenchCase& test, const std::string& axes) const;
};

/** Times of one pass in milliseconds, one sample a frame. Rounds of the sort are summed, and so are two frames that make a pair of eyes. */
struct PassSamples {
    std::string label;
    std::vector<double> milliseconds;
};

struct DrawerStats {
    DplFrameStats frame;                                 // the frozen baseline fills in only what it has
    std::vector<std::pair<std::string, double>> passes;  // milliseconds, in the order they ran
};

/** One renderer with the subject loaded and the views of one case. */
class Drawer {
public:
    virtual ~Drawer() = default;
    virtual Status pose(std::span<const float> rotations, const Vec3f& root) = 0;
    /** Starts a frame, as an app's thread does at display rate. */
    virtual Status draw() = 0;
    /** Waits for the frame and copies its pixels into `pictures`. */
    virtual Status read() = 0;
    virtual Result<DrawerStats> stats() = 0;
    std::vector<std::vector<uint8_t>> pictures;  // premultiplied RGBA8, one a view
};

struct Contestant {
    std::string name;    // for people, with the device
    std::string option;  // value of --renderers
    std::string whole;   // name of the same renderer with everything on; empty: this is it, or there is none
    bool frozen;         // the frozen baseline: always one sample a pixel, and its warm frames may allocate
    std::unique_ptr<Drawer> drawer;
    double loadMilliseconds = 0;
    std::vector<double> milliseconds = {}, drawMilliseconds = {}, gpuMilliseconds = {};
    std::vector<PassSamples> passes = {};
    DplFrameStats stats = {};
    uint64_t warmAllocations = 0, warmWaits = 0;  // of all warm frames
    PictureError error = {};
    double flip = 0;  // mean over the covered pixels of all views
};

/** Makes the contestant that a value of --renderers names. Unsupported: it cannot run on this machine, and the bench goes on without it. */
using ContestantMaker = std::function<Result<Contestant>(const std::string& renderer, const BenchOptions&, const BenchSubject&,
                                                         std::span<const Cameraf> views)>;

/** The renderers of the public API: software, vulkan, vulkan-quads, vulkan-tiles. */
Result<Contestant> sdkContestant(const std::string& renderer, const BenchOptions& options, const BenchSubject& subject,
                                 std::span<const Cameraf> views);

/** All of options.renderers, each with a context of its own, so that the bytes of a case are that case's alone. Prints a sentence for each
 * one that is left out. */
Result<std::vector<Contestant>> contestants(const ContestantMaker& make, const BenchOptions& options, const BenchSubject& subject,
                                            std::span<const Cameraf> views);

/** Rounds in which each contestant draws one frame; then each draws three frames without a read between them, as an app has in flight.
 *  Counts heap allocations of posing and drawing, and waits, once warm. */
Status timeFrames(std::vector<Contestant>& list, const BenchSubject& subject, uint32_t repeats,
                  const std::function<Status(double)>& progress);

/** The referee draws each view once; the last picture of each contestant is compared with it. */
Status measureErrors(std::vector<Contestant>& list, const BenchSubject& subject, std::span<const Cameraf> views,
                     const ReferenceFile& referee, const std::function<Status(double)>& progress);

/** An error that names the first contestant, the frozen baseline apart, whose warm frames allocated or waited. */
Status checkWarmFrames(const std::vector<Contestant>& list, const BenchCase& test);

double millisecondsSince(std::chrono::steady_clock::time_point start);

}  // namespace dpl
