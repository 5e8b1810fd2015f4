// SPDX-License-Identifier: Apache-2.0
#include "tests/metal/cpu/msl_entry.h"

const std::vector<const msl::Entry*>& msl::allEntries() {
    static const std::vector<const Entry*> all = trainingEntries();
    return all;
}
