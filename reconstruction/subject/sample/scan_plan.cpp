// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/subject/sample/scan_plan.h"

#include <cmath>
#include <cstdio>

#include "reconstruction/subject/sample/hair_swing.h"
#include "reconstruction/subject/sample/random.h"
#include "reconstruction/subject/sample/skeleton.h"

namespace dpl {
namespace {

constexpr double kTau = 6.283185307179586;

Camerad cameraAt(const SampleScanOptions& o, const Vec3d& eye, const Vec3d& target, double rollRad) {
    Camerad c;
    c.widthPx = o.widthPx, c.heightPx = o.heightPx;
    // A lens of 26 mm (35 mm equivalent): the image's diagonal corresponds to 43.27 mm of film.
    c.fx = c.fy = 26.0 / 43.266615 * std::hypot(double(o.widthPx), double(o.heightPx));
    c.cx = 0.5 * o.widthPx, c.cy = 0.5 * o.heightPx;
    const Vec3d z = glm::normalize(target - eye), level = glm::normalize(glm::cross(z, Vec3d(0, 1, 0))), down = glm::cross(z, level);
    const Vec3d x = std::cos(rollRad) * level + std::sin(rollRad) * down, y = glm::cross(z, x);
    c.viewFromWorldRotation = glm::transpose(Mat3d(x, y, z));
    c.viewFromWorldTranslation = -(c.viewFromWorldRotation * eye);
    return c;
}

std::string numbered(const char* stem, uint32_t index) {
    char text[32];
    std::snprintf(text, sizeof text, "%s_%03u", stem, index);
    return text;
}

struct CloseUp {
    const char* of;
    Vec3d target;
    double azimuthRad, distanceM;  // azimuth 0 is in front, positive towards the subject's left
    double spreadRad, lift;        // shots lie within ±spreadRad of the azimuth; the eye is lift · distanceM above the target
};

}  // namespace

std::vector<PlannedFrame> planScan(const Subject& subject, const SampleScanOptions& o) {
    std::vector<PlannedFrame> frames;
    Random random(o.seed, 31);
    double top = 0;
    for (const Vec3f& p : subject.mesh.restPositions) top = std::max(top, double(p.y));
    const double reach = 1.98 * top / 1.78;  // camera distance, proportional to the person's height
    const Vec3d middle(0, 0.51 * top, 0);

    // Three rings, one after the other, as a person with a camera would walk.
    for (uint32_t i = 0; i < o.fullFrames; ++i) {
        const double turn = 3.0 * i / o.fullFrames, ring = std::floor(turn);
        const double azimuth = kTau * (turn + ring * 0.17) + random.uniform(-0.04, 0.04), height = ring == 0   ? 1.25
                                                                                                   : ring == 1 ? 0.75
                                                                                                               : 1.80;
        const double distance = reach * random.uniform(0.97, 1.05);
        const Vec3d eye(distance * std::sin(azimuth), height * top / 1.78 + random.uniform(-0.05, 0.05), distance * std::cos(azimuth));
        PlannedFrame f;
        f.name = numbered("full", i);
        f.kind = FrameKind::StaticFull;
        f.split = i % 10 == 5 ? Split::Test : Split::Train;
        f.camera = cameraAt(o, eye, middle + Vec3d(random.uniform(-0.03, 0.03), random.uniform(-0.03, 0.03), random.uniform(-0.03, 0.03)),
                            random.uniform(-0.02, 0.02));
        f.pose = staticPose(o.seed, i, o.fingers);
        frames.push_back(std::move(f));
    }

    const Vec3d head(subject.joints[kHead].restPosition), chest(subject.joints[kSpine3].restPosition);
    const Vec3d left(subject.joints[kLeftMiddle1].restPosition), right(left * Vec3d(-1, 1, 1)),
        foot(subject.joints[kLeftFoot].restPosition);
    const CloseUp views[] = {
        {"logo", {0, chest.y - 0.05, 0.05}, 0, 0.85, 0.55, 0.12},
        {"back", {0, chest.y - 0.02, -0.05}, kTau / 2, 0.90, 0.60, 0.15},
        {"face", {0, head.y + 0.075, 0.03}, 0, 0.58, 0.85, 0.08},
        {"hand_l", left, 1.35, 0.50, 0.60, 0.25},
        {"hand_r", right, -1.35, 0.50, 0.60, 0.25},
        {"feet", {0, 0.10, foot.z - 0.06}, 0, 0.85, 0.9, 0.75},
    };
    for (uint32_t i = 0; i < o.closeupFrames; ++i) {
        const CloseUp& v = views[i * std::size(views) / o.closeupFrames];
        // `share`: this shot's place among those of the same target, from −1 to 1.
        uint32_t first = i, last = i;
        while (first > 0 && (first - 1) * std::size(views) / o.closeupFrames == i * std::size(views) / o.closeupFrames) --first;
        while (last + 1 < o.closeupFrames && (last + 1) * std::size(views) / o.closeupFrames == i * std::size(views) / o.closeupFrames)
            ++last;
        const double share = last > first ? 2.0 * (i - first) / (last - first) - 1 : 0;
        const double azimuth = v.azimuthRad + v.spreadRad * share + random.uniform(-0.06, 0.06),
                     distance = v.distanceM * random.uniform(0.95, 1.05);
        const Vec3d eye = v.target + distance * Vec3d(std::sin(azimuth), v.lift + random.uniform(-0.06, 0.06), std::cos(azimuth));
        PlannedFrame f;
        f.name = numbered("close", i);
        f.kind = FrameKind::StaticCloseup;
        f.closeupOf = v.of;
        f.camera = cameraAt(o, eye, v.target, random.uniform(-0.03, 0.03));
        f.pose = staticPose(o.seed, 1000 + i, o.fingers);
        const bool hand = f.closeupOf == "hand_l" || f.closeupOf == "hand_r";
        if (o.fingers && hand && i == last && last > first) f.split = Split::Test;
        if (o.chart && f.closeupOf == "logo" && i == (first + last) / 2 && last > first) f.split = Split::Test;
        frames.push_back(std::move(f));
    }

    const SampleMotion motion = SampleMotion::dynamicSequence(o.seed, o.dynamicS, o.fingers, o.hair == Hairstyle::Long);
    SwingSimulation swing(subject, motion);
    HairSwing hair(subject, motion);
    for (uint32_t i = 0; i < o.dynamicFrames; ++i) {
        PlannedFrame f;
        f.name = numbered("dyn", i);
        f.kind = FrameKind::Dynamic;
        f.split = i % 10 == 4 ? Split::Test : Split::Train;
        f.timeS = o.dynamicS * (i + 1) / (o.dynamicFrames + 1);
        f.pose = motion.pose(f.timeS);
        f.lag = swing.at(f.timeS);
        f.lockNodes = hair.at(f.timeS);
        f.keepPosed = i % 3 == 0 || f.split == Split::Test;
        const double azimuth = kTau * 1.5 * i / std::max(1u, o.dynamicFrames) + random.uniform(-0.03, 0.03),
                     distance = 1.09 * reach * random.uniform(0.98, 1.04);
        const Vec3d eye(distance * std::sin(azimuth), (1.15 + 0.25 * std::sin(0.7 * f.timeS)) * top / 1.78, distance * std::cos(azimuth));
        f.camera = cameraAt(o, eye, middle + Vec3d(0, 0.10, 0), random.uniform(-0.02, 0.02));
        frames.push_back(std::move(f));
    }
    for (const FrameKind kind : {FrameKind::StaticFull, FrameKind::Dynamic})
        if (const auto f =
                std::find_if(frames.begin(), frames.end(), [&](const PlannedFrame& p) { return p.kind == kind && p.split == Split::Test; });
            f != frames.end())
            f->keepFine = true;
    return frames;
}

}  // namespace dpl
