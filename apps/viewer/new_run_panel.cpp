// SPDX-License-Identifier: Apache-2.0
#include "apps/viewer/new_run_panel.h"

#include <imgui.h>
#include <imgui_stdlib.h>

#include <algorithm>

namespace dpl {
namespace {

void videos(NewRun& run) {
    static constexpr const char* kNames[] = {"stands still", "close-up", "moves"};
    for (size_t i = 0; i < run.videos.size(); ++i) {
        NewRun::Video& video = run.videos[i];
        ImGui::PushID(int(i));
        ImGui::TextWrapped("%s", video.file.filename().string().c_str());
        int role = int(video.role);
        if (ImGui::Combo("##role", &role, kNames, 3)) video.role = NewRun::Role(role);
        ImGui::PopID();
    }
}

void choices(ViewerState& state) {
    NewRun& run = state.starter->run;
    if (run.scan.empty())
        videos(run);
    else
        ImGui::TextWrapped("%s", run.scan.filename().string().c_str());
    static constexpr const char* kHelp[] = {"Minutes: to see whether the film is good", "The usual choice", "Hours: the finest"};
    for (size_t i = 0; i < kPresetNames.size(); ++i) {
        if (i > 0) ImGui::SameLine();
        if (ImGui::RadioButton(kPresetNames[i], size_t(run.preset) == i)) run.preset = NewRun::Preset(i);
        if (ImGui::IsItemHovered()) ImGui::SetTooltip("%s", kHelp[i]);
    }
    ImGui::DragInt("##minutes", &run.minutes, 1, 0, NewRun::kMostMinutes, run.minutes > 0 ? "%d minutes in all" : "no time budget",
                   ImGuiSliderFlags_AlwaysClamp);
    if (ImGui::IsItemHovered())
        ImGui::SetTooltip("About how long it may take in all: drag sideways, or double click to type; 0: as the choice above");
    std::string out = run.out.string();
    if (ImGui::InputText("##out", &out)) run.out = out;
    if (ImGui::IsItemHovered()) ImGui::SetTooltip("The folder that gets the avatar: %s", out.c_str());
    if (!state.starter->problem().empty()) ImGui::TextWrapped("%s", state.starter->problem().c_str());
    ImGui::BeginDisabled(run.out.empty());
    if (ImGui::Button("Look at the film, and begin", {-1, 0})) state.wantsLook = true;
    if (ImGui::IsItemHovered()) ImGui::SetTooltip("Says within a minute or two what to film again; if nothing, the avatar is made at once");
    if (ImGui::Button("Begin without a look", {-1, 0})) state.wantsRun = true;
    ImGui::EndDisabled();
}

}  // namespace

void drawNewRun(ViewerState& state) {
    using Step = RunStarter::Step;
    RunStarter& starter = *state.starter;
    switch (starter.step()) {
        case Step::Choosing:
            choices(state);
            break;
        case Step::Looking: {
            const auto progress = starter.progress();
            ImGui::TextWrapped("Looking at the film%s%s", progress ? ": " : " ...", progress ? progress->stage.c_str() : "");
            ImGui::PushStyleColor(ImGuiCol_PlotHistogram, ImVec4(0.16f, 0.5f, 0.3f, 1));  // white letters are read on it
            ImGui::ProgressBar(progress ? float(progress->share) : 0, {-1, 0});
            ImGui::PopStyleColor();
            break;
        }
        case Step::Advised:
            ImGui::TextUnformatted("Better filmed again:");
            for (const std::string& fault : starter.coach().faults) {
                ImGui::Bullet();
                ImGui::TextWrapped("%s", fault.c_str());
            }
            if (ImGui::Button("Make the avatar anyway", {-1, 0})) state.wantsRun = true;
            break;
        case Step::Starting:
        case Step::Started:
            ImGui::TextUnformatted("Beginning ...");
            return;  // it goes on by itself
    }
    if (ImGui::Button(starter.step() == Step::Choosing ? "Close" : "Back", {-1, 0})) state.wantsStarterEnd = true;
}

void drawRunControls(ViewerState& state) {
    WatchedRun& run = *state.run;
    const RunWatch::Life life = run.watch.life(state.nowS);
    using Life = RunWatch::Life;
    if (life == Life::Running) {
        ImGui::BeginDisabled(run.stops);
        if (ImGui::Button(run.stops ? "Stopping ..." : "Stop", {-1, 0})) state.wantsRunStop = true;
        ImGui::EndDisabled();
        if (ImGui::IsItemHovered())
            ImGui::SetTooltip("Nothing that was finished is lost; it can go on later. Closing the viewer stops no run");
    }
    const bool ended = life == Life::Stopped || life == Life::Failed || life == Life::Silent;
    if (ended && run.request && !state.starter && ImGui::Button("Continue", {-1, 0})) state.wantsRunContinue = true;
    if (!run.coach.empty() && ImGui::CollapsingHeader("What the coach said")) ImGui::TextWrapped("%s", run.coach.c_str());
}

}  // namespace dpl
