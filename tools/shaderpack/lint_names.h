// SPDX-License-Identifier: Apache-2.0
// Checks of the lint that need more than one line of the text: names and address spaces.
#pragma once

#include "sdk/core/result.h"
#include "tools/shaderpack/msl_text.h"

namespace dpl {

/** Every function that is called is defined in the text or is one of Metal's. */
Status lintNames(std::string_view name, const MslText& text);

/** Every reference and pointer has an address space, and what a call passes by reference lies in that of the parameter. Variables outside
 *  functions are constant. */
Status lintAddressSpaces(std::string_view name, const MslText& text);

}  // namespace dpl
