// SPDX-License-Identifier: Apache-2.0
// For web modules of persons, which every visitor loads: reading general splats is an eighth of a module (docs/adr/0089).
#include "sdk/api/decode_file.h"

namespace dpl::api {

Result<Decoded> decodeGeneralSplats(std::span<const uint8_t>, const std::string&) {
    return fail(Code::Unsupported, "these are general splats; this build of libdoppel reads persons only");
}

}  // namespace dpl::api
