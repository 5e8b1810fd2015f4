// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <nlohmann/json.hpp>

#include "reconstruction/input/capture/scan_check.h"

namespace dpl {
namespace {

double rounded(double value, double step = 0.01) {
    return std::round(value / step) * step;
}

std::string listed(const std::vector<std::string>& names) {
    std::string text;
    for (size_t i = 0; i < names.size() && i < 6; ++i) text += (i ? ", " : "") + names[i];
    if (names.size() > 6) text += formatText(" and {} more", names.size() - 6);
    return text;
}

const char* verdictWord(ScanVerdict verdict) {
    return verdict == ScanVerdict::Pass ? "PASS" : verdict == ScanVerdict::Usable ? "USABLE" : "REFUSE";
}

}  // namespace

std::string describeScanCheck(const Scan& scan, const ScanCheck& check) {
    size_t kinds[3] = {}, held = 0, usable = 0, warnings = 0, reasons = 0;
    for (const auto& f : scan.frames) ++kinds[size_t(f.kind)], held += f.split == Split::Test;
    for (const auto& f : check.frames) usable += f.usable;
    std::string text = formatText("Scan {} ({})\n", scan.name, scan.root.string());
    for (const auto& finding : check.findings) {
        (finding.refuses ? reasons : warnings) += 1;
        text += formatText("  {} {}: {}", finding.refuses ? "x" : "!", finding.topic, finding.sentence);
        text += finding.frames.empty() ? "\n" : formatText(" [{}]\n", listed(finding.frames));
    }
    text += formatText("  frames      {} full-body, {} close-up, {} dynamic; {} held out, {} usable\n", kinds[0], kinds[1], kinds[2], held,
                       usable);
    std::string bar;
    size_t filled = 0;
    for (const uint32_t count : check.azimuth) {
        bar += count == 0 ? '.' : count < 10 ? char('0' + count) : '#';
        filled += count > 0;
    }
    text +=
        formatText("  azimuth     [{}] {} of {} bins, largest gap {} deg\n", bar, filled, kAzimuthBins, rounded(check.largestGapDeg, 1));
    text += formatText("  sharpness   blur index {} (0 sharp, 1 soft)\n", rounded(check.medianBlurIndex));
    text += formatText("  exposure    spread {} stops, largest jump {}\n", rounded(check.exposureSpreadStops),
                       rounded(check.exposureJumpStops));
    if (check.silhouetteCoherence >= 0)
        text += formatText("  cameras     masks explain {} % of themselves", rounded(100 * check.silhouetteCoherence, 0.1));
    if (check.keypointErrorPx >= 0)
        text += formatText("{}keypoints agree to {} px", check.silhouetteCoherence >= 0 ? ", " : "  cameras     ",
                           rounded(check.keypointErrorPx, 0.1));
    if (check.focalFactor >= 0) text += formatText(", focal length {} times the given", rounded(check.focalFactor));
    if (check.silhouetteCoherence >= 0 || check.keypointErrorPx >= 0) text += "\n";
    if (check.moments > 0)
        text += formatText("  moments     {} seen by four cameras or more at once, whose keypoints agree to {} px\n", check.moments,
                           rounded(check.momentErrorPx, 0.1));
    for (size_t i = 0; i < check.joints.size(); ++i) {
        const auto& joint = check.joints[i];
        text += formatText("{}{} {}-{} deg{}",
                           i % 4 ? "  "
                           : i   ? "              "
                                 : "  poses       ",
                           joint.name, rounded(joint.lowDeg, 1), rounded(joint.highDeg, 1),
                           i % 4 == 3 || i + 1 == check.joints.size() ? "\n" : "");
    }
    text += verdictWord(check.verdict);
    if (reasons)
        text += formatText(": {} reason(s), {} warning(s)", reasons, warnings);
    else if (warnings)
        text += formatText(" with {} warning(s)", warnings);
    return text + "\n";
}

std::string scanCheckJson(const Scan& scan, const ScanCheck& check) {
    nlohmann::ordered_json out;
    out["scan"] = scan.name;
    out["verdict"] = verdictWord(check.verdict);
    out["findings"] = nlohmann::ordered_json::array();
    for (const auto& f : check.findings)
        out["findings"].push_back(
            {{"severity", f.refuses ? "refuse" : "warning"}, {"topic", f.topic}, {"sentence", f.sentence}, {"frames", f.frames}});
    out["azimuth_bins"] = check.azimuth;
    out["largest_gap_deg"] = check.largestGapDeg;
    out["median_blur_index"] = check.medianBlurIndex;
    out["exposure_spread_stops"] = check.exposureSpreadStops;
    out["exposure_jump_stops"] = check.exposureJumpStops;
    const auto orNull = [](double value) { return value >= 0 ? nlohmann::ordered_json(value) : nlohmann::ordered_json(nullptr); };
    out["silhouette_coherence"] = orNull(check.silhouetteCoherence);
    out["keypoint_error_px"] = orNull(check.keypointErrorPx);
    out["moments"] = check.moments;
    out["moment_error_px"] = orNull(check.momentErrorPx);
    out["focal_factor"] = orNull(check.focalFactor);
    out["joints"] = nlohmann::ordered_json::array();
    for (const auto& j : check.joints)
        out["joints"].push_back({{"name", j.name}, {"frames", j.frames}, {"low_deg", j.lowDeg}, {"high_deg", j.highDeg}});
    out["frames"] = nlohmann::ordered_json::array();
    for (const auto& f : check.frames) {
        nlohmann::ordered_json entry{{"name", f.name}, {"usable", f.usable}};
        if (!f.error.empty()) entry["error"] = f.error;
        if (f.measured) {
            entry["sharpness"] = f.sharpness;
            entry["relative_sharpness"] = f.relativeSharpness;
            entry["blur_index"] = f.blurIndex;
            entry["brightness"] = f.brightness;
            entry["mask_share"] = orNull(f.maskShare);
            entry["border_share"] = f.borderShare;
            entry["keypoints_on_person"] = orNull(f.keypointsOnPerson);
        }
        out["frames"].push_back(std::move(entry));
    }
    return out.dump(1, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + "\n";
}

}  // namespace dpl
