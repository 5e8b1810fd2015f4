// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/subject/sample/scan_writer.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstdio>
#include <memory>
#include <span>

#include "reconstruction/base/image_codec.h"
#include "reconstruction/input/capture/hand_keypoints.h"
#include "reconstruction/subject/sample/random.h"
#include "reconstruction/subject/sample/raycast.h"
#include "reconstruction/subject/sample/scan_files.h"
#include "sdk/core/task.h"

namespace dpl {
namespace {

namespace fs = std::filesystem;

constexpr uint64_t kBodyNoise = 50000, kHandNoise = 60000;  // streams of random numbers, one for each frame
constexpr int kFineScale = 4;                               // enlarged pictures score avatars that are drawn larger than they were trained
constexpr const char* kFineFolder = "hires/x4";
constexpr uint32_t kMaxSidePx = 4096;  // an enlarged picture then has at most 268 million pixels

Status writeFile(const fs::path& path, std::span<const uint8_t> bytes) {
    std::FILE* file = std::fopen(path.c_str(), "wb");
    if (!file) return fail(Code::Io, "cannot create {}: check that the folder is writable", path.string());
    const bool wrote = std::fwrite(bytes.data(), 1, bytes.size(), file) == bytes.size();
    const bool closed = std::fclose(file) == 0;
    if (!wrote || !closed) return fail(Code::Io, "cannot write {} ({} bytes): is the disk full?", path.string(), bytes.size());
    return {};
}

Status writeText(const fs::path& path, const std::string& text) {
    return writeFile(path, {reinterpret_cast<const uint8_t*>(text.data()), text.size()});
}

Status writeGrey(const fs::path& path, std::span<const uint8_t> pixels, uint32_t widthPx, uint32_t heightPx) {
    DPL_TRY(const auto bytes, encodePng(pixels, widthPx, heightPx, 1));
    return writeFile(path, bytes);
}

Status writeColours(const fs::path& path, const RaycastFrame& picture, uint32_t widthPx, uint32_t heightPx, int quality) {
    DPL_TRY(const auto bytes, encodeJpeg(picture.rgb, widthPx, heightPx, 3, quality));
    return writeFile(path, bytes);
}

/** Depth below the surface, metres, at which a keypoint still counts as visible: the thickness of the limb around it. */
double limbThickness(const std::string& name) {
    const std::string base = name.substr(0, name.find('_'));
    if (base == "nose" || base == "eye" || base == "ear" || base == "head") return 0.025;
    if (base == "pelvis" || base == "hip") return 0.15;
    if (base == "neck" || base == "shoulder") return 0.10;
    if (handKeypointNamed(name) >= 0) return 0.02;
    if (base == "knee" || base == "ankle" || base == "elbow") return 0.08;
    return 0.05;
}

std::vector<SampleKeypoint> observe(std::span<const BodyKeypoint> keypoints, const PersonTracer& tracer, const Camerad& camera,
                                    const std::vector<Vec3d>& points, Random random) {
    std::vector<SampleKeypoint> out;
    // Noise of a good detector: 1.5 px in a picture 378 px wide. Hidden points get 2.5 times as much.
    const double unit = 1.5 * double(camera.widthPx) / 378;
    for (size_t k = 0; k < points.size(); ++k) {
        SampleKeypoint truth;
        const double n0 = random.normal(), n1 = random.normal(), n2 = random.normal();
        const Vec3d view = camera.toView(points[k]);
        truth.inFront = view.z > 0.05;
        if (truth.inFront) {
            truth.px = {camera.fx * view.x / view.z + camera.cx, camera.fy * view.y / view.z + camera.cy};
            const bool inside = truth.px.x >= 0 && truth.px.y >= 0 && truth.px.x < camera.widthPx && truth.px.y < camera.heightPx;
            if (inside) {
                const double hit = tracer.firstHit(camera.eye(), points[k]) * glm::length(points[k] - camera.eye());
                const double depth = glm::length(points[k] - camera.eye());
                truth.visibility = hit > depth - limbThickness(keypoints[k].name) ? 2 : 1;
            }
            truth.sigmaPx = truth.visibility == 2 ? unit : 2.5 * unit;
            truth.noisyPx = truth.px + Vec2d(n0, n1) * truth.sigmaPx;
            if (inside) truth.confidence = std::clamp((truth.visibility == 2 ? 0.94 : 0.46) + 0.045 * n2, 0.05, 1.0);
        } else {
            truth.sigmaPx = 2.5 * unit;
        }
        out.push_back(truth);
    }
    return out;
}

Status writeFrame(const fs::path& folder, const Subject& subject, const PlannedFrame& frame, size_t index, const SampleScanOptions& o,
                  PersonTracer& tracer, TruePoints& points) {
    const std::vector<Vec3d> vertices =
        poseSubject(subject, frame.pose, frame.kind == FrameKind::Dynamic ? &frame.lag : nullptr, frame.lockNodes);
    points.body = keypointsWorld(subject, subject.keypoints, frame.pose, vertices);
    if (o.fingers) points.hands = keypointsWorld(subject, subject.handKeypoints, frame.pose, vertices);
    if (o.chart && frame.closeupOf == "logo" && frame.split == Split::Test) points.bars = seeBars(subject, vertices, frame.camera);
    tracer.setVertices(vertices);
    const RaycastOptions ray = sampleRays(o, index);
    const RaycastFrame picture = tracer.render(frame.camera, ray);
    DPL_RETURN_IF_ERROR(writeColours(folder / "images" / (frame.name + ".jpg"), picture, o.widthPx, o.heightPx, o.jpegQuality));
    DPL_RETURN_IF_ERROR(writeGrey(folder / "masks" / (frame.name + ".png"), picture.mask, o.widthPx, o.heightPx));
    DPL_RETURN_IF_ERROR(writeGrey(folder / "labels" / (frame.name + ".png"), picture.labels, o.widthPx, o.heightPx));
    if (frame.keepFine) {
        const Camerad camera = frame.camera.scaled(kFineScale);
        const RaycastFrame fine = tracer.render(camera, ray);
        DPL_RETURN_IF_ERROR(
            writeColours(folder / kFineFolder / (frame.name + ".jpg"), fine, camera.widthPx, camera.heightPx, o.jpegQuality));
        DPL_RETURN_IF_ERROR(writeGrey(folder / kFineFolder / (frame.name + ".mask.png"), fine.mask, camera.widthPx, camera.heightPx));
    }
    std::vector<SampleKeypoint> seen = observe(subject.keypoints, tracer, frame.camera, points.body, Random(o.seed, kBodyNoise + index));
    const std::vector<SampleKeypoint> hands =
        observe(subject.handKeypoints, tracer, frame.camera, points.hands, Random(o.seed, kHandNoise + index));
    seen.insert(seen.end(), hands.begin(), hands.end());
    DPL_RETURN_IF_ERROR(writeText(folder / "keypoints" / (frame.name + ".json"), keypointsJson(subject, frame, seen)));
    if (frame.keepPosed) DPL_RETURN_IF_ERROR(writeFile(folder / "posed" / (frame.name + ".bin"), posedBin(vertices)));
    return {};
}

Status writeAll(const fs::path& folder, const SampleScanOptions& o, Jobs& jobs) {
    DPL_RETURN_IF_ERROR(taskAt(0, "modelling the subject"));
    Subject subject = makeSubject(o.seed, jobs, o.skirt ? Bottom::Skirt : Bottom::Shorts, o.hair);
    subject.look.chart = o.chart;
    const std::vector<PlannedFrame> frames = planScan(subject, o);
    std::error_code error;
    for (const char* name : {"images", "masks", "labels", "keypoints", "geometry", "posed", kFineFolder}) {
        fs::create_directories(folder / name, error);
        if (error) return fail(Code::Io, "cannot create {}: {}", (folder / name).string(), error.message());
    }
    std::vector<std::unique_ptr<PersonTracer>> tracers(jobs.threadCount());
    std::vector<TruePoints> points(frames.size());
    std::vector<Status> results(frames.size());
    std::atomic<bool> stopped{false};
    std::atomic<size_t> done{0};
    Status goesOn;  // of the calling thread, which is worker 0
    jobs.forBlocks(frames.size(), [&](size_t f, uint32_t worker) {
        if (stopped) return;
        if (!tracers[worker]) tracers[worker] = std::make_unique<PersonTracer>(subject);
        results[f] = writeFrame(folder, subject, frames[f], f, o, *tracers[worker], points[f]);
        const size_t count = ++done;
        if (worker == 0) goesOn = taskAt(double(count) / double(frames.size()), frames[f].name);
        if (!results[f] || (worker == 0 && !goesOn)) stopped = true;
    });
    for (const Status& result : results)
        if (!result) return result.error();
    DPL_RETURN_IF_ERROR(goesOn);
    DPL_RETURN_IF_ERROR(writeFile(folder / "geometry" / "template.ply", templatePly(subject)));
    DPL_RETURN_IF_ERROR(writeFile(folder / "geometry" / "weights.bin", weightsBin(subject)));
    DPL_RETURN_IF_ERROR(writeText(folder / "truth.json", truthJson(subject, frames, points)));
    return writeText(folder / "scan.json", scanJson(subject, frames, o));
}

}  // namespace

RaycastOptions sampleRays(const SampleScanOptions& scan, size_t frame) {
    RaycastOptions rays;
    rays.samplesPerPixel = scan.samplesPerPixel;
    rays.sensorNoise = scan.sensorNoise;
    rays.posters = scan.posters;
    rays.seed = mixBits(scan.seed ^ mixBits(frame));
    rays.gain = std::exp(scan.exposureSpread * Random(scan.seed, 90000 + frame).normal());
    return rays;
}

Status makeSampleScan(const fs::path& folder, const SampleScanOptions& o, Jobs& jobs) {
    if (o.widthPx < 16 || o.heightPx < 16 || o.widthPx > kMaxSidePx || o.heightPx > kMaxSidePx)
        return fail(Code::InvalidArgument, "image size {}x{}: each side must be 16 to {} pixels", o.widthPx, o.heightPx, kMaxSidePx);
    if (o.fullFrames < 4) return fail(Code::InvalidArgument, "{} full-body frames: at least 4 are needed", o.fullFrames);
    if (o.fullFrames + o.closeupFrames + o.dynamicFrames > 2700)
        return fail(Code::InvalidArgument, "{} frames: a sample scan has at most 2700", o.fullFrames + o.closeupFrames + o.dynamicFrames);
    if (!(o.dynamicS > 1) || o.samplesPerPixel < 1 || o.samplesPerPixel > 1024)
        return fail(Code::InvalidArgument, "the motion must be longer than 1 s, and samples per pixel must be 1 to 1024");
    std::error_code error;
    const fs::path target = fs::absolute(folder, error).lexically_normal();
    if (fs::exists(target, error) && !(fs::is_directory(target, error) && fs::is_empty(target, error)))
        return fail(Code::InvalidArgument, "{} exists already: name a new folder, or empty it", target.string());
    fs::path plain = target;
    if (!plain.has_filename()) plain = plain.parent_path();
    const fs::path temporary = plain.string() + ".partial";
    fs::remove_all(temporary, error);
    fs::create_directories(temporary, error);
    if (error) return fail(Code::Io, "cannot create {}: {}", temporary.string(), error.message());
    Status status = writeAll(temporary, o, jobs);
    if (status) {
        fs::remove(plain, error);  // an empty folder of that name may exist
        fs::rename(temporary, plain, error);
        if (error) status = fail(Code::Io, "cannot rename {} to {}: {}", temporary.string(), plain.string(), error.message());
    }
    if (!status) fs::remove_all(temporary, error);
    return status;
}

}  // namespace dpl
