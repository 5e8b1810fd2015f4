// SPDX-License-Identifier: Apache-2.0
import CDoppel

/// Which renderer a context draws with.
public enum Renderer: Sendable {
    /// A GPU if there is one, else the CPU.
    case automatic
    case software
}

/// Owns a renderer and its threads. Avatars keep their context alive. All calls may come from any thread; those on one context wait for one
/// another, but for loads. For a context that draws into an app's Metal frames see `MetalStage` of DoppelUI.
public final class DoppelContext: Sendable {
    let handle: Handle

    /// threadCount: CPU threads with the caller's; 0: one per core. cacheFolder: an existing folder that keeps the GPU's self-test for the
    /// next start.
    public convenience init(renderer: Renderer = .automatic, threadCount: Int = 0, cacheFolder: String? = nil) throws(DoppelError) {
        guard let threads = UInt32(exactly: threadCount) else {
            throw DoppelError(.invalidArgument, "threadCount must be 0 to 256, not \(threadCount)")
        }
        var info = DplContextInfo.sized
        info.renderer = renderer == .software ? DPL_RENDERER_SOFTWARE : DPL_RENDERER_AUTO
        info.threadCount = threads
        var raw: DplContext?
        let result = withOptionalCString(cacheFolder) { folder in
            info.cacheFolder = folder
            return dplCreateContext(&info, &raw)
        }
        try check(result)
        self.init(owning: raw!)
    }

    /// Takes ownership of a context of the C interface, such as one of `dplCreateMetalContext`.
    public init(owning raw: DplContext) { handle = Handle(raw: raw) }

    deinit { dplDestroyContext(handle.raw) }

    /// For calls of the C interface. Valid as long as this object.
    public var raw: DplContext { handle.raw }

    /// Names the renderer for people, such as "software (2 threads)". Empty after an error.
    public var rendererName: String {
        var name: UnsafePointer<CChar>?
        guard dplGetRendererName(handle.raw, &name) == DPL_OK, let name else { return "" }
        return String(cString: name)
    }

    /// Loads an avatar or general splats and waits for it. `AvatarLoad` does it while frames go on.
    public func loadAvatar(_ bytes: [UInt8]) throws(DoppelError) -> Avatar {
        var raw: DplAvatar?
        try check(bytes.withUnsafeBufferPointer { dplLoadAvatar(handle.raw, $0.baseAddress, $0.count, &raw) })
        return Avatar(owning: raw!, of: self)
    }

    /// Limits what the renderer holds, from the next load on; see `dplSetMemoryLimit`. 0: no limit.
    public func setMemoryLimit(bytes: UInt64) throws(DoppelError) { try check(dplSetMemoryLimit(handle.raw, bytes)) }

    /// Draws far avatars with fewer and larger splats; see `DplDetail`. Zeros: draw everything.
    public func setDetail(splatsPerPixel: Float, splatBudget: Int = 0) throws(DoppelError) {
        guard let budget = UInt32(exactly: splatBudget) else {
            throw DoppelError(.invalidArgument, "splatBudget must not be negative: \(splatBudget)")
        }
        var detail = DplDetail.sized
        detail.splatsPerPixel = splatsPerPixel
        detail.splatBudget = budget
        try check(dplSetDetail(handle.raw, &detail))
    }

    /// Lets drawing take at most this long; see `dplSetFrameBudget`. 0: no budget.
    public func setFrameBudget(milliseconds: Double) throws(DoppelError) { try check(dplSetFrameBudget(handle.raw, milliseconds)) }
}

/// Calls `body` with a C string, or with nil.
package func withOptionalCString<R>(_ text: String?, _ body: (UnsafePointer<CChar>?) -> R) -> R {
    guard let text else { return body(nil) }
    return text.withCString { body($0) }
}
