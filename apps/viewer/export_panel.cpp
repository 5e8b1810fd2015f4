// SPDX-License-Identifier: Apache-2.0
#include "apps/viewer/export_panel.h"

#include <imgui.h>
#include <imgui_stdlib.h>

#include <algorithm>

namespace dpl {
namespace {

void progressBar(ViewerState& state) {
    const ExportProgress& running = *state.exports.running;
    ImGui::TextWrapped("%s", running.words.c_str());
    ImGui::PushStyleColor(ImGuiCol_PlotHistogram, ImVec4(0.16f, 0.5f, 0.3f, 1));  // white letters are read on it
    ImGui::ProgressBar(float(running.share), {-1, 0});
    ImGui::PopStyleColor();
    if (ImGui::Button("Cancel", {-1, 0})) state.wantsExportEnd = true;
    if (ImGui::IsItemHovered()) ImGui::SetTooltip("Nothing unfinished stays in the folder");
}

}  // namespace

void openExport(ViewerState& state) {
    std::error_code error;
    state.exports.here = std::filesystem::current_path(error).string();
    state.exports.open = true;
}

void drawExport(ViewerState& state, float width, float height) {
    ExportWindow& window = state.exports;
    if (!window.open) return;
    const ViewedSubject* chosen = state.chosen();
    constexpr float kUsualHeight = 380;
    // Its top stays where it is, so that nothing moves from under the cursor when words appear at its end.
    ImGui::SetNextWindowPos({width / 2, std::max(12.0f, (height - kUsualHeight) / 2)}, ImGuiCond_Always, {0.5f, 0});
    const float wide = std::min(440.0f, width - 24);
    ImGui::SetNextWindowSizeConstraints({wide, 0}, {wide, height - 24});
    ImGui::Begin(
        "Export", &window.open,
        ImGuiWindowFlags_AlwaysAutoResize | ImGuiWindowFlags_NoMove | ImGuiWindowFlags_NoCollapse | ImGuiWindowFlags_NoSavedSettings);
    for (const ExportKindWords& words : kExportKinds) {
        if (ImGui::RadioButton(words.name, window.kind == words.kind)) window.kind = words.kind;
        if (ImGui::IsItemHovered()) ImGui::SetTooltip("%s", words.help);
    }
    ImGui::Separator();
    ImGui::TextUnformatted("into the folder");
    ImGui::PushItemWidth(-1);
    ImGui::InputTextWithHint("##folder", window.here.c_str(), &state.settings.exports);
    ImGui::PopItemWidth();
    const std::string why = whyNotExport(window.kind, chosen, state.player());
    const bool byProgram = isByProgram(window.kind);
    if (window.running) {
        progressBar(state);
    } else {
        ImGui::BeginDisabled(!why.empty());
        if (ImGui::Button("Export", {-1, 0})) state.wantsExport = window.kind;
        ImGui::EndDisabled();
    }
    if (!why.empty())
        ImGui::TextWrapped("%s", why.c_str());
    else if (byProgram && chosen->clip && window.kind != ExportKind::Mesh)
        ImGui::TextWrapped("%s, at %.2f s of its clip. Joints bent by hand are not in it.", chosen->file.c_str(),
                           timeInClip(state.playback.timeS, chosen->clips[*chosen->clip].durationS, state.playback.loop));
    else if (byProgram)
        ImGui::TextWrapped("%s", chosen->file.c_str());
    if (!window.told.empty()) ImGui::TextWrapped("%s", window.told.c_str());
    ImGui::End();
}

void drawExportProgress(ViewerState& state, float width) {
    if (!state.exports.running || state.exports.open) return;
    ImGui::SetNextWindowPos({width / 2, 12}, ImGuiCond_Always, {0.5f, 0});
    ImGui::SetNextWindowSize({std::min(360.0f, width - 24), 0}, ImGuiCond_Always);
    ImGui::Begin("##exporting", nullptr,
                 ImGuiWindowFlags_NoTitleBar | ImGuiWindowFlags_NoResize | ImGuiWindowFlags_NoMove | ImGuiWindowFlags_NoSavedSettings |
                     ImGuiWindowFlags_NoFocusOnAppearing);
    progressBar(state);
    ImGui::End();
}

}  // namespace dpl
