// SPDX-License-Identifier: Apache-2.0
// For a module that loads in a moment: reading general splats is a tenth of libdoppel.
#include "sdk/api/decode_file.h"

namespace dpl::api {

Result<Decoded> decodeGeneralSplats(std::span<const uint8_t>, const std::string&) {
    return fail(Code::Unsupported, "these are general splats; this build of libdoppel reads persons only");
}

}  // namespace dpl::api
