// SPDX-License-Identifier: Apache-2.0
// The parts of MSL text that the lint looks at: tokens, functions and their parameters. Knows what SPIRV-Cross emits, not all of MSL.
#pragma once

#include <set>
#include <string>
#include <string_view>
#include <vector>

namespace dpl {

/** Identifiers (with their "::"), numbers and single other characters; without comments, preprocessor lines and [[attributes]]. */
std::vector<std::string> mslTokens(std::string_view text);

struct MslParameter {
    std::string space;    // "device", "constant", "thread", "threadgroup"; empty: none is written
    bool refers = false;  // a reference, a pointer or an array
    std::string name;
};
struct MslFunction {
    std::string name;
    std::vector<MslParameter> parameters;
    size_t bodyBegin = 0, bodyEnd = 0;  // tokens between the braces
};
struct MslText {
    std::vector<std::string> tokens;
    std::vector<MslFunction> functions;
    std::set<std::string> types;       // structs and template parameters
    std::vector<std::string> globals;  // variables outside functions that are not constant
};
MslText parseMsl(std::string_view text);

bool isMslName(const std::string& token);

/** The position behind the bracket that closes the one at `open`. */
size_t mslClosing(const std::vector<std::string>& tokens, size_t open);

/** Splits tokens at commas that lie in no bracket. */
std::vector<std::vector<std::string>> mslList(const std::vector<std::string>& tokens, size_t begin, size_t end);

}  // namespace dpl
