// SPDX-License-Identifier: Apache-2.0
// The renderers that a bench compares. All hold the same subject and draw the same views in turns, so other work on the machine slows them
// equally. `doppel bench` compares the renderers that users can choose; tools/bench/frames adds renderers with an optimisation switched
// off.
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
    std::string fill = "auto";  // fill of the renderer "vulkan"
    std::string clip, animation;
    double timeS = 0;
    uint32_t repeats = 11, threadCount = 0;
    std::string axes;  // empty: as the file states
    bool withoutReference = false;
    uint32_t shrink = 1;  // divides the sides of all pictures
};

struct BenchCase {
    const char* name;
    uint32_t widthPx, heightPx, viewCount;
    bool portrait = false;  // head and shoulders only
};

/** The avatar, its pose and its sizes. The pose is computed once, in a separate context, and given to every contestant. */
struct BenchSubject {
    std::vector<uint8_t> bytes;
    doppel::Context context;
    doppel::Avatar avatar;
    DplAvatarInfo info;  // its name pointer is valid as long as `avatar`
    std::vector<float> rotations;
    Vec3f root{0};
    Mat3d turnOnLoading{1};  // see DplFileAxes

    static Result<BenchSubject> load(const BenchOptions& options);
    std::vector<Cameraf> views(const BenchCase& test, const std::string& axes) const;
};

/** Times of one pass in milliseconds, one sample per frame. The rounds of the sort are summed. If each eye is a frame of its own, both
 * frames are summed. */
struct PassSamples {
    std::string label;
    std::vector<double> milliseconds;
};

struct DrawerStats {
    DplFrameStats frame;                                 // the frozen baseline fills in only the fields it knows
    std::vector<std::pair<std::string, double>> passes;  // label and milliseconds, in the order they ran
};

/** One renderer with the subject loaded and the views of one case. */
class Drawer {
public:
    virtual ~Drawer() = default;
    virtual Status pose(std::span<const float> rotations, const Vec3f& root) = 0;
    /** Starts a frame without waiting for it. */
    virtual Status draw() = 0;
    /** Waits for the frame and copies its pixels into `pictures`. */
    virtual Status read() = 0;
    virtual Result<DrawerStats> stats() = 0;
    std::vector<std::vector<uint8_t>> pictures;  // premultiplied RGBA8, one per view
};

struct Contestant {
    std::string name;    // display name, with the device
    std::string option;  // value of --renderers
    bool frozen;         // the frozen baseline: always one sample per pixel; its warm frames may allocate
    std::unique_ptr<Drawer> drawer;
    double loadMilliseconds = 0;
    std::vector<double> milliseconds = {}, drawMilliseconds = {}, gpuMilliseconds = {};
    std::vector<PassSamples> passes = {};
    DplFrameStats stats = {};
    uint64_t warmAllocations = 0, warmWaits = 0;  // sums over all warm frames
    PictureError error = {};
    double flip = 0;  // mean FLIP over the covered pixels of all views
};

/** Creates the contestant that a value of --renderers names. Returns Unsupported if it cannot run on this machine; the bench then goes on
 *  without it. */
using ContestantMaker = std::function<Result<Contestant>(const std::string& renderer, const BenchOptions&, const BenchSubject&,
                                                         std::span<const Cameraf> views)>;

/** The renderers of the public API: software, vulkan, vulkan-quads, vulkan-tiles. */
Result<Contestant> sdkContestant(const std::string& renderer, const BenchOptions& options, const BenchSubject& subject,
                                 std::span<const Cameraf> views);

/** Creates all of options.renderers. Each has its own context, so its memory figures hold only this case. Prints a sentence for each
 * renderer that is left out. */
Result<std::vector<Contestant>> contestants(const ContestantMaker& make, const BenchOptions& options, const BenchSubject& subject,
                                            std::span<const Cameraf> views);

/** Runs rounds in which each contestant draws one frame. Then each contestant draws three frames without a read between them, as an app
 * with three frames in flight does. After the warm-up, counts waits and the heap allocations of posing and drawing. */
Status timeFrames(std::vector<Contestant>& list, const BenchSubject& subject, uint32_t repeats,
                  const std::function<Status(double)>& progress);

/** Draws each view once with the referee and compares each contestant's last picture with it. */
Status measureErrors(std::vector<Contestant>& list, const BenchSubject& subject, std::span<const Cameraf> views,
                     const ReferenceFile& referee, const std::function<Status(double)>& progress);

/** Returns an error that names the first contestant whose warm frames allocated or waited. Skips the frozen baseline. */
Status checkWarmFrames(const std::vector<Contestant>& list, const BenchCase& test);

double millisecondsSince(std::chrono::steady_clock::time_point start);

}  // namespace dpl
