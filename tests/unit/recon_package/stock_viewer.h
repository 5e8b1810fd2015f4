// SPDX-License-Identifier: Apache-2.0
// Draws an exported mesh at rest as a viewer does that knows nothing of Doppel: meshes, one texture or vertex colours, no light.
#pragma once

#include <span>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "reconstruction/base/image_codec.h"
#include "reconstruction/subject/surface/mesh_raster.h"
#include "sdk/format/skinned_gltf.h"
#include "sdk/math/srgb.h"
#include "tests/unit/format/glb_parts.h"

namespace dpl::test {

class StockViewer {
public:
    struct Pixels {
        std::vector<Vec3f> rgb;      // 0 to 1, sRGB; 0 where nothing is drawn
        std::vector<uint32_t> mesh;  // that a pixel's centre sees; ~0u: none
        std::vector<Vec3f> place;    // on the mesh
        std::vector<bool> whole;     // every sample of the pixel is on the mesh
    };

private:
    template <class Value>
    auto corner(uint32_t t, const Vec2f& at, Value value) const {
        const Triangle& c = triangles_[t];
        return (1 - at.x - at.y) * value(c.x) + at.x * value(c.y) + at.y * value(c.z);
    }

public:
    explicit StockViewer(std::span<const uint8_t> glb) {
        auto read = readSkinnedGltf(glb);
        EXPECT_TRUE(read) << (read ? "" : read.error().message);
        if (!read) return;
        model_ = std::move(*read);
        const GlbParts parts = split(glb);
        if (parts.json.contains("images")) {
            const auto view = parts.json["bufferViews"][parts.json["images"][0]["bufferView"].get<size_t>()];
            const auto file = std::span(parts.bin).subspan(view["byteOffset"].get<size_t>(), view["byteLength"].get<size_t>());
            auto picture = decodePicture(file, PictureChannels::Rgb);
            EXPECT_TRUE(picture) << (picture ? "" : picture.error().message);
            if (picture) texture_ = std::move(*picture);
        }
        for (uint32_t m = 0; m < model_.meshes.size(); ++m) {
            const auto& mesh = model_.meshes[m];
            const uint32_t first = uint32_t(positions_.size());
            positions_.insert(positions_.end(), mesh.positions.begin(), mesh.positions.end());
            for (const auto& t : mesh.triangles) triangles_.push_back(t + first), meshOf_.push_back(m);
            firstVertex_.push_back(first);
        }
    }

    const SkinnedGltf& model() const { return model_; }
    const Picture& texture() const { return texture_; }
    std::span<const Vec3f> positions() const { return positions_; }

    /** Four samples a pixel, of which each takes its colour bilinearly. */
    Pixels draw(const Camerad& camera) const {
        const MeshRaster raster = rasteriseMesh(positions_, triangles_, camera.scaled(2));
        Pixels out;
        for (uint32_t y = 0; y < camera.heightPx; ++y)
            for (uint32_t x = 0; x < camera.widthPx; ++x) {
                Vec3f sum(0), place(0);
                uint32_t count = 0, mesh = ~0u;
                for (uint32_t k = 0; k < 4; ++k) {
                    const size_t sample = size_t(2 * y + k / 2) * raster.widthPx + 2 * x + k % 2;
                    const uint32_t t = raster.triangle[sample];
                    if (t == kNoTriangle) continue;
                    mesh = meshOf_[t], place = corner(t, raster.barycentric[sample], [&](uint32_t v) { return positions_[v]; });
                    sum += colourOf(t, raster.barycentric[sample]), ++count;
                }
                out.rgb.push_back(count > 0 ? sum / float(count) : Vec3f(0));
                out.mesh.push_back(mesh), out.place.push_back(place), out.whole.push_back(count == 4);
            }
        return out;
    }

private:
    Vec3f texel(int x, int y) const {
        x = std::clamp(x, 0, int(texture_.widthPx) - 1), y = std::clamp(y, 0, int(texture_.heightPx) - 1);
        const uint8_t* p = texture_.pixels.data() + 3 * (size_t(y) * texture_.widthPx + x);
        return Vec3f(p[0], p[1], p[2]) / 255.0f;
    }
    Vec3f colourOf(uint32_t t, const Vec2f& at) const {
        const uint32_t m = meshOf_[t];
        const SkinnedGltf::Mesh& mesh = model_.meshes[m];
        if (mesh.uv.empty()) {
            if (mesh.colours.empty()) return Vec3f(0);
            const Vec4f linear = corner(t, at, [&](uint32_t v) { return mesh.colours[v - firstVertex_[m]]; });
            return Vec3f(float(srgbFromLinear(double(linear.r))), float(srgbFromLinear(double(linear.g))),
                         float(srgbFromLinear(double(linear.b))));
        }
        const Vec2f uv = corner(t, at, [&](uint32_t v) { return mesh.uv[v - firstVertex_[m]]; });
        const float x = uv.x * float(texture_.widthPx) - 0.5f, y = uv.y * float(texture_.heightPx) - 0.5f;
        const int x0 = int(std::floor(x)), y0 = int(std::floor(y));
        const float fx = x - float(x0), fy = y - float(y0);
        return (1 - fy) * ((1 - fx) * texel(x0, y0) + fx * texel(x0 + 1, y0)) +
               fy * ((1 - fx) * texel(x0, y0 + 1) + fx * texel(x0 + 1, y0 + 1));
    }

    SkinnedGltf model_;
    Picture texture_;
    std::vector<Vec3f> positions_;
    std::vector<Triangle> triangles_;
    std::vector<uint32_t> meshOf_, firstVertex_;
};

}  // namespace dpl::test
