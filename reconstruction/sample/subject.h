// SPDX-License-Identifier: Apache-2.0
// The procedural subject: a clothed person from a seed, posed with exactly known truth.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "reconstruction/body/body_model.h"
#include "reconstruction/sample/look.h"
#include "reconstruction/sample/motion.h"
#include "reconstruction/sample/skinning.h"
#include "sdk/core/jobs.h"

namespace dpl {

/** Label numbers of docs/formats/scan.md. */
enum SubjectLabel : uint8_t { kLabelBackground, kLabelBody, kLabelTop, kLabelBottom, kLabelHair, kLabelShoes };

struct SubjectPart {
    std::string name;  // "body", "hair", "shoes", "top", "bottom": also the layer names of the mesh
    uint8_t label = 0;
    bool cloth = false;  // slides and swings in dynamic frames
};

/** How one cloth vertex leaves its skinned place (all zero for other vertices). */
struct ClothVertex {
    float slide = 0;                          // metres along the trunk at full arm raise
    std::array<uint8_t, 3> drivers{0, 0, 0};  // swing drivers
    std::array<float, 3> swing{0, 0, 0};      // and how much of each (0 where cloth is held, at most 1 in sum)
};

/** A hem point whose lag behind the body the cloth around it follows. */
struct SwingDriver {
    uint32_t vertex = 0;  // a cloth vertex; its skinned track drives the spring
    float frequencyHz = 2.2f, damping = 0.28f;
};

struct Subject {
    uint64_t seed = 0;
    std::string name;
    std::vector<JointData> joints;  // 55, morphs and soles included
    MeshData mesh;                  // layers in the order of `parts`; clothes are their outer surface
    std::vector<SubjectPart> parts;
    std::vector<Vec3f> canonical;     // V: where the vertex was before morphs: textures are functions of it
    std::vector<uint8_t> hiddenFace;  // F: 1 for body faces deep under clothes, left out of pictures
    std::vector<ClothVertex> cloth;   // V
    std::vector<uint32_t> anchor;     // V: nearest body vertex of each cloth vertex (itself elsewhere)
    std::vector<SwingDriver> drivers;
    std::vector<BodyKeypoint> keypoints;  // 24
    std::vector<std::pair<std::string, float>> morphValues;
    Look look;
};

/** About three seconds; deterministic for any thread count. Same seed, same person. */
Subject makeSubject(uint64_t seed, Jobs& jobs);

/** Vertices at a pose, metres. Without cloth state this is exactly linear blend skinning of the template; with it, clothes slide by a
 *  function of the pose and swing by `lag[driver]` (metres, from SwingSimulation), then are held out of the body by 3 mm. */
std::vector<Vec3d> poseSubject(const Subject& subject, const TruthPose& pose, const std::vector<Vec3d>* lag);

/** World positions of the 24 keypoints for posed vertices. */
std::vector<Vec3d> keypointsWorld(const Subject& subject, const TruthPose& pose, const std::vector<Vec3d>& vertices);

/** Second-order springs behind each driver: x'' = −ω²x − 2ζωx' − a(t), with a the acceleration of the driver's skinned track,
 *  integrated at a fixed 1/240 s from rest. So cloth depends on the motion so far, and its truth is exact. */
class SwingSimulation {
public:
    SwingSimulation(const Subject& subject, const Motion& motion);
    /** Runs on to `timeS` (times must not fall) and returns the lag of each driver, metres, at most 4.5 cm long. */
    const std::vector<Vec3d>& at(double timeS);

private:
    std::vector<Vec3d> tracks(double timeS) const;
    const Subject& subject_;
    const Motion& motion_;
    int64_t step_ = 0;
    std::vector<Vec3d> before_, now_, lag_, speed_, soft_;
};

}  // namespace dpl
