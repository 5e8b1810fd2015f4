// SPDX-License-Identifier: Apache-2.0
// Posed splats in buffers of an app that lends its device: frames of their own, which end without a picture.
//
//   pose ─► skin ─► triangles ─► write ─► rows of the app's buffer
//
// They pose the mesh anew, because what a picture has left of it is culled for its views. All layouts and eyes use one recording, which
// reads them from a uniform block.
#pragma once

#include <map>
#include <optional>

#include "sdk/core/function_ref.h"
#include "sdk/math/sh_rotation.h"
#include "sdk/render/avatar_store.h"
#include "sdk/render/posed_subject.h"

namespace dpl {

/** What is written of an avatar, and how its rows lie in the app's buffer. */
struct SplatWrite {
    Drawn what;
    uint32_t budget = 0;                   // most splats, but at least one a group; 0: all
    uint32_t shDegree = 0;                 // of SH
    std::optional<Vec3f> eye;              // world; none: no gate, and the colour is that of SH band 0
    std::span<const gpu::uvec4> elements;  // as WriteData
};

/** The frame of the app that it becomes part of. */
struct AppWrite {
    uint32_t slot = 0;
    uint64_t joined = 0;  // AppBackend::joinSlot
    AppCommands commands;
    FunctionRef<Status(FrameId frame, BufferId rows)> lend;  // binds the app's buffer in place of `rows`
};

/** Most writes of one avatar in one frame of the app: beyond it, the app has forgotten to begin its frames. */
constexpr uint32_t kMostWritesAFrame = 16;

/** Backend and store must live longer. One thread at a time. */
class SplatWriter {
public:
    SplatWriter(Backend& backend, const AvatarStore& store) : backend_(backend), store_(store) {}
    ~SplatWriter();
    SplatWriter(const SplatWriter&) = delete;
    SplatWriter& operator=(const SplatWriter&) = delete;

    /** How many splats a budget writes. Allocates for a budget that is new; the last four of an avatar are kept. */
    Result<uint32_t> rows(RenderAvatarId avatar, uint32_t budget);
    /** Encodes a write. Allocates where an avatar is written for the first time in a slot, or once more often in a frame than before, or
     *  with another budget; waits for nothing. InvalidArgument: more than kMostWritesAFrame of the avatar. */
    Status encode(const SplatWrite& write, const AppWrite& app);
    void remove(RenderAvatarId avatar);

private:
    struct Level {  // of detail
        explicit Level(Backend& backend) : buffers(backend) {}
        uint32_t budget = 0, rows = 0, keptRows = 0;  // keptRows: 0 where all splats are written
        SplatDetail detail;
        BufferId kept;
        DeviceBuffers buffers;
        uint64_t lastUse = 0;
    };
    struct Recording {  // of one write of a frame; its buffers are its own, as the CPU writes them while other frames run
        BufferId frame, palette, data, rows;
        FrameId recorded;     // none: not recorded
        uint32_t budget = 0;  // that it was recorded for
    };
    struct Slot {
        uint64_t joined = 0;  // of `used`
        uint32_t used = 0;    // recordings that the app's frame has
        std::vector<Recording> recordings;
    };
    struct Output {  // of an avatar
        explicit Output(Backend& backend) : buffers(backend) {}
        BufferId counts;  // that the passes before add to; nobody reads them
        std::vector<Level> levels;
        Slot slots[kAppSlots];
        DeviceBuffers buffers;
    };

    Output& outputOf(RenderAvatarId avatar);
    Result<Level*> levelOf(Output& output, const LoadedSubject& subject, uint32_t budget);
    Result<Recording*> recordingOf(Output& output, const LoadedSubject& subject, const Level& level, const AppWrite& app);
    Status record(const Output& output, const LoadedSubject& subject, const Level& level, Recording& recording);
    void fill(const Recording& recording, const LoadedSubject& subject, const Level& level, const SplatWrite& write);
    void forget(Output& output, uint32_t budget);
    void free(Output& output);

    Backend& backend_;
    const AvatarStore& store_;
    ShRotator rotator_;
    std::map<RenderAvatarId, Output> outputs_;
    DrawnSubject posed_;  // scratch
    uint64_t uses_ = 0;
};

}  // namespace dpl
