// SPDX-License-Identifier: Apache-2.0
// One large picture of the gallery with the avatar over it, and a slider between them. Private to reconstruction/judging/report.
#pragma once

namespace dpl {

/** Makes the large view above the gallery `.pairs`, whose figures hold picture and avatar, from the images that are in the page; those of
 *  `.differences`, in the same order, are its third view. Without scripts the gallery is all there is. */
extern const char* const kCompareScript;
extern const char* const kCompareStyle;

}  // namespace dpl
