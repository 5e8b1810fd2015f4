// SPDX-License-Identifier: Apache-2.0
#include "apps/viewer/options.h"

#include <cstdio>

#include "apps/shared/pictures.h"

namespace dpl {

std::optional<ViewerOptions> readOptions(int argc, const char* const* argv, int* exitCode) {
    ViewerOptions options;
    std::string size = "1280x800";
    CLI::App app{
        "Shows avatars and splats in a window. Drop files on it: avatars (.glb), splats (.ply, .spz, .glb), motions (.bvh, .glb), "
        "the folder of a doppel reconstruct, and films of a person, to make an avatar of.",
        "doppel-viewer"};
    app.set_version_flag("--version", "doppel-viewer " DOPPEL_VERSION);
    app.add_option("files", options.files,
                   "Avatars, splats, motions, and the output folder of a reconstruction to watch. A motion goes to the avatar before it");
    app.add_option("--clip", options.clip, "Clip that the avatars play: a name from the file, or a motion file");
    app.add_option("--animation", options.animation, kAnimationHelp)->needs("--clip");
    app.add_option("--compare", options.compare, "Compare the avatar of a run with the frame of its scan whose name begins so");
    app.add_option("--room", options.room, "auto: dark with avatars, none with splats alone")
        ->check(CLI::IsMember({"auto", "dark", "bright", "none"}))
        ->capture_default_str();
    app.add_option("--axes", options.axes, kAxesHelp)->check(CLI::IsMember(kAxesNames));
    app.add_option("--size", size, "Size of the picture")->check(isPictureSize())->capture_default_str();
    app.add_option("--scale", options.scale, "Size of panels and letters, 1 as on a usual screen; default: as the screen is scaled")
        ->check(inRange(0.5, 4));
    app.add_option("--azimuth", options.azimuthDeg, "Where the camera stands, degrees; 0: in front")->check(inRange(-360, 360));
    app.add_option("--magnification", options.magnification,
                   "How many pixels wide the finest details of the scan may become; the camera comes no nearer. 0: as near as you like")
        ->check(inRange(0, 1000))
        ->capture_default_str();
    app.add_option("--fill", options.fill, "How the GPU fills pixels")->check(CLI::IsMember(kFillNames))->capture_default_str();
    auto* screenshot =
        app.add_option("--screenshot", options.screenshot, "Draw, write this picture, and quit")->check(isOutputFile({".png"}));
    app.add_option("--turntable", options.turntable, "Turn once around, write a video or a folder of pictures, and quit")
        ->check(isOutputFile({".mp4"}, true))
        ->excludes(screenshot);
    app.add_option("--frames", options.frames, "Frames that --screenshot (1) or --turntable (120) draws, 30 a second of the clip")
        ->check(CLI::Range(1u, 100000u));
    app.add_flag("--hide-panels", options.hidePanels, "Start without panels; the key H shows them");
    app.add_flag("--timings", options.timings, "Print how long it took until the first pictures");
    app.add_flag("--validation", options.validation, "Load the Vulkan validation layer; what it says is printed and is a failure");
    app.footer(
        "Examples:\n"
        "  doppel-viewer ada/avatar.glb walk.bvh\n"
        "  doppel-viewer ada.glb walk.bvh bob.glb run.bvh          two avatars, a motion for each\n"
        "  doppel-viewer OUT                                       watches doppel reconstruct SCAN -o OUT\n"
        "  doppel-viewer walk.mp4                                   offers to make an avatar of the film\n"
        "  doppel-viewer OUT --compare full_003                     the avatar beside a photograph of its scan\n"
        "  doppel-viewer guitar.ply --axes y-down --room none\n"
        "  doppel-viewer ada.glb --clip walk --screenshot ada.png --size 1280x800 --frames 30 --room bright --hide-panels\n"
        "  doppel-viewer ada.glb --turntable ada.mp4\n"
        "Mouse: drag turns, right or middle drag moves, wheel zooms to the cursor, a double click turns around that place. Keys: F1 lists "
        "them.\n"
        "Exit codes: 0 done, 1 failed (the sentence says why), 2 wrong arguments.");
    *exitCode = 0;
    try {
        app.parse(argc, argv);
    } catch (const CLI::ParseError& error) {
        if (error.get_exit_code() == 0) {  // --help and --version
            app.exit(error);
            return std::nullopt;
        }
        std::fprintf(stderr, "doppel-viewer: %s. See doppel-viewer --help\n", error.what());
        *exitCode = 2;
        return std::nullopt;
    }
    options.size = parsePictureSize(size).value_or(PictureSize{});  // the option parser has checked it
    if (options.frames == 0) options.frames = options.turntable.empty() ? 1 : 120;
    return options;
}

}  // namespace dpl
