// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/judging/coach/film_faults.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <opencv2/imgproc.hpp>

#include "reconstruction/judging/coach/edge_blur.h"
#include "sdk/core/percentile.h"

namespace dpl {
namespace {

// Thresholds are round figures; docs/reference/body-map.md says on which films they were judged. They decide what is said, not what is
// made.
constexpr double kBlackLuma = 12;          // a covered lens; night scenes of phones stay above 20
constexpr double kDarkLuma = 42;           // of the median picture
constexpr double kJump = 1.7;              // ratio of brightness from one picture of a walk to the next: more than a stop
constexpr float kBlurredPx = 1.05f;        // of pictures 960 pixels long; sharp ones have 0.2 to 0.7, close-ups up to 1
constexpr double kBlurredShare = 0.34;     // of a part's pictures; a few are left out anyway
constexpr double kBinDeg = 30;             // of the round
constexpr double kWidestGapDeg = 90;       // without any picture
constexpr double kCutShare = 0.25;         // of the walk's pictures
constexpr double kHidden = 0.5;            // confidence below which a joint is hidden
constexpr double kHandShare = 0.12;        // length of a hand over the picture's longer side; from two metres it is 0.07 to 0.1
constexpr double kHandOfForearm = 0.75;    // length of a hand
constexpr double kOtherPersonShare = 0.2;  // of the pictures
constexpr double kOtherPersonTall = 0.5;   // of the first one's height
constexpr double kOtherClothes = 22;       // ΔE between the parts' median colours, of belly or of thighs
constexpr double kRaised = 0.08;           // an elbow above its shoulder, over the height from shoulder to ankle
constexpr double kBentDeg = 50;            // of an elbow
constexpr size_t kFewest = 4;              // pictures below which a part is not judged

// Landmarks of the left side; those of the right follow each.
constexpr size_t kLeftShoulder = 11, kLeftElbow = 13, kLeftWrist = 15, kLeftHip = 23, kLeftKnee = 25, kLeftAnkle = 27;

bool inside(const FilmPicture& p, const Vec2d& px) {
    return px.x >= 0 && px.y >= 0 && px.x < p.widthPx && px.y < p.heightPx;
}

double degreesOf(double radians) {
    return radians * 180 / std::numbers::pi;
}

/** Angle at `b` between `a` and `c`. */
double angleAt(const Vec2d& a, const Vec2d& b, const Vec2d& c) {
    const Vec2d u = a - b, v = c - b;
    const double lengths = glm::length(u) * glm::length(v);
    return lengths > 1e-9 ? degreesOf(std::acos(std::clamp(glm::dot(u, v) / lengths, -1.0, 1.0))) : 180;
}

std::string ofPictures(size_t count, size_t all) {
    return formatText("{} of {} pictures", count, all);
}

/** Mean colour of the parallelogram between four points, in CIELAB; none where it lies outside or is tiny. */
std::optional<Vec3f> colourBetween(const cv::Mat& rgb, std::array<Vec2d, 4> corners) {
    Vec2d middle(0);
    for (const Vec2d& c : corners) middle += 0.25 * c;
    std::vector<cv::Point> shape;
    for (const Vec2d& c : corners) {
        const Vec2d inner = middle + 0.6 * (c - middle);  // the outline is not of the clothes alone
        shape.emplace_back(int(std::clamp(inner.x, -1e6, 1e6)), int(std::clamp(inner.y, -1e6, 1e6)));
    }
    cv::Rect box = cv::boundingRect(shape) & cv::Rect(0, 0, rgb.cols, rgb.rows);
    if (box.area() < 30) return std::nullopt;
    for (cv::Point& p : shape) p -= box.tl();
    cv::Mat where = cv::Mat::zeros(box.size(), CV_8U);
    cv::fillConvexPoly(where, shape, cv::Scalar(255));
    if (cv::countNonZero(where) < 20) return std::nullopt;
    cv::Mat patch, lab;
    rgb(box).convertTo(patch, CV_32F, 1 / 255.0);
    cv::cvtColor(patch, lab, cv::COLOR_RGB2Lab);
    const cv::Scalar mean = cv::mean(lab, where);
    return Vec3f(float(mean[0]), float(mean[1]), float(mean[2]));
}

class Judge {
public:
    Judge(std::span<const FilmPicture> pictures, bool undivided) : pictures_(pictures), undivided_(undivided) {
        for (const FilmPicture& p : pictures) {
            of(p.kind).push_back(&p);
            looked_ |= p.looked;
        }
        for (const FilmPicture* p : of(FrameKind::StaticFull))
            if (p->person) walked_.push_back(p);
    }

    std::vector<FilmFault> run() {
        darkness();
        blur();
        if (looked_) nobody(), wrongPerson(), round(), cut();
        moves();
        if (looked_) hands();
        return std::move(faults_);
    }

private:
    std::span<const FilmPicture> pictures_;
    bool undivided_, looked_ = false;
    std::array<std::vector<const FilmPicture*>, 3> kinds_;
    std::vector<const FilmPicture*> walked_;  // still pictures with a person
    std::vector<FilmFault> faults_;

    std::vector<const FilmPicture*>& of(FrameKind kind) { return kinds_[size_t(kind)]; }
    void add(std::string key, std::string sentence) { faults_.push_back({std::move(key), std::move(sentence)}); }

    void darkness() {
        std::vector<double> seen;
        size_t black = 0, jumps = 0;
        for (const FilmPicture& p : pictures_) {
            if (p.luma < kBlackLuma)
                ++black;
            else
                seen.push_back(p.luma);
        }
        if (black > 0)
            add("black", formatText("Film again what is missing: {} are black, as behind a finger or a closed shutter",
                                    ofPictures(black, pictures_.size())));
        if (!seen.empty() && percentile(seen, 0.5) < kDarkLuma)
            add("dark", "Switch on all lamps, or go outside: the pictures are dark, so that noise hides the clothes");
        std::vector<const FilmPicture*> walk = of(FrameKind::StaticFull);
        std::stable_sort(walk.begin(), walk.end(), [](const FilmPicture* a, const FilmPicture* b) {
            return std::pair(a->film, a->timeS) < std::pair(b->film, b->timeS);
        });
        for (size_t i = 1; i < walk.size(); ++i) {
            const double a = walk[i - 1]->luma, b = walk[i]->luma;
            if (walk[i]->film == walk[i - 1]->film && std::min(a, b) >= kBlackLuma && std::max(a, b) / std::min(a, b) > kJump) ++jumps;
        }
        if (jumps > 0)
            add("exposure",
                formatText("Lock the exposure (long press on the person) and walk again: the brightness jumps {} times", jumps));
    }

    void blur() {
        constexpr std::pair<FrameKind, const char*> kParts[] = {
            {FrameKind::StaticFull, "walk"}, {FrameKind::StaticCloseup, "close-ups"}, {FrameKind::Dynamic, "moves"}};
        for (const auto& [kind, name] : kParts) {
            size_t blurred = 0, measured = 0;
            for (const FilmPicture* p : of(kind)) {
                if (!p->blurPx) continue;
                ++measured;
                const double longer = std::max(p->widthPx, p->heightPx);
                blurred += *p->blurPx > kBlurredPx * std::max(1.0, longer / 960);
            }
            if (measured >= kFewest && double(blurred) >= kBlurredShare * double(measured))
                add(formatText("blur {}", name),
                    formatText("Film the {} again, slower or in more light: {} are blurred", name, ofPictures(blurred, measured)));
        }
    }

    void nobody() {
        const size_t all = of(FrameKind::StaticFull).size();
        if (all >= kFewest && 2 * walked_.size() < all)
            add("nobody",
                formatText("Keep the whole person in the picture: {} of the walk show nobody", ofPictures(all - walked_.size(), all)));
    }

    void wrongPerson() {
        size_t crowded = 0, all = 0;
        for (const FilmPicture& p : pictures_) {
            if (!p.person || p.kind == FrameKind::StaticCloseup) continue;
            ++all, crowded += p.person->people > 1 && p.person->secondShare > kOtherPersonTall;
        }
        if (all >= kFewest && double(crowded) > kOtherPersonShare * double(all))
            add("person", formatText("Film the person alone: somebody else is in view in {}", ofPictures(crowded, all)));
        // Belly and thighs of the moves against those of the walk.
        double most = 0;
        for (size_t part = 0; part < 2; ++part) {
            std::array<std::vector<double>, 3> colour[2];
            for (const size_t moving : {0, 1})
                for (const FilmPicture* p : of(moving ? FrameKind::Dynamic : FrameKind::StaticFull))
                    if (p->person && p->clothes[part])
                        for (int c = 0; c < 3; ++c) colour[moving][size_t(c)].push_back(double((*p->clothes[part])[c]));
            if (colour[0][0].size() < kFewest || colour[1][0].size() < kFewest) return;
            double square = 0;
            for (size_t c = 0; c < 3; ++c) square += std::pow(percentile(colour[0][c], 0.5) - percentile(colour[1][c], 0.5), 2);
            most = std::max(most, std::sqrt(square));
        }
        if (most > kOtherClothes)
            add("person", "Film the moves of the same person in the same clothes: the person who moves wears other colours");
    }

    void round() {
        if (walked_.size() < kFewest) return;
        constexpr int kBins = int(360 / kBinDeg);
        std::array<size_t, kBins> bins{};
        for (const FilmPicture* p : walked_) {
            const int bin = int(std::floor(degreesOf(p->person->turnRad) / kBinDeg + 0.5));
            ++bins[size_t((bin % kBins + kBins) % kBins)];
        }
        const size_t enough = std::max<size_t>(1, walked_.size() / 30);  // one wrong look does not fill a gap
        int widest = 0, from = 0;
        for (int begin = 0; begin < kBins; ++begin) {
            int length = 0;
            while (length < kBins && bins[size_t((begin + length) % kBins)] < enough) ++length;
            if (length > widest) widest = length, from = begin;
        }
        if (widest * kBinDeg <= kWidestGapDeg) return;
        constexpr const char* kSides[] = {"front", "front left", "left", "back left", "back", "back right", "right", "front right"};
        const double middleDeg = (from + 0.5 * (widest - 1)) * kBinDeg;
        const int side = int(std::lround(middleDeg / 45)) % 8;
        add("turn", formatText("Walk past the person's {} too: about {}° of the round are in no picture", kSides[side],
                               std::lround(widest * kBinDeg)));
    }

    void cut() {
        size_t feet = 0, hem = 0;
        for (const FilmPicture* p : walked_) {
            bool feetCut = false, hemCut = false;
            for (const size_t side : {0, 1}) {
                feetCut |= !inside(*p, p->person->landmarks[kLeftAnkle + side]);
                hemCut |= !inside(*p, p->person->landmarks[kLeftKnee + side]);
            }
            feet += feetCut, hem += hemCut;
        }
        if (walked_.size() < kFewest) return;
        const auto often = [&](size_t count) { return double(count) > kCutShare * double(walked_.size()); };
        if (often(hem))
            add("hem",
                formatText("Step back until feet and hem are in the picture: {} end above the knees", ofPictures(hem, walked_.size())));
        else if (often(feet))
            add("feet", formatText("Step back until there is floor below the feet: {} cut them off", ofPictures(feet, walked_.size())));
    }

    void moves() {
        const std::vector<const FilmPicture*>& moving = of(undivided_ ? FrameKind::StaticFull : FrameKind::Dynamic);
        if (moving.empty()) {
            add("moves", "Film the moves too (--motion): without them clothes look stiff when the avatar moves");
            return;
        }
        if (!looked_ || moving.size() < kFewest) return;
        double raised = 0, bent = 0;
        for (const FilmPicture* p : moving) {
            if (!p->person) continue;
            const auto& at = p->person->landmarks;
            const double tall = std::max(1.0, glm::length(at[kLeftShoulder] - at[kLeftAnkle]));
            for (const size_t side : {0, 1}) {
                raised = std::max(raised, (at[kLeftShoulder + side].y - at[kLeftElbow + side].y) / tall);
                bent = std::max(bent, 180 - angleAt(at[kLeftShoulder + side], at[kLeftElbow + side], at[kLeftWrist + side]));
            }
        }
        std::string missing;
        const auto need = [&](bool shown, const char* words) {
            if (!shown) missing += (missing.empty() ? "" : ", ") + std::string(words);
        };
        need(raised > kRaised, "raise both arms to the side and up");
        need(bent > kBentDeg, "bend both elbows");
        if (!missing.empty()) add("moves", formatText("Film these moves too: {}", missing));
    }

    void hands() {
        bool seen[2] = {false, false};
        size_t partsOnly = 0;  // close-ups of a part of the person so small that nobody is found: hands are among them, or may be
        for (const FilmPicture& p : pictures_) {
            if (!p.person) {
                partsOnly += p.kind == FrameKind::StaticCloseup && p.looked && p.luma >= kBlackLuma;
                continue;
            }
            const double longer = std::max(p.widthPx, p.heightPx);
            for (const size_t side : {0, 1}) {
                const Vec2d wrist = p.person->landmarks[kLeftWrist + side], elbow = p.person->landmarks[kLeftElbow + side];
                seen[side] |= inside(p, wrist) && p.person->confidence[kLeftWrist + side] > kHidden &&
                              kHandOfForearm * glm::length(wrist - elbow) > kHandShare * longer;
            }
        }
        if (partsOnly > 0) return;
        if (!seen[0] && !seen[1])
            add("hands", "Film each hand from 40 cm, slowly from all sides: no picture shows one from near");
        else if (!seen[0] || !seen[1])
            add("hands", formatText("Film the {} hand from 40 cm, slowly from all sides: no picture shows it from near",
                                    seen[0] ? "right" : "left"));
    }
};

}  // namespace

FilmPicture measureFilmPicture(const ImageRgb8& image, FrameKind kind, size_t film, double timeS, const Glance* glance) {
    FilmPicture out{.kind = kind, .film = film, .timeS = timeS, .widthPx = image.widthPx, .heightPx = image.heightPx};
    const cv::Mat rgb(int(image.heightPx), int(image.widthPx), CV_8UC3, const_cast<uint8_t*>(image.pixels.data()));
    const cv::Scalar mean = cv::mean(rgb);
    out.luma = 0.299 * mean[0] + 0.587 * mean[1] + 0.114 * mean[2];
    std::vector<float> sigmas;
    for (const EdgeBlur& edge : edgeBlurs(image, {})) sigmas.push_back(edge.sigmaPx);
    out.blurPx = blurOf(std::move(sigmas));
    out.looked = glance != nullptr;
    if (!glance || glance->landmarks.size() < 33 || glance->confidence.size() < 33) return out;
    out.person = *glance;
    const auto& at = glance->landmarks;
    const Vec2d hipsDown[2] = {0.5 * (at[kLeftHip] + at[kLeftKnee]), 0.5 * (at[kLeftHip + 1] + at[kLeftKnee + 1])};
    out.clothes[0] = colourBetween(rgb, {at[kLeftShoulder], at[kLeftShoulder + 1], at[kLeftHip + 1], at[kLeftHip]});
    out.clothes[1] = colourBetween(rgb, {at[kLeftHip], at[kLeftHip + 1], hipsDown[1], hipsDown[0]});
    return out;
}

std::vector<FilmFault> filmFaults(std::span<const FilmPicture> pictures, bool undivided) {
    return Judge(pictures, undivided).run();
}

}  // namespace dpl
