// SPDX-License-Identifier: Apache-2.0
// Says how far the figures of a scan may be trusted: whether constants of the reconstruction were chosen on it, and whether its subject is
// easier than a real person.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace dpl {

/** Whether constants of the reconstruction were chosen on the scan of this name. Procedural scans are named after their seed. Nothing but
 *  the name is compared: pictures of a development scan that went through a video have other bytes. */
bool isDevelopmentScan(std::string_view scanName);

/** Sentences for the report. `sameBody`: the scan's subject was made from the body model that is fitted. */
std::vector<std::string> provenanceOf(std::string_view scanName, bool sameBody);

}  // namespace dpl
