// SPDX-License-Identifier: Apache-2.0
// The heights of a person that may be stated, in a scan and on the command line.
#pragma once

namespace dpl {

constexpr double kShortestPersonM = 0.3, kTallestPersonM = 2.8;

}  // namespace dpl
