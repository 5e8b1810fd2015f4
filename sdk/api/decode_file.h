// SPDX-License-Identifier: Apache-2.0
// Decodes the files that dplLoadAvatar reads. Internal to sdk/api.
#pragma once

#include <memory>
#include <optional>
#include <span>

#include "sdk/api/api_state.h"

namespace dpl::api {

/** A decoded file: the object behind the handle, and its splats as they are in the file. */
struct Decoded {
    std::shared_ptr<Avatar> avatar;
    CodedSplats splats;                      // of an avatar
    std::optional<StaticSplatData> general;  // of general splats
};

/** Takes long, and notices that the task of the thread is cancelled (sdk/core/task.h). The avatar has no context yet. file: its name for
 *  warnings; empty: unknown. */
Result<Decoded> decodeFile(std::span<const uint8_t> bytes, const std::string& file);

/** Its part for general splats: an avatar without joints. Unsupported: this build reads none (general_splats_absent.cpp). */
Result<Decoded> decodeGeneralSplats(std::span<const uint8_t> bytes, const std::string& file);

}  // namespace dpl::api
