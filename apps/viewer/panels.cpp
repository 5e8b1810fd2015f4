// SPDX-License-Identifier: Apache-2.0
#include "apps/viewer/panels.h"

#include <imgui.h>

#include <algorithm>
#include <cfloat>

#include "apps/shared/pictures.h"

namespace dpl {
namespace {

constexpr float kLeftWidth = 292, kRightWidth = 268, kGap = 12;
const ImVec4 kError{1.0f, 0.52f, 0.45f, 1}, kQuiet{0.62f, 0.66f, 0.72f, 1};

/** Opens a panel at a corner that grows with its content as far as the window allows. */
void beginPanel(const char* title, float x, float y, float width, float mostHeight) {
    ImGui::SetNextWindowPos({x, y}, ImGuiCond_Always);
    ImGui::SetNextWindowSizeConstraints({width, 0}, {width, std::max(60.0f, mostHeight)});
    ImGui::Begin(title, nullptr, ImGuiWindowFlags_AlwaysAutoResize | ImGuiWindowFlags_NoMove | ImGuiWindowFlags_NoSavedSettings);
    ImGui::PushItemWidth(-1);
}

/** Returns the height of the panel. */
float endPanel() {
    ImGui::PopItemWidth();
    const float height = ImGui::GetWindowHeight();
    ImGui::End();
    return height;
}

void quiet(const char* format, double a = 0, double b = 0) {
    ImGui::PushStyleColor(ImGuiCol_Text, kQuiet);
    ImGui::Text(format, a, b);
    ImGui::PopStyleColor();
}

void subjectList(ViewerState& state) {
    if (state.subjects.empty() && state.atHand.empty())
        ImGui::TextWrapped("Drop an avatar (.glb) or splats (.ply, .spz, .glb) on the window.");
    for (size_t i = 0; i < state.subjects.size(); ++i) {
        const ViewedSubject& subject = state.subjects[i];
        ImGui::PushID(int(i));
        const float crossWidth = ImGui::CalcTextSize("x").x + 2 * ImGui::GetStyle().FramePadding.x;
        const float rowWidth = ImGui::GetContentRegionAvail().x - crossWidth - ImGui::GetStyle().ItemSpacing.x;
        if (ImGui::Selectable(subject.file.c_str(), state.selected == i, 0, {rowWidth, 0})) state.selected = i;
        ImGui::SameLine();
        if (ImGui::SmallButton("x")) state.wantsRemoval = i;
        if (ImGui::IsItemHovered()) ImGui::SetTooltip("Remove %s", subject.file.c_str());
        ImGui::PopID();
    }
    if (const ViewedSubject* chosen = state.chosen())
        quiet(chosen->isAvatar() ? "%.0f splats, %.0f joints" : "%.0f splats", chosen->info.splatCount, double(chosen->joints.size()));
    if (!state.atHand.empty()) ImGui::TextWrapped("Loading %s ...", state.atHand.c_str());
}

void clipControls(ViewerState& state, ViewedSubject& subject) {
    const char* shown = subject.clip ? subject.clips[*subject.clip].name.c_str() : "rest pose";
    if (ImGui::BeginCombo("##clip", shown)) {
        if (ImGui::Selectable("rest pose", !subject.clip)) subject.clip.reset();
        for (uint32_t i = 0; i < subject.clips.size(); ++i) {
            ImGui::PushID(int(i));
            if (ImGui::Selectable(subject.clips[i].name.c_str(), subject.clip == i)) subject.clip = i;
            ImGui::PopID();
        }
        ImGui::EndCombo();
    }
    if (!subject.clip) {
        if (subject.clips.empty()) quiet("Drop a motion (.bvh, .glb) to add a clip.");
        return;
    }
    const double durationS = subject.clips[*subject.clip].durationS;
    if (ImGui::Button(state.playback.playing ? "Pause" : "Play", {64, 0})) state.playback.playing = !state.playback.playing;
    ImGui::SameLine();
    float timeS = float(timeInClip(state.playback.timeS, durationS));
    if (ImGui::SliderFloat("##time", &timeS, 0, float(durationS), "%.2f s")) state.playback.timeS = timeS, state.playback.playing = false;
    float speed = float(state.playback.speed);
    if (ImGui::SliderFloat("##speed", &speed, -2, 2, "speed %.2f")) state.playback.speed = speed;
    if (ImGui::IsItemHovered()) ImGui::SetTooltip("Ctrl and click to type a number");
    ImGui::SliderFloat("##stiffness", &subject.clothStiffness, 0, 10, "cloth stiffness %.1f", ImGuiSliderFlags_AlwaysClamp);
    if (ImGui::IsItemHovered()) ImGui::SetTooltip("1: clothes move as learned; stiffer ones swing and lag less");
}

void jointList(ViewedSubject& subject) {
    if (ImGui::Button("All as in the clip", {-1, 0})) std::fill(subject.byHandDeg.begin(), subject.byHandDeg.end(), Vec3f(0));
    ImGui::BeginChild("joints", {0, std::min(240.0f, 52.0f * float(subject.joints.size()))});
    ImGui::PushItemWidth(-1);
    for (size_t i = 0; i < subject.joints.size(); ++i) {
        ImGui::PushID(int(i));
        ImGui::TextUnformatted(subject.joints[i].c_str());
        ImGui::SliderFloat3("##angles", &subject.byHandDeg[i].x, -180, 180, "%.0f°");
        ImGui::PopID();
    }
    ImGui::PopItemWidth();
    ImGui::EndChild();
}

void pictureControls(ViewerState& state) {
    int room = !state.room ? 2 : *state.room == platform::RoomLight::Bright ? 1 : 0;
    bool changed = ImGui::RadioButton("dark", &room, 0);
    ImGui::SameLine();
    changed |= ImGui::RadioButton("bright", &room, 1);
    ImGui::SameLine();
    changed |= ImGui::RadioButton("no room", &room, 2);
    if (changed) state.room = room == 2 ? std::nullopt : std::optional(room == 1 ? platform::RoomLight::Bright : platform::RoomLight::Dark);
    if (std::any_of(state.subjects.begin(), state.subjects.end(), [](const ViewedSubject& s) { return !s.isAvatar(); }))
        if (ImGui::BeginCombo("##axes", state.axes.empty() ? "files stand as they state" : ("files are " + state.axes).c_str())) {
            if (ImGui::Selectable("as they state", state.axes.empty())) state.axes.clear(), state.wantsFrame = true;
            for (const std::string& axes : kAxesNames)
                if (ImGui::Selectable(axes.c_str(), state.axes == axes)) state.axes = axes, state.wantsFrame = true;
            ImGui::EndCombo();
        }
    ImGui::SliderFloat("##detail", &state.splatsPerPixel, 0, 24,
                       state.splatsPerPixel > 0 ? "detail %.1f splats a pixel" : "detail: all splats");
    ImGui::SliderFloat("##budget", &state.frameBudgetMs, 0, 50, state.frameBudgetMs > 0 ? "budget %.1f ms a frame" : "no frame budget");
    ImGui::SliderFloat("##magnification", &state.magnification, 0, 32,
                       state.magnification <= 0 ? "come as near as you like"
                       : state.keptAway         ? "details %.0f pixels wide: no nearer"
                                                : "details at most %.0f pixels wide");
    const float half = (ImGui::GetContentRegionAvail().x - ImGui::GetStyle().ItemSpacing.x) / 2;
    if (ImGui::Button("Screenshot", {half, 0})) state.wantsScreenshot = true;
    ImGui::SameLine();
    if (ImGui::Button("Turntable", {half, 0})) state.wantsTurntable = true;
}

const char* textOf(DplBudgetState budget) {
    switch (budget) {
        case DPL_BUDGET_UNTIMED:
            return "budget: measuring";
        case DPL_BUDGET_FREE:
            return "budget: all splats fit";
        case DPL_BUDGET_LIMITED:
            return "budget: fewer splats are drawn";
        case DPL_BUDGET_UNREACHABLE:
            return "budget: too small for this window";
        default:
            return nullptr;
    }
}

void row(const char* name, const char* format, double value) {
    ImGui::TableNextRow();
    ImGui::TableNextColumn();
    ImGui::TextUnformatted(name);
    ImGui::TableNextColumn();
    char text[32];
    std::snprintf(text, sizeof text, format, value);
    ImGui::SetCursorPosX(ImGui::GetCursorPosX() + std::max(0.0f, ImGui::GetContentRegionAvail().x - ImGui::CalcTextSize(text).x));
    ImGui::TextUnformatted(text);
}

void timings(const ViewerState& state) {
    const Figures& figures = state.figures;
    ImGui::TextWrapped("%s", state.rendererName.c_str());
    if (ImGui::BeginTable("figures", 2, ImGuiTableFlags_SizingStretchProp)) {
        ImGui::TableSetupColumn("what", 0, 2);
        ImGui::TableSetupColumn("value", 0, 1);
        row("frames a second", "%.0f", figures.framesPerSecond);
        row("splats drawn", "%.0f", figures.stats.splatsDrawn);
        row("Doppel, ms", "%.2f", figures.stats.frameMs);
        for (const auto& [label, ms] : figures.passesMs) row(("  " + label).c_str(), "%.2f", ms);
        ImGui::EndTable();
    }
    if (const char* text = textOf(figures.stats.budgetState)) ImGui::TextUnformatted(text);
}

}  // namespace

FreeSpan freeSpan(const ViewerState& state, float width) {
    constexpr float kLeft = kLeftWidth + kGap, kRight = kRightWidth + kGap;
    if (!state.panels || width < 2 * (kLeft + kRight)) return {0, width};
    return {kLeft, width - kRight};
}

void drawPanels(ViewerState& state, float width, float height) {
    beginPanel("Avatars", kGap, kGap, kLeftWidth, height - 2 * kGap);
    subjectList(state);
    if (ViewedSubject* subject = state.chosen(); subject && subject->isAvatar()) {
        if (ImGui::CollapsingHeader("Clip", ImGuiTreeNodeFlags_DefaultOpen)) clipControls(state, *subject);
        if (ImGui::CollapsingHeader("Joints by hand", ImGuiTreeNodeFlags_DefaultOpen)) jointList(*subject);
    }
    endPanel();
    if (width < kLeftWidth + kRightWidth + 3 * kGap) return;  // no room for the second column
    const float x = width - kRightWidth - kGap;
    beginPanel("Picture", x, kGap, kRightWidth, height - 2 * kGap);
    pictureControls(state);
    const float used = endPanel();
    if (state.subjects.empty()) return;
    beginPanel("Timings", x, used + 2 * kGap, kRightWidth, height - used - 3 * kGap);
    timings(state);
    endPanel();
}

void drawMessages(ViewerState& state, float width, float height) {
    if (state.messages.lines().empty()) return;
    const float wide = std::min(640.0f, width - 2 * kGap);
    ImGui::SetNextWindowPos({width / 2, height - kGap}, ImGuiCond_Always, {0.5f, 1});
    ImGui::SetNextWindowSizeConstraints({wide, 0}, {wide, FLT_MAX});
    ImGui::Begin("##messages", nullptr,
                 ImGuiWindowFlags_AlwaysAutoResize | ImGuiWindowFlags_NoMove | ImGuiWindowFlags_NoTitleBar |
                     ImGuiWindowFlags_NoSavedSettings | ImGuiWindowFlags_NoFocusOnAppearing);
    std::optional<size_t> dismissed;
    for (size_t i = 0; i < state.messages.lines().size(); ++i) {
        const Messages::Line& line = state.messages.lines()[i];
        ImGui::PushID(int(i));
        if (line.error) {
            if (ImGui::SmallButton("x")) dismissed = i;
            ImGui::SameLine();
            ImGui::PushStyleColor(ImGuiCol_Text, kError);
        }
        ImGui::TextWrapped("%s", line.text.c_str());
        if (line.error) ImGui::PopStyleColor();
        ImGui::PopID();
    }
    ImGui::End();
    if (dismissed) state.messages.dismiss(*dismissed);
}

}  // namespace dpl
