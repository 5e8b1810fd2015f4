// SPDX-License-Identifier: Apache-2.0
// What the start-up self-test found, remembered per device, driver version and shader pack: in the process always, in a folder when the
// host names one.
#pragma once

#include "sdk/core/function_ref.h"
#include "sdk/render/choose_fill.h"

namespace dpl {

/** Draws the scene by a renderer that is trusted: premultiplied RGBA8, top row first. */
using TrustedPicture = FunctionRef<Result<std::vector<uint8_t>>(const FillScene&)>;

/** Sets the fill that the self-test found best on this renderer's device; runs the test when nothing remembers it. cacheFolder: UTF-8,
 * empty: none. Code::Device when the device draws wrong pixels both ways (remembered in the process, never in the folder: a driver may be
 * mended). An unreadable or damaged file in the folder is the same as none and is replaced. Any thread; one test runs at a time. */
Status setBestFill(Renderer& renderer, const std::string& cacheFolder, TrustedPicture trusted);

}  // namespace dpl
