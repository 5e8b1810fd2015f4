// SPDX-License-Identifier: Apache-2.0
// The procedural subject: a clothed person made from a seed, with exactly known geometry in every pose.
#pragma once

#include <array>
#include <span>
#include <string>
#include <vector>

#include "reconstruction/subject/body/body_model.h"
#include "reconstruction/subject/sample/hair_locks.h"
#include "reconstruction/subject/sample/look.h"
#include "reconstruction/subject/sample/motion.h"
#include "reconstruction/subject/sample/skinning.h"
#include "sdk/core/jobs.h"

namespace dpl {

/** Label numbers of docs/formats/scan.md. */
enum SubjectLabel : uint8_t { kLabelBackground, kLabelBody, kLabelTop, kLabelBottom, kLabelHair, kLabelShoes };

struct SubjectPart {
    std::string name;  // "body", "hair", "shoes", "top", "bottom": also the layer names of the mesh
    uint8_t label = 0;
    bool cloth = false;  // slides or swings in dynamic frames
};

/** How one cloth vertex moves relative to its skinned position. All zero for other vertices. */
struct ClothVertex {
    float slide = 0;                          // metres up the trunk when the arms are fully raised
    std::array<uint8_t, 3> drivers{0, 0, 0};  // indices into Subject::drivers
    std::array<float, 3> swing{0, 0, 0};      // share of each driver's lag; 0 where cloth is held, sum at most 1
};

/** What the subject wears below the waist. */
enum class Bottom : uint8_t { Shorts, Skirt };

/** A hem point on a spring. The cloth around it follows its lag behind the body. */
struct SwingDriver {
    uint32_t vertex = 0;  // a cloth vertex; its skinned path drives the spring
    float frequencyHz = 2.2f, damping = 0.28f;
    double maxLagM = 0.045;  // the lag stays shorter than this
};

struct Subject {
    uint64_t seed = 0;
    std::string name;
    std::vector<JointData> joints;  // 55, with morphs and sole height applied
    MeshData mesh;                  // layers in the order of `parts`; of clothes only the outer surface
    std::vector<SubjectPart> parts;
    std::vector<Vec3f> canonical;     // per vertex: position before morphs, the coordinates of textures
    std::vector<uint8_t> hiddenFace;  // per triangle: 1 on the body deep under clothes, left out of pictures
    std::vector<ClothVertex> cloth;   // per vertex
    std::vector<uint32_t> anchor;     // per vertex: nearest body vertex; of body vertices themselves
    std::vector<SwingDriver> drivers;
    std::vector<BodyKeypoint> keypoints;      // 24
    std::vector<BodyKeypoint> handKeypoints;  // 40, in the order of handKeypointNames()
    std::vector<std::pair<std::string, float>> morphValues;
    Look look;
    Bottom bottom = Bottom::Shorts;
    HairLocks hair;
};

/** The same seed gives the same person for any thread count, and another bottom or hair changes nothing else. Takes about three seconds,
 *  with long hair five. */
Subject makeSubject(uint64_t seed, Jobs& jobs, Bottom bottom = Bottom::Shorts, Hairstyle hair = Hairstyle::Cap);

/** Vertices at a pose, metres. With `lag` null this is exactly linear blend skinning of the template. Otherwise clothes also slide by a
 *  function of the pose, swing by `lag[driver]` (metres, from SwingSimulation), and are then pushed 3 mm out of the body. A skirt is also
 *  pushed out of the legs that it hangs over, wherever these have moved to. Locks of hair lie along `lockNodes` (from HairSwing); without
 *  these they follow the skinning. */
std::vector<Vec3d> poseSubject(const Subject& subject, const TruthPose& pose, const std::vector<Vec3d>* lag,
                               std::span<const LockNode> lockNodes = {});

/** World positions of some of the subject's keypoints for posed vertices. */
std::vector<Vec3d> keypointsWorld(const Subject& subject, std::span<const BodyKeypoint> keypoints, const TruthPose& pose,
                                  const std::vector<Vec3d>& vertices);

/** A damped spring per driver: x'' = −ω²x − 2ζωx' − a(t), where a is the acceleration of the driver's skinned path. Integrated from rest
 *  with a fixed step of 1/240 s, so the lag depends on the motion so far and not on when it is asked for. Subject and motion must outlive
 *  it. */
class SwingSimulation {
public:
    SwingSimulation(const Subject& subject, const SampleMotion& motion);
    /** Advances to `timeS`, which must not decrease, and returns the lag of each driver: metres, shorter than its maxLagM. Valid until the
     * next call. */
    const std::vector<Vec3d>& at(double timeS);

private:
    std::vector<Vec3d> tracks(double timeS) const;
    const Subject& subject_;
    const SampleMotion& motion_;
    int64_t step_ = 0;
    std::vector<Vec3d> before_, now_, lag_, speed_, soft_;
};

}  // namespace dpl
