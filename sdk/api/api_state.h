// SPDX-License-Identifier: Apache-2.0
// The objects behind handles, and the helpers of every entry point: find the object, turn errors and exceptions into a DplResult. Internal
// to sdk/api.
#pragma once

#include <array>
#include <cstring>
#include <memory>
#include <mutex>
#include <new>
#include <optional>
#include <shared_mutex>
#include <string>
#include <unordered_map>
#include <vector>

#include "sdk/api/create_renderer.h"
#include "sdk/avatar/pose_trust.h"
#include "sdk/avatar/rig.h"
#include "sdk/core/result.h"
#include "sdk/draw/renderer.h"
#include "sdk/format/avatar_data.h"
#include "sdk/include/doppel/doppel.h"
#include "sdk/motion/clip_memory.h"
#include "sdk/motion/clip_mix.h"
#include "sdk/motion/face_gaze.h"
#include "sdk/motion/face_motion.h"
#include "sdk/motion/gaze.h"
#include "sdk/motion/motion_clock.h"

namespace dpl::api {

class Loader;
struct Surface;
struct VulkanSide;
struct MetalSide;

/** The object behind a DplContext. Avatars share ownership, so that context and avatars may be destroyed in any order. */
struct Context {
    std::mutex mutex;         // guards the renderer, the cameras and the avatars; a load prepares without it and holds it only to add
    std::shared_mutex loads;  // shared by loads, so that the renderer stays; alone to replace it. Locked before mutex
    bool closing = false;     // dplDestroyContext was called: no load starts any more
    std::unique_ptr<Loader> loader;      // of loads in the background; null before the first one
    std::shared_ptr<Renderer> renderer;  // null once the context is destroyed; a load that is preparing keeps it alive
    bool lent = false;                   // its device is the program's, which destroys it
    ContextRequest request;              // that it was created with
    std::string rendererName;
    DetailOptions detail;                // of dplSetDetail
    double frameBudgetMs = 0;            // of dplSetFrameBudget; 0: none
    uint64_t memoryLimit = 0;            // of dplSetMemoryLimit, bytes; 0: none
    std::vector<Cameraf> cameras;        // scratch of a draw, kept to save allocations
    std::shared_ptr<VulkanSide> vulkan;  // of a context on an app's Vulkan device (vulkan.cpp); else null
    std::shared_ptr<MetalSide> metal;    // of a context on an app's Metal device (metal.cpp); else null
    Context();
    ~Context();
};

constexpr std::array<float, 12> kStandsAtOrigin = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};  // a row-major 3×4 identity

/** The object behind a DplAvatar. context->mutex guards all that changes after loading. */
struct Avatar {
    std::shared_ptr<Context> context;
    std::shared_ptr<const AvatarData> data;  // for general splats: a name and no joints
    uint32_t splatCount = 0, shDegree = 0;   // as loaded; fewer than in the file if memory was short
    uint32_t fileSplatCount = 0, fileShDegree = 0;
    bool axesStated = true;   // by the file or the standard of its format
    Mat3d loadedFromFile{1};  // how loading turned general splats
    RenderAvatarId renderId = 0;
    Vec3f restMin{0}, restMax{0};
    Pose pose, givenPose;                                          // givenPose: scratch of dplSetPose and dplSetPoseFromClips
    MotionClock clock;                                             // of `pose`
    float clothStiffness = 1;                                      // of dplSetClothStiffness
    ExpressionWeights expression{};                                // of dplSetExpression
    FaceMotion faceMotion;                                         // of dplSetFaceMotion
    int64_t faceTimeNs = 0;                                        // the same
    FaceEyes faceEyes;                                             // of data; without expressions: nothing
    std::array<float, 12> worldFromAvatar = kStandsAtOrigin;       // as given
    Placement placement;                                           // the same
    uint32_t drawnViews = 0, drawnWidthPx = 0, drawnHeightPx = 0;  // of the last frame that belongs to this avatar; 0 views: none
    bool drawnDepth = false, drawnMeshDepth = false;
    Governor governor;                             // of the pictures that belong to this avatar
    FrameTiming timing;                            // of their last finished frame that was seen
    std::vector<std::unique_ptr<ClipData>> added;  // by dplLoadClip
    std::vector<const ClipData*> clips;            // of the file, then of `added`
    std::vector<ClipMemory> clipMemories;          // of `clips`
    ClipMix mix;                                   // keeps the memory of dplSetPoseFromClips
    std::vector<ClipLayer> layers;                 // scratch of dplSetPoseFromClips
    std::optional<GazeJoints> gazeJoints;          // found by the first dplLookAtPoint
    std::vector<Mat3x4f> transforms;               // scratch of dplGetJointPositions, dplGetNearestDistance and dplLookAtPoint
    PoseTrust trust;                               // scratch of dplGetPoseTrust
    FrameStats stats;                              // result of the last dplGetFrameStats
    std::unique_ptr<Surface> surface;              // of the calls of doppel_surface.h; null before the first
    std::vector<uint8_t> carriesSplats;            // one a triangle
    uint64_t hiddenLayers = 0;                     // a bit each
    Avatar();
    ~Avatar();

    /** `pose` with the stiffness of the clothes and the expression, which stay while poses come and go. */
    const Pose& drawnPose() {
        pose.clothStiffness = clothStiffness, pose.expression = shownExpression();
        return pose;
    }
    /** What was set, what the face does by itself, and where the pose turns the eyes. */
    ExpressionWeights shownExpression() const {
        return withGaze(faceAt(expression, faceMotion, faceTimeNs), faceEyes, pose.localRotations);
    }
    /** Replays a clip, which must stay where it is. Takes milliseconds, and needs no lock. */
    ClipMemory memoryOf(const ClipData& clip) const { return {clip, data->joints, data->correctives.motion}; }
    void addClip(const ClipData& clip, ClipMemory memory) { clips.push_back(&clip), clipMemories.push_back(std::move(memory)); }
};

/** Objects by handle. Handles are numbers that are never reused, so a stale handle is not found. Any thread. */
template <class T>
class HandleTable {
public:
    explicit HandleTable(uintptr_t first) : next_(first) {}
    uintptr_t add(std::shared_ptr<T> object) {
        std::lock_guard lock(mutex_);
        const uintptr_t handle = next_;
        next_ += 4;  // tables differ in the lowest bits, so that no handle is taken for one of another kind
        objects_.emplace(handle, std::move(object));
        return handle;
    }
    std::shared_ptr<T> find(uintptr_t handle) const {
        std::lock_guard lock(mutex_);
        const auto at = objects_.find(handle);
        return at == objects_.end() ? nullptr : at->second;
    }
    std::shared_ptr<T> take(uintptr_t handle) {
        std::lock_guard lock(mutex_);
        const auto at = objects_.find(handle);
        if (at == objects_.end()) return nullptr;
        auto object = std::move(at->second);
        objects_.erase(at);
        return object;
    }

private:
    mutable std::mutex mutex_;
    std::unordered_map<uintptr_t, std::shared_ptr<T>> objects_;
    uintptr_t next_;
};

HandleTable<Context>& contexts();
HandleTable<Avatar>& avatars();

Result<std::shared_ptr<Context>> contextOf(DplContext handle);
Result<std::shared_ptr<Avatar>> avatarOf(DplAvatar handle);

/** Whether the context, whose mutex is locked, can draw and load. InvalidArgument: it was destroyed. Device: its device was lost. */
Status checkUsable(const Context& context);

/** Sets the level of detail of the next draw, which belongs to `first`: that of dplSetDetail, within the frame budget. Call it before each
 *  draw, with the context locked. Neither waits nor allocates. */
void setDetailOfDraw(Context& context, Avatar& first);

/** InvalidArgument for general splats, which have no joints. */
Status checkPosable(const Avatar& avatar);

/** Clip `clip` of the avatar, whose context must be locked. NotFound: there is none. */
Result<const ClipData*> clipOf(const Avatar& avatar, uint32_t clip);

/** Stores the error for dplGetLastError, logs it if it is a caller's mistake (InvalidArgument), and returns its public code. */
DplResult report(const char* function, const Error& error) noexcept;

/** Runs `body`, which returns a Status. Exceptions become errors. function: name of the entry point, for the error text. */
template <class Body>
DplResult guarded(const char* function, Body&& body) noexcept {
    try {
        const Status status = body();
        return status ? DPL_OK : report(function, status.error());
    } catch (const std::bad_alloc&) {
        return report(function, Error{Code::OutOfMemory, {}});
    } catch (const std::exception& e) {
        return report(function, Error{Code::Internal, e.what()});
    } catch (...) {
        return report(function, Error{Code::Internal, {}});
    }
}

constexpr uint32_t kMaxStructSize = 4096;  // larger than every struct of the API: a larger structSize was not initialised

/** Reads a caller's struct, which may be of an older or newer version; fields that it lacks are 0. `smallest`: size of its first version.
 */
template <class T>
Result<T> readStruct(const void* from, const char* what, size_t smallest = sizeof(T)) {
    if (from == nullptr) return fail(Code::InvalidArgument, "{} is NULL", what);
    uint32_t size;
    std::memcpy(&size, from, sizeof size);
    if (size < smallest || size > kMaxStructSize)
        return fail(Code::InvalidArgument, "structSize of {} is {}; set it to sizeof the struct ({})", what, size, sizeof(T));
    T value{};
    std::memcpy(&value, from, std::min<size_t>(size, sizeof(T)));
    return value;
}

/** Element i of a caller's array, whose stride is the structSize of element 0. `smallest`: size of its first version. */
template <class T>
Result<T> element(const T* array, size_t i, const char* what, size_t smallest = sizeof(T)) {
    DPL_TRY(const T first, readStruct<T>(array, what, smallest));
    DPL_TRY(const T value, readStruct<T>(reinterpret_cast<const uint8_t*>(array) + i * first.structSize, what, smallest));
    if (value.structSize != first.structSize) return fail(Code::InvalidArgument, "elements of {} have different structSize", what);
    return value;
}

/** Copies `value` into the caller's struct, but neither its structSize nor bytes beyond the caller's structSize. */
template <class T>
Status writeStruct(T* to, T value, const char* what, size_t smallest = sizeof(T)) {
    DPL_TRY(const T given, readStruct<T>(to, what, smallest));
    value.structSize = given.structSize;
    std::memcpy(static_cast<void*>(to), &value, std::min<size_t>(given.structSize, sizeof(T)));
    return {};
}

}  // namespace dpl::api
