// SPDX-License-Identifier: Apache-2.0
// The points of the hands that a keypoint file may name beside the body's. They have a list of their own, because they take no part in
// anything that is found from the body's points: cameras, scale, sides, shape.
#pragma once

#include <span>
#include <string_view>

#include "reconstruction/input/capture/scan.h"

namespace dpl {

constexpr size_t kHandFingers = 5, kFingerPoints = 4, kHandPoints = kHandFingers * kFingerPoints;

/** "thumb1_l" … "pinky4_l", then the same of the right hand: 2 × kHandPoints names. A finger's points go from the palm to its tip: three
 *  joints and the tip; fingers from the thumb to the pinky. */
std::span<const std::string_view> handKeypointNames();

/** The place of a name in handKeypointNames(), or −1. */
int32_t handKeypointNamed(std::string_view name);

/** The hands' points of one frame, in the order of handKeypointNames(), from the file that readKeypoints() reads, if that has `names`.
 *  Empty when it shows none of them. */
Result<std::vector<Keypoint>> readHandKeypoints(const Scan& scan, const ScanFrame& frame);

}  // namespace dpl
