// SPDX-License-Identifier: Apache-2.0
import CDoppel

/// How `Player.play` plays a clip.
public struct Playback: Sendable, Equatable {
    /// Of the clip's own time; below 0: backwards.
    public var speed: Double
    /// Seconds within which the clip takes over from what played before; 0: at once.
    public var fadeS: Double
    /// Where the clip starts.
    public var fromS: Double
    /// Otherwise it holds its last pose.
    public var loop: Bool
    /// Recorded walks go on from where the person stands, in each round and from clip to clip.
    public var travel: Bool

    public init(speed: Double = 1, fadeS: Double = 0.3, fromS: Double = 0, loop: Bool = true, travel: Bool = false) {
        self.speed = speed
        self.fadeS = fadeS
        self.fromS = fromS
        self.loop = loop
        self.travel = travel
    }
}

/// Play, pause, speed, loops and cross-fades of clips of one avatar, as layers for `Avatar.setPose(layers:timeNs:)`. Times are nanoseconds
/// of any one clock; the layers follow from the calls and from the time that is asked for, so every picture rate gives the same motion. A
/// player of a part of the body, such as a waving arm, plays over that of the whole body: append its layers.
public struct Player: Sendable {
    /// A clip that plays, or silence that fades in. Times are those of the player's clock, which stands still in a pause.
    private struct Voice: Sendable {
        var layer: Avatar.ClipLayer?
        var startS, fadeS, fromS, sinceS, speed: Double

        func timeS(_ clock: Double) -> Double { fromS + (clock - sinceS) * speed }

        func share(_ clock: Double) -> Double {
            let t = fadeS > 0 ? (clock - startS) / fadeS : 1
            return t >= 1 ? 1 : t <= 0 ? 0 : t * t * (3 - 2 * t)
        }

        func layer(at clock: Double, weight: Float) -> Avatar.ClipLayer? {
            guard var out = layer else { return nil }
            out.timeS = timeS(clock)
            out.weight = weight
            return out
        }
    }

    private let joint: Int
    private var voices: [Voice] = []
    private var clockS = 0.0
    private var sinceNs: Int64 = 0
    public private(set) var isPaused = false

    /// joint: the clips move this joint and all below it; 0: the whole body.
    public init(joint: Int = 0) { self.joint = joint }

    /// Cross-fades to a clip of `avatar`. An error changes nothing.
    public mutating func play(_ clip: Int, of avatar: Avatar, nowNs: Int64, _ how: Playback = Playback()) throws(DoppelError) {
        _ = try avatar.clip(clip)
        guard how.speed.isFinite, how.fromS.isFinite, how.fadeS.isFinite, how.fadeS >= 0 else {
            throw DoppelError(.invalidArgument, "speed, fromS and fadeS of a clip must be finite, and fadeS not below 0")
        }
        let now = voices.isEmpty ? 0 : clock(nowNs)
        var layer = Avatar.ClipLayer(clip: clip, timeS: how.fromS, joint: joint, loop: how.loop, travel: how.travel)
        if how.travel, joint == 0, let before = voices.last?.layer(at: now, weight: 1) { try avatar.join(before, &layer) }
        setPaused(isPaused, nowNs)
        voices.append(Voice(layer: layer, startS: clockS, fadeS: how.fadeS, fromS: how.fromS, sinceS: clockS, speed: how.speed))
    }

    /// Fades out within fadeS, of a part of the body: what plays beneath is left. The whole body always plays something.
    public mutating func stop(nowNs: Int64, fadeS: Double = 0.3) throws(DoppelError) {
        guard joint != 0 else {
            throw DoppelError(.invalidArgument, "nothing plays beneath the whole body: pause it, or play another clip")
        }
        guard fadeS.isFinite, fadeS >= 0 else { throw DoppelError(.invalidArgument, "fadeS must be finite and not below 0") }
        if voices.isEmpty { return }
        voices.append(Voice(layer: nil, startS: clock(nowNs), fadeS: fadeS, fromS: 0, sinceS: 0, speed: 0))
    }

    /// Clips and fades stand still until `resume`, also those that are played meanwhile.
    public mutating func pause(nowNs: Int64) { setPaused(true, nowNs) }
    public mutating func resume(nowNs: Int64) { setPaused(false, nowNs) }

    /// Of the clip that was played last, from now on.
    public mutating func setSpeed(_ speed: Double, nowNs: Int64) throws(DoppelError) {
        guard speed.isFinite else { throw DoppelError(.invalidArgument, "the speed must be finite") }
        guard var last = voices.popLast() else { return }
        let now = clock(nowNs)
        last.fromS = last.timeS(now)
        last.sinceS = now
        last.speed = speed
        voices.append(last)
    }

    /// What plays at nowNs; empty: nothing. What has faded out is forgotten, so a time before that gives no longer what it gave.
    public mutating func layers(nowNs: Int64) -> [Avatar.ClipLayer] {
        let clock = clock(nowNs)
        var made: [Avatar.ClipLayer] = []
        var left = 1.0  // of the weight, for what played before
        var i = voices.count - 1
        while i >= 0, left > 0, made.count < Int(DPL_MAX_CLIP_LAYERS) {
            let voice = voices[i]
            let share = i == 0 && joint == 0 ? 1 : voice.share(clock)
            if share == 1 {
                voices.removeFirst(i)
                i = 0
            }
            if left * share > 0, let layer = voice.layer(at: clock, weight: Float(left * share)) { made.append(layer) }
            left *= 1 - share
            i -= 1
        }
        return made
    }

    private func clock(_ nowNs: Int64) -> Double { clockS + (isPaused ? 0 : dplSecondsBetween(sinceNs, nowNs)) }

    private mutating func setPaused(_ paused: Bool, _ nowNs: Int64) {
        clockS = voices.isEmpty ? 0 : clock(nowNs)
        sinceNs = nowNs
        isPaused = paused
    }
}
