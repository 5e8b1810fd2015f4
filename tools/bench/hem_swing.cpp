// SPDX-License-Identifier: Apache-2.0
// For measurements only: how the hems of a reconstruction's garments swing beside the truth of its scan (docs/reference/metrics.md, "Swing
// of the hem").
//   bench_hem_swing SCAN OUT [--garment NAME]
#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <map>

#include "reconstruction/judging/ladder/carried_points.h"
#include "reconstruction/judging/ladder/garment_distance.h"
#include "reconstruction/judging/ladder/rig_fit.h"
#include "reconstruction/judging/ladder/swing.h"
#include "reconstruction/judging/ladder/true_mesh.h"
#include "reconstruction/output/package/avatar_bytes.h"
#include "reconstruction/run/film_memory.h"
#include "reconstruction/run/run_scan.h"
#include "reconstruction/subject/shape/implicit_mesh.h"
#include "sdk/avatar/posed_mesh.h"
#include "sdk/core/evenly_spaced.h"

namespace dpl {
namespace {

constexpr float kHemM = 0.1f;        // height of what counts as hem, at rest
constexpr size_t kParts = 12;        // of a hem, by direction from its middle
constexpr double kMostLateS = 0.3;   // beyond it a swing of 1.5 Hz is as near to the stroke before
constexpr size_t kStillFrames = 12;  // over which the avatar's garment is bound to the true one
constexpr size_t kFitStride = 3;     // every third vertex pulls in the fit of true poses

/** The parts of a hem: vertices of each. */
using Hem = std::vector<std::vector<uint32_t>>;

Hem hemOf(const GarmentPair& garment, const MeshData& mesh) {
    std::vector<uint32_t> vertices;
    float lowest = 1e9f;
    for (const Triangle& t : garment.avatar)
        for (int c = 0; c < 3; ++c) vertices.push_back(t[c]), lowest = std::min(lowest, mesh.restPositions[t[c]].y);
    std::sort(vertices.begin(), vertices.end());
    vertices.erase(std::unique(vertices.begin(), vertices.end()), vertices.end());
    std::erase_if(vertices, [&](uint32_t v) { return mesh.restPositions[v].y > lowest + kHemM; });
    Vec3f middle(0);
    for (const uint32_t v : vertices) middle += mesh.restPositions[v] / float(vertices.size());
    Hem hem(kParts);
    for (const uint32_t v : vertices) {
        const Vec3f d = mesh.restPositions[v] - middle;
        const double turn = std::atan2(double(d.z), double(d.x)) / (2 * glm::pi<double>()) + 0.5;
        hem[std::min(size_t(turn * kParts), kParts - 1)].push_back(v);
    }
    std::erase_if(hem, [](const auto& part) { return part.empty(); });
    return hem;
}

/** Means of the parts of `a`, less those of `b` where given, in the frame of the hips: x and z. */
std::vector<Vec2d> partsOf(const Hem& hem, std::span<const Vec3f> a, std::span<const Vec3f> b, const Mat3d& worldFromHips,
                           const Vec3d& hipsM) {
    std::vector<Vec2d> parts;
    for (const auto& vertices : hem) {
        Vec3d mean(0);
        for (const uint32_t v : vertices) mean += (Vec3d(a[v]) - (b.empty() ? hipsM : Vec3d(b[v]))) / double(vertices.size());
        const Vec3d own = glm::transpose(worldFromHips) * mean;
        parts.emplace_back(own.x, own.z);
    }
    return parts;
}

/** Both kinds of motion of a hem: what clothes add to plain skinning, and all that is seen. */
struct Film {
    std::vector<SwingSample> added, whole;
};

class Subject {
public:
    Subject(const RunScan& run, const AvatarData& avatar, TrueMesh truth, Jobs& jobs)
        : run_(run),
          avatar_(avatar),
          truth_(std::move(truth)),
          jobs_(jobs),
          bind_(restTriangles(avatar.mesh)),
          cloth_(avatar.joints, avatar.mesh, avatar.correctives) {
        for (size_t j = 0; j < avatar.joints.size(); ++j)
            if (avatar.joints[j].humanoidBone == "hips") hips_ = j;
        std::vector<size_t> stills;
        for (size_t f = 0; f < run.scan.frames.size(); ++f)
            if (truth_.frames[f].known && run.scan.frames[f].kind == FrameKind::StaticFull && run.poses.frames[f].split == Split::Train)
                stills.push_back(f);
        stills_ = evenlySpaced(stills, kStillFrames);
        std::vector<uint8_t> visible;
        for (size_t t = 0; t < truth_.triangles.size(); ++t) visible.push_back(!truth_.hidden[t]);
        garments_ = garmentPairs(avatar.mesh, truth_, visible);
    }

    const std::vector<GarmentPair>& garments() const { return garments_; }
    bool known() const { return !stills_.empty(); }

    /** The best poses that the run knows. */
    std::vector<Pose> foundPoses() const {
        std::vector<Pose> poses;
        for (const FramePose& frame : run_.poses.frames) poses.push_back(frame.bestPose());
        return poses;
    }
    /** The avatar's rig fitted to the true body. */
    std::vector<Pose> truePoses() {
        std::vector<uint8_t> body;
        for (size_t t = 0; t < truth_.triangles.size(); ++t) body.push_back(!truth_.hidden[t] && !truth_.clothTriangle[t]);
        std::optional<CarriedPoints> points;
        for (const size_t f : stills_) {
            const std::vector<Vec3f> ours = posed(run_.poses.frames[f].pose, false), surface = skinnedTruth(truth_, truth_.frames[f]);
            if (!points) points.emplace(ours, vertexNormals(ours, avatar_.mesh.triangles), surface, truth_.triangles, body, jobs_);
            points->average(ours, surface);
        }
        std::vector<float> weights;
        for (const float distanceM : points->distancesM())
            weights.push_back(weights.size() % kFitStride == 0 ? 1 / (1 + 2500 * distanceM * distanceM) : 0.0f);
        std::vector<Pose> poses = foundPoses();
        for (size_t f = 0; f < poses.size(); ++f)
            if (run_.scan.frames[f].kind == FrameKind::Dynamic && truth_.frames[f].known)
                poses[f] = fitRig(avatar_.joints, avatar_.mesh, points->at(skinnedTruth(truth_, truth_.frames[f])), weights, poses[f]);
        rememberPoses(run_.scan, avatar_.correctives.motion, poses);
        return poses;
    }

    std::vector<Vec3f> posed(const Pose& pose, bool correctives) {
        static const PoseCorrectiveData kNone;
        posed_.pose({avatar_.joints, avatar_.mesh, correctives ? avatar_.correctives : kNone, {bind_}, nullptr, {}, &cloth_}, pose, jobs_);
        return {posed_.positions().begin(), posed_.positions().end()};
    }

    /** The avatar's hem in all moving frames, by time. */
    Film film(const Hem& hem, std::span<const Pose> poses, bool correctives) {
        Film out;
        for (const size_t f : movingByTime()) {
            const std::vector<Vec3f> ours = posed(poses[f], correctives), plain = posed(poses[f], false);
            const Mat3x4f& g = posed_.worldFromRest()[hips_];
            const Mat3d turn{Mat3f(g)};
            const Vec3d place(g * Vec4f(avatar_.joints[hips_].restPosition, 1));
            const double timeS = run_.scan.frames[f].timeS;
            out.added.push_back({timeS, partsOf(hem, ours, plain, turn, place)});
            out.whole.push_back({timeS, partsOf(hem, ours, {}, turn, place)});
        }
        return out;
    }

    /** The same of the true garment, in frames of which the true surface is known. */
    Result<Film> trueFilm(const Hem& hem, const GarmentPair& garment, bool heldOut) {
        std::vector<GarmentPlaces::Still> stills;
        for (const size_t f : stills_) {
            std::vector<Vec3f> ours = posed(run_.poses.frames[f].pose, true), normals = vertexNormals(ours, avatar_.mesh.triangles);
            stills.push_back({std::move(ours), std::move(normals), skinnedTruth(truth_, truth_.frames[f])});
        }
        const GarmentPlaces places(garment, stills, jobs_);
        Film out;
        for (const size_t f : movingByTime()) {
            if ((run_.poses.frames[f].split == Split::Test) != heldOut) continue;
            DPL_TRY(const auto surface, trueSurface(truth_, truth_.frames[f], FrameKind::Dynamic));
            if (!surface) continue;
            const TrueFrame& frame = truth_.frames[f];
            const std::vector<Vec3f> ours = places.at(*surface), plain = places.at(skinnedTruth(truth_, frame));
            const Mat3d turn = glm::mat3_cast(frame.rotations[0]);
            const double timeS = run_.scan.frames[f].timeS;
            out.added.push_back({timeS, partsOf(hem, ours, plain, turn, Vec3d(0))});
            out.whole.push_back({timeS, partsOf(hem, ours, {}, turn, truth_.joints[0] + frame.translation)});
        }
        return out;
    }

private:
    std::vector<size_t> movingByTime() const {
        std::vector<size_t> rows;
        for (size_t f = 0; f < run_.scan.frames.size(); ++f)
            if (run_.scan.frames[f].kind == FrameKind::Dynamic) rows.push_back(f);
        std::stable_sort(rows.begin(), rows.end(),
                         [&](size_t a, size_t b) { return run_.scan.frames[a].timeS < run_.scan.frames[b].timeS; });
        return rows;
    }

    const RunScan& run_;
    const AvatarData& avatar_;
    const TrueMesh truth_;
    Jobs& jobs_;
    std::vector<RestTriangle<float>> bind_;
    ClothLimits cloth_;
    PosedMesh posed_;
    size_t hips_ = 0;
    std::vector<size_t> stills_;
    std::vector<GarmentPair> garments_;
};

void printRow(const char* what, const Swing& swing) {
    std::printf("  %-44s %6.1f mm  %5.2f x  %+5.0f ms  %5.2f  (%zu times)\n", what, 1000 * swing.trueRmsM, swing.amplitude,
                1000 * swing.lateS, swing.correlation, swing.times);
}

Status measure(const std::filesystem::path& scan, const std::filesystem::path& out, const std::string& wanted) {
    const std::filesystem::path avatarPath = out / "avatar.glb";
    DPL_TRY(const auto bytes, readAvatarBytes(avatarPath));
    DPL_TRY(const AvatarData avatar, avatarOf(avatarPath, bytes, "garments"));
    DPL_TRY(RunScan run, readRunScan(scan, out / "poses.json"));
    DPL_RETURN_IF_ERROR(checkSkeleton(run.poses, out / "poses.json", avatar.joints, avatarPath));
    rememberPoses(run.scan, avatar.correctives.motion, run.poses);
    DPL_TRY(auto truth, readTrueMesh(run.scan));
    if (!truth) return fail(Code::NotFound, "{} has no truth (truth.json, geometry/)", scan.string());
    Jobs jobs(0);
    Subject subject(run, avatar, std::move(*truth), jobs);
    if (!subject.known()) return fail(Code::NotFound, "{} has no still training frame with a truth", scan.string());
    const std::vector<Pose> found = subject.foundPoses(), truePoses = subject.truePoses();
    for (const GarmentPair& garment : subject.garments()) {
        if (!wanted.empty() && garment.name != wanted) continue;
        const Hem hem = hemOf(garment, avatar.mesh);
        for (const bool heldOut : {false, true}) {
            DPL_TRY(const Film real, subject.trueFilm(hem, garment, heldOut));
            std::printf("%s, %s moving frames: true swing, amplitude, late, correlation\n", garment.name.c_str(),
                        heldOut ? "held-out" : "training");
            for (const auto& [name, poses] : {std::pair("true poses", &truePoses), std::pair("found poses", &found)})
                for (const bool correctives : {true, false}) {
                    const Film film = subject.film(hem, *poses, correctives);
                    const std::string how = std::string(name) + (correctives ? "" : ", plain skinning");
                    if (correctives) printRow((how + ", beyond plain skinning").c_str(), compareSwing(real.added, film.added, kMostLateS));
                    printRow((how + ", all that is seen").c_str(), compareSwing(real.whole, film.whole, kMostLateS));
                }
        }
    }
    return {};
}

}  // namespace
}  // namespace dpl

int main(int argc, char** argv) {
    CLI::App app("Compares the swing of hems with the truth of a scan (measuring only)");
    std::filesystem::path scan, out;
    std::string garment;
    app.add_option("scan", scan, "Scan folder with truth.json and geometry/")->required();
    app.add_option("out", out, "Its reconstruction")->required();
    app.add_option("--garment", garment, "One garment only, by its label");
    CLI11_PARSE(app, argc, argv);
    const dpl::Status done = dpl::measure(scan, out, garment);
    if (!done) std::fprintf(stderr, "bench_hem_swing: %s\n", done.error().message.c_str());
    return done ? 0 : 1;
}
