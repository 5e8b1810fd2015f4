// SPDX-License-Identifier: Apache-2.0
@testable import Doppel
import XCTest

/// Loads in the background: progress, errors, cancelling.
final class LoadTests: XCTestCase {
    func testProgressRisesToReadyAndTheAvatarDraws() async throws {
        let context = try DoppelContext(renderer: .software)
        let load = try AvatarLoad(contentsOf: URL(fileURLWithPath: TestAvatar.path), with: context)
        var seen: [AvatarLoad.Status] = []
        for await status in load.progress { seen.append(status) }
        XCTAssertEqual(seen.last, AvatarLoad.Status.ready)
        XCTAssertEqual(seen.map(\.progress), seen.map(\.progress).sorted())
        let avatar = try await load.avatar()
        XCTAssertEqual(try avatar.info().splatCount, 128)
        do {
            _ = try await load.avatar()
            XCTFail("an avatar can be taken once")
        } catch {
            XCTAssertEqual((error as? DoppelError)?.code, .invalidArgument)
        }
    }

    func testTheConvenienceReportsProgress() async throws {
        let context = try DoppelContext(renderer: .software)
        let last = Latest()
        let avatar = try await context.avatar(contentsOf: URL(fileURLWithPath: TestAvatar.path)) { last.set($0) }
        XCTAssertEqual(try avatar.info().jointCount, 2)
        XCTAssertEqual(last.value, 1)
    }

    func testDamagedFilesFailWithTheSentenceOfTheLibrary() async throws {
        let context = try DoppelContext(renderer: .software)
        for length in [0, 3, 40, TestAvatar.bytes.count - 1] {
            let bytes = Array(TestAvatar.bytes.prefix(length))
            do {
                _ = try await AvatarLoad(bytes, with: context).avatar()
                XCTFail("\(length) bytes must not load")
            } catch let error as DoppelError {
                var direct: DoppelError?
                do { _ = try context.loadAvatar(bytes) } catch { direct = error }
                XCTAssertEqual(error.code, direct?.code)
                XCTAssertEqual(withoutFunction(error.message), withoutFunction(direct?.message ?? ""))
            }
        }
    }

    /// A sentence of the library begins with the function that failed.
    private func withoutFunction(_ text: String) -> Substring { text.drop { $0 != ":" } }

    func testFilesThatCannotBeReadSaySo() async throws {
        let context = try DoppelContext(renderer: .software)
        for path in ["/nowhere/avatar.glb", "/"] {
            do {
                _ = try await context.avatar(contentsOf: URL(fileURLWithPath: path))
                XCTFail("\(path) must not load")
            } catch let error as DoppelError {
                XCTAssertEqual(error.code, .io)
                XCTAssertTrue(error.message.contains(path), error.message)
            }
        }
    }

    func testCancellingTheTaskCancelsTheLoad() async throws {
        let context = try DoppelContext(renderer: .software)
        let load = try AvatarLoad(TestAvatar.bytes, with: context)
        let task = Task {
            withUnsafeCurrentTask { $0?.cancel() }
            return try await load.avatar()
        }
        do {
            _ = try await task.value
            // The load was ready before the first look: then nothing was cancelled, and the avatar is there.
        } catch {
            XCTAssertTrue(error is CancellationError, "\(error)")
            XCTAssertThrowsError(try load.status())
        }
        // The context goes on.
        let after = try await AvatarLoad(TestAvatar.bytes, with: context).avatar()
        XCTAssertEqual(try after.info().splatCount, 128)
    }

    func testACancelledLoadEndsItsProgress() async throws {
        let context = try DoppelContext(renderer: .software)
        let load = try AvatarLoad(TestAvatar.bytes, with: context)
        load.cancel()
        for await status in load.progress { XCTFail("\(status) after cancel") }
        XCTAssertThrowsError(try load.status()) { XCTAssertTrue("\($0)".contains("cancelled"), "\($0)") }
    }

    func testALoadThatIsForgottenIsCancelled() throws {
        let context = try DoppelContext(renderer: .software)
        for _ in 0..<20 { _ = try AvatarLoad(TestAvatar.bytes, with: context) }
        XCTAssertEqual(try context.loadAvatar(TestAvatar.bytes).info().splatCount, 128)
    }
}

extension AvatarLoad.Status {
    fileprivate static let ready = AvatarLoad.Status(state: .ready, progress: 1)
}

private final class Latest: @unchecked Sendable {
    private let lock = NSLock()
    private var kept: Float = 0
    var value: Float { lock.withLock { kept } }
    func set(_ value: Float) { lock.withLock { kept = value } }
}
