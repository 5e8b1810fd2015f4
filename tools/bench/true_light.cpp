// SPDX-License-Identifier: Apache-2.0
// For measurements only: what the light of the scene explains at the true surface of a synthetic scan, with normals of the posed surface
// and with skinned normals of the rest pose; and how both differ on a reconstruction. docs/reference/light.md
//   bench_true_light SCAN [--run OUT]
#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <optional>

#include "reconstruction/judging/ladder/true_mesh.h"
#include "reconstruction/judging/report/score.h"
#include "reconstruction/output/package/avatar_bytes.h"
#include "reconstruction/run/film_memory.h"
#include "reconstruction/run/run_scan.h"
#include "reconstruction/subject/shape/implicit_mesh.h"
#include "reconstruction/subject/surface/mesh_raster.h"
#include "reconstruction/training/light/light_model.h"
#include "reconstruction/training/light/priors.h"
#include "sdk/avatar/posed_mesh.h"
#include "sdk/avatar/scene_light.h"
#include "sdk/splat/splat_engine.h"

namespace dpl {
namespace {

constexpr double kCellM = 0.0035;                      // of the texture that still pictures paint: about a pixel
constexpr double kLeastCosine = 0.25;                  // at which a picture paints
constexpr float kDepthEdgeM = 0.03f;                   // between neighbours; beyond it a pixel may show two things
constexpr float kLeastFactor = 0.2f, kMostFactor = 3;  // of brightness, as drawn
constexpr size_t kStillFrames = 12;                    // over which normals of still frames are averaged

double decibels(double meanSquare) {
    return -10 * std::log10(std::max(meanSquare, 1e-12));
}

double degreesBetween(const Vec3f& a, const Vec3f& b) {
    return glm::degrees(std::acos(std::clamp(double(glm::dot(glm::normalize(a), glm::normalize(b))), -1.0, 1.0)));
}

/** Mean, median and 95th percentile. */
struct Spread {
    std::vector<double> values;
    void print(const char* what) {
        if (values.empty()) return;
        std::sort(values.begin(), values.end());
        double sum = 0;
        for (const double v : values) sum += v;
        std::printf("  %s: mean %.1f, median %.1f, 95 %% below %.1f degrees\n", what, sum / double(values.size()),
                    values[values.size() / 2], values[values.size() * 95 / 100]);
    }
};

/** Colours of small cells on the triangles of the true mesh, as still pictures show them. */
class CellTexture {
public:
    CellTexture(std::span<const Vec3f> rest, std::span<const Triangle> triangles) : triangles_(triangles) {
        size_t cells = 0;
        for (const Triangle& t : triangles) {
            const double edge = double(
                std::max({glm::length(rest[t.x] - rest[t.y]), glm::length(rest[t.y] - rest[t.z]), glm::length(rest[t.z] - rest[t.x])}));
            side_.push_back(uint32_t(std::max(1.0, std::ceil(edge / kCellM)))), first_.push_back(cells);
            cells += size_t(side_.back()) * side_.back();
        }
        sums_.assign(cells, Vec4d(0)), whole_.assign(triangles.size(), Vec4d(0));
    }

    void paint(const MeshRaster& raster, std::span<const Vec3f> positions, const Camerad& camera, const FramePicture& picture) {
        const Vec3d eye = camera.eye();
        const size_t w = raster.widthPx;
        for (size_t y = 1; y + 1 < raster.heightPx; ++y)
            for (size_t x = 1; x + 1 < w; ++x) {
                const size_t i = y * w + x;
                if (raster.triangle[i] == kNoTriangle || !isPerson(picture.mask.pixels[i])) continue;
                bool edge = false;
                for (const size_t n : {i - 1, i + 1, i - w, i + w})
                    edge = edge || raster.triangle[n] == kNoTriangle || !isPerson(picture.mask.pixels[n]) ||
                           std::abs(raster.depthM[n] - raster.depthM[i]) > kDepthEdgeM;
                const double cosine = std::abs(frontCosine(positions, triangles_[raster.triangle[i]], eye));
                if (edge || cosine < kLeastCosine) continue;
                const uint8_t* rgb = &picture.image.pixels[3 * i];
                const Vec4d seen = cosine * cosine * Vec4d(rgb[0], rgb[1], rgb[2], 1);
                sums_[cellOf(raster, i)] += seen, whole_[raster.triangle[i]] += seen;
            }
    }

    /** The colour at a pixel, 0 to 1; none where no still picture showed it. */
    std::optional<Vec3d> at(const MeshRaster& raster, size_t pixel) const {
        if (raster.triangle[pixel] == kNoTriangle) return std::nullopt;
        const Vec4d &cell = sums_[cellOf(raster, pixel)], &triangle = whole_[raster.triangle[pixel]];
        const Vec4d& sum = cell.w > 0.6 ? cell : triangle;
        if (sum.w < 0.3) return std::nullopt;
        return Vec3d(sum) / (255 * sum.w);
    }

private:
    size_t cellOf(const MeshRaster& raster, size_t pixel) const {
        const uint32_t t = raster.triangle[pixel], n = side_[t];
        const auto index = [&](float b) { return size_t(std::clamp(int(b * float(n)), 0, int(n) - 1)); };
        return first_[t] + index(raster.barycentric[pixel].x) * n + index(raster.barycentric[pixel].y);
    }

    std::span<const Triangle> triangles_;
    std::vector<uint32_t> side_;
    std::vector<size_t> first_;
    std::vector<Vec4d> sums_, whole_;  // weighted colours and weight
};

/** The true surface of one picture, with its normals in both ways. */
struct TrueView {
    size_t frame = 0;
    std::vector<Vec3f> positions, posed, skinned;
};

class TrueLight {
public:
    TrueLight(const Scan& scan, TrueMesh truth) : scan_(scan), truth_(std::move(truth)) {
        std::vector<uint8_t> cloth(truth_.restPositions.size(), 0);
        for (size_t t = 0; t < truth_.triangles.size(); ++t) {
            if (truth_.hidden[t]) continue;
            shown_.push_back(truth_.triangles[t]);
            for (int c = 0; c < 3; ++c) cloth[truth_.triangles[t][c]] |= truth_.clothTriangle[t];
        }
        for (const uint8_t c : cloth) trust_.push_back(c ? priors::kClothLightTrust : 1.0);
        // Skinning is affine in the rest position, so a normal is turned by the difference of two places.
        moved_ = truth_;
        const std::vector<Vec3f> rest = vertexNormals(truth_.restPositions, shown_);
        for (size_t v = 0; v < rest.size(); ++v) moved_.restPositions[v] += rest[v];
    }

    Status measure() {
        CellTexture texture(truth_.restPositions, shown_);
        stillNormals_.assign(truth_.restPositions.size(), Vec3f(0));
        std::vector<LightSighting> byPosed, bySkinned;
        size_t stills = 0;
        for (size_t f = 0; f < scan_.frames.size(); ++f) {
            const ScanFrame& frame = scan_.frames[f];
            if (frame.kind == FrameKind::StaticCloseup || frame.split == Split::Test || frame.maskPath.empty()) continue;
            DPL_TRY(const auto view, viewOf(f));
            if (!view) continue;
            DPL_TRY(const FramePicture picture, readFramePicture(frame));
            const bool moving = frame.kind == FrameKind::Dynamic;
            addLightSightings({view->positions, view->posed, trust_, shown_}, frame.camera, moving, picture, byPosed);
            addLightSightings({view->positions, view->skinned, trust_, shown_}, frame.camera, moving, picture, bySkinned);
            if (moving) continue;
            texture.paint(rasteriseMesh(view->positions, shown_, frame.camera), view->positions, frame.camera, picture);
            if (stills++ < kStillFrames)
                for (size_t v = 0; v < stillNormals_.size(); ++v) stillNormals_[v] += view->posed[v];
        }
        const LightFit posed = fitLight(byPosed, truth_.restPositions.size()), skinned = fitLight(bySkinned, truth_.restPositions.size());
        std::printf("light by posed normals:  ");
        for (const float c : posed.light.irradiance) std::printf(" %.3f", double(c));
        std::printf("\nlight by skinned normals:");
        for (const float c : skinned.light.irradiance) std::printf(" %.3f", double(c));
        std::printf("\n");
        for (const auto& [kind, split, name] : {std::tuple(FrameKind::StaticFull, Split::Test, "still, held out"),
                                                {FrameKind::Dynamic, Split::Train, "moving, training"},
                                                {FrameKind::Dynamic, Split::Test, "moving, held out"}})
            DPL_RETURN_IF_ERROR(score(texture, posed.light, skinned.light, kind, split, name));
        return {};
    }

private:
    Result<std::optional<TrueView>> viewOf(size_t f) const {
        const TrueFrame& frame = truth_.frames[f];
        DPL_TRY(auto surface, trueSurface(truth_, frame, scan_.frames[f].kind));
        if (!surface) return std::optional<TrueView>();
        TrueView view{f, std::move(*surface), {}, skinnedTruth(moved_, frame)};
        view.posed = vertexNormals(view.positions, shown_);
        const std::vector<Vec3f> plain = skinnedTruth(truth_, frame);
        for (size_t v = 0; v < plain.size(); ++v) view.skinned[v] -= plain[v];
        return std::optional(std::move(view));
    }

    std::vector<float> factorsOf(const LightData& light, std::span<const Vec3f> normals) const {
        std::vector<float> factors(normals.size(), 1.0f);
        for (size_t v = 0; v < normals.size(); ++v)
            if (glm::length(normals[v]) > 1e-3f && glm::length(stillNormals_[v]) > 1e-3f)
                factors[v] =
                    std::clamp(irradianceOn(light, glm::normalize(normals[v])) / irradianceOn(light, glm::normalize(stillNormals_[v])),
                               kLeastFactor, kMostFactor);
        return factors;
    }

    Status score(const CellTexture& texture, const LightData& byPosed, const LightData& bySkinned, FrameKind kind, Split split,
                 const char* name) const {
        constexpr int kWays = 3;
        struct Sums {
            double squares[kWays] = {}, pixels = 0;
        };
        std::array<Sums, 3> all{};  // all, skin, cloth; means of frames
        size_t frames = 0;
        Spread angles[2];
        for (size_t f = 0; f < scan_.frames.size(); ++f) {
            const ScanFrame& frame = scan_.frames[f];
            if (frame.kind != kind || frame.split != split || frame.maskPath.empty()) continue;
            DPL_TRY(const auto view, viewOf(f));
            if (!view) continue;
            DPL_TRY(const FramePicture picture, readFramePicture(frame));
            const MeshRaster raster = rasteriseMesh(view->positions, shown_, frame.camera);
            const std::vector<float> factors[2] = {factorsOf(byPosed, view->posed), factorsOf(bySkinned, view->skinned)};
            std::array<Sums, 3> sums{};
            for (size_t i = 0; i < raster.triangle.size(); ++i) {
                if (!isPerson(picture.mask.pixels[i])) continue;
                const auto colour = texture.at(raster, i);
                if (!colour) continue;
                const Triangle& t = shown_[raster.triangle[i]];
                const Vec2f uv = raster.barycentric[i];
                const Vec3d truth =
                    Vec3d(picture.image.pixels[3 * i], picture.image.pixels[3 * i + 1], picture.image.pixels[3 * i + 2]) / 255.0;
                const bool cloth = trust_[t.x] < 1;
                for (int way = 0; way < kWays; ++way) {
                    double factor = 1;
                    if (way > 0) {
                        const std::vector<float>& of = factors[way - 1];
                        factor = double((1 - uv.x - uv.y) * of[t.x] + uv.x * of[t.y] + uv.y * of[t.z]);
                    }
                    const Vec3d miss = glm::min(factor * *colour, Vec3d(1)) - truth;
                    for (const size_t group : {size_t(0), size_t(cloth ? 2 : 1)}) sums[group].squares[way] += glm::dot(miss, miss) / 3;
                }
                for (const size_t group : {size_t(0), size_t(cloth ? 2 : 1)}) ++sums[group].pixels;
                if (i % 7 == 0 && glm::length(view->posed[t.x]) > 1e-3f && glm::length(view->skinned[t.x]) > 1e-3f)
                    angles[cloth].values.push_back(degreesBetween(view->posed[t.x], view->skinned[t.x]));
            }
            ++frames;
            for (size_t g = 0; g < all.size(); ++g)
                if (sums[g].pixels > 50) {
                    for (int way = 0; way < kWays; ++way) all[g].squares[way] += sums[g].squares[way] / sums[g].pixels;
                    ++all[g].pixels;
                }
        }
        if (frames == 0) return {};
        std::printf("%s, %zu frames, true surface, texture of still pictures\n", name, frames);
        const char* groups[] = {"all", "skin", "cloth"};
        for (size_t g = 0; g < all.size(); ++g) {
            std::printf("  %-6s", groups[g]);
            const char* ways[] = {"no light", "posed normals", "skinned normals"};
            for (int way = 0; way < kWays; ++way)
                std::printf("  %s %.2fe-3 (%.2f dB)", ways[way], 1000 * all[g].squares[way] / all[g].pixels,
                            decibels(all[g].squares[way] / all[g].pixels));
            std::printf("\n");
        }
        angles[0].print("skin, posed against skinned normals");
        angles[1].print("cloth, posed against skinned normals");
        return {};
    }

    const Scan& scan_;
    const TrueMesh truth_;
    TrueMesh moved_;  // truth_ with each vertex moved by its normal
    std::vector<Triangle> shown_;
    std::vector<double> trust_;
    std::vector<Vec3f> stillNormals_;
};

/** Draws a reconstruction's moving frames with its light by skinned normals, as it ships, and by normals of the posed mesh. */
Status compareOnRun(const std::filesystem::path& scan, const std::filesystem::path& out) {
    DPL_TRY(const auto bytes, readAvatarBytes(out / "avatar.glb"));
    DPL_TRY(const AvatarData avatar, avatarOf(out / "avatar.glb", bytes, "light"));
    DPL_TRY(RunScan run, readRunScan(scan, out / "poses.json"));
    DPL_RETURN_IF_ERROR(checkSkeleton(run.poses, out / "poses.json", avatar.joints, out / "avatar.glb"));
    rememberPoses(run.scan, avatar.correctives.motion, run.poses);
    Jobs jobs(0);
    SplatEngine engine(jobs);
    std::vector<uint32_t> triangle;
    for (size_t t = 0; t + 1 < avatar.splats.triangleStart.size(); ++t) triangle.resize(avatar.splats.triangleStart[t + 1], uint32_t(t));
    const SplatData& s = avatar.splats;
    const PackedSplats splats(BoundSplatView{triangle, s.uv, s.phi, s.scaleM, s.opacity, s.flags, s.shDegree, s.sh});
    const std::vector<RestTriangle<float>> bind = restTriangles(avatar.mesh);
    const ClothLimits cloth(avatar.joints, avatar.mesh, avatar.correctives);
    const RestNormals normalsOf(avatar.mesh);
    const std::vector<Vec3f> rest = restVertexNormals(avatar.mesh);
    const size_t skinCount = avatar.mesh.layers.empty() ? rest.size() : avatar.mesh.layers.front().vertexCount;
    PosedMesh posed;
    std::vector<TriangleFrame<float>> frames;
    std::vector<Vec3f> normals;
    std::vector<uint8_t> rgba;
    Spread angles[2];
    double sums[3] = {};
    size_t count = 0;
    for (size_t f = 0; f < run.scan.frames.size(); ++f) {
        const ScanFrame& frame = run.scan.frames[f];
        if (frame.kind != FrameKind::Dynamic || run.poses.frames[f].split != Split::Test || frame.maskPath.empty()) continue;
        DPL_TRY(const FramePicture picture, readFramePicture(frame));
        posed.pose({avatar.joints, avatar.mesh, avatar.correctives, {bind}, &avatar.light, rest, &cloth}, run.poses.frames[f].bestPose(),
                   jobs);
        normalsOf.compute(posed.positions(), avatar.mesh.triangles, normals);
        std::vector<float> ways[3];  // as it ships, by posed normals, without
        ways[0].assign(posed.light().begin(), posed.light().end());
        ways[0].resize(rest.size(), 1.0f);
        ways[1] = ways[2] = ways[0];
        for (size_t v = 0; v < rest.size(); ++v) {
            const Vec3f skinned = turnedNormal(rest[v], avatar.mesh.jointIndices[v], avatar.mesh.jointWeights[v], posed.worldFromRest());
            if (v % 7 == 0 && glm::length(skinned) > 1e-6f) angles[v >= skinCount].values.push_back(degreesBetween(normals[v], skinned));
            if (posed.sceneLight().empty()) continue;
            const float was = posed.sceneLight()[v], is = irradianceOn(avatar.light, normals[v]) / irradianceOn(avatar.light, rest[v]);
            ways[1][v] *= is / was, ways[2][v] /= was;
        }
        for (int way = 0; way < 3; ++way) {
            poseTriangles(avatar.mesh, {bind}, posed.positions(), jobs, frames, ways[way]);
            engine.project(splats, frames, run.cameras[f].cast<float>(), avatar.kappaPx2, avatar.compensated);
            engine.bin();
            engine.blendRgba8(rgba);
            std::vector<uint8_t> straight = rgba;
            for (size_t i = 0; i < straight.size(); i += 4)
                for (size_t c = i; c < i + 3 && straight[i + 3] > 0; ++c)
                    straight[c] = uint8_t(std::min(255.0f, float(straight[c]) * 255.0f / float(straight[i + 3]) + 0.5f));
            sums[way] += scorePicture(straight, picture.image, picture.mask).maskedPsnrDb;
        }
        ++count;
    }
    if (count == 0) return fail(Code::NotFound, "{} has no moving test frame with a mask", scan.string());
    std::printf("the avatar of %s, %zu moving held-out frames, poses fitted%s\n", out.string().c_str(), count,
                avatar.light.empty() ? "; it has no light" : "");
    std::printf("  without light %.3f dB, skinned normals %.3f dB, posed normals %.3f dB\n", sums[2] / double(count),
                sums[0] / double(count), sums[1] / double(count));
    angles[0].print("skin, posed against skinned normals");
    angles[1].print("clothes, hair and shoes, posed against skinned normals");
    return {};
}

Status measure(const std::filesystem::path& folder, const std::filesystem::path& run) {
    DPL_TRY(const Scan scan, readScan(folder));
    DPL_TRY(auto truth, readTrueMesh(scan));
    if (!truth && run.empty()) return fail(Code::NotFound, "{} has no truth (truth.json, geometry/)", folder.string());
    if (truth) DPL_RETURN_IF_ERROR(TrueLight(scan, std::move(*truth)).measure());
    return run.empty() ? Status() : compareOnRun(folder, run);
}

}  // namespace
}  // namespace dpl

int main(int argc, char** argv) {
    CLI::App app("Measures the light of the scene at the true surface of a scan (measuring only)");
    std::filesystem::path scan, run;
    app.add_option("scan", scan, "Scan folder; without truth.json and geometry/ the run alone is measured")->required();
    app.add_option("--run", run, "A reconstruction of it, whose light and normals are compared too");
    CLI11_PARSE(app, argc, argv);
    const dpl::Status done = dpl::measure(scan, run);
    if (!done) std::fprintf(stderr, "bench_true_light: %s\n", done.error().message.c_str());
    return done ? 0 : 1;
}
