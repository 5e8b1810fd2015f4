// SPDX-License-Identifier: Apache-2.0
// Players of clips, of the C++ wrapper. Part of doppel.hpp, which includes it.
#pragma once

#include <cmath>
#include <cstdint>
#include <span>
#include <vector>

#include <doppel/doppel_convert.h>
#include <doppel/doppel_avatar.hpp>

namespace doppel {

/** How Player::play plays a clip. */
struct Playback {
    double speed = 1;     // of the clip's own time; below 0: backwards
    double fadeS = 0.3;   // within which the clip takes over from what played before, seconds; 0: at once
    double fromS = 0;     // where the clip starts
    bool loop = true;     // otherwise it holds its last pose
    bool travel = false;  // recorded walks go on from where the person stands, in each round and from clip to clip
};

/** Play, pause, speed, loops and cross-fades of clips of one avatar, as layers for Avatar::setPoseFromClips. Times are nanoseconds of any
 * one clock; the layers are a function of the calls and of the time that is asked for, so every picture rate gives the same motion. A
 * Player of a part of the body, such as a waving arm, plays over that of the whole body: append its layers. Holds no handle; one thread at
 * a time. */
class Player {
public:
    /** joint: the clips move this joint and all below it; 0: the whole body. */
    explicit Player(uint32_t joint = 0) : joint_(joint) {}

    /** Cross-fades to a clip. DPL_ERROR_NOT_FOUND: no such clip. An error changes nothing. */
    Status play(const Avatar& avatar, uint32_t clip, int64_t nowNs, const Playback& how = {}) {
        if (auto known = avatar.clip(clip); !known) return known.error();
        if (!std::isfinite(how.speed) || !std::isfinite(how.fromS) || !std::isfinite(how.fadeS) || how.fadeS < 0)
            return Error{DPL_ERROR_INVALID_ARGUMENT, "speed, fromS and fadeS of a clip must be finite, and fadeS not below 0"};
        const uint32_t loop = how.loop ? DPL_LAYER_LOOP : 0, travel = how.travel ? DPL_LAYER_TRAVEL : 0;
        setRate(nowNs, rate_);
        Voice next{clipLayer(clip, how.fromS, 1, joint_, loop | travel), clockS_, how.fadeS, clockS_, how.speed, true};
        if (how.travel && joint_ == 0 && !voices_.empty()) {
            DplClipLayer before = voices_.back().layer;
            before.timeS = voices_.back().timeS(clockS_);
            if (Status joined = avatar.joinClipLayer(before, next.layer); !joined) return joined;
        }
        voices_.push_back(next);
        return {};
    }
    /** Fades out within fadeS, of a part of the body: what plays beneath is left. The whole body always plays something. */
    Status stop(int64_t nowNs, double fadeS = 0.3) {
        if (joint_ == 0) return Error{DPL_ERROR_INVALID_ARGUMENT, "nothing plays beneath the whole body: pause it, or play another clip"};
        if (!std::isfinite(fadeS) || fadeS < 0) return Error{DPL_ERROR_INVALID_ARGUMENT, "fadeS must be finite and not below 0"};
        if (!voices_.empty()) voices_.push_back({clipLayer(0, 0, 1, joint_), clockS(nowNs), fadeS, 0, 0, false});
        return {};
    }
    /** Clips and fades stand still until resume(), also those that are played meanwhile. */
    void pause(int64_t nowNs) { setRate(nowNs, 0); }
    void resume(int64_t nowNs) { setRate(nowNs, 1); }
    bool paused() const { return rate_ == 0; }
    /** Of the clip that was played last, from now on. DPL_ERROR_INVALID_ARGUMENT: not finite. */
    Status setSpeed(double speed, int64_t nowNs) {
        if (!std::isfinite(speed)) return Error{DPL_ERROR_INVALID_ARGUMENT, "the speed must be finite"};
        if (voices_.empty()) return {};
        Voice& last = voices_.back();
        last.layer.timeS = last.timeS(clockS(nowNs)), last.sinceS = clockS(nowNs), last.speed = speed;
        return {};
    }

    /** What plays at nowNs, valid until the next call; empty: nothing. Allocates nothing once as many clips have played at once. What has
     *  faded out is forgotten, so a time before that gives no longer what it gave. */
    std::span<const DplClipLayer> layers(int64_t nowNs) {
        layers_.clear();
        const double clock = clockS(nowNs);
        double left = 1;  // of the weight, for what played before
        for (size_t i = voices_.size(); i-- > 0 && left > 0 && layers_.size() < DPL_MAX_CLIP_LAYERS;) {
            const double share = i == 0 && joint_ == 0 ? 1 : voices_[i].share(clock);
            if (share == 1) voices_.erase(voices_.begin(), voices_.begin() + std::ptrdiff_t(i)), i = 0;
            if (const double weight = left * share; voices_[i].sounds && weight > 0) {
                layers_.push_back(voices_[i].layer);
                layers_.back().timeS = voices_[i].timeS(clock), layers_.back().weight = float(weight);
            }
            left *= 1 - share;
        }
        return layers_;
    }

private:
    /** A clip that plays, or silence that fades in. Times are those of the player's clock, which stands still in a pause. */
    struct Voice {
        DplClipLayer layer;  // timeS: at sinceS
        double startS, fadeS, sinceS, speed;
        bool sounds;

        double timeS(double clock) const { return layer.timeS + (clock - sinceS) * speed; }
        double share(double clock) const {
            const double t = fadeS > 0 ? (clock - startS) / fadeS : 1;
            return t >= 1 ? 1 : t <= 0 ? 0 : t * t * (3 - 2 * t);
        }
    };
    double clockS(int64_t nowNs) const { return clockS_ + (rate_ == 0 ? 0 : dplSecondsBetween(sinceNs_, nowNs)); }
    void setRate(int64_t nowNs, int rate) {
        clockS_ = voices_.empty() ? 0 : clockS(nowNs);
        sinceNs_ = nowNs, rate_ = rate;
    }

    uint32_t joint_;
    std::vector<Voice> voices_;
    std::vector<DplClipLayer> layers_;
    double clockS_ = 0;  // at sinceNs_
    int64_t sinceNs_ = 0;
    int rate_ = 1;
};

}  // namespace doppel
