// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/output/package/texture_bake.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "reconstruction/output/package/avatar_drawer.h"
#include "reconstruction/output/package/texture_fill.h"
#include "reconstruction/output/package/texture_photographs.h"
#include "reconstruction/subject/shape/implicit_mesh.h"
#include "reconstruction/subject/surface/mesh_raster.h"
#include "sdk/core/task.h"
#include "sdk/math/projection.h"
#include "sdk/splat/mesh_depth.h"

namespace dpl {
namespace {

constexpr float kOutlineM = 0.006f;     // splats reach so far over the outline of what they lie on
constexpr float kDepthErrorM = 0.002f;  // of a depth at a pixel's centre, on a surface that faces the camera
constexpr float kContactM = 0.015f;     // what is so near to a surface lies on it, and its outline is part of the picture: hair, hems
constexpr float kFacing = 4;            // power of the cosine in the weight of a picture; more follow it, fewer blur
constexpr float kLeastCosine = 0.15f;
constexpr float kLeastAlpha = 0.5f;
constexpr float kBesideOutline = 1e-4f;  // weight of a picture that sees a texel beside an outline: only where no other sees it
constexpr uint32_t kGrain = 64;
constexpr double kSplatsEnd = 0.5;  // of the progress, where photographs follow

enum class Sight { Free, BesideOutline, Hidden };

/** Depth of a mesh in a picture, and the least depth within the width of an outline around each pixel. 0: nothing. */
class Depths {
public:
    void draw(Jobs& jobs, std::span<const Vec3f> positions, std::span<const Triangle> triangles, const Cameraf& camera, uint32_t reachPx) {
        reachPx_ = reachPx;
        depth_.draw(jobs, positions, triangles, camera, here_);
        around_.resize(here_.size()), rows_.resize(here_.size());
        const int width = int(camera.widthPx), height = int(camera.heightPx), reach = int(reachPx);
        const auto nearer = [](float a, float b) { return a > 0 && (b <= 0 || a < b) ? a : b; };
        jobs.forRange(height, 16, [&](size_t begin, size_t end, uint32_t) {
            for (int y = int(begin); y < int(end); ++y)
                for (int x = 0; x < width; ++x) {
                    float least = 0;
                    for (int k = std::max(0, x - reach); k <= std::min(width - 1, x + reach); ++k)
                        least = nearer(here_[size_t(y) * width + k], least);
                    rows_[size_t(y) * width + x] = least;
                }
        });
        jobs.forRange(height, 16, [&](size_t begin, size_t end, uint32_t) {
            for (int y = int(begin); y < int(end); ++y) {
                float* out = around_.data() + size_t(y) * width;
                std::fill(out, out + width, 0.0f);
                for (int k = std::max(0, y - reach); k <= std::min(height - 1, y + reach); ++k)
                    for (int x = 0; x < width; ++x) out[x] = nearer(rows_[size_t(k) * width + x], out[x]);
            }
        });
    }
    /** How the picture sees a point of the mesh: at `inView` and `pixel`, on a face with this normal in the view and this cosine to the
     * eye. */
    Sight sightOf(const Vec3f& inView, const Vec2f& pixel, const Vec3f& faceInView, float cosine, const Cameraf& camera) const {
        const size_t at = size_t(pixel.y) * camera.widthPx + size_t(pixel.x);
        // The depth of the face at the pixel's centre, where the picture of depths has its value.
        const Vec3f centre((std::floor(pixel.x) + 0.5f - camera.cx) / camera.fx, (std::floor(pixel.y) + 0.5f - camera.cy) / camera.fy, 1);
        const float ahead = glm::dot(faceInView, centre), depth = ahead != 0 ? glm::dot(faceInView, inView) / ahead : inView.z;
        const float recedes = inView.z / camera.fx * std::sqrt(1 - std::min(1.0f, cosine * cosine)) / cosine;  // over a pixel
        if (!(here_[at] > 0) || std::max(depth, inView.z - recedes) > here_[at] + kDepthErrorM) return Sight::Hidden;
        return inView.z > around_[at] + kContactM + recedes * float(reachPx_ + 1) ? Sight::BesideOutline : Sight::Free;
    }

private:
    MeshDepth depth_;
    uint32_t reachPx_ = 0;
    std::vector<float> here_, around_, rows_;
};

/** The straight colour of a picture at a place, and how opaque it is there; bilinear. */
struct Sample {
    Vec3f colour;
    float alpha;
};
std::optional<Sample> sampleAt(const SplatImage& image, const Vec2f& pixel) {
    const float x = pixel.x - 0.5f, y = pixel.y - 0.5f;
    if (!(x >= 0 && y >= 0 && x < float(image.widthPx - 1) && y < float(image.heightPx - 1))) return std::nullopt;
    const uint32_t x0 = uint32_t(x), y0 = uint32_t(y);
    const float fx = x - float(x0), fy = y - float(y0);
    Sample out{Vec3f(0), 0};
    for (uint32_t k = 0; k < 4; ++k) {
        const size_t p = size_t(y0 + k / 2) * image.widthPx + x0 + k % 2;
        const float share = (k % 2 ? fx : 1 - fx) * (k / 2 ? fy : 1 - fy);
        out.colour += share * Vec3f(image.rgb[3 * p], image.rgb[3 * p + 1], image.rgb[3 * p + 2]);
        out.alpha += share * image.alpha[p];
    }
    if (out.alpha < kLeastAlpha) return std::nullopt;
    out.colour /= out.alpha;
    return out;
}

/** The colour texture, picture by picture. */
class TextureBake {
public:
    TextureBake(const MeshData& mesh, std::span<const Vec3f> positions, const AtlasTexels& texels, Jobs& jobs)
        : mesh_(mesh),
          positions_(positions),
          normals_(vertexNormals(positions, mesh.triangles)),
          texels_(texels),
          sum_(texels.all.size(), Vec4f(0)),
          jobs_(jobs) {}

    void add(const TextureView& view, const SplatImage& image) {
        depths_.draw(jobs_, positions_, mesh_.triangles, view.camera, std::max(1u, uint32_t(std::ceil(kOutlineM / view.pixelM))));
        jobs_.forRange(mesh_.triangles.size(), kGrain, [&](size_t begin, size_t end, uint32_t) {
            for (size_t t = begin; t < end; ++t)
                if (texels_.start[t] < texels_.start[t + 1]) addTriangle(t, view, image);
        });
    }

    /** Of all texels; those that nothing was seen of continue the surface around them. */
    std::vector<Vec3f> colours() const {
        std::vector<Vec3f> out(sum_.size());
        std::vector<Vec4f> ofVertex(positions_.size(), Vec4f(0));
        forTexels([&](const Triangle& corners, const Vec3f& share, uint32_t i) {
            if (!(sum_[i].w > 0)) return;
            out[i] = Vec3f(sum_[i]) / sum_[i].w;
            for (int k = 0; k < 3; ++k) ofVertex[corners[k]] += Vec4f(share[k] * out[i], share[k]);
        });
        const std::vector<Vec3f> around = spreadColours(ofVertex, mesh_);
        forTexels([&](const Triangle& corners, const Vec3f& share, uint32_t i) {
            if (!(sum_[i].w > 0)) out[i] = share.x * around[corners.x] + share.y * around[corners.y] + share.z * around[corners.z];
        });
        return out;
    }

private:
    template <class Body>
    void forTexels(Body body) const {
        for (size_t t = 0; t < mesh_.triangles.size(); ++t)
            for (uint32_t i = texels_.start[t]; i < texels_.start[t + 1]; ++i) {
                const Vec2f at = texels_.all[i].barycentric;
                body(mesh_.triangles[t], Vec3f(1 - at.x - at.y, at.x, at.y), i);
            }
    }

    void addTriangle(size_t t, const TextureView& view, const SplatImage& image) {
        const Cameraf& camera = view.camera;
        const Triangle& c = mesh_.triangles[t];
        const Vec3f eye = camera.eye(), first = positions_[c.x], e1 = positions_[c.y] - first, e2 = positions_[c.z] - first;
        const Vec3f across = glm::cross(e1, e2);
        const float length = glm::length(across);
        if (!(length > 0)) return;
        const Vec3f face = across / length, faceInView = camera.viewFromWorldRotation * face;
        if (glm::dot(face, eye - first) <= 0) return;
        for (uint32_t i = texels_.start[t]; i < texels_.start[t + 1]; ++i) {
            const Vec2f at = texels_.all[i].barycentric;
            const Vec3f p = first + at.x * e1 + at.y * e2, inView = camera.toView(p);
            if (!(inView.z > float(kNearM))) continue;
            const Vec2f pixel = camera.pixelOf(inView);
            if (!(pixel.x >= 0 && pixel.y >= 0 && pixel.x < float(camera.widthPx) && pixel.y < float(camera.heightPx))) continue;
            const Vec3f toEye = glm::normalize(eye - p);
            const Vec3f normal = glm::normalize((1 - at.x - at.y) * normals_[c.x] + at.x * normals_[c.y] + at.y * normals_[c.z]);
            const float flat = glm::dot(face, toEye), cosine = std::min(flat, glm::dot(normal, toEye));
            if (cosine < kLeastCosine) continue;
            const Sight sight = depths_.sightOf(inView, pixel, faceInView, flat, camera);
            if (sight == Sight::Hidden) continue;
            const auto sample = sampleAt(image, pixel);
            if (!sample) continue;
            const float weight =
                view.weight * std::pow(cosine * sample->alpha, kFacing) * (sight == Sight::BesideOutline ? kBesideOutline : 1);
            sum_[i] += Vec4f(weight * sample->colour, weight);
        }
    }

    const MeshData& mesh_;
    std::span<const Vec3f> positions_;
    std::vector<Vec3f> normals_;  // V, unit
    const AtlasTexels& texels_;
    std::vector<Vec4f> sum_;  // of each texel: colour times weight, weight
    Jobs& jobs_;
    Depths depths_;
};

std::vector<uint8_t> filled(const MeshAtlas& atlas, const AtlasTexels& texels, std::span<const Vec3f> colours) {
    TextureFill fill(atlas.sidePx);
    for (size_t i = 0; i < colours.size(); ++i) fill.set(texels.all[i].pixel, colours[i]);
    return fill.finish(2 * atlas.gutterPx);
}

}  // namespace

Result<std::vector<uint8_t>> bakeTexture(const AvatarData& avatar, std::span<const Vec3f> positions, const MeshAtlas& atlas,
                                         std::span<const TextureView> views, std::span<const TrainFrame> photographs, Jobs& jobs) try {
    const AtlasTexels texels(atlas);
    std::vector<Vec3f> colours;
    {
        const TaskPart part(0, photographs.empty() ? 1 : kSplatsEnd);
        TextureBake bake(avatar.mesh, positions, texels, jobs);
        const ClothLimits cloth(avatar.joints, avatar.mesh, avatar.correctives);
        AvatarDrawer drawer(avatar, jobs, &cloth);
        const Pose rest = Pose::rest(avatar.joints.size());
        SplatImage image;
        for (size_t v = 0; v < views.size(); ++v) {
            DPL_RETURN_IF_ERROR(taskAt(double(v) / double(views.size()), formatText("view {} of {}", v + 1, views.size())));
            drawer.project(rest, views[v].camera).blend(image);
            bake.add(views[v], image);
        }
        colours = bake.colours();
    }
    std::vector<uint8_t> texture = filled(atlas, texels, colours);
    if (photographs.empty()) return texture;
    const TaskPart part(kSplatsEnd, 1);
    DPL_RETURN_IF_ERROR(addPhotographs(avatar, atlas, texels, texture, photographs, colours, jobs));
    return filled(atlas, texels, colours);
} catch (const std::bad_alloc&) {
    return fail(Code::OutOfMemory, "there is not enough memory for a texture of {} pixels a side; give a smaller --texture-size",
                atlas.sidePx);
}

std::vector<bool> seenTriangles(std::span<const Vec3f> positions, std::span<const Triangle> triangles, std::span<const TextureView> views) {
    std::vector<bool> vertexSeen(positions.size(), false);
    for (const TextureView& view : views) {
        const MeshRaster raster = rasteriseMesh(positions, triangles, view.camera.cast<double>());
        for (const uint32_t t : raster.triangle)
            if (t != kNoTriangle)
                for (int k = 0; k < 3; ++k) vertexSeen[triangles[t][k]] = true;
    }
    std::vector<bool> out;
    for (const Triangle& t : triangles) out.push_back(vertexSeen[t.x] || vertexSeen[t.y] || vertexSeen[t.z]);
    return out;
}

}  // namespace dpl
