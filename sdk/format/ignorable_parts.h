// SPDX-License-Identifier: Apache-2.0
// Parts of an avatar file that a reader may leave out: without them the avatar looks the same, at weights of zero and until asked. So one
// of a newer encoding is left out, and the avatar is read.
#pragma once

#include "sdk/core/function_ref.h"
#include "sdk/format/avatar_data.h"
#include "sdk/format/extension_fields.h"

namespace dpl {

/** The bytes of a stream by its name in a `streams` object; empty where it is absent. */
using StreamReader = FunctionRef<Result<std::span<const uint8_t>>(const nlohmann::json& streams, const char* name)>;

/** Each fills its part of `avatar`, whose mesh, joints and pose correctives are read, and returns the bytes of its streams. root: the
 *  extension. CorruptData: fields or streams that do not fit. The caller checks the values (checkAvatar). */
Result<uint64_t> readExpressions(const ExtensionFields& root, StreamReader stream, AvatarData& avatar);
Result<uint64_t> readCaptureMap(const ExtensionFields& root, StreamReader stream, AvatarData& avatar);

}  // namespace dpl
