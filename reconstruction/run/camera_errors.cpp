// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/run/camera_errors.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>
#include <numbers>

#include "reconstruction/input/cameras/align_cameras.h"
#include "sdk/core/percentile.h"

namespace dpl {
namespace {

constexpr double kDegrees = 180 / std::numbers::pi;

std::optional<FrameKind> kindOf(const ScanFrame& frame) {
    if (frame.split == Split::Test) return std::nullopt;
    return frame.kind;
}

/** Where a person who stands at the origin is. */
std::vector<Vec3d> personPoints() {
    std::vector<Vec3d> points;
    for (double y = 0.05; y < 1.75; y += 0.2)
        for (const double x : {-0.2, 0.0, 0.2}) points.emplace_back(x, y, 0);
    return points;
}

}  // namespace

Result<CameraErrors> compareCameras(const Scan& scan, const Scan& truth) {
    if (!truth.metricWorld) return fail(Code::InvalidArgument, "{}: the true cameras must be in metres", truth.root.string());
    std::map<std::string, const ScanFrame*> byName;
    for (const ScanFrame& frame : scan.frames) byName[frame.name] = &frame;
    std::vector<Camerad> from, to;
    for (const ScanFrame& frame : truth.frames)
        if (const auto found = byName.find(frame.name); found != byName.end() && kindOf(frame) == FrameKind::StaticFull)
            from.push_back(found->second->camera), to.push_back(frame.camera);
    const auto align = alignCameras(from, to);
    if (!align) return fail(Code::NotFound, "only {} still training frames have a camera in both scans", from.size());
    CameraErrors out;
    out.scale = align->scale;
    out.tiltDeg = std::acos(std::clamp((align->rotation * Vec3d(0, 1, 0)).y, -1.0, 1.0)) * kDegrees;
    out.focalPx = from[0].fx, out.trueFocalPx = to[0].fx;
    const std::vector<Vec3d> points = personPoints();
    for (const auto kind : {std::optional(FrameKind::StaticFull), std::optional(FrameKind::StaticCloseup),
                            std::optional(FrameKind::Dynamic), std::optional<FrameKind>()}) {
        CameraErrorRow row;
        row.kind = kind;
        std::vector<double> eyes, turns, px;
        for (const ScanFrame& frame : truth.frames) {
            if (kindOf(frame) != kind) continue;
            ++row.frames;
            const auto found = byName.find(frame.name);
            if (found == byName.end()) {
                ++row.missing;
                continue;
            }
            const CameraError error = cameraError(moved(found->second->camera, *align), frame.camera, points);
            eyes.push_back(1000 * error.eye), turns.push_back(kDegrees * error.rotationRad);
            if (error.px >= 0) px.push_back(error.px);
        }
        row.eyeMmMedian = percentile(eyes, 0.5), row.eyeMmP90 = percentile(eyes, 0.9), row.eyeMmWorst = percentile(eyes, 1);
        row.turnDegMedian = percentile(turns, 0.5), row.turnDegP90 = percentile(turns, 0.9), row.turnDegWorst = percentile(turns, 1);
        row.pxMedian = percentile(px, 0.5), row.pxP90 = percentile(px, 0.9);
        if (row.frames > 0) out.rows.push_back(row);
    }
    return out;
}

std::string describeCameraErrors(const CameraErrors& errors) {
    char line[200];
    std::snprintf(line, sizeof line, "focal length %.2f px of %.2f px; up is off by %.2f degrees; one unit is %.4f m\n", errors.focalPx,
                  errors.trueFocalPx, errors.tiltDeg, errors.scale);
    std::string text = line;
    text +=
        "kind        frames missing   eye mm: median   90 %  worst   turn deg: median   90 %  worst   on the person px: median   90 %\n";
    for (const CameraErrorRow& row : errors.rows) {
        std::snprintf(line, sizeof line, "%-10s %7zu %7zu %16.2f %6.2f %6.2f %18.3f %6.3f %6.3f %25.2f %6.2f\n",
                      row.kind ? shortKindName(*row.kind) : "held out", row.frames, row.missing, row.eyeMmMedian, row.eyeMmP90,
                      row.eyeMmWorst, row.turnDegMedian, row.turnDegP90, row.turnDegWorst, row.pxMedian, row.pxP90);
        text += line;
    }
    return text;
}

}  // namespace dpl
