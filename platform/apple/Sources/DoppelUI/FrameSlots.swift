// SPDX-License-Identifier: Apache-2.0
import Foundation

/// The slots of frames in flight (`DPL_METAL_SLOTS`), used in turn. Completion handlers give them back on threads of Metal's.
public final class FrameSlots: @unchecked Sendable {  // the condition guards everything
    public static let count = 3
    private let condition = NSCondition()
    private var busy = [Bool](repeating: false, count: count)
    private var next = 0

    public init() {}

    /// The next slot in turn. Nil if its last frame is still in flight after waitS seconds: leave this frame out.
    public func take(waitS: Double = 0) -> UInt32? {
        condition.lock()
        defer { condition.unlock() }
        let end = Date(timeIntervalSinceNow: waitS)
        while busy[next] {
            if waitS <= 0 || !condition.wait(until: end) { return nil }
        }
        let slot = next
        busy[slot] = true
        next = (next + 1) % FrameSlots.count
        return UInt32(slot)
    }

    /// After the GPU has run the frame, or when its commands were dropped.
    public func giveBack(_ slot: UInt32) {
        condition.lock()
        busy[Int(slot)] = false
        condition.broadcast()
        condition.unlock()
    }
}
