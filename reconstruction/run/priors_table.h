// SPDX-License-Identifier: Apache-2.0
// The priors of every room as values, for the keys of stages. The build makes the table of the priors.h files; comments do not count.
#pragma once

#include <nlohmann/json.hpp>
#include <span>

namespace dpl {

struct PriorValue {
    const char *room, *name, *value;  // "subject/body", "kHumanSize", "1.3"
};

/** All priors, room by room. */
std::span<const PriorValue> priorsTable();

/** A hash of the priors of each of these rooms, by room. */
nlohmann::json priorsOf(std::span<const char* const> rooms, std::span<const PriorValue> table = priorsTable());

}  // namespace dpl
