// SPDX-License-Identifier: Apache-2.0
#include "tests/conformance/skinned_example.h"

#include <doppel/doppel.hpp>

#include <cmath>
#include <nlohmann/json.hpp>

#include "reconstruction/base/image_codec.h"
#include "reconstruction/base/sdk_camera.h"
#include "reconstruction/subject/shape/implicit_mesh.h"
#include "sdk/core/files.h"
#include "sdk/format/avatar_file.h"
#include "sdk/format/gltf_mesh.h"
#include "sdk/math/camera.h"
#include "sdk/math/sh.h"

namespace dpl {
namespace {

namespace fs = std::filesystem;

constexpr uint32_t kRings = 16, kSegments = 12;
constexpr float kTurn = 6.2831853f, kRadiusM = 0.16f, kHeightM = 1.0f;
constexpr uint64_t kMaxPictureBytes = 1 << 20;
constexpr float kSheen = 0.15f;  // of colour, from edge-on to straight on

Vec3f outwards(uint32_t segment) {
    const float angle = kTurn * float(segment) / float(kSegments);
    return {std::cos(angle), 0, std::sin(angle)};
}

void addSurface(MeshData& mesh) {
    for (uint32_t r = 0; r <= kRings; ++r) {
        const float y = kHeightM * float(r) / float(kRings), share = glm::clamp((y - 0.35f) / 0.3f, 0.0f, 1.0f);
        const auto upper = uint8_t(std::lround(255 * share));
        for (uint32_t s = 0; s < kSegments; ++s) {
            mesh.restPositions.push_back(kRadiusM * outwards(s) + Vec3f(0, y, 0));
            mesh.colours.push_back({190, 140, 110, 255});
            mesh.jointIndices.push_back({0, 1, 0, 0});
            mesh.jointWeights.push_back({uint8_t(255 - upper), upper, 0, 0});
        }
    }
    for (uint32_t r = 0; r < kRings; ++r)
        for (uint32_t s = 0; s < kSegments; ++s) {
            const uint32_t here = r * kSegments + s, next = r * kSegments + (s + 1) % kSegments;
            mesh.triangles.push_back({here, here + kSegments, next});
            mesh.triangles.push_back({next, here + kSegments, next + kSegments});
        }
    mesh.layers = {{"sleeve", "body", 0, uint32_t(mesh.restPositions.size()), 0, uint32_t(mesh.triangles.size())}};
}

/** Bands and a check, so that a wrong triangle or corner shows. */
Vec3f paint(uint32_t ring, uint32_t segment) {
    static const Vec3f kBands[] = {{0.85f, 0.25f, 0.2f}, {0.95f, 0.75f, 0.25f}, {0.2f, 0.55f, 0.75f}, {0.3f, 0.3f, 0.45f}};
    const float shade = (ring + segment) % 2 ? 1.0f : 0.6f;
    return shade * kBands[(ring / 4) % 4] * (segment == 3 ? 0.2f : 1.0f);
}

void addSplats(const MeshData& mesh, SplatData& splats) {
    splats.shDegree = 1;
    splats.triangleStart.push_back(0);
    for (uint32_t t = 0; t < mesh.triangles.size(); ++t) {
        const uint32_t ring = t / (2 * kSegments), segment = (t / 2) % kSegments;
        const Vec3f colour = paint(ring, segment), normal = outwards(segment);
        for (uint32_t k = 0; k < 3; ++k) {
            splats.uv.push_back({k == 1 ? 0.625f : 0.1875f, k == 2 ? 0.625f : 0.1875f});
            splats.phi.push_back(0.3f + 0.9f * float(k));
            splats.scaleM.push_back({0.018f, 0.011f});
            splats.opacity.push_back(0.9f);
            splats.flags.push_back(ring + 2 < kRings ? kSplatSingleFace : 0);  // the uppermost bands show both faces
            for (int c = 0; c < 3; ++c) splats.sh.push_back((colour[c] - 0.5f) / float(kShC0));
            // Brighter where the surface looks at the eye: kSheen·(−d·n), by the signs of band 1.
            for (const float along : {normal.y, -normal.z, normal.x}) splats.sh.insert(splats.sh.end(), 3, kSheen * along / 0.48860251f);
        }
        splats.triangleStart.push_back(splats.count());
    }
}

AvatarData makeSleeve() {
    AvatarData a;
    a.name = "sleeve", a.generator = "doppel tests";
    a.joints = {{"shoulder", -1, {0, 0, 0}, "hips"}, {"elbow", 0, {0, 0.5f, 0}, "spine"}};
    addSurface(a.mesh);
    addSplats(a.mesh, a.splats);
    auto about = [](float degrees, const Vec3f& axis) { return glm::angleAxis(glm::radians(degrees), axis); };
    const Vec3f x(1, 0, 0), y(0, 1, 0);
    a.clips = {{"bend",
                {0, 0.5f, 1},
                {{0, {about(0, y), about(25, y), about(-40, y)}}, {1, {about(0, x), about(60, x), about(80, x) * about(170, y)}}},
                {{0, 0, 0}, {0, 0.0625f, 0}, {0.125f, 0, 0}}}};
    return a;
}

struct View {
    const char* name;
    size_t key;  // of the clip
    Vec3f eye;
};

constexpr View kViews[] = {{"rest", 0, {0.5f, 0.8f, 1.7f}},
                           {"bent", 1, {-1.0f, 0.9f, 1.4f}},
                           {"twisted", 2, {0.9f, 0.7f, 1.5f}},
                           {"inside", 0, {0.25f, 1.9f, 0.75f}}};

Cameraf cameraOf(const View& view) {
    const Vec3f forward = glm::normalize(Vec3f(0, 0.5f, 0) - view.eye), right = glm::normalize(glm::cross(forward, Vec3f(0, 1, 0)));
    Cameraf c;
    c.widthPx = 240, c.heightPx = 240;
    c.fx = c.fy = 350, c.cx = c.cy = 120;
    c.viewFromWorldRotation = glm::transpose(Mat3f(right, glm::cross(forward, right), forward));
    c.viewFromWorldTranslation = -(c.viewFromWorldRotation * view.eye);
    return c;
}

nlohmann::json described(const View& view, const ClipData& clip) {
    const DplCamera c = sdkCamera(cameraOf(view));
    return {{"picture", std::string(view.name) + ".png"},
            {"animation", clip.name},
            {"time", clip.timesS[view.key]},
            {"camera",
             {{"width_px", c.widthPx},
              {"height_px", c.heightPx},
              {"fx", c.fx},
              {"fy", c.fy},
              {"cx", c.cx},
              {"cy", c.cy},
              {"view_from_world", std::vector<float>(c.viewFromWorld, c.viewFromWorld + 12)}}}};
}

Error sdk(const doppel::Error& error) {
    return fail(Code::Internal, "{}", error.message);
}

Status writePicture(doppel::Avatar& avatar, const View& view, const fs::path& folder) {
    DplCamera camera = sdkCamera(cameraOf(view));
    std::vector<uint8_t> pixels(size_t(camera.widthPx) * camera.heightPx * 4), rgb;
    DplImage image{};
    image.structSize = sizeof image, image.rgba = pixels.data(), image.rgbaBytes = pixels.size();
    if (auto drawn = avatar.render({&camera, 1}, {&image, 1}); !drawn) return sdk(drawn.error());
    for (size_t p = 0; p < pixels.size(); p += 4)
        for (size_t c = 0; c < 3; ++c) rgb.push_back(uint8_t(std::min(255, pixels[p + c] + 255 - pixels[p + 3])));
    DPL_TRY(const auto png, encodePng(rgb, camera.widthPx, camera.heightPx, 3));
    return writeFileAtomically(folder / (std::string(view.name) + ".png"), png);
}

Status writeNumbers(const doppel::Avatar& avatar, const View& view, const fs::path& folder) {
    constexpr uint64_t kFloats = 13, kStride = kFloats * sizeof(float);
    const std::vector<DplBufferElement> places = {doppel::bufferElement(DPL_SPLAT_POSITION, 0, kStride),
                                                  doppel::bufferElement(DPL_SPLAT_COVARIANCE, 3 * sizeof(float), kStride),
                                                  doppel::bufferElement(DPL_SPLAT_OPACITY, 9 * sizeof(float), kStride),
                                                  doppel::bufferElement(DPL_SPLAT_COLOUR, 10 * sizeof(float), kStride)};
    doppel::SplatOptions options;
    options.eye = &view.eye.x;
    const auto count = avatar.splatCount(options);
    if (!count) return sdk(count.error());
    std::vector<uint8_t> bytes(*count * kStride);
    if (auto written = avatar.writeSplats(places, std::as_writable_bytes(std::span(bytes)), options); !written) return sdk(written.error());
    return writeFileAtomically(folder / (std::string(view.name) + ".f32"), bytes);
}

}  // namespace

Status writeSkinnedExample(const fs::path& folder) {
    DPL_TRY(const auto file, writeAvatar(makeSleeve()));
    DPL_TRY(const AvatarData sleeve, readAvatar(file));
    DPL_TRY(const auto glb, writeGltfSkinnedSplats(sleeve, vertexNormals(sleeve.mesh.restPositions, sleeve.mesh.triangles)));
    DPL_RETURN_IF_ERROR(writeFileAtomically(folder / "example.glb", glb));

    auto context = doppel::Context::create(DPL_RENDERER_SOFTWARE);
    if (!context) return sdk(context.error());
    auto avatar = context->loadAvatar(file);
    if (!avatar) return sdk(avatar.error());
    const ClipData& clip = sleeve.clips[0];
    nlohmann::json views = nlohmann::json::array();
    for (const View& view : kViews) {
        std::vector<float> rotations;
        for (const ClipChannel& channel : clip.channels) {
            const Quatf& q = channel.rotations[view.key];
            rotations.insert(rotations.end(), {q.x, q.y, q.z, q.w});
        }
        if (auto set = avatar->setPose(rotations, {&clip.rootTranslations[view.key].x, 3}); !set) return sdk(set.error());
        DPL_RETURN_IF_ERROR(writePicture(*avatar, view, folder));
        DPL_RETURN_IF_ERROR(writeNumbers(*avatar, view, folder));
        views.push_back(described(view, clip));
    }
    const std::string text = nlohmann::json{{"file", "example.glb"}, {"background", "white"}, {"views", views}}.dump(2) + "\n";
    return writeFileAtomically(folder / "views.json", {reinterpret_cast<const uint8_t*>(text.data()), text.size()});
}

Status compareSkinnedPictures(const fs::path& made, const fs::path& kept) {
    for (const View& view : kViews) {
        const fs::path name = std::string(view.name) + ".png";
        DPL_TRY(const auto madeBytes, readFile(made / name, kMaxPictureBytes));
        DPL_TRY(const auto keptBytes, readFile(kept / name, kMaxPictureBytes));
        DPL_TRY(const Picture a, decodePicture(madeBytes, PictureChannels::Rgb));
        DPL_TRY(const Picture b, decodePicture(keptBytes, PictureChannels::Rgb));
        if (a.pixels.size() != b.pixels.size()) return fail(Code::CorruptData, "{} has another size", (kept / name).string());
        for (size_t i = 0; i < a.pixels.size(); ++i)
            if (std::abs(int(a.pixels[i]) - int(b.pixels[i])) > 1)
                return fail(Code::CorruptData, "{} shows {} at pixel {}, the library draws {}", (kept / name).string(), b.pixels[i], i / 3,
                            a.pixels[i]);
    }
    return {};
}

}  // namespace dpl
