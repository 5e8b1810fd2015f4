// SPDX-License-Identifier: Apache-2.0
// The plain frame for programs: an avatar file or general splats drawn as they were before any optimisation (README.md).
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
    std::string label;  // as today's pass of that work is called
    double milliseconds = 0;
};

struct PlainStats {
    uint32_t splatsDrawn = 0;                  // of the eye that sees most
    uint64_t residentBytes = 0;                // on the device
    uint64_t avatarBytes = 0, splatBytes = 0;  // as in DplFrameStats: the avatar with its posing data on the CPU; its splats alone
    std::vector<PlainPassTime> passes;         // of the frames read last, in the order they ran, eye after eye; empty without timestamps
};

/** How it fills pixels: quads blended in f16, as the plain frame did, or the first version of the tiles behind the same records and sort.
 */
enum class PlainFill { Quads, Tiles };

/** One thread at a time. */
class PlainFile {
public:
    /** On the best Vulkan device, a software one included, as DPL_RENDERER_VULKAN chooses. The bytes may be freed afterwards. Errors of
     * readAvatar and readSplats; Unsupported: no Vulkan on this machine, or a device that cannot hold the splats as floats. */
    static Result<PlainFile> open(std::span<const uint8_t> bytes, PlainFill fill = PlainFill::Quads);
    PlainFile(PlainFile&&) noexcept;
    PlainFile& operator=(PlainFile&&) noexcept;
    ~PlainFile();

    /** "vulkan: DEVICE (plain float)", or "(plain float, tiles)". */
    const std::string& name() const { return name_; }

    /** rotations: xyzw a joint, as dplGetPose gives them; general splats ignore the pose. One or two views of equal size. Starts
     * the frames. */
    Status draw(std::span<const float> rotations, const Vec3f& rootTranslation, std::span<const Cameraf> views);
    /** Waits, and copies one picture a view out: RGBA8 premultiplied, display-referred, top row first. Unsupported: the lists of tiles
     * could not hold the frame. */
    Status read(std::span<std::vector<uint8_t>> pictures);

    PlainStats stats() const;

private:
    struct State;
    PlainFile(std::unique_ptr<State> state, std::string name);
    std::unique_ptr<State> state_;
    std::string name_;
};

}  // namespace dpl
