// SPDX-License-Identifier: Apache-2.0
// Garments of one subject on another, by `doppel dress`.
#pragma once

#include <array>

#include "apps/viewer/subject.h"

namespace dpl {

/** The layers that change hands: options of doppel, without dashes. */
constexpr std::array<const char*, 4> kGarments{"top", "bottom", "shoes", "hair"};

/** Whose garment is put on, as the handle of the subject; NULL: the wearer keeps their own. */
using Outfit = std::array<DplAvatar, kGarments.size()>;

/** Whether a subject can wear and give: an avatar with a file of its own. */
bool canDress(const ViewedSubject& subject);

/** The command line that dresses `wearer`; empty if nothing is put on. Subjects of the outfit that are gone count as NULL. */
std::vector<std::string> dressArguments(const std::filesystem::path& program, const ViewedSubject& wearer, const Outfit& outfit,
                                        const std::vector<ViewedSubject>& subjects, const std::filesystem::path& out);

}  // namespace dpl
