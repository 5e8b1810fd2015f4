// SPDX-License-Identifier: Apache-2.0
// Apart from msl_entry.cpp, on which the compiled shaders depend, because this depends on them.
#include "tests/metal/cpu/msl_entry.h"

namespace msl {

const Entry* entryOfText(std::string_view text) {
    for (const Entry* entry : allEntries())
        if (entry->text == text) return entry;
    return nullptr;
}

const Entry* entryNamed(std::string_view name) {
    for (const Entry* entry : allEntries())
        if (entry->name == name) return entry;
    return nullptr;
}

}  // namespace msl
