// SPDX-License-Identifier: Apache-2.0
#include "tests/metal/cpu/msl_entry.h"

const std::vector<const msl::Entry*>& msl::allEntries() {
    static const std::vector<const Entry*> all = [] {
        std::vector<const Entry*> list = fewEntries(), most = mostEntries();
        list.insert(list.end(), most.begin(), most.end());
        return list;
    }();
    return all;
}
