// SPDX-License-Identifier: Apache-2.0
#include "tests/metal/software/raster.h"

#include <algorithm>
#include <cmath>

namespace dpl::mtl {
namespace {

constexpr int64_t kSubpixels = 256;  // of a pixel's width; positions of vertices are rounded to these

struct Vertex {
    std::vector<std::byte> out;
    int64_t x = 0, y = 0;  // subpixels
    double z = 0, w = 1;   // depth, clip w
};

struct Edge {
    int64_t dx, dy, x, y;
    bool topLeft;
    Edge(const Vertex& a, const Vertex& b) : dx(b.x - a.x), dy(b.y - a.y), x(a.x), y(a.y), topLeft((dy == 0 && dx > 0) || dy < 0) {}
    /** Positive inside. */
    int64_t at(int64_t px, int64_t py) const { return dx * (py - y) - dy * (px - x); }
    bool covers(int64_t value) const { return value > 0 || (value == 0 && topLeft); }
};

class Rasteriser {
public:
    Rasteriser(const Draw& draw, std::vector<std::string>& faults) : d_(draw), faults_(faults) {
        position_ = d_.vertex->output("position");
        layer_ = d_.vertex->output("render_target_array_index");
        stageIn_.resize(d_.fragment->inputBytes);
        out_.resize(d_.fragment->outputBytes);
        eachSample_ = d_.samples > 1 && d_.fragment->takes(msl::Given::Sample);
        const Pixels& any = d_.colours[0].pixels ? *d_.colours[0].pixels : *d_.depth;
        widthPx_ = any.widthPx, heightPx_ = any.heightPx;
        for (const ColourTarget& colour : d_.colours) outputs_.push_back(nullptr), (void)colour;
        for (size_t i = 0; i < 2; ++i) outputs_[i] = d_.fragment->output("color(" + std::to_string(i) + ")");
        depthOut_ = d_.fragment->output("depth");
        for (const msl::Field& in : d_.fragment->inputs) {
            const msl::Field* from = in.attribute == "position" ? position_ : d_.vertex->output(in.attribute);
            if (!from || from->floats < in.floats)
                faults_.push_back(d_.fragment->name + " reads " + in.attribute + ", which " + d_.vertex->name + " does not write");
            froms_.push_back(from);
        }
    }

    void run() {
        if (std::find(froms_.begin(), froms_.end(), nullptr) != froms_.end()) return;
        const bool strip = d_.type == PrimitiveType::Strip;
        Vertex v[3];
        for (uint32_t i = 0; i < d_.instances; ++i)
            for (uint32_t n = 0; n + 3 <= d_.vertices; n += strip ? 1 : 3) {
                if (strip && n > 0)
                    v[0] = v[1], v[1] = v[2], v[2] = shade(n + 2, i);
                else
                    for (uint32_t k = 0; k < 3; ++k) v[k] = shade(n + k, i);
                triangle(v);
            }
    }

private:
    void bind(const msl::Entry& entry, const msl::Bindings& bindings) {
        msl::running.entry = &entry;
        msl::running.bindings = &bindings;
        msl::running.discarded = false;
    }

    template <class T>
    static T read(const std::vector<std::byte>& from, const msl::Field& field) {
        T value;
        std::memcpy(&value, from.data() + field.offset, sizeof value);
        return value;
    }

    Vertex shade(uint32_t number, uint32_t instance) {
        bind(*d_.vertex, d_.vertexBindings);
        Vertex v;
        v.out.resize(d_.vertex->outputBytes);
        msl::Invocation how;
        how.bindings = &d_.vertexBindings;
        how.vertexId = d_.firstVertex + number;
        how.instanceId = d_.firstInstance + instance;
        how.baseInstance = d_.firstInstance;
        d_.vertex->call(*d_.vertex, how, v.out.data());
        const auto clip = read<glm::vec4>(v.out, *position_);
        v.w = clip.w;
        v.z = double(clip.z) / clip.w;
        const double x = (double(clip.x) / clip.w * 0.5 + 0.5) * d_.viewWidthPx + d_.viewX,
                     y = (0.5 - double(clip.y) / clip.w * 0.5) * d_.viewHeightPx + d_.viewY;
        if (!(clip.w > 0) || !(std::abs(x) < 1e6) || !(std::abs(y) < 1e6)) {
            const std::string text = d_.vertex->name +
                                     " gives a vertex that the software device cannot draw: behind the eye, not finite or "
                                     "a million pixels away";
            if (std::find(faults_.begin(), faults_.end(), text) == faults_.end()) faults_.push_back(text);
            v.w = 0;
            return v;
        }
        v.x = std::llround(x * kSubpixels), v.y = std::llround(y * kSubpixels);
        return v;
    }

    void triangle(const Vertex* v) {
        if (v[0].w == 0 || v[1].w == 0 || v[2].w == 0) return;
        const Vertex *a = &v[0], *b = &v[1], *c = &v[2];
        int64_t area = Edge(*a, *b).at(c->x, c->y);
        if (area == 0) return;
        if (area < 0) std::swap(b, c), area = -area;
        corners_[0] = a, corners_[1] = b, corners_[2] = c, first_ = &v[0];
        target_ = layer_ ? read<uint32_t>(v[0].out, *layer_) : 0;
        if (target_ >= std::max(d_.layers, 1u)) {
            const std::string text = d_.vertex->name + " draws into layer " + std::to_string(target_) + " of " + std::to_string(d_.layers);
            if (std::find(faults_.begin(), faults_.end(), text) == faults_.end()) faults_.push_back(text);
            return;
        }
        const Edge bc(*b, *c), ca(*c, *a), ab(*a, *b);
        const auto pixel = [](int64_t place) { return place >= 0 ? place / kSubpixels : -1; };
        const int64_t x0 = std::max<int64_t>(pixel(std::min({a->x, b->x, c->x})), 0),
                      y0 = std::max<int64_t>(pixel(std::min({a->y, b->y, c->y})), 0);
        const int64_t x1 = std::min<int64_t>(pixel(std::max({a->x, b->x, c->x})), int64_t(widthPx_) - 1),
                      y1 = std::min<int64_t>(pixel(std::max({a->y, b->y, c->y})), int64_t(heightPx_) - 1);
        for (int64_t y = y0; y <= y1; ++y)
            for (int64_t x = x0; x <= x1; ++x) {
                uint32_t covered = 0;
                for (uint32_t s = 0; s < d_.samples; ++s) {
                    const glm::vec2 place = placeOf(s);
                    const int64_t px = x * kSubpixels + int64_t(place.x * kSubpixels), py = y * kSubpixels + int64_t(place.y * kSubpixels);
                    const double inViewX = double(x) + place.x - d_.viewX, inViewY = double(y) + place.y - d_.viewY;
                    if (inViewX < 0 || inViewY < 0 || inViewX >= d_.viewWidthPx || inViewY >= d_.viewHeightPx) continue;
                    if (bc.covers(bc.at(px, py)) && ca.covers(ca.at(px, py)) && ab.covers(ab.at(px, py))) covered |= 1u << s;
                }
                if (covered == 0) continue;
                const Plane plane{bc, ca, ab, double(area)};
                if (!eachSample_) {
                    fragment(plane, uint32_t(x), uint32_t(y), covered, {0.5f, 0.5f}, 0);
                } else {
                    for (uint32_t s = 0; s < d_.samples; ++s)
                        if (covered >> s & 1) fragment(plane, uint32_t(x), uint32_t(y), 1u << s, placeOf(s), s);
                }
            }
    }

    struct Plane {
        const Edge &bc, &ca, &ab;
        double area;
    };

    glm::vec2 placeOf(uint32_t sample) const { return d_.samples == 1 ? glm::vec2(0.5f) : msl::kSamplePlaces[sample]; }

    /** Depth of the triangle at a place of a pixel. */
    double depthAt(const Plane& plane, uint32_t x, uint32_t y, glm::vec2 place, double (&weights)[3]) const {
        const int64_t px = int64_t(x) * kSubpixels + int64_t(place.x * kSubpixels),
                      py = int64_t(y) * kSubpixels + int64_t(place.y * kSubpixels);
        weights[0] = double(plane.bc.at(px, py)) / plane.area, weights[1] = double(plane.ca.at(px, py)) / plane.area;
        weights[2] = double(plane.ab.at(px, py)) / plane.area;
        double z = 0;
        for (int k = 0; k < 3; ++k) z += weights[k] * corners_[k]->z;
        return z;
    }

    /** Shades once, at `place` in the pixel, for the covered samples. */
    void fragment(const Plane& plane, uint32_t x, uint32_t y, uint32_t covered, glm::vec2 place, uint32_t sample) {
        double weights[3];
        const double z = depthAt(plane, x, y, place, weights);
        double perW = 0;
        for (int k = 0; k < 3; ++k) weights[k] /= corners_[k]->w, perW += weights[k];
        for (size_t i = 0; i < froms_.size(); ++i) {
            const msl::Field& in = d_.fragment->inputs[i];
            for (uint32_t k = 0; k < in.floats; ++k) {
                float value;
                const size_t at = froms_[i]->offset + 4 * k;
                std::memcpy(&value, first_->out.data() + at, 4);
                if (!in.flat) {
                    double sum = 0;
                    for (int c = 0; c < 3; ++c) {
                        float corner;
                        std::memcpy(&corner, corners_[c]->out.data() + at, 4);
                        sum += weights[c] * corner;
                    }
                    value = float(sum / perW);
                }
                std::memcpy(stageIn_.data() + in.offset + 4 * k, &value, 4);
            }
        }
        msl::Invocation how;
        how.bindings = &d_.fragmentBindings;
        how.layer = target_;
        how.sample = sample;
        how.position = {float(x) + 0.5f, float(y) + 0.5f, float(z), float(perW)};
        how.stageIn = stageIn_.data();
        bind(*d_.fragment, d_.fragmentBindings);
        d_.fragment->call(*d_.fragment, how, out_.data());
        if (msl::running.discarded) return;
        for (uint32_t s = 0; s < d_.samples; ++s)
            if (covered >> s & 1) blend(plane, x, y, s);
    }

    void blend(const Plane& plane, uint32_t x, uint32_t y, uint32_t s) {
        if (d_.depth) {
            double unused[3];
            const float z = depthOut_ ? read<float>(out_, *depthOut_) : float(depthAt(plane, x, y, placeOf(s), unused));
            if (!(z >= 0 && z <= 1)) return;
            const uint32_t slice = d_.depthSlice + target_;
            const float old = d_.depth->texel(x, y, slice, s).r;
            const bool passes = d_.nearer == CompareFunction::Always || (d_.nearer == CompareFunction::Less ? z < old : z > old);
            if (!passes) return;
            if (d_.writesDepth) d_.depth->store(x, y, slice, s, glm::vec4(z));
        }
        for (size_t i = 0; i < 2; ++i) {
            const ColourTarget& to = d_.colours[i];
            if (!to.pixels || !to.how.writes || !outputs_[i]) continue;
            const auto from = read<glm::vec4>(out_, *outputs_[i]);
            const uint32_t slice = to.slice + target_;
            glm::vec4 value = from;
            if (to.how.blends) {
                const auto factor = [&](BlendFactor f) {
                    return f == BlendFactor::Zero ? 0.0f : f == BlendFactor::One ? 1.0f : 1 - from.a;
                };
                const glm::vec4 old = to.pixels->texel(x, y, slice, s);
                const float rgb = factor(to.how.rgbTo);
                value = {from.r + rgb * old.r, from.g + rgb * old.g, from.b + rgb * old.b,
                         factor(to.how.alphaFrom) * from.a + factor(to.how.alphaTo) * old.a};
            }
            to.pixels->store(x, y, slice, s, value);
        }
    }

    const Draw& d_;
    std::vector<std::string>& faults_;
    const msl::Field *position_ = nullptr, *layer_ = nullptr, *depthOut_ = nullptr;
    std::vector<const msl::Field*> outputs_, froms_;
    std::vector<std::byte> stageIn_, out_;
    bool eachSample_ = false;
    uint32_t widthPx_ = 0, heightPx_ = 0, target_ = 0;
    const Vertex *corners_[3] = {}, *first_ = nullptr;
};

}  // namespace

void draw(const Draw& d, std::vector<std::string>& faults) {
    msl::running.faults = &faults;
    Rasteriser(d, faults).run();
    msl::running = {};
}

}  // namespace dpl::mtl
