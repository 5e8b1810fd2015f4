// SPDX-License-Identifier: Apache-2.0
#include "apps/viewer/open_panel.h"

#include <imgui.h>

#include <algorithm>

#include "apps/viewer/panel_style.h"

namespace dpl {
namespace {

const char* mark(FolderEntry::Kind kind) {
    switch (kind) {
        case FolderEntry::Kind::Run:
            return "  (a run)";
        case FolderEntry::Kind::Scan:
            return "  (a scan)";
        case FolderEntry::Kind::Folder:
            return " /";
        default:
            return "";
    }
}

void entries(ViewerState& state) {
    OpenWindow& open = *state.open;
    const std::filesystem::path& folder = open.list.folder;
    if (folder.has_relative_path() && ImGui::Selectable(".. /")) state.wantsFolder = folder.parent_path().string();
    for (const FolderEntry& entry : open.list.entries) {
        if (!ImGui::Selectable((entry.name + mark(entry.kind)).c_str())) continue;
        const std::string path = (folder / entry.name).string();
        if (entry.kind == FolderEntry::Kind::Folder)
            state.wantsFolder = path;
        else
            state.wantsOpen = path;
    }
    if (open.list.cut) ImGui::TextDisabled("and more; drop those on the window");
    if (open.list.entries.empty() && !open.waits) ImGui::TextDisabled("nothing here that can be opened");
}

}  // namespace

void drawRecent(ViewerState& state, size_t most) {
    for (size_t i = 0; i < std::min(most, state.settings.recent.size()); ++i) {
        const std::string& path = state.settings.recent[i];
        const std::filesystem::path file = path;
        ImGui::PushID(int(i));
        const std::string name = (file.parent_path().filename() / file.filename()).string();
        if (ImGui::Selectable(name.c_str())) state.wantsOpen = path;
        if (ImGui::IsItemHovered()) ImGui::SetTooltip("%s", path.c_str());
        ImGui::PopID();
    }
}

void drawOpen(ViewerState& state, float width, float height) {
    if (!state.open) return;
    bool open = true;
    ImGui::SetNextWindowPos({width / 2, height / 2}, ImGuiCond_Always, {0.5f, 0.5f});
    ImGui::SetNextWindowSize({std::min(560.0f, width - 24), std::min(520.0f, height - 24)}, ImGuiCond_Always);
    ImGui::Begin("Open", &open,
                 ImGuiWindowFlags_NoMove | ImGuiWindowFlags_NoResize | ImGuiWindowFlags_NoCollapse | ImGuiWindowFlags_NoSavedSettings);
    ImGui::PushStyleColor(ImGuiCol_Text, kQuietColour);
    ImGui::TextWrapped(
        "Avatars and splats (.glb, .ply, .spz), motions (.bvh, .glb), videos, and folders of runs and scans. They can also be dropped "
        "on the window.");
    ImGui::PopStyleColor();
    if (!state.settings.recent.empty() && ImGui::CollapsingHeader("Opened lately")) drawRecent(state, ViewerSettings::kMostRecent);
    ImGui::Separator();
    ImGui::TextWrapped("%s%s", state.open->list.folder.string().c_str(), state.open->waits ? " ..." : "");
    ImGui::BeginChild("entries");
    entries(state);
    ImGui::EndChild();
    ImGui::End();
    if (!open || state.wantsOpen) state.open.reset();
}

}  // namespace dpl
