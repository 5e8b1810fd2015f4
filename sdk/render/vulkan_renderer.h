// SPDX-License-Identifier: Apache-2.0
// Creates the GPU renderer on a Vulkan device. DPL_RENDERER_AUTO first asks listVulkanDevices() for a device that is not software.
//
//   auto renderer = createVulkanRenderer({.allowSoftwareDevice = true});
//   if (!renderer) return renderer.error();
//   DPL_TRY(auto id, (*renderer)->addAvatar(avatar));
//   DPL_RETURN_IF_ERROR((*renderer)->draw(id, pose, views, wants));
#pragma once

#include "sdk/backend/vulkan/vulkan_backend.h"
#include "sdk/draw/renderer.h"

namespace dpl {

/** Code::Unsupported when no device fits the options; the text names the best device of the machine. */
Result<std::unique_ptr<Renderer>> createVulkanRenderer(const VulkanOptions& options = {}, Fill fill = Fill::Quads);

}  // namespace dpl
