// SPDX-License-Identifier: Apache-2.0
import Doppel
import SwiftUI
import UniformTypeIdentifiers

/// The window: loads an avatar, opens the room, plays the clip, moves the avatar over the floor.
struct ContentView: View {
    let host: Host
    @Environment(\.openImmersiveSpace) private var openRoom
    @Environment(\.dismissImmersiveSpace) private var closeRoom
    @State private var choosing = false
    @State private var isOpen = false
    @State private var progress: Float?
    @State private var message: String?
    @State private var loading: Task<Void, Never>?

    var body: some View {
        VStack {
            Text(message ?? host.message ?? "Open an avatar, then the room.").padding()
            if let part = progress { ProgressView(value: Double(part)) }
            HStack {
                Button("Open") { choosing = true }
                Button("Cancel") { loading?.cancel() }.disabled(progress == nil)
                Button(isOpen ? "Leave the room" : "Into the room") { Task { await toggleRoom() } }
                Button("Play or pause") { host.isPlaying.toggle() }
            }
            HStack {
                Button("Left") { host.move(x: -0.25) }
                Button("Right") { host.move(x: 0.25) }
                Button("Nearer") { host.move(z: 0.25) }
                Button("Farther") { host.move(z: -0.25) }
                Button("Turn") { host.move(yawRad: .pi / 8) }
            }
        }
        .padding()
        .fileImporter(isPresented: $choosing, allowedContentTypes: [UTType.data]) { result in
            if case .success(let file) = result { load(file) }
        }
    }

    private func toggleRoom() async {
        if isOpen {
            await closeRoom()
            isOpen = false
        } else if case .opened = await openRoom(id: "room") {
            isOpen = true
        } else {
            message = "the room could not be opened"
        }
    }

    /// The upload is part of the room's frames: outside of the room a load waits at "uploading".
    private func load(_ file: URL) {
        guard let stage = host.stage else { return }
        loading?.cancel()
        loading = Task {
            let granted = file.startAccessingSecurityScopedResource()
            defer { if granted { file.stopAccessingSecurityScopedResource() } }
            progress = 0
            message = isOpen ? "loading" : "go into the room to finish loading"
            do {
                let avatar = try await stage.context.avatar(contentsOf: file) { part in Task { @MainActor in progress = part } }
                try host.show(avatar)
                message = nil
            } catch is CancellationError {
                message = nil
            } catch {
                message = "\(error)"
            }
            progress = nil
        }
    }
}
