// SPDX-License-Identifier: Apache-2.0
// Loaded avatars and general splats: their static records on the device, and what posing and level of detail need on the CPU.
#pragma once

#include <map>
#include <memory>
#include <optional>

#include "sdk/avatar/cloth_limits.h"
#include "sdk/draw/renderer.h"
#include "sdk/render/avatar_upload.h"
#include "sdk/render/device_buffers.h"
#include "sdk/render/frame_ids.h"
#include "sdk/render/subject_upload.h"
#include "sdk/visibility/components.h"
#include "sdk/visibility/detail.h"

namespace dpl {

/** What is uploaded of a subject. It stays on the CPU, so that a lost device can be replaced. */
struct SubjectRecords {
    AvatarRecords avatar;                   // of an avatar
    std::vector<gpu::uvec4> generalSplats;  // of general splats
    std::vector<gpu::uvec4> sh;

    uint64_t bytes() const;
};

/** One avatar or one set of general splats. It does not change from frame to frame, except that generalDetail remembers the last
 *  views. */
struct LoadedSubject {
    std::shared_ptr<const AvatarData> avatar;  // null: general splats
    std::shared_ptr<const SubjectRecords> records;
    SplatSet splats;
    SubjectIds ids;             // counts and buffers; the scene set adds the places in its lists
    uint32_t paletteSize = 0;   // of an avatar: vec4s
    uint32_t filledGroups = 0;  // of an avatar: groups with any splat
    bool wide = false;          // general splats that reach so far that 16 bits of depth are too few
    std::shared_ptr<DeviceBuffers> buffers;
    std::shared_ptr<SubjectUpload> upload;  // null: uploaded
    uint64_t residentBytes = 0;             // device memory of the splats and of all that poses them
    uint64_t splatBytes = 0;                // the part of residentBytes that holds splats
    Components components;                  // of an avatar; those out of view need no posing
    ClothLimits cloth;                      // of an avatar
    DetailSubject detail;                   // of an avatar
    GeneralDetailSubject generalDetail;     // of general splats

    /** The pixel size of its training is known, and says which pixels are too coarse for one sample. */
    bool mayTakeFourSamples() const { return avatar && avatar->trainedPixelM > 0; }
};

/** Owns the loaded subjects and their device buffers. The backend must live longer. One thread at a time, except to prepare. */
class AvatarStore {
public:
    explicit AvatarStore(Backend& backend) : backend_(backend) {}

    /** Checks the subject and packs its records. Any thread: reads nothing but the limits of the device. avatar->splats is not read.
     * InvalidArgument: arrays that do not fit. Unsupported: above a limit of the device. */
    Result<std::unique_ptr<PreparedSubject>> prepareAvatar(std::shared_ptr<const AvatarData> avatar, CodedSplats splats) const;
    Result<std::unique_ptr<PreparedSubject>> prepareSplats(const StaticSplatData& splats) const;
    /** Makes the buffers of what this store prepared. */
    Result<RenderAvatarId> begin(std::unique_ptr<PreparedSubject> prepared);
    /** As Renderer. InvalidArgument: no such subject. */
    Result<double> continueUpload(RenderAvatarId id, UploadSlice& slice);
    Status finishUpload(RenderAvatarId id);
    /** Uploads the subjects of another store, also those whose upload is not complete there, under the same numbers. This store has none
     * yet. After an error it has some of them. */
    Status addAll(const AvatarStore& other);
    /** Destroys the subject's buffers. No recorded frame may still use them. */
    void remove(RenderAvatarId id) { subjects_.erase(id); }

    /** Null when there is none. Valid until it is removed. */
    LoadedSubject* find(RenderAvatarId id);
    /** For checkDraw. */
    std::optional<std::span<const JointData>> jointsOf(RenderAvatarId id) const;
    const LoadedSubject& at(RenderAvatarId id) const { return subjects_.at(id); }
    const std::map<RenderAvatarId, LoadedSubject>& all() const { return subjects_; }

private:
    Status makeBuffers(LoadedSubject& subject);

    Backend& backend_;
    std::map<RenderAvatarId, LoadedSubject> subjects_;
    RenderAvatarId lastId_ = 0;
};

}  // namespace dpl
