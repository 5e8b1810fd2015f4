// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/run/priors_table.h"

#include <string>
#include <string_view>

#include "reconstruction/run/stage.h"

namespace dpl {

nlohmann::json priorsOf(std::span<const char* const> rooms, std::span<const PriorValue> table) {
    nlohmann::json out = nlohmann::json::object();
    for (const char* room : rooms) {
        std::string text;
        for (const PriorValue& prior : table)
            if (std::string_view(prior.room) == room) text += std::string(prior.name) + " = " + prior.value + "\n";
        out[room] = hashText(text);
    }
    return out;
}

}  // namespace dpl
