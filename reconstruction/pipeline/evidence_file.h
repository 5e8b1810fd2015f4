// SPDX-License-Identifier: Apache-2.0
// The parts of an avatar that must earn their place, how to take one away, and the file in which the evidence stage says what it found.
#pragma once

#include <filesystem>
#include <vector>

#include "sdk/core/result.h"
#include "sdk/format/avatar_data.h"

namespace dpl {

enum class AvatarPart : uint8_t { CorrectiveOffsets, CorrectiveLight, ViewDependentColour };

struct PartEvidence {
    AvatarPart part = AvatarPart::CorrectiveOffsets;
    EvidenceData row;
};

/** Whether the avatar has the part at all. */
bool hasPart(const AvatarData& avatar, AvatarPart part);
/** Offsets or light of all control nodes to zero; SH to degree 0. */
void removePart(AvatarData& avatar, AvatarPart part);
/** Correctives whose nodes are all zero go. */
void dropEmptyCorrectives(AvatarData& avatar);

Status writeEvidence(const std::vector<PartEvidence>& parts, const std::filesystem::path& path);
Result<std::vector<PartEvidence>> readEvidence(const std::filesystem::path& path);

}  // namespace dpl
