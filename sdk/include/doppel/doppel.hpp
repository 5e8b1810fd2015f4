// SPDX-License-Identifier: Apache-2.0
// C++20 wrapper of doppel.h: owns handles, takes spans and forwards to the C functions. Header only. It throws nothing itself; its
// std::string and std::vector may throw std::bad_alloc.
//
//   auto context = doppel::Context::create();
//   if (!context) return report(context.error());
//   auto avatar = context->loadAvatarFile("avatar.glb");  // Result<Avatar>, move-only owner
//   avatar->setPoseFromClip(0, 1.25);
//   auto camera = doppel::Camera::lookAt({.eye = {0, 1, 3}, .target = {0, 1, 0}, .fovYRad = 0.8f, .widthPx = 512, .heightPx = 768});
//   avatar->render(*camera, {&image, 1});
//
// Threads, units and errors: as in doppel.h.
#pragma once

// Compilers whose C++20 is young give a number between those of C++17 and C++20. MSVC gives it in _MSVC_LANG.
#if defined(_MSVC_LANG) ? _MSVC_LANG <= 201703L : __cplusplus <= 201703L
#error "doppel.hpp needs C++20: compile with -std=c++20 (MSVC: /std:c++20), or include doppel.h, which needs C99"
#else  // without the rest of this header, whose errors would hide that one

#include <array>
#include <cmath>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <doppel/doppel.h>
#include <doppel/doppel_convert.h>

namespace doppel {

/** Why a call failed. */
struct Error {
    DplResult code = DPL_ERROR_INTERNAL;
    std::string message;  // a sentence for a human
};

/** `code` with the text of the last call that failed on this thread. */
inline Error lastError(DplResult code) {
    return {code, dplGetLastError()};
}

/** A value or an error. Test it before use: reading the value of an error, or the error of a value, is undefined. */
template <class T>
class [[nodiscard]] Result {
public:
    Result(T value) : value_(std::move(value)) {}
    Result(Error error) : error_(std::move(error)) {}
    explicit operator bool() const { return value_.has_value(); }
    T& operator*() { return *value_; }
    const T& operator*() const { return *value_; }
    T* operator->() { return &*value_; }
    const T* operator->() const { return &*value_; }
    const Error& error() const { return error_; }

private:
    std::optional<T> value_;
    Error error_;
};

/** Success or an error. */
template <>
class [[nodiscard]] Result<void> {
public:
    Result() = default;
    Result(Error error) : error_(std::move(error)) {}
    explicit operator bool() const { return !error_.has_value(); }
    const Error& error() const { return *error_; }

private:
    std::optional<Error> error_;
};

/** What functions without a value return. */
using Status = Result<void>;

/** Version of the loaded library; see dplGetVersion. */
inline uint32_t version() {
    return dplGetVersion();
}
/** Name of a result code; see dplGetResultName. */
inline const char* resultName(DplResult result) {
    return dplGetResultName(result);
}

/** The Status of a C call that has just returned `result` on this thread. */
inline Status status(DplResult result) {
    if (result == DPL_OK) return {};
    return lastError(result);
}

/** Sends the log of the process to `callback`; see dplSetLogCallback. */
inline Status setLogCallback(DplLogCallback callback, void* user = nullptr) {
    return status(dplSetLogCallback(callback, user));
}

/** Calls get(arguments..., &out) with a struct of type T whose structSize is set, and returns the struct. */
template <class T, class Get, class... Arguments>
Result<T> filled(Get get, Arguments... arguments) {
    T out{};
    out.structSize = sizeof out;
    if (const DplResult r = get(arguments..., &out); r != DPL_OK) return lastError(r);
    return out;
}

/** How Camera::lookAt aims; see dplCameraLookAt. What is left out is an error, but for up. */
struct LookAt {
    std::array<float, 3> eye{}, target{};  // metres, in the world
    std::array<float, 3> up{0, 1, 0};      // of any length; not parallel to the view direction
    float fovYRad = 0;                     // vertical field of view
    uint32_t widthPx = 0, heightPx = 0;
};

/** A DplCamera whose structSize is set. */
struct Camera : DplCamera {
    Camera() : DplCamera{} { structSize = sizeof(DplCamera); }
    /** A camera at `how.eye` that looks at `how.target`. */
    static Result<Camera> lookAt(const LookAt& how) {
        return filled<Camera>(dplCameraLookAt, how.eye.data(), how.target.data(), how.up.data(), how.fovYRad, how.widthPx, how.heightPx);
    }
    /** Functions that take views take a camera as one view. */
    operator std::span<const DplCamera>() const { return {static_cast<const DplCamera*>(this), 1}; }
};
static_assert(sizeof(Camera) == sizeof(DplCamera));

/** Owns one tracker, which it destroys. Move-only, as Avatar. It may outlive its avatar, but then poses nothing. */
class Tracker {
public:
    /** Takes ownership of `handle`. */
    explicit Tracker(DplTracker handle) : handle_(handle) {}
    Tracker(Tracker&& other) noexcept : handle_(std::exchange(other.handle_, nullptr)) {}
    Tracker& operator=(Tracker&& other) noexcept {
        std::swap(handle_, other.handle_);
        return *this;
    }
    ~Tracker() { dplDestroyTracker(handle_); }

    DplTracker handle() const { return handle_; }
    /** One frame of the platform; see dplTrackFrame. rotations: 4 floats a joint, or empty. positions: 3 a joint. confidence: 1 a joint, or
     *  empty. */
    Status frame(int64_t timeNs, std::span<const float> rotations, std::span<const float> positions,
                 std::span<const float> confidence = {}) {
        const size_t count = positions.size() / 3;
        if (positions.size() != 3 * count || (!rotations.empty() && rotations.size() != 4 * count) ||
            (!confidence.empty() && confidence.size() != count))
            return Error{DPL_ERROR_INVALID_ARGUMENT, "a frame has 3 numbers a joint for positions, 4 for rotations and 1 for confidence"};
        DplTrackFrame given{};
        given.structSize = sizeof given, given.jointCount = uint32_t(count), given.timeNs = timeNs;
        given.rotations = rotations.empty() ? nullptr : rotations.data(), given.positions = positions.data();
        given.confidence = confidence.empty() ? nullptr : confidence.data();
        return status(dplTrackFrame(handle_, &given));
    }
    /** Poses the avatar for a picture that is shown at displayTimeNs. */
    Result<DplTrackerStatus> setPose(int64_t displayTimeNs) {
        return filled<DplTrackerStatus>(dplSetPoseFromTracker, handle_, displayTimeNs);
    }

private:
    DplTracker handle_ = nullptr;
};

/** Name of a joint of a tracker's format in the platform's words; see dplGetTrackJointName. */
inline Result<const char*> trackJointName(DplTrackFormat format, uint32_t joint) {
    const char* name = nullptr;
    if (const DplResult r = dplGetTrackJointName(format, joint, &name); r != DPL_OK) return lastError(r);
    return name;
}

/** How Avatar::lookAtPoint looks; see DplGaze. Its weights are the usual ones. */
struct Gaze : DplGaze {
    /** targetM: metres, in the space of the avatar's pose. */
    explicit Gaze(const std::array<float, 3>& targetM) : DplGaze{} {
        structSize = sizeof(DplGaze), headWeight = 0.7f, eyeWeight = 1;
        for (size_t axis = 0; axis < 3; ++axis) target[axis] = targetM[axis];
    }
};

/** A layer for Avatar::setPoseFromClips; see DplClipLayer. */
inline DplClipLayer clipLayer(uint32_t clip, double timeS, float weight = 1, uint32_t joint = 0, uint32_t flags = DPL_LAYER_LOOP) {
    DplClipLayer layer{};
    layer.structSize = sizeof layer, layer.clip = clip, layer.timeS = timeS;
    layer.weight = weight, layer.joint = joint, layer.flags = flags;
    return layer;
}

/** Owns one avatar, which it destroys. Move-only: construction by move leaves the source empty, assignment by move swaps. */
class Avatar {
public:
    /** Takes ownership of `handle`, which was loaded with `context`. The context is not owned. */
    Avatar(DplContext context, DplAvatar handle) : context_(context), handle_(handle) {}
    Avatar(Avatar&& other) noexcept : context_(other.context_), handle_(std::exchange(other.handle_, nullptr)) {}
    Avatar& operator=(Avatar&& other) noexcept {
        std::swap(context_, other.context_);
        std::swap(handle_, other.handle_);
        return *this;
    }
    ~Avatar() { dplDestroyAvatar(handle_); }

    DplAvatar handle() const { return handle_; }

    Result<DplAvatarInfo> info() const { return filled<DplAvatarInfo>(dplGetAvatarInfo, handle_); }
    Result<DplFileAxes> fileAxes() const { return filled<DplFileAxes>(dplGetFileAxes, handle_); }
    Result<DplJointInfo> joint(uint32_t index) const { return filled<DplJointInfo>(dplGetJointInfo, handle_, index); }
    Result<uint32_t> findJoint(const std::string& name) const {
        uint32_t index = 0;
        if (const DplResult r = dplFindJoint(handle_, name.c_str(), &index); r != DPL_OK) return lastError(r);
        return index;
    }
    Result<DplClipInfo> clip(uint32_t index) const { return filled<DplClipInfo>(dplGetClipInfo, handle_, index); }
    /** Where it stands, until changed: a row-major 3×4 matrix of a rotation, one scale and a translation. See dplSetTransform. */
    Status setTransform(std::span<const float, 12> worldFromAvatar) { return status(dplSetTransform(handle_, worldFromAvatar.data())); }
    Result<std::array<float, 12>> transform() const {
        std::array<float, 12> worldFromAvatar{};
        if (const DplResult r = dplGetTransform(handle_, worldFromAvatar.data()); r != DPL_OK) return lastError(r);
        return worldFromAvatar;
    }
    /** rotations: 4 floats (x, y, z, w) per joint, local. rootTranslation: 3 floats, metres, or empty for zero. */
    Status setPose(std::span<const float> rotations, std::span<const float> rootTranslation = {}) {
        if (Status fits = checkPoseSizes(rotations.size(), rootTranslation.size()); !fits) return fits;
        return status(dplSetPose(handle_, rotations.data(), uint32_t(rotations.size() / 4),
                                 rootTranslation.empty() ? nullptr : rootTranslation.data()));
    }
    /** The same for a picture that is shown at timeNs, ns of any one clock: clothes then remember. See dplSetPoseAtTime. */
    Status setPose(std::span<const float> rotations, std::span<const float> rootTranslation, int64_t timeNs) {
        if (Status fits = checkPoseSizes(rotations.size(), rootTranslation.size()); !fits) return fits;
        return status(dplSetPoseAtTime(handle_, rotations.data(), uint32_t(rotations.size() / 4),
                                       rootTranslation.empty() ? nullptr : rootTranslation.data(), timeNs));
    }
    /** Clothes forget: they are those of the current pose alone. */
    Status settle() { return status(dplSettle(handle_)); }
    /** What the clothes remember in the current pose, and its time. */
    Result<std::vector<uint8_t>> motionState() const {
        size_t size = 0;
        if (const DplResult r = dplGetMotionState(handle_, nullptr, 0, &size); r != DPL_OK) return lastError(r);
        std::vector<uint8_t> state(size);
        if (const DplResult r = dplGetMotionState(handle_, state.data(), state.size(), &size); r != DPL_OK) return lastError(r);
        return state;
    }
    /** Restores motionState() of an avatar of the same file. */
    Status setMotionState(std::span<const uint8_t> state) { return status(dplSetMotionState(handle_, state.data(), state.size())); }
    /** The current pose: 4 floats a joint, and the root translation. Either may be empty. */
    Status pose(std::span<float> rotations, std::span<float> rootTranslation = {}) const {
        if (Status fits = checkPoseSizes(rotations.size(), rootTranslation.size()); !fits) return fits;
        return status(dplGetPose(handle_, rotations.empty() ? nullptr : rotations.data(), uint32_t(rotations.size() / 4),
                                 rootTranslation.empty() ? nullptr : rootTranslation.data()));
    }
    /** timeS: seconds from the start of the clip; it wraps around if `loop`, else it is clamped. */
    Status setPoseFromClip(uint32_t clip, double timeS, bool loop = true) {
        return status(dplSetPoseFromClip(handle_, clip, timeS, loop ? DPL_TRUE : DPL_FALSE));
    }
    /** Retargets a BVH or glTF motion onto this avatar. Returns the index of the new clip. */
    Result<uint32_t> loadClip(std::span<const uint8_t> bytes, const DplClipOptions* options = nullptr) {
        uint32_t index = 0;
        if (const DplResult r = dplLoadClip(handle_, bytes.data(), bytes.size(), options, &index); r != DPL_OK) return lastError(r);
        return index;
    }
    /** Mixes clips for a picture that is shown at timeNs, ns of any one clock: cross-fades, and layers over a part of the body. See
     *  dplSetPoseFromClips; Player makes layers. */
    Status setPoseFromClips(std::span<const DplClipLayer> layers, int64_t timeNs) {
        return status(dplSetPoseFromClips(handle_, layers.data(), uint32_t(layers.size()), timeNs));
    }
    /** Moves `layer` so that it goes on from where `before` stands; see dplJoinClipLayer. */
    Status joinClipLayer(const DplClipLayer& before, DplClipLayer& layer) const {
        return status(dplJoinClipLayer(handle_, &before, &layer));
    }
    /** Turns neck, head and eyes of the current pose towards a point. Once after each pose, before drawing; see dplLookAtPoint. */
    Status lookAtPoint(const DplGaze& gaze) { return status(dplLookAtPoint(handle_, &gaze)); }
    /** How far the current pose lies from the training poses. distances: one for each joint, or empty. */
    Result<DplPoseTrust> poseTrust(std::span<float> distances = {}) const {
        DplPoseTrust trust{};
        trust.structSize = sizeof trust;
        const DplResult r = dplGetPoseTrust(handle_, &trust, distances.empty() ? nullptr : distances.data(), uint32_t(distances.size()));
        if (r != DPL_OK) return lastError(r);
        return trust;
    }
    /** Turns joints back until none is farther from its training than `limit` standard deviations. */
    Status holdPose(float limit) { return status(dplHoldPose(handle_, limit)); }
    /** A tracker that poses this avatar. rest: 4 and 3 floats a joint, or empty; flags: DplTrackerFlag. See dplCreateTracker. */
    Result<Tracker> createTracker(DplTrackFormat format, uint32_t flags = 0, std::span<const float> restRotations = {},
                                  std::span<const float> restPositions = {}) const {
        if (restRotations.size() / 4 != restPositions.size() / 3)
            return Error{DPL_ERROR_INVALID_ARGUMENT, "a rest pose has 4 floats a joint for rotations and 3 for positions"};
        DplTrackerInfo wanted{};
        wanted.structSize = sizeof wanted, wanted.format = format, wanted.flags = flags;
        wanted.restCount = uint32_t(restPositions.size() / 3);
        wanted.restRotations = restRotations.data(), wanted.restPositions = restPositions.data();
        DplTracker made = nullptr;
        if (const DplResult r = dplCreateTracker(handle_, &wanted, &made); r != DPL_OK) return lastError(r);
        return Tracker(made);
    }
    /** World positions of all joints in the current pose and transform, 3 floats each, metres. */
    Result<std::vector<float>> jointPositions() const {
        auto about = info();
        if (!about) return about.error();
        std::vector<float> positions(size_t(about->jointCount) * 3);
        if (const DplResult r = dplGetJointPositions(handle_, positions.data(), about->jointCount); r != DPL_OK) return lastError(r);
        return positions;
    }
    /** How finely the scan shows the surface of a joint; all 0 without a capture map. */
    Result<DplCaptureDetail> captureDetail(uint32_t joint) const { return filled<DplCaptureDetail>(dplGetCaptureDetail, handle_, joint); }
    /** How near a camera may come before it magnifies the scan's finest details more than so many times; metres, 0 without a capture map.
     *  point, eye: 3 floats, metres. */
    Result<float> nearestDistance(std::span<const float, 3> point, std::span<const float, 3> eye, float focalPx,
                                  float magnification) const {
        float distanceM = 0;
        if (const DplResult r = dplGetNearestDistance(handle_, point.data(), eye.data(), focalPx, magnification, &distanceM); r != DPL_OK)
            return lastError(r);
        return distanceM;
    }
    Result<DplFrameStats> frameStats() const { return filled<DplFrameStats>(dplGetFrameStats, handle_); }
    Result<DplPassTime> passTime(uint32_t pass) const { return filled<DplPassTime>(dplGetPassTime, handle_, pass); }
    /** Draws and returns when the pixels are in the images. One image per view. */
    Status render(std::span<const DplCamera> views, std::span<const DplImage> images) const {
        if (views.size() != images.size()) return Error{DPL_ERROR_INVALID_ARGUMENT, "as many images as views are needed"};
        return status(dplRender(context_, handle_, views.data(), uint32_t(views.size()), images.data()));
    }

    /** render() in two halves, as dplDraw and dplReadImages. flags: DplDrawFlag, combined by |. */
    Status draw(std::span<const DplCamera> views, uint32_t flags = 0) const {
        return status(dplDraw(context_, handle_, views.data(), uint32_t(views.size()), flags));
    }
    Status readImages(std::span<const DplImage> images) const {
        return status(dplReadImages(context_, handle_, images.data(), uint32_t(images.size())));
    }

private:
    static Status checkPoseSizes(size_t rotations, size_t rootTranslation) {
        if (rotations % 4 == 0 && (rootTranslation == 0 || rootTranslation == 3)) return {};
        return Error{DPL_ERROR_INVALID_ARGUMENT, "a pose has 4 floats a joint and a root translation of 3 floats or none"};
    }
    DplContext context_ = nullptr;
    DplAvatar handle_ = nullptr;
};

/** How Player::play plays a clip. */
struct Playback {
    double speed = 1;     // of the clip's own time; below 0: backwards
    double fadeS = 0.3;   // within which the clip takes over from what played before, seconds; 0: at once
    double fromS = 0;     // where the clip starts
    bool loop = true;     // otherwise it holds its last pose
    bool travel = false;  // recorded walks go on from where the person stands, in each round and from clip to clip
};

/** Play, pause, speed, loops and cross-fades of clips of one avatar, as layers for Avatar::setPoseFromClips. Times are nanoseconds of any
 * one clock; the layers are a function of the calls and of the time that is asked for, so every picture rate gives the same motion. A
 * Player of a part of the body, such as a waving arm, plays over that of the whole body: append its layers. Holds no handle; one thread at
 * a time. */
class Player {
public:
    /** joint: the clips move this joint and all below it; 0: the whole body. */
    explicit Player(uint32_t joint = 0) : joint_(joint) {}

    /** Cross-fades to a clip. DPL_ERROR_NOT_FOUND: no such clip. An error changes nothing. */
    Status play(const Avatar& avatar, uint32_t clip, int64_t nowNs, const Playback& how = {}) {
        if (auto known = avatar.clip(clip); !known) return known.error();
        if (!std::isfinite(how.speed) || !std::isfinite(how.fromS) || !std::isfinite(how.fadeS) || how.fadeS < 0)
            return Error{DPL_ERROR_INVALID_ARGUMENT, "speed, fromS and fadeS of a clip must be finite, and fadeS not below 0"};
        const uint32_t loop = how.loop ? DPL_LAYER_LOOP : 0, travel = how.travel ? DPL_LAYER_TRAVEL : 0;
        setRate(nowNs, rate_);
        Voice next{clipLayer(clip, how.fromS, 1, joint_, loop | travel), clockS_, how.fadeS, clockS_, how.speed, true};
        if (how.travel && joint_ == 0 && !voices_.empty()) {
            DplClipLayer before = voices_.back().layer;
            before.timeS = voices_.back().timeS(clockS_);
            if (Status joined = avatar.joinClipLayer(before, next.layer); !joined) return joined;
        }
        voices_.push_back(next);
        return {};
    }
    /** Fades out within fadeS, of a part of the body: what plays beneath is left. The whole body always plays something. */
    Status stop(int64_t nowNs, double fadeS = 0.3) {
        if (joint_ == 0) return Error{DPL_ERROR_INVALID_ARGUMENT, "nothing plays beneath the whole body: pause it, or play another clip"};
        if (!std::isfinite(fadeS) || fadeS < 0) return Error{DPL_ERROR_INVALID_ARGUMENT, "fadeS must be finite and not below 0"};
        if (!voices_.empty()) voices_.push_back({clipLayer(0, 0, 1, joint_), clockS(nowNs), fadeS, 0, 0, false});
        return {};
    }
    /** Clips and fades stand still until resume(), also those that are played meanwhile. */
    void pause(int64_t nowNs) { setRate(nowNs, 0); }
    void resume(int64_t nowNs) { setRate(nowNs, 1); }
    bool paused() const { return rate_ == 0; }
    /** Of the clip that was played last, from now on. DPL_ERROR_INVALID_ARGUMENT: not finite. */
    Status setSpeed(double speed, int64_t nowNs) {
        if (!std::isfinite(speed)) return Error{DPL_ERROR_INVALID_ARGUMENT, "the speed must be finite"};
        if (voices_.empty()) return {};
        Voice& last = voices_.back();
        last.layer.timeS = last.timeS(clockS(nowNs)), last.sinceS = clockS(nowNs), last.speed = speed;
        return {};
    }

    /** What plays at nowNs, valid until the next call; empty: nothing. Allocates nothing once as many clips have played at once. What has
     *  faded out is forgotten, so a time before that gives no longer what it gave. */
    std::span<const DplClipLayer> layers(int64_t nowNs) {
        layers_.clear();
        const double clock = clockS(nowNs);
        double left = 1;  // of the weight, for what played before
        for (size_t i = voices_.size(); i-- > 0 && left > 0 && layers_.size() < DPL_MAX_CLIP_LAYERS;) {
            const double share = i == 0 && joint_ == 0 ? 1 : voices_[i].share(clock);
            if (share == 1) voices_.erase(voices_.begin(), voices_.begin() + std::ptrdiff_t(i)), i = 0;
            if (const double weight = left * share; voices_[i].sounds && weight > 0) {
                layers_.push_back(voices_[i].layer);
                layers_.back().timeS = voices_[i].timeS(clock), layers_.back().weight = float(weight);
            }
            left *= 1 - share;
        }
        return layers_;
    }

private:
    /** A clip that plays, or silence that fades in. Times are those of the player's clock, which stands still in a pause. */
    struct Voice {
        DplClipLayer layer;  // timeS: at sinceS
        double startS, fadeS, sinceS, speed;
        bool sounds;

        double timeS(double clock) const { return layer.timeS + (clock - sinceS) * speed; }
        double share(double clock) const {
            const double t = fadeS > 0 ? (clock - startS) / fadeS : 1;
            return t >= 1 ? 1 : t <= 0 ? 0 : t * t * (3 - 2 * t);
        }
    };
    double clockS(int64_t nowNs) const { return clockS_ + (rate_ == 0 ? 0 : dplSecondsBetween(sinceNs_, nowNs)); }
    void setRate(int64_t nowNs, int rate) {
        clockS_ = voices_.empty() ? 0 : clockS(nowNs);
        sinceNs_ = nowNs, rate_ = rate;
    }

    uint32_t joint_;
    std::vector<Voice> voices_;
    std::vector<DplClipLayer> layers_;
    double clockS_ = 0;  // at sinceNs_
    int64_t sinceNs_ = 0;
    int rate_ = 1;
};

/** Owns one load in the background, which it cancels unless it is finished. Move-only, as Avatar. */
class Load {
public:
    /** Takes ownership of `handle`, which was started with `context`. */
    Load(DplContext context, DplLoad handle) : context_(context), handle_(handle) {}
    Load(Load&& other) noexcept : context_(other.context_), handle_(std::exchange(other.handle_, nullptr)) {}
    Load& operator=(Load&& other) noexcept {
        std::swap(context_, other.context_);
        std::swap(handle_, other.handle_);
        return *this;
    }
    ~Load() { dplCancelLoad(handle_); }

    DplLoad handle() const { return handle_; }
    Result<DplLoadStatus> status() const { return filled<DplLoadStatus>(dplGetLoadStatus, handle_); }
    /** Waits if the load is neither ready nor failed; see dplFinishLoad. Afterwards this owns nothing. */
    Result<Avatar> finish() {
        DplAvatar avatar = nullptr;
        if (const DplResult r = dplFinishLoad(std::exchange(handle_, nullptr), &avatar); r != DPL_OK) return lastError(r);
        return Avatar(context_, avatar);
    }

private:
    DplContext context_ = nullptr;
    DplLoad handle_ = nullptr;
};

/** Owns one context, which it destroys. Move-only, as Avatar. Its avatars may be destroyed before or after it. */
class Context {
public:
    /** Parameters: fields of DplContextInfo. */
    static Result<Context> create(const DplContextInfo& info) {
        DplContext handle = nullptr;
        if (const DplResult r = dplCreateContext(&info, &handle); r != DPL_OK) return lastError(r);
        return Context(handle);
    }
    /** The same, without cacheFolder. */
    static Result<Context> create(DplRenderer renderer = DPL_RENDERER_AUTO, uint32_t threadCount = 0, uint32_t flags = 0,
                                  DplFill fill = DPL_FILL_AUTO) {
        DplContextInfo info{};
        info.structSize = sizeof info;
        info.renderer = renderer;
        info.threadCount = threadCount;
        info.flags = flags;
        info.fill = fill;
        return create(info);
    }
    /** Takes ownership of `handle`. */
    explicit Context(DplContext handle) : handle_(handle) {}
    Context(Context&& other) noexcept : handle_(std::exchange(other.handle_, nullptr)) {}
    Context& operator=(Context&& other) noexcept {
        std::swap(handle_, other.handle_);
        return *this;
    }
    ~Context() { dplDestroyContext(handle_); }

    DplContext handle() const { return handle_; }
    /** Empty on failure. */
    std::string rendererName() const {
        const char* name = "";
        return dplGetRendererName(handle_, &name) == DPL_OK ? name : "";
    }
    /** Loads an avatar or general splats; see dplLoadAvatar. The bytes may be freed on return. */
    Result<Avatar> loadAvatar(std::span<const uint8_t> bytes) const {
        DplAvatar avatar = nullptr;
        if (const DplResult r = dplLoadAvatar(handle_, bytes.data(), bytes.size(), &avatar); r != DPL_OK) return lastError(r);
        return Avatar(handle_, avatar);
    }
    /** The same for a file. path: UTF-8. See dplLoadAvatarFile. */
    Result<Avatar> loadAvatarFile(const std::string& path) const {
        DplAvatar avatar = nullptr;
        if (const DplResult r = dplLoadAvatarFile(handle_, path.c_str(), &avatar); r != DPL_OK) return lastError(r);
        return Avatar(handle_, avatar);
    }

    /** Limits what the renderer holds; avatars that would exceed it are loaded with less. 0: no limit. See dplSetMemoryLimit. */
    Status setMemoryLimit(uint64_t bytes) const { return status(dplSetMemoryLimit(handle_, bytes)); }
    /** Starts to load an avatar or general splats in the background; see dplStartLoad. The bytes are kept until they are read. */
    Result<Load> startLoad(std::vector<uint8_t> bytes) const {
        auto kept = std::make_unique<std::vector<uint8_t>>(std::move(bytes));
        DplLoadInfo info{};
        info.structSize = sizeof info, info.data = kept->data(), info.size = kept->size();
        info.release = [](void* user) { delete static_cast<std::vector<uint8_t>*>(user); };
        info.user = kept.get();
        DplLoad load = nullptr;
        if (const DplResult r = dplStartLoad(handle_, &info, &load); r != DPL_OK) return lastError(r);
        kept.release();
        return Load(handle_, load);
    }

    /** Draws several avatars in one picture, which belongs to the first one. One image per view. */
    Status renderTogether(std::span<const DplAvatar> avatars, std::span<const DplCamera> views, std::span<const DplImage> images) const {
        if (views.size() != images.size()) return Error{DPL_ERROR_INVALID_ARGUMENT, "as many images as views are needed"};
        return status(
            dplRenderTogether(handle_, avatars.data(), uint32_t(avatars.size()), views.data(), uint32_t(views.size()), images.data()));
    }
    Status drawTogether(std::span<const DplAvatar> avatars, std::span<const DplCamera> views, uint32_t flags = 0) const {
        return status(dplDrawTogether(handle_, avatars.data(), uint32_t(avatars.size()), views.data(), uint32_t(views.size()), flags));
    }
    /** Sets level of detail and splat budget from the next call on; zeros draw everything. See DplDetail. */
    Status setDetail(float splatsPerPixel, uint32_t splatBudget = 0) const {
        DplDetail detail{};
        detail.structSize = sizeof detail, detail.splatsPerPixel = splatsPerPixel, detail.splatBudget = splatBudget;
        return status(dplSetDetail(handle_, &detail));
    }
    /** Sets how long a frame may take; 0: no budget. See dplSetFrameBudget. */
    Status setFrameBudget(double milliseconds) const { return status(dplSetFrameBudget(handle_, milliseconds)); }

private:
    DplContext handle_ = nullptr;
};

}  // namespace doppel
#endif
