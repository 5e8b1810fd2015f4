// SPDX-License-Identifier: Apache-2.0
// Pictures of the subject by ray casting (Embree): its own camera rays, light, shadows and sampling; no splat code.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <vector>

#include "reconstruction/sample/subject.h"
#include "sdk/math/camera.h"

namespace dpl {

struct RaycastOptions {
    uint32_t samplesPerPixel = 4;  // stratified in a grid; numbers like 4, 6, 9 fill it
    double sensorNoise = 0.004;    // standard deviation, display-referred
    double gain = 1;               // exposure of this frame
    uint64_t seed = 1;
};

struct RaycastFrame {
    std::vector<uint8_t> rgb;     // w·h·3, sRGB
    std::vector<uint8_t> mask;    // 255 where at least half of the samples see the person
    std::vector<uint8_t> labels;  // the label most samples see there, 0 outside the mask
};

/** One posed subject in an Embree scene. Not shared between threads: one a worker. */
class PersonTracer {
public:
    explicit PersonTracer(const Subject& subject);
    ~PersonTracer();
    PersonTracer(const PersonTracer&) = delete;
    PersonTracer& operator=(const PersonTracer&) = delete;

    /** Rebuilds the scene for posed vertices (V, metres): visible faces, clothes with 2 mm of thickness and closed hems. */
    void setVertices(const std::vector<Vec3d>& vertices);

    RaycastFrame render(const Camerad& camera, const RaycastOptions& options) const;

    /** Distance along the ray from `from` to the first surface towards `to` over |to − from|; 1e9 when nothing is met. */
    double firstHit(const Vec3d& from, const Vec3d& to) const;

private:
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace dpl
