// SPDX-License-Identifier: Apache-2.0
// Avatars and trackers of the C++ wrapper. Part of doppel.hpp, which includes it.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <initializer_list>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <doppel/doppel_result.hpp>

namespace doppel {

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

/** What a face does by itself; see DplFaceMotion. Those of other seeds blink at other times. */
inline DplFaceMotion faceMotion(uint32_t seed, float blinks = 1, float glances = 1) {
    DplFaceMotion motion{};
    motion.structSize = sizeof motion, motion.seed = seed, motion.blinks = blinks, motion.glances = glances;
    return motion;
}

/** A layer for Avatar::setPoseFromClips; see DplClipLayer. */
inline DplClipLayer clipLayer(uint32_t clip, double timeS, float weight = 1, uint32_t joint = 0, uint32_t flags = DPL_LAYER_LOOP) {
    DplClipLayer layer{};
    layer.structSize = sizeof layer, layer.clip = clip, layer.timeS = timeS;
    layer.weight = weight, layer.joint = joint, layer.flags = flags;
    return layer;
}

/** The shadow by which feet stand on a floor, and where its picture lies; see DplContactShadow. */
struct ContactShadow : DplContactShadow {
    std::array<uint8_t, DPL_CONTACT_SHADOW_PX * DPL_CONTACT_SHADOW_PX> alpha{};
    ContactShadow() : DplContactShadow{} { structSize = sizeof(DplContactShadow); }
};

/** That of an avatar. floorM: height of the app's floor, metres; nothing: where the avatar stands at rest. See dplGetContactShadow. */
inline Result<ContactShadow> contactShadowOf(DplAvatar avatar, std::optional<float> floorM = {}) {
    ContactShadow made;
    const DplResult r = dplGetContactShadow(avatar, floorM ? &*floorM : nullptr, made.alpha.data(), made.alpha.size(), &made);
    if (r != DPL_OK) return lastError(r);
    return made;
}

/** Where a property lies in a buffer, for Avatar::writeSplats and Avatar::writeMesh; see DplBufferElement. */
inline DplBufferElement bufferElement(uint32_t property, uint64_t offsetBytes, uint64_t strideBytes = 0,
                                      DplNumber number = DPL_NUMBER_FLOAT) {
    return {sizeof(DplBufferElement), property, number, 0, offsetBytes, strideBytes};
}

/** DplSplatOptions that know their size. */
struct SplatOptions : DplSplatOptions {
    SplatOptions() : DplSplatOptions{} { structSize = sizeof(DplSplatOptions); }
};

/** Owns one avatar, which it destroys. Move-only: construction by move leaves the source empty, assignment by move swaps. */
class Avatar {
public:
    /** None: every call is DPL_ERROR_INVALID_ARGUMENT until an avatar is moved here. */
    Avatar() = default;
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
    Result<DplLayerInfo> layer(uint32_t index) const { return filled<DplLayerInfo>(dplGetLayerInfo, handle_, index); }
    /** Hides a layer, or shows it again; see dplHideLayer, which says what can be hidden. */
    Status hideLayer(uint32_t layer, bool hidden = true) { return status(dplHideLayer(handle_, layer, hidden ? DPL_TRUE : DPL_FALSE)); }
    Result<DplClipInfo> clip(uint32_t index) const { return filled<DplClipInfo>(dplGetClipInfo, handle_, index); }
    /** The index of the first clip of that name. DPL_ERROR_NOT_FOUND: there is none; the text lists all. */
    Result<uint32_t> findClip(std::string_view name) const {
        const auto about = info();
        if (!about) return about.error();
        std::string names;
        for (uint32_t i = 0; i < about->clipCount; ++i) {
            const auto one = clip(i);
            if (!one) return one.error();
            if (name == one->name) return i;
            names += (i == 0 ? "" : ", ") + std::string(one->name);
        }
        return Error{DPL_ERROR_NOT_FOUND, "there is no clip '" + std::string(name) + "'; the avatar has: " + names};
    }
    /** Where it stands, until changed: a row-major 3×4 matrix of a rotation, one scale and a translation. See dplSetTransform. */
    Status setTransform(std::span<const float, 12> worldFromAvatar) { return status(dplSetTransform(handle_, worldFromAvatar.data())); }
    /** The same, upright: at a place in metres, turned by yawRad about the vertical (a quarter turn takes +Z to +X), `scale` times as
     * large. */
    Status stand(const std::array<float, 3>& at, float yawRad = 0, float scale = 1) {
        const float c = scale * std::cos(yawRad), s = scale * std::sin(yawRad);
        return setTransform(std::array<float, 12>{c, 0, s, at[0], 0, scale, 0, at[1], -s, 0, c, at[2]});
    }
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
    /** How stiff the clothes are, until changed: 0 to 100, 1 as learned. See dplSetClothStiffness. */
    Status setClothStiffness(float stiffness) { return status(dplSetClothStiffness(handle_, stiffness)); }
    /** Sets the face: DPL_EXPRESSION_COUNT weights, 0 to 1, in ARKit's order, or as many as a stream has that needs no names. See
     *  dplSetExpression and dplSetExpressionNamed. */
    Status setExpression(std::span<const float> weights) {
        return status(dplSetExpressionNamed(handle_, nullptr, weights.data(), uint32_t(weights.size())));
    }
    /** The same by names of ARKit, MediaPipe, Live Link, VRM or OpenXR; all others become zero. See dplSetExpressionNamed. */
    Status setExpression(std::initializer_list<std::pair<const char*, float>> weights) {
        std::vector<const char*> names;
        std::vector<float> values;
        for (const auto& [name, weight] : weights) names.push_back(name), values.push_back(weight);
        return setExpression(names, values);
    }
    Status setExpression(std::span<const char* const> names, std::span<const float> weights) {
        if (names.size() != weights.size()) return Error{DPL_ERROR_INVALID_ARGUMENT, "a weight is needed for each name"};
        static const char* const kNone = nullptr;  // an empty list has names too
        return status(dplSetExpressionNamed(handle_, names.empty() ? &kNone : names.data(), weights.data(), uint32_t(weights.size())));
    }
    /** Blinks, glances and the end of a stream, for a picture at a time: for each picture; see dplSetFaceMotion. */
    Status setFaceMotion(const DplFaceMotion& motion, int64_t timeNs) { return status(dplSetFaceMotion(handle_, &motion, timeNs)); }
    /** What the face shows. */
    Result<std::array<float, DPL_EXPRESSION_COUNT>> expression() const {
        std::array<float, DPL_EXPRESSION_COUNT> weights{};
        if (const DplResult r = dplGetExpression(handle_, weights.data(), DPL_EXPRESSION_COUNT); r != DPL_OK) return lastError(r);
        return weights;
    }
    /** Index of an expression by its name; see dplFindExpression. */
    static Result<uint32_t> findExpression(const std::string& name) {
        uint32_t index = 0;
        if (const DplResult r = dplFindExpression(name.c_str(), &index); r != DPL_OK) return lastError(r);
        return index;
    }
    /** Name of an expression, and whether this avatar holds it. */
    Result<DplExpressionInfo> expressionInfo(uint32_t expression) const {
        return filled<DplExpressionInfo>(dplGetExpressionInfo, handle_, expression);
    }
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
    /** The same for the first clip of that name. */
    Status setPoseFromClip(std::string_view name, double timeS, bool loop = true) {
        const auto clip = findClip(name);
        return clip ? setPoseFromClip(*clip, timeS, loop) : Status(clip.error());
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
    /** The shadow by which its feet stand on a floor; see contactShadowOf. */
    Result<ContactShadow> contactShadow(std::optional<float> floorM = {}) const { return contactShadowOf(handle_, floorM); }
    /** Positions of the posed mesh, 3 floats a vertex, metres, in the avatar's own space; see dplGetPosedMesh. */
    Result<std::vector<float>> posedVertices() const {
        auto about = info();
        if (!about) return about.error();
        std::vector<float> positions(size_t(about->vertexCount) * 3);
        const DplResult r = dplGetPosedMesh(handle_, positions.data(), about->vertexCount, nullptr, 0);
        if (r != DPL_OK) return lastError(r);
        return positions;
    }
    /** Its triangles, 3 vertex numbers each; those of hidden layers are three zeros. */
    Result<std::vector<uint32_t>> meshTriangles() const {
        auto about = info();
        if (!about) return about.error();
        std::vector<uint32_t> triangles(size_t(about->triangleCount) * 3);
        const DplResult r = dplGetPosedMesh(handle_, nullptr, 0, triangles.data(), about->triangleCount);
        if (r != DPL_OK) return lastError(r);
        return triangles;
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
    /** How many splats writeSplats writes. */
    Result<uint32_t> splatCount(const SplatOptions& options = {}) const {
        const auto written = filled<DplWritten>(dplWriteSplats, handle_, &options, nullptr);
        return written ? Result<uint32_t>(written->count) : Result<uint32_t>(written.error());
    }
    /** Writes the splats of the current pose into `data`, laid out by bufferElement()s. See dplWriteSplats. */
    Result<DplWritten> writeSplats(std::span<const DplBufferElement> elements, std::span<std::byte> data,
                                   const SplatOptions& options = {}) const {
        const DplBuffer buffer{sizeof buffer, uint32_t(elements.size()), elements.data(), data.data(), data.size()};
        return filled<DplWritten>(dplWriteSplats, handle_, &options, &buffer);
    }
    /** Writes the vertices of the current pose. See dplWriteMesh. */
    Result<DplWritten> writeMesh(std::span<const DplBufferElement> elements, std::span<std::byte> data) const {
        const DplBuffer buffer{sizeof buffer, uint32_t(elements.size()), elements.data(), data.data(), data.size()};
        return filled<DplWritten>(dplWriteMesh, handle_, &buffer);
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

/** The avatars of a call for several, in their order. */
using Avatars = std::initializer_list<std::reference_wrapper<const Avatar>>;

/** Handles of Avatars. Behind DPL_MAX_TOGETHER they are not kept: the library refuses so many. */
class Handles {
public:
    Handles(Avatars avatars) : count_(uint32_t(avatars.size())) {
        size_t i = 0;
        for (const Avatar& avatar : avatars)
            if (i < all_.size()) all_[i++] = avatar.handle();
    }
    const DplAvatar* data() const { return all_.data(); }
    uint32_t count() const { return count_; }

private:
    std::array<DplAvatar, DPL_MAX_TOGETHER> all_{};
    uint32_t count_;
};

/** What a ray meets first of some avatars, `pick({ada, bob}, origin, direction)`; see dplPick. Metres, world. */
inline Result<DplPick> pick(Avatars avatars, const std::array<float, 3>& origin, const std::array<float, 3>& direction) {
    const Handles handles(avatars);
    return filled<DplPick>(dplPick, handles.data(), handles.count(), origin.data(), direction.data());
}

}  // namespace doppel
