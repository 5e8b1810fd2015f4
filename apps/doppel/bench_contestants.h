// SPDX-License-Identifier: Apache-2.0
// Who races in `doppel bench`: today's renderers, whole or with something switched off, and the frozen plain frame. They draw the same
// subject in turns, so that a busy machine is busy for all.
#pragma once

#include <doppel/doppel.hpp>

#include <filesystem>
#include <functional>
#include <memory>
#include <optional>

#include "apps/doppel/frame_model.h"
#include "sdk/core/result.h"
#include "sdk/math/camera.h"
#include "tests/reference/reference_file.h"

namespace dpl {

struct BenchOptions {
    std::filesystem::path avatar, jsonFile, plotFile;
    std::vector<std::string> renderers;  // of benchRenderers()
    std::string fill = "auto";
    std::string clip;
    double timeS = 0;
    uint32_t repeats = 11, threadCount = 0;
    std::string axes = "y-up";
    bool withoutReference = false;
    ModelMachine model;
};

struct BenchCase {
    const char* name;
    uint32_t widthPx, heightPx, viewCount;
    bool portrait = false;  // head and shoulders only
};

/** Values of --renderers, and those that race unless it is given. */
const std::vector<std::string>& benchRenderers();
std::vector<std::string> defaultBenchRenderers();

/** The avatar, its pose and what it looks like: of a context of its own, so that all who race are told the same. */
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

/** Times of one pass, in milliseconds, a sample a frame; rounds of the sort, and both eyes of a pair of frames, are summed. */
struct PassSamples {
    std::string label;
    std::vector<double> milliseconds;
};

struct DrawerStats {
    DplFrameStats frame;                                 // the plain frame fills in what it has
    std::vector<std::pair<std::string, double>> passes;  // milliseconds, in the order they ran
};

/** One renderer with the subject loaded and the views of one case. */
class Drawer {
public:
    virtual ~Drawer() = default;
    virtual Status pose(std::span<const float> rotations, const Vec3f& root) = 0;
    /** Starts a frame, as an app's thread does at display rate. */
    virtual Status draw() = 0;
    /** Waits for it: its pixels are in pictures. */
    virtual Status read() = 0;
    virtual Result<DrawerStats> stats() = 0;
    std::vector<std::vector<uint8_t>> pictures;  // premultiplied RGBA8, one a view
};

/** What was switched off to be measured. */
struct SwitchedOff {
    const char* renderer;  // of --renderers
    uint32_t flags;
    const char* label;  // behind the renderer's name
    bool stereoOnly = false;
    std::optional<DplFill> fill = {};  // else as --fill says, quads for auto
};

struct Contestant {
    std::string name;
    std::string option;          // of --renderers
    std::string whole;           // the renderer's name without what is switched off
    const SwitchedOff* without;  // none: everything is on, or it is the plain frame
    bool plain;                  // the frozen baseline
    std::unique_ptr<Drawer> drawer;
    double loadMilliseconds = 0;
    std::vector<double> milliseconds, drawMilliseconds, gpuMilliseconds;
    std::vector<PassSamples> passes;
    DplFrameStats stats{};
    uint64_t warmAllocations = 0, warmWaits = 0;  // of all warm frames
    PictureError error;
    double flip = 0;  // of covered pixels, mean of the views
};

/** A context of its own for each case, so that its bytes are those of the case. Left out with a sentence: renderers that the machine does
 * not have, and those whose device cannot hold the avatar. */
Result<std::vector<Contestant>> contestants(const BenchOptions& options, const BenchSubject& subject, const BenchCase& test,
                                            std::span<const Cameraf> views);

/** Rounds in which everybody draws one frame, then for each three frames without a read between them, as an app has in flight. Counts heap
 *  allocations of posing and drawing, and waits, once warm. */
Status timeFrames(std::vector<Contestant>& list, const BenchSubject& subject, uint32_t repeats,
                  const std::function<Status(double)>& progress);

/** The referee draws each view once; everybody's last picture is compared with it. */
Status measureErrors(std::vector<Contestant>& list, const BenchSubject& subject, std::span<const Cameraf> views,
                     const ReferenceFile& referee, const std::function<Status(double)>& progress);

/** An error that names the first of today's renderers whose warm frames allocated or waited. */
Status checkWarmFrames(const std::vector<Contestant>& list, const BenchCase& test);

}  // namespace dpl
