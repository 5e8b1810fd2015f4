// SPDX-License-Identifier: Apache-2.0
// HTML with a person in it who moves. Every page works from disk and without network.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "reconstruction/output/page/web_module.h"

namespace dpl {

/** The figure that the script brings to life. stillImage: an <img>, which stays where scripts are off. One a page. */
std::string liveFigure(const std::string& stillImage);

/** Avatar, module and script, for the end of the page; module.style belongs into its head. The bytes are in base64: 4/3 of the avatar, and
 * 4/3 of the packed module. */
std::string liveParts(const WebModule& module, std::span<const uint8_t> avatar);

struct SharedPerson {
    std::string name;
    std::string licence;         // in words, or as an SPDX identifier; empty: none is stated
    std::vector<uint8_t> still;  // a JPEG of the person on white
    std::vector<uint8_t> avatar;
};

/** A page of the person alone. */
std::string sharePage(const SharedPerson& person, const WebModule& module);

}  // namespace dpl
