// SPDX-License-Identifier: Apache-2.0
// The plain frame for programs: draws an avatar file or general splats as the renderer did before any optimisation (README.md).
//
//   auto plain = PlainFile::open(bytes);
//   plain->draw(rotations, root, views);
//   plain->read(pixels);
#pragma once

#include <memory>
#include <span>
#include <string>
#include <vector>

#include "sdk/core/result.h"
#include "sdk/math/camera.h"

namespace dpl {

struct PlainPassTime {
    std::string label;  // same label as the pass of the current frame that does this work
    double milliseconds = 0;
};

struct PlainStats {
    uint32_t splatsDrawn = 0;                  // of the eye that draws most
    uint64_t residentBytes = 0;                // on the device
    uint64_t avatarBytes = 0, splatBytes = 0;  // as in DplFrameStats: the avatar including its posing data on the CPU; its splats alone
    std::vector<PlainPassTime>
        passes;  // of the frames read last, in the order they ran, one eye after the other; empty if the device has no timestamps
};

/** How pixels are filled: by quads blended in f16, or by the first version of compute tiles. Both use the same records and sort. */
enum class PlainFill { Quads, Tiles };

/** Not thread-safe: use it from one thread at a time. */
class PlainFile {
public:
    /** Opens the file on the Vulkan device that DPL_RENDERER_VULKAN would choose, which may be a software one. The bytes may be freed
     *  afterwards. Errors: those of readAvatar and readSplats; Unsupported if there is no Vulkan device or it cannot hold the splats as
     *  floats. */
    static Result<PlainFile> open(std::span<const uint8_t> bytes, PlainFill fill = PlainFill::Quads);
    PlainFile(PlainFile&&) noexcept;
    PlainFile& operator=(PlainFile&&) noexcept;
    ~PlainFile();

    /** "vulkan: DEVICE (plain float)", or "(plain float, tiles)". */
    const std::string& name() const { return name_; }

    /** Starts the frames of one or two views of equal size. rotations: one xyzw quaternion per joint, as dplGetPose returns them; general
     *  splats ignore the pose. */
    Status draw(std::span<const float> rotations, const Vec3f& rootTranslation, std::span<const Cameraf> views);
    /** Waits for the frames and copies out one picture per view: RGBA8 premultiplied, display-referred, top row first. Returns Unsupported
     *  if the tile lists could not hold the frame. */
    Status read(std::span<std::vector<uint8_t>> pictures);

    PlainStats stats() const;

private:
    struct State;
    PlainFile(std::unique_ptr<State> state, std::string name);
    std::unique_ptr<State> state_;
    std::string name_;
};

}  // namespace dpl
