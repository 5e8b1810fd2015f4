// SPDX-License-Identifier: Apache-2.0
import CDoppel
import Foundation

/// A load in the background. A thread of the library reads the file; frames go on. It is cancelled when this object goes, or the task that
/// waits for its avatar is cancelled.
///
///     let load = try AvatarLoad(Array(data), with: context)
///     for await status in load.progress { bar.fraction = status.progress }
///     let avatar = try await load.avatar()
///
/// On a context of `MetalStage`, frames carry the upload: while an app is in the background no frame is drawn, and the load waits.
public final class AvatarLoad: Sendable {
    public enum State: UInt32, Sendable {
        case waiting = 0
        case decoding, uploading, ready, failed
    }

    public struct Status: Sendable, Equatable {
        public let state: State
        /// 0 to 1; it never falls.
        public let progress: Float
        public var isOver: Bool { state == .ready || state == .failed }
    }

    /// How often progress is asked for.
    static let pollNs: UInt64 = 8_000_000

    private let context: DoppelContext
    private let load: Locked<Handle?>

    public init(_ bytes: [UInt8], with context: DoppelContext) throws(DoppelError) {
        self.context = context
        load = Locked(try AvatarLoad.start(try KeptBytes(copying: bytes), with: context))
    }

    /// Reads the file before it returns, so call it where waiting for storage is allowed; `DoppelContext.avatar(contentsOf:)` does.
    public init(contentsOf url: URL, with context: DoppelContext) throws(DoppelError) {
        self.context = context
        load = Locked(try AvatarLoad.start(try KeptBytes(contentsOf: url), with: context))
    }

    deinit { cancel() }

    private static func start(_ bytes: KeptBytes, with context: DoppelContext) throws(DoppelError) -> Handle? {
        var info = DplLoadInfo.sized
        info.data = UnsafePointer(bytes.start)
        info.size = bytes.count
        let kept = Unmanaged.passRetained(bytes)
        info.user = kept.toOpaque()
        info.release = { Unmanaged<KeptBytes>.fromOpaque($0!).release() }
        var raw: DplLoad?
        let result = dplStartLoad(context.handle.raw, &info, &raw)
        if result != DPL_OK {
            let error = DoppelError(result)
            kept.release()
            throw error
        }
        return Handle(raw: raw!)
    }

    public func status() throws(DoppelError) -> Status {
        var c = DplLoadStatus.sized
        let error: DoppelError? = load.use { handle in
            guard let handle else { return AvatarLoad.gone }
            let result = dplGetLoadStatus(handle.raw, &c)
            return result == DPL_OK ? nil : DoppelError(result)
        }
        if let error { throw error }
        return Status(state: State(rawValue: UInt32(c.state.rawValue)) ?? .failed, progress: c.progress)
    }

    /// Waits for the avatar without blocking a thread. Throws the load's DoppelError, or CancellationError after the task was cancelled,
    /// which cancels the load. The avatar can be taken once.
    public func avatar() async throws -> Avatar {
        do {
            while !(try status().isOver) { try await Task.sleep(nanoseconds: AvatarLoad.pollNs) }
        } catch let error as CancellationError {
            cancel()
            throw error
        }
        guard let handle = take() else { throw AvatarLoad.gone }
        var raw: DplAvatar?
        try check(dplFinishLoad(handle.raw, &raw))
        return Avatar(owning: raw!, of: context)
    }

    /// Drops the load; its bytes are freed at the next step of the library's thread.
    public func cancel() {
        if let handle = take() { dplCancelLoad(handle.raw) }
    }

    private func take() -> Handle? {
        load.use { handle in
            defer { handle = nil }
            return handle
        }
    }

    private static let gone = DoppelError(.invalidArgument, "the load was cancelled, or its avatar was taken")

    /// Each change of the status, until the load is ready, failed or cancelled.
    public var progress: Progress { Progress(load: self) }

    public struct Progress: AsyncSequence, Sendable {
        public typealias Element = Status
        let load: AvatarLoad

        public func makeAsyncIterator() -> Iterator { Iterator(load: load) }

        public struct Iterator: AsyncIteratorProtocol {
            let load: AvatarLoad
            var last: Status?

            public mutating func next() async -> Status? {
                if let last, last.isOver { return nil }
                while let status = try? load.status() {
                    if status != last {
                        last = status
                        return status
                    }
                    if (try? await Task.sleep(nanoseconds: AvatarLoad.pollNs)) == nil { return nil }
                }
                return nil
            }
        }
    }
}

extension DoppelContext {
    /// Loads an avatar while frames go on. progress is called from any thread. Cancelling the task cancels the load.
    public func avatar(contentsOf url: URL, progress: (@Sendable (Float) -> Void)? = nil) async throws -> Avatar {
        let load = try AvatarLoad(contentsOf: url, with: self)
        if let progress {
            for await status in load.progress { progress(status.progress) }
        }
        return try await load.avatar()
    }
}

/// The bytes of a file, at one address until the library needs them no more.
private final class KeptBytes {
    let start: UnsafeMutablePointer<UInt8>
    let count: Int

    private init(count: Int, of what: String) throws(DoppelError) {
        guard let memory = malloc(max(count, 1)) else { throw DoppelError(.outOfMemory, "no memory for the \(count) bytes of \(what)") }
        self.count = count
        start = memory.assumingMemoryBound(to: UInt8.self)
    }

    convenience init(copying bytes: [UInt8]) throws(DoppelError) {
        try self.init(count: bytes.count, of: "an avatar")
        bytes.withUnsafeBufferPointer { if let from = $0.baseAddress { start.initialize(from: from, count: bytes.count) } }
    }

    /// Reads the file straight into the memory that the library gets. It is not mapped: another process that shortens a mapped file would
    /// end this one.
    convenience init(contentsOf url: URL) throws(DoppelError) {
        guard let file = fopen(url.path, "rb") else { throw DoppelError(.io, "\(url.path): \(String(cString: strerror(errno)))") }
        defer { fclose(file) }
        var about = stat()
        guard fstat(fileno(file), &about) == 0, about.st_mode & S_IFMT == S_IFREG else {
            throw DoppelError(.io, "\(url.path) is not a file")
        }
        try self.init(count: Int(about.st_size), of: url.path)
        let read = fread(start, 1, count, file)
        if read != count { throw DoppelError(.io, "\(url.path): \(read) of \(count) bytes could be read") }
    }

    deinit { free(start) }
}
