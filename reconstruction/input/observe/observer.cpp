// SPDX-License-Identifier: Apache-2.0
// Runs BlazePose, the clothes parser and the networks of hands on one picture.
#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <span>

#include "reconstruction/base/models_folder.h"
#include "reconstruction/input/observe/choose_person.h"
#include "reconstruction/input/observe/hand_finder.h"
#include "reconstruction/input/observe/observations.h"
#include "reconstruction/input/observe/onnx_net.h"
#include "reconstruction/input/observe/person_detector.h"
#include "reconstruction/input/observe/pose_crop.h"
#include "reconstruction/input/observe/priors.h"
#include "reconstruction/input/observe/refine_matte.h"

namespace dpl {
namespace {

constexpr int kPoseSide = 256, kParserSide = 512, kSelfieSide = 256;
constexpr int kCropRounds = 3;
constexpr size_t kMostPeople = 6;   // that the pose network looks at in a picture
constexpr double kConfirmed = 0.5;  // of a person
constexpr double kSameBox = 0.5;    // overlap of two boxes of one person
constexpr uint8_t kBody = 1, kTop = 2, kBottom = 3, kHair = 4, kShoes = 5;

double sigmoid(double x) {
    return 1 / (1 + std::exp(-x));
}

PersonCrop boxCrop(const ImageRgb8& image, const ImageGrey8* mask, double margin) {
    cv::Rect box(0, 0, int(image.widthPx), int(image.heightPx));
    if (mask) {
        const cv::Mat soft(int(mask->heightPx), int(mask->widthPx), CV_8U, const_cast<uint8_t*>(mask->pixels.data()));
        const cv::Rect person = cv::boundingRect(soft >= 128);
        if (person.area() > 0) box = person;
    }
    return {{box.x + 0.5 * box.width, box.y + 0.5 * box.height}, margin * std::max(box.width, box.height), 0};
}

double segmentDistance(const Vec2d& p, const Vec2d& a, const Vec2d& b) {
    const Vec2d d = b - a;
    const double length2 = glm::dot(d, d);
    const double t = length2 > 0 ? std::clamp(glm::dot(p - a, d) / length2, 0.0, 1.0) : 0.0;
    return glm::length(p - a - t * d);
}

/** Labels clothes by the nearest limb: top at torso and arms, bottom at legs, shoes at feet. Landmarks in picture pixels.
 */
uint8_t garmentAt(const Vec2d& px, std::span<const Vec2d> p) {
    const Vec2d hips = 0.5 * (p[23] + p[24]), shoulders = 0.5 * (p[11] + p[12]);
    const Vec2d waist = hips + 0.12 * (shoulders - hips);
    double top = segmentDistance(px, waist, shoulders),
           bottom = std::min(segmentDistance(px, hips, p[25]), segmentDistance(px, hips, p[26])), shoes = 1e9;
    for (const size_t side : {0, 1}) {
        top = std::min({top, segmentDistance(px, p[11 + side], p[13 + side]), segmentDistance(px, p[13 + side], p[15 + side]),
                        segmentDistance(px, p[15 + side], p[19 + side]), segmentDistance(px, waist, p[11 + side])});
        const Vec2d shinEnd = p[25 + side] + 0.92 * (p[27 + side] - p[25 + side]);
        bottom = std::min({bottom, segmentDistance(px, p[23 + side], p[25 + side]), segmentDistance(px, p[25 + side], shinEnd)});
        shoes = std::min({shoes, segmentDistance(px, p[27 + side], p[31 + side]), segmentDistance(px, p[29 + side], p[31 + side])});
    }
    return top <= bottom && top <= shoes ? kTop : bottom <= shoes ? kBottom : kShoes;
}

struct Pose {
    PersonCrop crop;
    std::array<Vec2d, 39> landmarks{};
    std::array<double, 39> confidence{};
    std::array<double, 39> depthPx{};  // of the first look, towards the camera is less
    double score = 0;
    std::vector<float> segmentation;
    PersonCrop next;  // what the landmarks say that the crop should have been
};

/** How a pose network looks at a person: at a crop that is changed a little, whose errors differ. */
struct Look {
    double scale, turnRad;
    Vec2d shift;  // of the crop's side
    bool mirrored;
};
constexpr Look kLooks[] = {
    {1, 0, {0, 0}, false}, {1, 0, {0, 0}, true}, {0.9, 0.1, {0.008, 0.005}, false}, {0.9, -0.1, {-0.008, 0.005}, true}};

/** The landmark that a mirrored picture shows in place of landmark k: BlazePose numbers eyes by threes, all others left, right. */
size_t mirroredLandmark(size_t k) {
    if (k == 0 || k >= 33) return k;
    if (k <= 6) return k <= 3 ? k + 3 : k - 3;
    return k % 2 == 1 ? k + 1 : k - 1;
}

/** Landmarks lie inside the body: there is room beyond them for crown, hands and toes. */
PersonBox boxOf(const Pose& pose) {
    PersonBox box{Vec2d(1e30), Vec2d(-1e30)};
    for (size_t k = 0; k < 33; ++k) box.low = glm::min(box.low, pose.landmarks[k]), box.high = glm::max(box.high, pose.landmarks[k]);
    const double room = 0.06 * (box.high.y - box.low.y);
    return {box.low - Vec2d(room), box.high + Vec2d(room, 0.5 * room)};
}

/** Landmarks, confidence and score are means over the looks; crop and mask are the first one's. */
Pose meanOf(const std::vector<Pose>& looks) {
    Pose mean = looks[0];
    for (size_t i = 1; i < looks.size(); ++i) {
        for (size_t k = 0; k < 39; ++k) mean.landmarks[k] += looks[i].landmarks[k], mean.confidence[k] += looks[i].confidence[k];
        mean.score += looks[i].score;
    }
    const double count = double(looks.size());
    for (size_t k = 0; k < 39; ++k) mean.landmarks[k] /= count, mean.confidence[k] /= count;
    mean.score /= count;
    return mean;
}

/** The mean of the looks' masks in the picture, 0 … 1. */
cv::Mat meanMask(const std::vector<Pose>& looks, const ImageRgb8& image) {
    cv::Mat mean = cv::Mat::zeros(int(image.heightPx), int(image.widthPx), CV_32F);
    for (const Pose& look : looks) mean += spreadCrop(look.segmentation.data(), kPoseSide, look.crop, image.widthPx, image.heightPx);
    return mean / double(looks.size());
}

Result<std::optional<OnnxNet>> loadIfThere(const std::filesystem::path& file) {
    std::error_code ignored;
    if (!std::filesystem::exists(file, ignored)) return std::optional<OnnxNet>();
    DPL_TRY(OnnxNet network, OnnxNet::load(file));
    return std::optional(std::move(network));
}

}  // namespace

struct Observer::State {
    OnnxNet pose;
    std::optional<OnnxNet> heavyPose;  // slower and more exact; looks beside the other, whose errors differ
    std::optional<OnnxNet> parser, detector, selfie;
    std::optional<HandFinder> hands;

    /** The pose in one crop, which the network sees mirrored if told so. */
    Result<Pose> lookAt(OnnxNet& network, const ImageRgb8& image, const PersonCrop& crop, bool mirrored) {
        std::vector<float> input = cropToTensor(image, crop, kPoseSide, {0, 0, 0}, {1, 1, 1});
        if (mirrored) mirrorRows(input, kPoseSide);
        DPL_TRY(const auto outputs, network.run(input, kPoseSide));
        const Tensor *points = nullptr, *flag = nullptr, *segmentation = nullptr;
        for (const Tensor& t : outputs) {
            if (t.name.find("ld_3d") != std::string::npos && t.data.size() == 195) points = &t;
            if (t.name.find("poseflag") != std::string::npos && t.data.size() == 1) flag = &t;
            if (t.name.find("segmentation") != std::string::npos && t.data.size() == size_t(kPoseSide) * kPoseSide) segmentation = &t;
        }
        if (!points || !flag || !segmentation)
            return fail(Code::Unsupported, "the pose network has other outputs than BlazePose; use {}", network_files::kPose);
        Pose found;
        found.crop = found.next = crop;
        found.score = std::clamp(double(flag->data[0]), 0.0, 1.0);
        found.segmentation = segmentation->data;
        for (size_t k = 0; k < 39; ++k) {
            const float* v = points->data.data() + 5 * (mirrored ? mirroredLandmark(k) : k);
            found.landmarks[k] = cropToPicture(crop, {mirrored ? kPoseSide - v[0] : v[0], v[1]}, kPoseSide);
            found.confidence[k] = sigmoid(v[3]) * sigmoid(v[4]);
            found.depthPx[k] = double(v[2]) * crop.sidePx / kPoseSide;
        }
        if (mirrored) mirrorRows(found.segmentation, kPoseSide);
        return found;
    }

    Result<Pose> findPose(const ImageRgb8& image, PersonCrop crop, int rounds) {
        Pose found;
        for (int round = 0; round < rounds; ++round) {
            DPL_TRY(found, lookAt(pose, image, crop, false));
            if (found.score < kConfirmed) break;  // no person: the next crop would drift away
            const Vec2d up = found.landmarks[34] - found.landmarks[33];
            const double reach = glm::length(up);
            if (!(reach > 1) || !std::isfinite(reach)) break;
            crop = {found.landmarks[33], 2.5 * reach, std::atan2(up.x, -up.y)};
        }
        found.next = crop;
        return found;
    }

    /** The people in a picture, best first. Without a detector only the one whom the network finds in the whole picture. */
    Result<std::vector<Pose>> confirmedPoses(const ImageRgb8& image) {
        std::vector<DetectedPerson> places{{boxCrop(image, nullptr, 1.25), 1}};
        if (detector) {
            DPL_TRY(places, detectPeople(*detector, image, kMostPeople));
        }
        std::vector<Pose> seen, kept;
        for (const DetectedPerson& place : places) {
            DPL_TRY(Pose found, findPose(image, place.crop, 2));
            if (found.score >= kConfirmed) seen.push_back(std::move(found));
        }
        std::stable_sort(seen.begin(), seen.end(), [](const Pose& a, const Pose& b) { return a.score > b.score; });
        for (Pose& one : seen)
            if (std::none_of(kept.begin(), kept.end(), [&](const Pose& other) { return boxOverlap(boxOf(one), boxOf(other)) > kSameBox; }))
                kept.push_back(std::move(one));
        return kept;
    }

    /** A confirmed pose, which is the first network's first look, and the other looks that confirm somebody too. A pose that is not
     *  confirmed stays alone. */
    Result<std::vector<Pose>> looksAround(const ImageRgb8& image, Pose first) {
        std::vector<Pose> looks{std::move(first)};
        if (looks[0].score < kConfirmed) return looks;
        const PersonCrop best = looks[0].next;
        const auto add = [&](OnnxNet& network, const Look& look) -> Status {
            const PersonCrop crop{best.centrePx + best.sidePx * look.shift, best.sidePx * look.scale, best.angleRad + look.turnRad};
            DPL_TRY(Pose seen, lookAt(network, image, crop, look.mirrored));
            if (seen.score >= kConfirmed) looks.push_back(std::move(seen));
            return {};
        };
        for (const Look& look : std::span(kLooks).subspan(1)) DPL_RETURN_IF_ERROR(add(pose, look));
        if (heavyPose)
            for (const Look& look : kLooks) DPL_RETURN_IF_ERROR(add(*heavyPose, look));
        return looks;
    }

    /** The mask of a picture of a part of a person, 0 … 1: Selfie Segmentation on the whole picture and its mirror image. */
    Result<cv::Mat> closeupMask(const ImageRgb8& image) {
        const cv::Mat source(int(image.heightPx), int(image.widthPx), CV_8UC3, const_cast<uint8_t*>(image.pixels.data()));
        ImageRgb8 small{uint32_t(kSelfieSide), uint32_t(kSelfieSide), std::vector<uint8_t>(size_t(3) * kSelfieSide * kSelfieSide)};
        cv::Mat squeezed(kSelfieSide, kSelfieSide, CV_8UC3, small.pixels.data());
        cv::resize(source, squeezed, squeezed.size(), 0, 0, cv::INTER_AREA);
        const PersonCrop whole{Vec2d(kSelfieSide / 2.0), double(kSelfieSide), 0};
        std::vector<float> input = cropToTensor(small, whole, kSelfieSide, {0, 0, 0}, {1, 1, 1});
        cv::Mat mean = cv::Mat::zeros(kSelfieSide, kSelfieSide, CV_32F);
        for (const bool mirrored : {false, true}) {
            if (mirrored) mirrorRows(input, kSelfieSide);
            DPL_TRY(auto outputs, selfie->run(input, kSelfieSide));
            if (outputs.size() != 1 || outputs[0].data.size() != size_t(kSelfieSide) * kSelfieSide)
                return fail(Code::Unsupported, "{} has other outputs than Selfie Segmentation; run tools/models again",
                            network_files::kCloseups);
            if (mirrored) mirrorRows(outputs[0].data, kSelfieSide);
            mean += 0.5 * cv::Mat(kSelfieSide, kSelfieSide, CV_32F, outputs[0].data.data());
        }
        cv::resize(mean, mean, source.size(), 0, 0, cv::INTER_LINEAR);
        return mean;
    }

    Status findLabels(const ImageRgb8& image, const Pose& pose33, Observation& out) {
        const PersonCrop crop = boxCrop(image, &out.mask, 1.1);
        DPL_TRY(const auto outputs,
                parser->run(cropToTensor(image, crop, kParserSide, {0.485f, 0.456f, 0.406f}, {0.229f, 0.224f, 0.225f}), kParserSide));
        constexpr size_t kPlane = size_t(kParserSide) * kParserSide;
        if (outputs.size() != 1 || outputs[0].data.size() != 3 * kPlane)
            return fail(Code::Unsupported, "the clothes network has other outputs than skin, clothes, hair; use {}",
                        network_files::kClothes);
        cv::Mat share[3];
        for (size_t c = 0; c < 3; ++c)
            share[c] = spreadCrop(outputs[0].data.data() + c * kPlane, kParserSide, crop, image.widthPx, image.heightPx);
        out.labels = {image.widthPx, image.heightPx, std::vector<uint8_t>(size_t(image.widthPx) * image.heightPx, 0)};
        for (uint32_t y = 0; y < image.heightPx; ++y)
            for (uint32_t x = 0; x < image.widthPx; ++x) {
                const size_t i = size_t(y) * image.widthPx + x;
                if (out.mask.pixels[i] < 128) continue;
                const float skin = share[0].at<float>(int(y), int(x)), clothes = share[1].at<float>(int(y), int(x)),
                            hair = share[2].at<float>(int(y), int(x));
                if (hair >= skin && hair >= clothes && hair > 0.3f)
                    out.labels.pixels[i] = kHair;
                else if (skin > clothes && skin > 0.3f)
                    out.labels.pixels[i] = kBody;
                else
                    out.labels.pixels[i] = garmentAt({x + 0.5, y + 0.5}, pose33.landmarks);
            }
        return {};
    }
};

Observer::Observer(std::unique_ptr<State> state) : state_(std::move(state)) {}
Observer::Observer(Observer&&) noexcept = default;
Observer& Observer::operator=(Observer&&) noexcept = default;
Observer::~Observer() = default;
bool Observer::hasLabels() const {
    return state_->parser.has_value();
}
bool Observer::hasDetector() const {
    return state_->detector.has_value();
}
bool Observer::hasHands() const {
    return state_->hands.has_value();
}

Result<Observer> Observer::load(const std::filesystem::path& models) {
    std::error_code ignored;
    const bool light = !std::filesystem::exists(models / network_files::kPose, ignored) &&
                       std::filesystem::exists(models / network_files::kLightPose, ignored);
    DPL_TRY(auto pose, OnnxNet::load(models / (light ? network_files::kLightPose : network_files::kPose)));
    DPL_TRY(auto heavyPose, loadIfThere(models / network_files::kHeavyPose));
    DPL_TRY(auto parser, loadIfThere(models / network_files::kClothes));
    DPL_TRY(auto detector, loadIfThere(models / network_files::kDetector));
    DPL_TRY(auto selfie, loadIfThere(models / network_files::kCloseups));
    DPL_TRY(auto hands, HandFinder::loadIfThere(models));
    return Observer(std::unique_ptr<State>(
        new State{std::move(pose), std::move(heavyPose), std::move(parser), std::move(detector), std::move(selfie), std::move(hands)}));
}

Result<std::vector<SeenPerson>> Observer::people(const ImageRgb8& image) {
    DPL_TRY(const std::vector<Pose> poses, state_->confirmedPoses(image));
    std::vector<SeenPerson> seen;
    for (const Pose& pose : poses) seen.push_back({boxOf(pose), pose.next, pose.score});
    return seen;
}

Result<Glance> Observer::glance(const ImageRgb8& image) {
    DPL_TRY(const std::vector<Pose> poses, state_->confirmedPoses(image));
    Glance glance;
    glance.people = poses.size();
    if (poses.empty()) return glance;
    const Pose& pose = poses[0];
    glance.landmarks.assign(pose.landmarks.begin(), pose.landmarks.begin() + 33);
    glance.confidence.assign(pose.confidence.begin(), pose.confidence.begin() + 33);
    Vec2d across(0);  // from the right shoulder and hip to the left ones: to the picture's right, and away from the camera
    for (const size_t left : {11, 23})
        across += Vec2d(pose.landmarks[left].x - pose.landmarks[left + 1].x, pose.depthPx[left] - pose.depthPx[left + 1]);
    glance.turnRad = std::atan2(-across.y, across.x);
    const auto tall = [](const Pose& one) { return boxOf(one).high.y - boxOf(one).low.y; };
    if (poses.size() > 1) glance.secondShare = tall(poses[1]) / std::max(1.0, tall(pose));
    return glance;
}

Result<Observation> Observer::observe(const ImageRgb8& image, const ImageGrey8* mask, const PersonCrop* start, bool closeup) {
    if (image.pixels.size() != size_t(3) * image.widthPx * image.heightPx || image.pixels.empty())
        return fail(Code::InvalidArgument, "an empty image cannot be observed");
    if (mask && (mask->widthPx != image.widthPx || mask->heightPx != image.heightPx))
        return fail(Code::InvalidArgument, "the mask has another size than the image");
    DPL_TRY(Pose found, state_->findPose(image, start ? *start : boxCrop(image, mask, 1.25), kCropRounds));
    DPL_TRY(const std::vector<Pose> looks, state_->looksAround(image, std::move(found)));
    const Pose pose = meanOf(looks);
    Observation out;
    out.personScore = pose.score;
    if (mask) {
        out.mask = *mask;
    } else {
        const bool seen = pose.score >= kConfirmed;
        cv::Mat soft = seen ? meanMask(looks, image) : cv::Mat::zeros(int(image.heightPx), int(image.widthPx), CV_32F);
        if (closeup && state_->selfie) {
            DPL_TRY(const cv::Mat near, state_->closeupMask(image));
            soft = seen ? cv::Mat(0.5 * (soft + near)) : near;
        }
        out.mask = {image.widthPx, image.heightPx, std::vector<uint8_t>(size_t(image.widthPx) * image.heightPx, 0)};
        cv::Mat cut(soft.size(), CV_8U, out.mask.pixels.data());
        cv::compare(soft, priors::kMatteCut, cut, cv::CMP_GT);
        // A pixel of a network's mask covers several of the picture: its edge is wrong by about two of its own pixels.
        const double sidePx = seen ? pose.crop.sidePx : std::max(image.widthPx, image.heightPx);
        out.mask = refineMatte(image, out.mask, std::max(2, int(std::ceil(2 * sidePx / kPoseSide))));
    }
    std::array<double, 33> confidence{};
    for (size_t k = 0; k < 33; ++k) confidence[k] = pose.score >= kConfirmed ? pose.confidence[k] * pose.score : 0;
    out.keypoints = keypointsFromLandmarks(std::span(pose.landmarks).first(33), confidence, &out.mask);
    if (state_->hands) {
        DPL_TRY(out.hands, state_->hands->find(image, std::span(pose.landmarks).first(33), confidence, closeup));
    }
    if (state_->parser && pose.score >= kConfirmed) DPL_RETURN_IF_ERROR(state_->findLabels(image, pose, out));
    return out;
}

}  // namespace dpl
