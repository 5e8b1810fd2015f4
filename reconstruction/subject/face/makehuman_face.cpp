// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/subject/face/makehuman_face.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <string_view>
#include <tuple>

#include "reconstruction/subject/body/makehuman.h"
#include "reconstruction/subject/face/face_shapes.h"
#include "reconstruction/subject/face/smooth.h"
#include "sdk/format/expression_names.h"

namespace dpl {
namespace {

namespace fs = std::filesystem;

constexpr const char* kFamilies[] = {"african", "asian", "caucasian"};
constexpr float kMaskHalfM = 0.008f;  // from the middle of the face: where the half of a unit fades
constexpr float kLidOutsideM = 2e-4f;
constexpr float kLookUpRad = 0.40f, kLookDownRad = 0.42f, kLookInRad = 0.52f, kLookOutRad = 0.56f;

struct UnitWeight {
    const char* unit;
    float weight;
};

/** An expression of the left side or of both. Symmetric units are cut in half for a side. */
struct Recipe {
    const char* name;
    bool half;
    std::vector<UnitWeight> units;
};

std::vector<Recipe> recipes() {
    return {
        {"eyeBlinkLeft", false, {{"eye-left-closure", 1}}},
        {"eyeLookDownLeft", false, {{"eye-left-closure", 0.3f}}},
        {"eyeLookUpLeft", false, {{"eye-left-opened-up", 0.5f}}},
        {"eyeSquintLeft", false, {{"eye-left-slit", 1}}},
        {"eyeWideLeft", false, {{"eye-left-opened-up", 1}}},
        {"jawOpen", false, {{"mouth-open", 0.7f}}},
        {"mouthFunnel", false, {{"mouth-protusion", 0.7f}, {"mouth-pursing", 0.3f}}},
        {"mouthPucker", false, {{"mouth-pursing", 0.8f}}},
        {"mouthSmileLeft", true, {{"mouth-corner-puller", 0.9f}}},
        {"mouthFrownLeft", true, {{"mouth-depression", 0.7f}}},
        {"mouthDimpleLeft", true, {{"mouth-upward-retraction", 0.5f}}},
        {"mouthStretchLeft", true, {{"mouth-retraction", 1}}},
        {"mouthPressLeft", true, {{"mouth-compression", 0.6f}}},
        {"mouthLowerDownLeft", true, {{"mouth-depression-retraction", 0.7f}}},
        {"mouthUpperUpLeft", true, {{"mouth-elevation", 0.8f}}},
        {"mouthShrugLower", false, {{"mouth-eversion", 0.6f}, {"mouth-parling", 0.35f}}},
        {"browDownLeft", false, {{"eyebrows-left-down", 1}}},
        {"browInnerUp", false, {{"eyebrows-left-inner-up", 1}, {"eyebrows-right-inner-up", 1}}},
        {"browOuterUpLeft", false, {{"eyebrows-left-extern-up", 1}}},
        {"noseSneerLeft", false, {{"nose-left-elevation", 1}}},
        {"tongueOut", false, {{"mouth-open", 0.3f}}},
    };
}

Mat3f turnAboutX(float angle) {  // +: what is in front goes down
    const float c = std::cos(angle), s = std::sin(angle);
    return {{1, 0, 0}, {0, c, s}, {0, -s, c}};
}
Mat3f turnAboutY(float angle) {  // +: what is in front goes to the left
    const float c = std::cos(angle), s = std::sin(angle);
    return {{c, 0, -s}, {0, 1, 0}, {s, 0, c}};
}

enum class Part : uint8_t { Skin, LeftEye, RightEye, UpperTeeth, LowerTeeth, Tongue };

class Face {
public:
    Face(const fs::path& root, const MakeHumanMesh& source, const BodyModel& body)
        : root_(root), source_(source), vertices_(makeHumanVertices(source)), at_(body.mesh.restPositions) {}

    /** InvalidArgument where the body is of another mesh. */
    Status prepare();

    Result<ExpressionShape> shape(size_t expression);

private:
    using Offsets = std::vector<Vec3f>;

    Result<const Offsets*> unit(const std::string& name);
    /** A name of the left side or of both. */
    Result<Offsets> leftOrBoth(std::string_view name);
    void look(std::string_view name, Offsets& offsets) const;
    /** Lower teeth and tongue turn with the jaw, as far as the unit moves the lower teeth. */
    void turnWithJaw(Offsets& offsets) const;
    void putTongueOut(Offsets& offsets) const;
    void keepOutside(Part eye, Offsets& offsets) const;
    Offsets mirrored(const Offsets& offsets) const;

    Vec3f middleOf(Part part) const {
        Vec3d sum(0);
        double count = 0;
        for (size_t v = 0; v < at_.size(); ++v)
            if (part_[v] == part) sum += Vec3d(at_[v]), ++count;
        return count > 0 ? Vec3f(sum / count) : Vec3f(0);
    }

    const fs::path& root_;
    const MakeHumanMesh& source_;
    std::vector<MakeHumanVertex> vertices_;
    const std::vector<Vec3f>& at_;
    std::vector<Part> part_;
    std::vector<uint32_t> mirror_;
    FaceLandmarks landmarks_;
    Vec3f leftEye_{0}, rightEye_{0}, hinge_{0};
    float eyeRadiusM_ = 0;
    std::map<std::string, Offsets> units_;
};

Status Face::prepare() {
    constexpr uint32_t kUpperLip = 474, kLowerLip = 493, kChin = 732;  // hm08: edges of the lips in the middle; the lowest of the chin
    if (vertices_.size() != at_.size())
        return fail(Code::InvalidArgument, "the body has {} vertices, MakeHuman's mesh makes {}", at_.size(), vertices_.size());
    std::map<uint32_t, Part> partOf;
    for (const auto& [group, part] : {std::pair{"helper-l-eye", Part::LeftEye},
                                      {"helper-r-eye", Part::RightEye},
                                      {"helper-upper-teeth", Part::UpperTeeth},
                                      {"helper-lower-teeth", Part::LowerTeeth},
                                      {"helper-tongue", Part::Tongue}})
        for (const uint32_t v : source_.groups.at(group)) partOf[v] = part;
    std::map<std::tuple<int, int, int, Part>, uint32_t> atPlace;
    const auto place = [&](size_t v, float side) {
        const Vec3f p = 1e5f * source_.positionsDm[vertices_[v].vertex];
        return std::tuple(int(std::lround(side * p.x)), int(std::lround(p.y)), int(std::lround(p.z)));
    };
    for (const MakeHumanVertex& v : vertices_) {
        const auto found = partOf.find(v.vertex);
        part_.push_back(found == partOf.end() ? Part::Skin : found->second);
    }
    const auto key = [&](size_t v, float side) {
        const auto [x, y, z] = place(v, side);
        Part part = part_[v];
        if (side < 0 && part == Part::LeftEye)
            part = Part::RightEye;
        else if (side < 0 && part == Part::RightEye)
            part = Part::LeftEye;
        return std::tuple(x, y, z, part);
    };
    for (uint32_t v = 0; v < at_.size(); ++v) atPlace.try_emplace(key(v, 1), v);
    for (uint32_t v = 0; v < at_.size(); ++v) {
        const auto twin = atPlace.find(key(v, -1));
        if (twin == atPlace.end())
            return fail(Code::Unsupported, "vertex {} of MakeHuman's base.obj has no mirror image; left and right cannot be told", v);
        mirror_.push_back(twin->second);
    }
    leftEye_ = middleOf(Part::LeftEye), rightEye_ = middleOf(Part::RightEye);
    for (size_t v = 0; v < at_.size(); ++v)
        if (part_[v] == Part::LeftEye) eyeRadiusM_ = std::max(eyeRadiusM_, glm::length(at_[v] - leftEye_));
    const Vec3f front(0, 0, eyeRadiusM_);
    landmarks_ = {leftEye_ + front, rightEye_ + front, 0.5f * (at_[kUpperLip] + at_[kLowerLip]), at_[kChin]};
    // The hinge of the jaw lies behind and above the teeth, as far as in the default rig.
    hinge_ = middleOf(Part::UpperTeeth) + Vec3f(0, 0.024f, -0.060f);
    return {};
}

Result<const Face::Offsets*> Face::unit(const std::string& name) {
    const auto known = units_.find(name);
    if (known != units_.end()) return &known->second;
    Offsets sum(source_.positionsDm.size(), Vec3f(0));
    for (const char* family : kFamilies)
        DPL_RETURN_IF_ERROR(addMakeHumanTarget(root_, formatText("expression/units/{}/{}", family, name), 1.0f / 3, sum));
    Offsets& own = units_[name];
    for (const MakeHumanVertex& v : vertices_) own.push_back(v.of(sum));
    return &own;
}

void Face::look(std::string_view name, Offsets& offsets) const {
    Mat3f turn(1);
    if (name == "eyeLookUpLeft") turn = turnAboutX(-kLookUpRad);
    if (name == "eyeLookDownLeft") turn = turnAboutX(kLookDownRad);
    if (name == "eyeLookInLeft") turn = turnAboutY(-kLookInRad);
    if (name == "eyeLookOutLeft") turn = turnAboutY(kLookOutRad);
    for (size_t v = 0; v < at_.size(); ++v)
        if (part_[v] == Part::LeftEye) offsets[v] = turn * (at_[v] - leftEye_) - (at_[v] - leftEye_);
}

void Face::turnWithJaw(Offsets& offsets) const {
    Vec3d move(0), from(0);
    for (size_t v = 0; v < at_.size(); ++v)
        if (part_[v] == Part::LowerTeeth) move += Vec3d(offsets[v]), from += Vec3d(at_[v] - hinge_);
    const Vec3d to = from + move;
    const float angle = float(std::atan2(from.y, from.z) - std::atan2(to.y, to.z));
    const Mat3f turn = turnAboutX(angle);
    for (size_t v = 0; v < at_.size(); ++v)
        if (part_[v] == Part::LowerTeeth || part_[v] == Part::Tongue) offsets[v] = turn * (at_[v] - hinge_) - (at_[v] - hinge_);
}

void Face::putTongueOut(Offsets& offsets) const {
    float back = 1e9f, tip = -1e9f;
    for (size_t v = 0; v < at_.size(); ++v)
        if (part_[v] == Part::Tongue) back = std::min(back, at_[v].z), tip = std::max(tip, at_[v].z);
    for (size_t v = 0; v < at_.size(); ++v)
        if (part_[v] == Part::Tongue) offsets[v] += smooth(back, tip, at_[v].z) * Vec3f(0, 0.002f, 0.036f);
}

void Face::keepOutside(Part eye, Offsets& offsets) const {
    const Vec3f centre = eye == Part::LeftEye ? leftEye_ : rightEye_;
    const float least = eyeRadiusM_ + kLidOutsideM;
    for (size_t v = 0; v < at_.size(); ++v) {
        if (part_[v] != Part::Skin || offsets[v] == Vec3f(0) || glm::length(at_[v] - centre) < eyeRadiusM_) continue;
        for (int tenth = 1; tenth <= 10; ++tenth) {
            const float weight = 0.1f * float(tenth);
            const Vec3f from = at_[v] + weight * offsets[v] - centre;
            const float distance = glm::length(from);
            if (distance < least && distance > 0) offsets[v] += (least - distance) / weight * (from / distance);
        }
    }
}

Face::Offsets Face::mirrored(const Offsets& offsets) const {
    Offsets out;
    for (const uint32_t twin : mirror_) out.push_back(Vec3f(-1, 1, 1) * offsets[twin]);
    return out;
}

Result<Face::Offsets> Face::leftOrBoth(std::string_view name) {
    Offsets offsets(at_.size(), Vec3f(0));
    static const std::vector<Recipe> kRecipes = recipes();
    const auto recipe = std::find_if(kRecipes.begin(), kRecipes.end(), [&](const Recipe& r) { return r.name == name; });
    if (recipe != kRecipes.end()) {
        for (const UnitWeight& part : recipe->units) {
            DPL_TRY(const Offsets* unit, this->unit(part.unit));
            for (size_t v = 0; v < at_.size(); ++v)
                offsets[v] += part.weight * (recipe->half ? smooth(-kMaskHalfM, kMaskHalfM, at_[v].x) : 1.0f) * (*unit)[v];
        }
        if (name == "jawOpen" || name == "tongueOut") turnWithJaw(offsets);
        if (name == "tongueOut") putTongueOut(offsets);
    } else if (const auto expression = expressionOf(name); expression && !name.starts_with("eyeLook")) {
        const bool jaw = name.starts_with("jaw");
        Vec3f whole(0);  // how far the chin goes
        for (size_t v = 0; v < at_.size(); ++v) {
            if (part_[v] == Part::Skin) offsets[v] = faceOffset(landmarks_, *expression, at_[v]);
            if (glm::length(offsets[v]) > glm::length(whole)) whole = offsets[v];
        }
        for (size_t v = 0; jaw && v < at_.size(); ++v)
            if (part_[v] == Part::LowerTeeth || part_[v] == Part::Tongue) offsets[v] = whole;
    }
    if (name.starts_with("eyeLook")) look(name, offsets);
    if (name.starts_with("eye")) keepOutside(Part::LeftEye, offsets);
    return offsets;
}

Result<ExpressionShape> Face::shape(size_t expression) {
    std::string name = kExpressionNames[expression];
    const bool bothSided = name.starts_with("jaw") || name == "mouthLeft" || name == "mouthRight";
    const bool right = name.ends_with("Right") && !bothSided;
    if (right) name.replace(name.size() - 5, 5, "Left");
    DPL_TRY(Offsets offsets, leftOrBoth(name));
    return ExpressionShape{uint8_t(expression), right ? mirrored(offsets) : std::move(offsets)};
}

}  // namespace

Result<std::vector<ExpressionShape>> makeHumanExpressions(const fs::path& folder, const BodyModel& body) {
    DPL_TRY(const fs::path root, makeHumanRoot(folder));
    DPL_TRY(const MakeHumanMesh source, readMakeHumanObj(root / "3dobjs" / "base.obj"));
    std::vector<ExpressionShape> shapes;
    for (const char* part : {"helper-l-eye", "helper-r-eye", "helper-upper-teeth", "helper-lower-teeth", "helper-tongue"})
        if (!source.groups.contains(part)) return shapes;
    if (!fs::exists(root / "targets" / "expression" / "units")) return shapes;
    Face face(root, source, body);
    DPL_RETURN_IF_ERROR(face.prepare());
    for (size_t expression = 0; expression < kExpressionCount; ++expression) {
        DPL_TRY(ExpressionShape shape, face.shape(expression));
        shapes.push_back(std::move(shape));
    }
    return shapes;
}

}  // namespace dpl
