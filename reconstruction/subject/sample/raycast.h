// SPDX-License-Identifier: Apache-2.0
// Pictures of the subject by ray casting (Embree), with camera rays, light, shadows and sampling of its own. No splat code is used.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "reconstruction/subject/sample/scan_writer.h"
#include "reconstruction/subject/sample/subject.h"
#include "sdk/math/camera.h"

namespace dpl {

struct RaycastOptions {
    uint32_t samplesPerPixel = 4;  // stratified in a grid of floor(√n) columns: 4, 6 or 9 fill it
    double sensorNoise = 0.004;    // standard deviation, display-referred
    double gain = 1;               // exposure: factor of the light
    bool posters = false;          // posters on the wall and a patterned floor, for feature matching
    uint64_t seed = 1;
};

/** The rays of one frame of a sample scan. */
RaycastOptions sampleRays(const SampleScanOptions& scan, size_t frame);

struct RaycastFrame {
    std::vector<uint8_t> rgb;     // w·h·3, sRGB
    std::vector<uint8_t> mask;    // 255 where at least half of the samples see the person
    std::vector<uint8_t> labels;  // SubjectLabel that most samples see, 0 outside the mask
};

/** One posed subject in an Embree scene. Use one per thread. The subject must outlive it. */
class PersonTracer {
public:
    explicit PersonTracer(const Subject& subject);
    ~PersonTracer();
    PersonTracer(const PersonTracer&) = delete;
    PersonTracer& operator=(const PersonTracer&) = delete;

    /** Rebuilds the scene for posed vertices (V, metres). Hidden triangles are left out; clothes get 2 mm of thickness and closed hems.
     *  Call before render() and firstHit(). */
    void setVertices(const std::vector<Vec3d>& vertices);

    RaycastFrame render(const Camerad& camera, const RaycastOptions& options) const;

    /** Display-referred sRGB, 0 to 1, of a point on the outer side of the subject's triangle, barycentric u of corner 1 and v of corner 2,
     *  seen along its normal from 1.5 m: the mean of `samples` light samples. Patterns finer than footprintM fade to their mean. nullopt
     * for a hidden triangle. Call setVertices() before. */
    std::optional<Vec3f> colourAt(uint32_t triangle, float u, float v, float footprintM, uint32_t samples) const;

    /** Distance from `from` to the first surface in the direction of `to`, as a multiple of |to − from|. 1e9 when the ray hits nothing. */
    double firstHit(const Vec3d& from, const Vec3d& to) const;

private:
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace dpl
