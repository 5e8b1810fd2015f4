// SPDX-License-Identifier: Apache-2.0
// Leaves splats out when an avatar is loaded and memory is short, in the order in which level of detail would.
#pragma once

#include <optional>

#include "sdk/format/avatar_data.h"
#include "sdk/format/coded_splats.h"

namespace dpl {

/** How much of a file's splats is kept. */
struct Leanness {
    uint32_t shDegree = 3;  // higher bands are left out
    double share = 1;       // of the splats, 0 to 1
    bool operator==(const Leanness&) const = default;
};

constexpr double kLeastShare = 1.0 / 16;  // leaner avatars have holes; a frame budget stops there too

/** Keeps about that share of an avatar's splats, at least one of each group: face and hands keep more (measureDetail). Kept splats grow by
 *  the formula of level of detail, those of a chunk alike. The avatar must have passed checkAvatarPosable. Without leanness, a copy. */
CodedSplats leanSplats(const AvatarData& avatar, const CodedSplats& splats, const Leanness& lean);

/** The same for general splats: each group keeps the same share. The order of the splats changes. */
StaticSplatData leanSplats(const StaticSplatData& splats, const Leanness& lean);

/** Looks for the leanness that fits into memory: SH bands go first, one by one, then splats. */
class LeanSearch {
public:
    explicit LeanSearch(uint32_t shDegree) : lean_{shDegree, 1} {}
    const Leanness& lean() const { return lean_; }
    /** Chooses less than lean(), which took `needs` bytes and did not fit. room: bytes that there are; none: unknown. False: lean() is the
     *  least. */
    bool lower(uint64_t needs, std::optional<uint64_t> room);

private:
    Leanness lean_;
    double shareBefore_ = 0, needsBefore_ = 0;  // of the attempt before, if it left out splats too
};

}  // namespace dpl
