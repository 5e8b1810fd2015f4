// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/input/observe/choose_person.h"

#include <algorithm>
#include <cmath>

namespace dpl {
namespace {

constexpr size_t kMostMissed = 15;      // frames that a track may miss, half a second of a video
constexpr double kLargestStep = 0.6;    // of a box's middle between neighbouring frames, share of its height
constexpr double kLargestGrowth = 1.6;  // of a box's height between neighbouring frames; a lifted arm grows it by a third
constexpr size_t kLongTrack = 5;        // frames; pictures that continue each other this long are in order
constexpr double kPointed = 1e9;        // value of a track that the user points at
constexpr double kMiddleShare = 0.5;    // distance from the middle, share of the half diagonal, at which nearness is 1/2

struct Track {
    std::vector<size_t> frames, people;  // one entry a frame in which it is seen
    double value = 0;
};

Vec2d middle(const PersonBox& box) {
    return 0.5 * (box.low + box.high);
}
double height(const PersonBox& box) {
    return std::max(1.0, box.high.y - box.low.y);
}

/** How far `b` is from continuing `a`, `gap` frames later; at most 1 if it does. */
double stepCost(const PersonBox& a, const PersonBox& b, size_t gap) {
    const double room = std::sqrt(double(gap));
    const double step = glm::length(middle(a) - middle(b)) / (kLargestStep * room * std::max(height(a), height(b)));
    const double growth = std::abs(std::log(height(a) / height(b))) / std::log(kLargestGrowth);
    return std::max(step, growth);
}

double valueOf(const PeopleOfFrame& frame, const SeenPerson& person) {
    const double off = glm::length(middle(person.box) - 0.5 * frame.sizePx) / (0.5 * glm::length(frame.sizePx)) / kMiddleShare;
    double value = person.score * height(person.box) / frame.sizePx.y / (1 + off * off);
    if (frame.pointPx) {
        const Vec2d& p = *frame.pointPx;
        if (p.x >= person.box.low.x && p.y >= person.box.low.y && p.x <= person.box.high.x && p.y <= person.box.high.y) value += kPointed;
    }
    return value;
}

/** Whether the person of the chosen frames before and after this track could have come to where it begins and ends. */
bool couldContinue(std::span<const PeopleOfFrame> frames, std::span<const size_t> chosen, const Track& track) {
    const auto boxIn = [&](size_t f, size_t person) -> const PersonBox& { return frames[f].people[person].box; };
    for (size_t f = track.frames.front(); f-- > 0;)
        if (chosen[f] != kNobody) {
            if (stepCost(boxIn(f, chosen[f]), boxIn(track.frames.front(), track.people.front()), track.frames.front() - f) > 1)
                return false;
            break;
        }
    for (size_t f = track.frames.back() + 1; f < frames.size(); ++f)
        if (chosen[f] != kNobody)
            return stepCost(boxIn(track.frames.back(), track.people.back()), boxIn(f, chosen[f]), f - track.frames.back()) <= 1;
    return true;
}

/** Each frame extends the open tracks by its people, the closest pair first. */
std::vector<Track> makeTracks(std::span<const PeopleOfFrame> frames) {
    std::vector<Track> tracks;
    struct Pair {
        double cost;
        size_t track, person;
    };
    for (size_t f = 0; f < frames.size(); ++f) {
        std::vector<Pair> pairs;
        for (size_t t = 0; t < tracks.size(); ++t) {
            const size_t last = tracks[t].frames.back(), gap = f - last;
            if (gap > kMostMissed) continue;
            const PersonBox& before = frames[last].people[tracks[t].people.back()].box;
            for (size_t p = 0; p < frames[f].people.size(); ++p)
                if (const double cost = stepCost(before, frames[f].people[p].box, gap); cost <= 1) pairs.push_back({cost, t, p});
        }
        std::stable_sort(pairs.begin(), pairs.end(), [](const Pair& a, const Pair& b) { return a.cost < b.cost; });
        std::vector<bool> taken(frames[f].people.size(), false);
        for (const Pair& pair : pairs) {
            Track& track = tracks[pair.track];
            if (taken[pair.person] || track.frames.back() == f) continue;
            taken[pair.person] = true;
            track.frames.push_back(f), track.people.push_back(pair.person);
        }
        for (size_t p = 0; p < taken.size(); ++p)
            if (!taken[p]) tracks.push_back({{f}, {p}});
    }
    for (Track& track : tracks)
        for (size_t i = 0; i < track.frames.size(); ++i)
            track.value += valueOf(frames[track.frames[i]], frames[track.frames[i]].people[track.people[i]]);
    return tracks;
}

}  // namespace

double boxOverlap(const PersonBox& a, const PersonBox& b) {
    const Vec2d size = glm::max(Vec2d(0), glm::min(a.high, b.high) - glm::max(a.low, b.low));
    const auto area = [](const Vec2d& d) { return d.x * d.y; };
    const double both = area(size), either = area(a.high - a.low) + area(b.high - b.low) - both;
    return either > 0 ? both / either : 0;
}

std::vector<size_t> choosePerson(std::span<const PeopleOfFrame> frames) {
    std::vector<Track> tracks = makeTracks(frames);
    std::stable_sort(tracks.begin(), tracks.end(), [](const Track& a, const Track& b) { return a.value > b.value; });
    std::vector<size_t> chosen(frames.size(), kNobody);
    for (const Track& track : tracks) {
        if (std::any_of(track.frames.begin(), track.frames.end(), [&](size_t f) { return chosen[f] != kNobody; })) continue;
        if (tracks[0].frames.size() >= kLongTrack && !couldContinue(frames, chosen, track)) continue;
        for (size_t i = 0; i < track.frames.size(); ++i) chosen[track.frames[i]] = track.people[i];
    }
    return chosen;
}

size_t nearestPerson(std::span<const SeenPerson> people, const PersonBox& box) {
    size_t best = kNobody;
    double least = 2;
    for (size_t p = 0; p < people.size(); ++p)
        if (const double cost = stepCost(box, people[p].box, 1); cost < least) least = cost, best = p;
    return best;
}

}  // namespace dpl
