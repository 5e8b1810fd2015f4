// SPDX-License-Identifier: Apache-2.0
#include "apps/viewer/timings_panel.h"

#include <imgui.h>

#include <algorithm>
#include <cstdio>

namespace dpl {
namespace {

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

}  // namespace

void drawTimings(const ViewerState& state) {
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

}  // namespace dpl
