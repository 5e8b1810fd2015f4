// SPDX-License-Identifier: Apache-2.0
#include "platform/desktop/gui.h"

#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>
#include <backends/imgui_impl_glfw.h>
#include <backends/imgui_impl_vulkan.h>
#include <imgui.h>
#include <unistd.h>

namespace dpl::platform {
namespace {

constexpr const char* kFont = "/usr/share/fonts/truetype/dejavu/DejaVuSans.ttf";

/** Ends a call of Dear ImGui in which Vulkan has failed. Without it the call would go on with handles that are not there, and crash. */
struct ImGuiStopped {
    VkResult result;
};

/** Runs calls of Dear ImGui that call Vulkan. No exception leaves it. */
template <class Calls>
Status guarded(Calls&& calls) {
    try {
        calls();
    } catch (const ImGuiStopped& stopped) {
        return vulkanError(stopped.result, "Dear ImGui");
    }
    return {};
}

Status uploadFont(Device& device) {
#if IMGUI_VERSION_NUM >= 19000
    (void)device;
    return guarded([] { ImGui_ImplVulkan_CreateFontsTexture(); });  // submits by itself; no other thread uses the queue yet
#else
    Status recorded;
    DPL_SHELL_OK(device.runOnce(
        [&recorded](VkCommandBuffer commands) { recorded = guarded([commands] { ImGui_ImplVulkan_CreateFontsTexture(commands); }); }));
    ImGui_ImplVulkan_DestroyFontUploadObjects();
    return recorded;
#endif
}

void setStyle() {
    ImGui::StyleColorsDark();
    ImGuiStyle& style = ImGui::GetStyle();
    style.WindowRounding = 6, style.FrameRounding = 4, style.GrabRounding = 4, style.PopupRounding = 4, style.ScrollbarRounding = 4;
    style.WindowBorderSize = 0;
    style.WindowPadding = {12, 10}, style.FramePadding = {7, 4}, style.ItemSpacing = {8, 6};
    style.Colors[ImGuiCol_WindowBg] = {0.09f, 0.10f, 0.12f, 0.92f};
    style.Colors[ImGuiCol_TitleBg] = style.Colors[ImGuiCol_TitleBgActive] = {0.13f, 0.15f, 0.18f, 1};
}

float imguiFromWindow = 1;  // coordinates of the mouse; of the one Gui that there is

#if IMGUI_VERSION_NUM >= 18700  // positions come as events
void takeMouse(GLFWwindow* window) {
    glfwSetCursorPosCallback(window, [](GLFWwindow* of, double x, double y) {
        ImGui_ImplGlfw_CursorPosCallback(of, x * double(imguiFromWindow), y * double(imguiFromWindow));
    });
}
void scaleMouse() {}
#else
void takeMouse(GLFWwindow*) {}
void scaleMouse() {
    ImVec2& at = ImGui::GetIO().MousePos;
    if (ImGui::IsMousePosValid(&at)) at = {at.x * imguiFromWindow, at.y * imguiFromWindow};
}
#endif

}  // namespace

std::unique_ptr<Gui> Gui::create(const Window& window, float scale) {
    std::unique_ptr<Gui> made(new Gui(scale));
    IMGUI_CHECKVERSION();
    ImGui::CreateContext();
    ImGuiIO& io = ImGui::GetIO();
    io.IniFilename = nullptr;  // panels have their places; nothing is written into the folder of the user
    if (access(kFont, R_OK) == 0) io.Fonts->AddFontFromFileTTF(kFont, 15 * scale), io.FontGlobalScale = 1 / scale;
    setStyle();
    ImGui_ImplGlfw_InitForVulkan(window.handle(), true);
    takeMouse(window.handle());
    return made;
}

Status Gui::enter(Device& device, VkRenderPass pass, uint32_t framesInFlight) {
    const VkDescriptorPoolSize size{VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER, 8};
    VkDescriptorPoolCreateInfo pool{VK_STRUCTURE_TYPE_DESCRIPTOR_POOL_CREATE_INFO};
    pool.flags = VK_DESCRIPTOR_POOL_CREATE_FREE_DESCRIPTOR_SET_BIT;
    pool.maxSets = 8;
    pool.poolSizeCount = 1;
    pool.pPoolSizes = &size;
    DPL_VK_MAKE(pool_, vkCreateDescriptorPool, device.device(), pool);
    device_ = &device;
    ImGui_ImplVulkan_InitInfo info{};
    info.Instance = device.instance(), info.PhysicalDevice = device.physical(), info.Device = device.device();
    info.QueueFamily = device.family(), info.Queue = device.queue();
    info.DescriptorPool = pool_;
    info.MinImageCount = info.ImageCount = framesInFlight;
    info.MSAASamples = VK_SAMPLE_COUNT_1_BIT;
    info.CheckVkResultFn = [](VkResult result) {
        if (result != VK_SUCCESS) throw ImGuiStopped{result};
    };
    DPL_SHELL_OK(guarded([&] { ImGui_ImplVulkan_Init(&info, pass); }));
    return uploadFont(device);
}

void Gui::leave() {
    if (frameOpen_) endFrame();
    if (!device_) return;
    ImGui_ImplVulkan_Shutdown();
    vkDestroyDescriptorPool(device_->device(), pool_, nullptr);
    pool_ = VK_NULL_HANDLE;
    device_ = nullptr;
}

Gui::~Gui() {
    leave();
    ImGui_ImplGlfw_Shutdown();
    ImGui::DestroyContext();
}

void Gui::beginFrame(VkExtent2D size) {
    ImGui_ImplVulkan_NewFrame();
    ImGui_ImplGlfw_NewFrame();
    ImGuiIO& io = ImGui::GetIO();
    // The picture may have another size than the window (scripts). Systems count a scaled window in its pixels, or in fewer units.
    const float ofWindow = io.DisplayFramebufferScale.x > 0 ? io.DisplayFramebufferScale.x : 1;
    io.DisplaySize = {float(size.width) / scale_, float(size.height) / scale_};
    io.DisplayFramebufferScale = {scale_, scale_};
    imguiFromWindow = ofWindow / scale_;
    scaleMouse();
    ImGui::NewFrame();
    frameOpen_ = true;
}

void Gui::endFrame() {
    ImGui::Render();
    frameOpen_ = false;
}

Status Gui::record(VkCommandBuffer commands) const {
    return guarded([commands] { ImGui_ImplVulkan_RenderDrawData(ImGui::GetDrawData(), commands); });
}

}  // namespace dpl::platform
