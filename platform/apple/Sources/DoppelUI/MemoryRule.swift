// SPDX-License-Identifier: Apache-2.0

/// How much an app lets the renderer hold. Loads that would exceed it bring fewer SH bands or splats, see `dplSetMemoryLimit`.
public enum MemoryRule {
    /// Of what the system lets the app still allocate, this share is for avatars.
    static let share = 0.5
    static let leastBytes: UInt64 = 64 << 20

    /// residentBytes: what the renderer holds now. availableBytes: what the app may still allocate; 0: not known, and there is no limit.
    public static func limit(residentBytes: UInt64, availableBytes: UInt64) -> UInt64 {
        if availableBytes == 0 { return 0 }
        let more = UInt64(Double(availableBytes) * share)
        let (sum, overflow) = residentBytes.addingReportingOverflow(more)
        return max(overflow ? .max : sum, leastBytes)
    }

    /// After a memory warning: what is loaded stays, and loads to come must fit what is held now.
    public static func limitAfterWarning(residentBytes: UInt64) -> UInt64 { max(residentBytes, leastBytes) }
}
