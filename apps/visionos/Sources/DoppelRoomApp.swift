// SPDX-License-Identifier: Apache-2.0
import CompositorServices
import DoppelUI
import SwiftUI

@main
struct DoppelRoomApp: App {
    @State private var host = Host()

    var body: some SwiftUI.Scene {
        WindowGroup { ContentView(host: host) }
        ImmersiveSpace(id: "room") {
            CompositorLayer(configuration: AvatarLayerConfiguration()) { [host] layer in host.renderer?.start(layer) }
        }
        .immersionStyle(selection: .constant(.mixed), in: .mixed, .full)
    }
}
