// SPDX-License-Identifier: Apache-2.0
// The optional parts of an avatar, their removal, and the file with the evidence stage's measurements of them.
#pragma once

#include <filesystem>
#include <vector>

#include "sdk/core/result.h"
#include "sdk/format/avatar_data.h"

namespace dpl {

enum class AvatarPart : uint8_t { CorrectiveOffsets, CorrectiveLight, MotionModes, SceneLight, ViewDependentColour };

struct PartEvidence {
    AvatarPart part = AvatarPart::CorrectiveOffsets;
    EvidenceData row;
};

/** Its name in files: "corrective-offsets". */
const char* nameOf(AvatarPart part);
/** Whether the avatar has the part. */
bool hasPart(const AvatarData& avatar, AvatarPart part);
/** Sets the offsets or the brightness of all control nodes to zero, removes the motion modes or the light of the scene, or reduces SH to
 * degree 0. */
void removePart(AvatarData& avatar, AvatarPart part);
/** Removes the correctives if all their nodes are zero. */
void dropEmptyCorrectives(AvatarData& avatar);

Status writeEvidence(const std::vector<PartEvidence>& parts, const std::filesystem::path& path);
Result<std::vector<PartEvidence>> readEvidence(const std::filesystem::path& path);

}  // namespace dpl
