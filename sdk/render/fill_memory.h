// SPDX-License-Identifier: Apache-2.0
// Remembers the result of the start-up self-test for each device, driver version and shader pack: always in the process, and in a
// folder if the host names one.
#pragma once

#include "sdk/core/function_ref.h"
#include "sdk/render/choose_fill.h"

namespace dpl {

/** Draws the scene with a trusted renderer and returns its picture: premultiplied RGBA8, top row first. */
using TrustedPicture = FunctionRef<Result<std::vector<uint8_t>>(const FillScene&)>;

/** Sets the fill that the self-test found best on this renderer's device. Runs the test if no result is remembered. cacheFolder: UTF-8;
 *  empty: none. Code::Device when the device draws wrong pixels with both fills; this is remembered in the process only, because a
 *  driver update may fix it. A lost device and missing memory are errors that are not remembered. An unreadable or damaged file counts as
 * missing and is replaced. Any thread; one test runs at a time. */
Status setBestFill(Renderer& renderer, const std::string& cacheFolder, TrustedPicture trusted);

}  // namespace dpl
