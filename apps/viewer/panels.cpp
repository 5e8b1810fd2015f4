// SPDX-License-Identifier: Apache-2.0
#include "apps/viewer/panels.h"

#include <imgui.h>

#include <algorithm>
#include <cfloat>

#include "apps/shared/pictures.h"
#include "apps/viewer/compare_panel.h"
#include "apps/viewer/dressing_panel.h"
#include "apps/viewer/export_panel.h"
#include "apps/viewer/new_run_panel.h"
#include "apps/viewer/open_panel.h"
#include "apps/viewer/overlay_panel.h"
#include "apps/viewer/run_panel.h"

namespace dpl {
namespace {

constexpr float kLeftWidth = 292, kRightWidth = 268, kGap = 12, kTimelineHeight = 46, kWidestTimeline = 760;
constexpr float kFarthestM = 5;       // that a subject is moved
constexpr size_t kRecentAtStart = 5;  // of what was opened lately
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
    if (state.subjects.empty()) {  // also while the first is loaded: nothing moves from under the cursor
        ImGui::TextWrapped("Drop an avatar (.glb) or splats (.ply, .spz, .glb) on the window, or a film of a person to make an avatar of.");
        ImGui::BeginDisabled(!state.atHand.empty() && !state.rendererName.empty());  // before there is a renderer it waits for it
        if (ImGui::Button("Load the sample", {-1, 0})) state.wantsSample = true;
        ImGui::EndDisabled();
        if (ImGui::IsItemHovered()) ImGui::SetTooltip("An avatar that comes with Doppel; it is made the first time, in seconds");
        if (!state.settings.recent.empty()) quiet("Opened lately");
        drawRecent(state, kRecentAtStart);
    }
    for (size_t i = 0; i < state.subjects.size(); ++i) {
        const ViewedSubject& subject = state.subjects[i];
        ImGui::PushID(int(i));
        ImGui::Checkbox("##shown", &state.subjects[i].shown);
        if (ImGui::IsItemHovered()) ImGui::SetTooltip(subject.shown ? "Hide %s" : "Show %s", subject.file.c_str());
        ImGui::SameLine();
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
    const float half = (ImGui::GetContentRegionAvail().x - ImGui::GetStyle().ItemSpacing.x) / 2;
    if (ImGui::Button("Open ...", {half, 0})) state.wantsOpenWindow = true;
    if (ImGui::IsItemHovered()) ImGui::SetTooltip("The key O does it too");
    ImGui::SameLine();
    if (ImGui::Button("Export ...", {half, 0})) openExport(state);
    if (ImGui::IsItemHovered()) ImGui::SetTooltip("Pictures, videos, splats and meshes; the key E does it too");
    if (!state.atHand.empty()) ImGui::TextWrapped("Loading %s ...", state.atHand.c_str());
}

void clipControls(ViewerState& state, ViewedSubject& subject) {
    const char* shown = subject.clip ? subject.clips[*subject.clip].name.c_str() : "rest pose";
    if (ImGui::BeginCombo("##clip", shown)) {
        if (ImGui::Selectable("rest pose", !subject.clip)) state.wantsClip.emplace(std::nullopt);
        for (uint32_t i = 0; i < subject.clips.size(); ++i) {
            ImGui::PushID(int(i));
            if (ImGui::Selectable(subject.clips[i].name.c_str(), subject.clip == i)) state.wantsClip.emplace(i);
            ImGui::PopID();
        }
        ImGui::EndCombo();
    }
    if (!subject.clip) {
        if (subject.clips.empty()) quiet("Drop a motion (.bvh, .glb) to add a clip.");
        return;
    }
    ImGui::SliderFloat("##stiffness", &subject.clothStiffness, 0, 10, "cloth stiffness %.1f", ImGuiSliderFlags_AlwaysClamp);
    if (ImGui::IsItemHovered()) ImGui::SetTooltip("1: clothes move as learned; stiffer ones swing and lag less");
    if (ImGui::Button("Settle clothes", {-1, 0}))
        if (const auto settled = subject.avatar.settle(); !settled) state.messages.error(settled.error().message);
    if (ImGui::IsItemHovered()) ImGui::SetTooltip("Clothes forget how the avatar moved until now");
}

/** Play, time, loop and speed of all clips; the length is that of the chosen avatar's. */
void timeline(ViewerState& state, float width, float height) {
    const ViewedSubject* chosen = state.chosen();
    if (!chosen || !chosen->clip || state.compared) return;
    const FreeSpan free = freeSpan(state, width);
    const float wide = std::min(kWidestTimeline, free.right - free.left - 2 * kGap);
    ImGui::SetNextWindowPos({0.5f * (free.left + free.right), height - kGap}, ImGuiCond_Always, {0.5f, 1});
    ImGui::SetNextWindowSize({wide, 0}, ImGuiCond_Always);
    ImGui::Begin("##timeline", nullptr,
                 ImGuiWindowFlags_NoTitleBar | ImGuiWindowFlags_NoResize | ImGuiWindowFlags_NoMove | ImGuiWindowFlags_NoSavedSettings |
                     ImGuiWindowFlags_NoFocusOnAppearing | ImGuiWindowFlags_NoScrollbar);
    Playback& clock = state.playback;
    const double durationS = chosen->clips[*chosen->clip].durationS;
    if (ImGui::Button(clock.playing ? "Pause" : "Play", {64, 0})) {
        clock.playing = !clock.playing;
        if (clock.playing && !clock.loop && clock.timeS >= durationS) clock.timeS = 0;
    }
    if (ImGui::IsItemHovered()) ImGui::SetTooltip("The space bar does it too");
    ImGui::SameLine();
    ImGui::PushItemWidth(std::max(40.0f, ImGui::GetContentRegionAvail().x - 172));
    float timeS = float(timeInClip(clock.timeS, durationS, clock.loop));
    if (ImGui::SliderFloat("##time", &timeS, 0, float(durationS), "%.2f s")) clock.timeS = timeS, clock.playing = false;
    ImGui::PopItemWidth();
    ImGui::SameLine();
    ImGui::Checkbox("loop", &clock.loop);
    ImGui::SameLine();
    ImGui::PushItemWidth(-1);
    float speed = float(clock.speed);
    if (ImGui::DragFloat("##speed", &speed, 0.01f, -2, 2, "%.2f x", ImGuiSliderFlags_AlwaysClamp)) clock.speed = speed;
    if (ImGui::IsItemHovered()) ImGui::SetTooltip("Speed: drag sideways, or double click to type; below 0 it plays backwards");
    ImGui::PopItemWidth();
    ImGui::End();
}

void jointList(ViewedSubject& subject) {
    if (ImGui::Button("All as in the clip", {-1, 0})) std::fill(subject.byHandDeg.begin(), subject.byHandDeg.end(), Vec3f(0));
    ImGui::BeginChild("joints", {0, std::min(240.0f, 52.0f * float(subject.joints.size()))});
    ImGui::PushItemWidth(-1);
    for (size_t region = 0; region < kBodyRegions; ++region) {
        const auto here = [&](size_t joint) { return size_t(subject.regions[joint]) == region; };
        bool any = false;
        for (size_t i = 0; i < subject.joints.size() && !any; ++i) any = here(i);
        if (!any || !ImGui::TreeNodeEx(nameOf(BodyRegion(region)), ImGuiTreeNodeFlags_SpanAvailWidth)) continue;
        for (size_t i = 0; i < subject.joints.size(); ++i) {
            if (!here(i)) continue;
            ImGui::PushID(int(i));
            ImGui::TextUnformatted(subject.joints[i].c_str());
            ImGui::SliderFloat3("##angles", &subject.byHandDeg[i].x, -180, 180, "%.0f°");
            ImGui::PopID();
        }
        ImGui::TreePop();
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
    if (changed)
        state.settings.room = room == 2   ? "none"
                              : room == 1 ? "bright"
                                          : "dark",
        state.room = room == 2 ? std::nullopt : std::optional(room == 1 ? platform::RoomLight::Bright : platform::RoomLight::Dark);
    if (std::any_of(state.subjects.begin(), state.subjects.end(), [](const ViewedSubject& s) { return !s.isAvatar(); }))
        if (ImGui::BeginCombo("##axes", state.axes.empty() ? "files stand as they state" : ("files are " + state.axes).c_str())) {
            if (ImGui::Selectable("as they state", state.axes.empty())) state.axes.clear(), state.wantsFrame = true;
            for (const std::string& axes : kAxesNames)
                if (ImGui::Selectable(axes.c_str(), state.axes == axes)) state.axes = axes, state.wantsFrame = true;
            ImGui::EndCombo();
        }
    float lensDeg = glm::degrees(float(state.camera.fovYRad()));
    if (ImGui::SliderFloat("##lens", &lensDeg, glm::degrees(float(OrbitCamera::kLeastFovYRad)),
                           glm::degrees(float(OrbitCamera::kMostFovYRad)), "lens %.0f°", ImGuiSliderFlags_AlwaysClamp))
        state.camera.setFovY(glm::radians(double(lensDeg)));
    if (ImGui::IsItemHovered())
        ImGui::SetTooltip("Field of view: narrow as a portrait lens, wide as a phone's. The person keeps their size");
    if (ImGui::Button("Keys and mouse (F1)", {-1, 0})) state.help = !state.help;
    if (!ImGui::CollapsingHeader("For engineers")) return;
    ImGui::SliderFloat("##detail", &state.splatsPerPixel, 0, 24,
                       state.splatsPerPixel > 0 ? "detail %.1f splats a pixel" : "detail: all splats");
    ImGui::SliderFloat("##budget", &state.frameBudgetMs, 0, 50, state.frameBudgetMs > 0 ? "budget %.1f ms a frame" : "no frame budget");
    ImGui::SliderFloat("##magnification", &state.magnification, 0, 32,
                       state.magnification <= 0 ? "come as near as you like"
                       : state.keptAway         ? "details %.0f pixels wide: no nearer"
                                                : "details at most %.0f pixels wide");
    if (ImGui::IsItemHovered()) ImGui::SetTooltip("How near the camera may come before it shows more than the scan has seen; 0: no limit");
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

namespace {

/** Between the panels. */
FreeSpan betweenPanels(const ViewerState& state, float width) {
    constexpr float kLeft = kLeftWidth + kGap, kRight = kRightWidth + kGap;
    if (!state.panels || width < 2 * (kLeft + kRight)) return {0, width};
    return {kLeft, width - kRight};
}

}  // namespace

FreeSpan heldBackSpan(const ViewerState& state, float width) {
    constexpr float kLeastWidth = 400;  // of both
    const FreeSpan free = betweenPanels(state, width);
    if (state.compared) return {};
    const bool belowPanels = state.panels && free.left == 0;
    if (!state.run || state.run->heldBack.id == 0 || belowPanels || free.right - free.left < kLeastWidth) return {};
    return {free.left + kHeldBackMargin, 0.5f * (free.left + free.right) - kHeldBackMargin / 2};
}

FreeSpan freeSpan(const ViewerState& state, float width) {
    const FreeSpan free = betweenPanels(state, width), heldBack = heldBackSpan(state, width);
    return heldBack.left < heldBack.right ? FreeSpan{heldBack.right, free.right} : free;
}

void drawPanels(ViewerState& state, float width, float height) {
    float top = kGap;
    const ViewedSubject* played = state.chosen();
    const bool overBar = played && played->clip && !state.compared && freeSpan(state, width).left < kLeftWidth;
    const float bottom = height - kGap - (overBar ? kTimelineHeight + kGap : 0);
    if (state.compared) {
        beginPanel("Compare", kGap, top, kLeftWidth, height - 2 * kGap);
        drawComparison(state);
        top += endPanel() + kGap;
    }
    if (state.starter) {
        beginPanel("New avatar", kGap, top, kLeftWidth, height - 2 * kGap);
        drawNewRun(state);
        top += endPanel() + kGap;
    }
    if (state.run) {
        beginPanel(("Run: " + state.run->watch.name() + "###run").c_str(), kGap, top, kLeftWidth, height - 2 * kGap);
        const FreeSpan heldBack = heldBackSpan(state, width);
        drawRun(state, heldBack.left < heldBack.right);
        top += endPanel() + kGap;
    }
    beginPanel("Avatars", kGap, top, kLeftWidth, bottom - top);
    subjectList(state);
    if (ViewedSubject* subject = state.chosen(); subject) {
        ImGui::SliderFloat("##turned", &subject->turnedDeg, -180, 180, "turned by %.0f°", ImGuiSliderFlags_AlwaysClamp);
        ImGui::PushItemWidth((ImGui::GetContentRegionAvail().x - ImGui::GetStyle().ItemSpacing.x) / 2);
        for (int axis = 0; axis < 2; ++axis) {
            if (axis == 1) ImGui::SameLine();
            ImGui::PushID(axis);
            ImGui::DragFloat("##moved", &subject->movedM[axis], 0.01f, -kFarthestM, kFarthestM, axis == 0 ? "right %.2f m" : "front %.2f m",
                             ImGuiSliderFlags_AlwaysClamp);
            if (ImGui::IsItemHovered()) ImGui::SetTooltip("Moved by hand: drag sideways, or double click to type");
            if (ImGui::IsItemDeactivatedAfterEdit()) state.wantsRoom = true;
            ImGui::PopID();
        }
        ImGui::PopItemWidth();
    }
    if (ViewedSubject* subject = state.chosen(); subject && subject->isAvatar()) {
        if (subject->comparable && !state.compared) {
            if (ImGui::Button("Compare with its pictures", {-1, 0})) state.wantsCompare = true;
            if (ImGui::IsItemHovered()) ImGui::SetTooltip("The photographs of its scan over or beside it, and what differs");
        }
        if (ImGui::CollapsingHeader("Clip", ImGuiTreeNodeFlags_DefaultOpen)) clipControls(state, *subject);
        if (ImGui::CollapsingHeader("Joints by hand")) jointList(*subject);
        drawOverlayChoice(state);
        drawDressing(state);
    }
    endPanel();
    timeline(state, width, height);
    if (width < kLeftWidth + kRightWidth + 3 * kGap) return;  // no room for the second column
    const float x = width - kRightWidth - kGap;
    beginPanel("Picture", x, kGap, kRightWidth, height - 2 * kGap);
    pictureControls(state);
    const float used = endPanel();
    if (state.subjects.empty()) return;
    ImGui::SetNextWindowCollapsed(true, ImGuiCond_Once);
    beginPanel("Timings", x, used + 2 * kGap, kRightWidth, height - used - 3 * kGap);
    timings(state);
    endPanel();
}

void drawHelp(ViewerState& state, float width, float height) {
    if (!state.help) return;
    static constexpr const char* kWays[][2] = {
        {"drag", "turn around the middle"},
        {"right or middle button", "move sideways; shift and drag too"},
        {"wheel", "nearer to the cursor, farther"},
        {"double click", "turn around this place, from nearer"},
        {"1  2  3", "body, face, one hand, then the other"},
        {"F", "show everything"},
        {"O", "open a file"},
        {"left, right", "the next photograph, while comparing"},
        {"space", "play, pause"},
        {"H", "hide or show the panels"},
        {"E", "export pictures, videos, files"},
        {"P", "save a picture without panels"},
        {"F1", "this list"},
    };
    ImGui::SetNextWindowPos({width / 2, height / 2}, ImGuiCond_Always, {0.5f, 0.5f});
    bool open = true;
    ImGui::Begin(
        "Keys and mouse", &open,
        ImGuiWindowFlags_AlwaysAutoResize | ImGuiWindowFlags_NoMove | ImGuiWindowFlags_NoCollapse | ImGuiWindowFlags_NoSavedSettings);
    if (ImGui::BeginTable("ways", 2, ImGuiTableFlags_SizingFixedFit)) {
        for (const auto& way : kWays)
            for (const char* text : way) {
                ImGui::TableNextColumn();
                ImGui::TextUnformatted(text);
            }
        ImGui::EndTable();
    }
    ImGui::End();
    state.help = open;
}

void drawMessages(ViewerState& state, float width, float height) {
    if (state.messages.lines().empty()) return;
    const float wide = std::min(640.0f, width - 2 * kGap);
    const bool bar = state.panels && state.chosen() && state.chosen()->clip;
    ImGui::SetNextWindowPos({width / 2, height - kGap - (bar ? kTimelineHeight + kGap : 0)}, ImGuiCond_Always, {0.5f, 1});
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
