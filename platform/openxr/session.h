// SPDX-License-Identifier: Apache-2.0
// Frames of a headset: begins and ends sessions as the runtime asks, draws a Scene into its images, submits them as a projection layer with
// depth. A lost session is torn down, and the next frame() makes a new one; the scene hears end() and begin(), avatars stay.
//
//   for (;;) switch (auto step = session.frame(scene); ...)     one call a frame
//
// No frame() that draws allocates, logs, or waits for anything but xrWaitFrame, the runtime's images and its own fences. It never sleeps.
#pragma once

#include <memory>
#include <optional>
#include <span>

#include "platform/openxr/controllers.h"
#include "platform/openxr/runtime.h"
#include "platform/openxr/scene.h"

namespace dpl::xr {

struct SessionOptions {
    float nearM = 0.1f;     // near plane of the scene's depth
    bool array = true;      // false: an image for each view, even where an array image for a group is possible
    bool quadViews = true;  // draws foveated insets too, where the runtime has them; false: two views
    bool capture = false;   // captureNextFrame() is possible
    float refreshHz = 0;    // the nearest rate that the display offers; 0: leaves it to the runtime
    /** Wished. Alpha and Additive show the real surroundings: by the blend mode of the display, or else by XR_FB_passthrough. Where neither
     *  is there, the picture is opaque. SessionImages::blend says what came of it. */
    Blend blend = Blend::Opaque;
};

/** What a call of frame() did. */
enum class Step {
    Drew,    // a picture was submitted
    Hidden,  // a frame was submitted without a picture: nobody would see it, or the head is not tracked (see lastComplaint)
    Idle,    // no session is running, or no headset is there; sleep a little and call again
    Lost,    // the session was lost; the next call makes a new one
    Ended,   // the user or requestExit() ended the session; further calls give Ended
};

/** A view as it was submitted; for tests and screenshots. */
struct CapturedView {
    uint32_t widthPx = 0, heightPx = 0;
    VkFormat format = VK_FORMAT_UNDEFINED;
    std::vector<uint8_t> colour;  // pixels of `format`, rows without padding
    std::vector<float> depthM;    // view z of the scene, metres; 0: nothing
    DplCamera camera{};
    XrPosef pose{};
    XrFovf fov{};
};

class Session {
public:
    /** The runtime must live longer. */
    Session(Runtime& runtime, const SessionOptions& options);
    ~Session();  // calls end() of the scene if a session is alive
    Session(const Session&) = delete;
    Session& operator=(const Session&) = delete;

    /** Handles events and then waits for, draws and submits one frame. `scene` must be the same object at every call and outlive the
     * session. After an error, the session is unusable: the instance or the GPU was lost, the scene failed, the runtime broke its contract,
     * or five sessions in a row were lost before they drew. The text says which. */
    Result<Step> frame(Scene& scene);
    /** Asks the runtime to end the session. Call frame() until it returns Ended. Without a session, the next frame() returns Ended. */
    void requestExit();
    /** The next drawn frame is copied; captured() has it when frame() returns Drew. That call allocates and waits. Without
     *  SessionOptions::capture, nothing is copied. */
    void captureNextFrame();
    std::span<const CapturedView> captured() const;

    /** Of the last drawn frame, in the runtime's order of views. */
    std::span<const DplCamera> cameras() const;
    const Frame& lastFrame() const;
    /** What went wrong last without stopping frames, such as "the runtime gave a view a pose that is no rotation"; "": nothing. */
    const std::string& lastComplaint() const;
    XrSessionState state() const;
    const Controllers& controllers() const;
    /** Pose of the new origin of the world in the old one, in the first frame after the user or runtime moved it; else none. Things that
     *  shall stay where they are in the room move by its inverse. */
    const std::optional<XrPosef>& originMoved() const;
    /** Measured or told by the runtime, Hz; 0: unknown. */
    float refreshHz() const;

private:
    struct Self;
    std::unique_ptr<Self> self_;
};

}  // namespace dpl::xr
