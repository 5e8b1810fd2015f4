// SPDX-License-Identifier: Apache-2.0
// Loaded avatars and general splats: their static records on the device, and what posing and level of detail need on the CPU.
#pragma once

#include <map>
#include <memory>

#include "sdk/draw/renderer.h"
#include "sdk/render/avatar_upload.h"
#include "sdk/render/device_buffers.h"
#include "sdk/render/frame_ids.h"
#include "sdk/visibility/components.h"
#include "sdk/visibility/detail.h"

namespace dpl {

/** One avatar or one set of general splats. Nothing here changes from frame to frame, except the views that `generalDetail` saw last. */
struct LoadedSubject {
    explicit LoadedSubject(Backend& backend) : buffers(backend) {}

    std::shared_ptr<const AvatarData> avatar;  // null: general splats
    SplatSet splats;
    SubjectIds ids;  // counts and buffers; places in the lists of a frame belong to a scene set
    DeviceBuffers buffers;
    uint64_t residentBytes = 0;          // splats and what poses them
    uint64_t splatBytes = 0;             // of these, the splats
    Components components;               // empty when nothing is culled
    DetailSubject detail;                // of an avatar
    GeneralDetailSubject generalDetail;  // of general splats
};

/** Owns the loaded subjects and their device buffers. The backend must live longer. One thread at a time. */
class AvatarStore {
public:
    /** cullComponents: find the components of an avatar, so that those out of view need no posing. */
    AvatarStore(Backend& backend, bool cullComponents) : backend_(backend), cullComponents_(cullComponents) {}

    /** Uploads; blocks until the device has the data. InvalidArgument: damaged arrays. Unsupported: above a limit of the device. */
    Result<RenderAvatarId> addAvatar(std::shared_ptr<const AvatarData> avatar);
    /** avatar->splats is not read. */
    Result<RenderAvatarId> addCodedAvatar(std::shared_ptr<const AvatarData> avatar, CodedSplats splats);
    Result<RenderAvatarId> addSplats(const StaticSplatData& splats);
    /** Destroys its buffers. No recorded frame may use them any more. */
    void remove(RenderAvatarId id) { subjects_.erase(id); }

    /** Null when there is none. Valid until it is removed. */
    LoadedSubject* find(RenderAvatarId id);
    const LoadedSubject& at(RenderAvatarId id) const { return subjects_.at(id); }

private:
    RenderAvatarId keep(LoadedSubject subject);

    Backend& backend_;
    bool cullComponents_;
    std::map<RenderAvatarId, LoadedSubject> subjects_;
    RenderAvatarId lastId_ = 0;
};

}  // namespace dpl
