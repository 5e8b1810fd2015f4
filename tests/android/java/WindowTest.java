// SPDX-License-Identifier: Apache-2.0
package org.doppel;

import static org.doppel.Checks.expect;
import static org.doppel.Checks.expectError;
import static org.doppel.Checks.floats;

import java.nio.ByteBuffer;
import java.nio.FloatBuffer;
import java.nio.file.Files;
import java.nio.file.Path;

/** The natives with a window: pictures as the C API draws them, and everything that may happen to a window, its surface and its device. */
final class WindowTest {
    private static final int QUADS = 1;
    private static final int SHOWN = 0;
    private static final int NO_WINDOW = 1;
    private static final int SURFACE_LOST = 3;
    private static final int DEVICE_LOST_OUTCOME = 4;
    private static final float BLUE = 0.2f;

    private final Path work;
    private final ByteBuffer file;
    private long view;
    private long avatar;

    private WindowTest(Path work) throws Exception {
        this.work = work;
        file = Checks.mapped(work.resolve("avatar.glb"));
    }

    public static void main(String[] arguments) throws Exception {
        WindowTest test = new WindowTest(Checks.work(arguments));
        if (!Files.exists(test.work.resolve("vulkan.rgba"))) Checks.skip("no Vulkan device is here");
        boolean validation = Boolean.getBoolean("org.doppel.validation");
        test.view = Native.createView(QUADS, null, validation);
        test.avatar = Native.loadAvatar(Native.viewContext(test.view), test.file, 0, test.file.capacity());
        Native.setPoseFromClip(test.avatar, 0, 0.5, true);
        test.noWindowIsNoFrame();
        test.pictureIsThatOfTheCApi();
        test.turnedDisplayShowsTheSamePicture();
        test.theScenesDepthHidesTheAvatar();
        test.aShadowDarkensTheBackground();
        test.windowChangesItsSize();
        test.surfaceLostInMidFrame();
        test.windowGoesAndComes();
        test.formatThatCannotBeShown();
        test.memoryIsShort();
        test.backgroundWhileLoading();
        test.deviceIsLost();
        if (validation) {
            String[] complaints = Native.viewComplaints(test.view);
            for (String complaint : complaints) System.out.println(complaint);
            expect(complaints.length == 0, "the validation layer has nothing to say");
        }
        test.closedViewIsAnError();
        System.exit(Checks.exitCode());
    }

    private int draw() {
        return Native.drawView(view, new long[] {avatar}, Checks.CAMERA, null, 0, 0, BLUE, false);
    }

    private void show(FakeWindow window) {
        Native.setWindow(view, window, Checks.WIDTH, Checks.HEIGHT);
    }

    /** Takes the window from the view, and expects that nothing of it is left there. */
    private void end(FakeWindow window, String what) {
        Native.setWindow(view, null, 0, 0);
        expect(window.users() == 0 && window.surfaces() == 0 && window.swapchains() == 0 && window.wrong() == 0,
                what + ": nothing is left of its window");
        window.close();
    }

    private void noWindowIsNoFrame() {
        expect(draw() == NO_WINDOW, "without a window nothing is drawn");
        FakeWindow released = new FakeWindow(8, 8);
        released.close();
        expectError(DoppelException.INVALID_ARGUMENT, "released", "a surface that was released", () -> show(released));
    }

    /** PSNR, dB, of what the window shows against the picture of draw_with_c over the background. */
    private double agreement(byte[] shown, boolean turned) throws Exception {
        byte[] alone = Checks.read(work.resolve("vulkan.rgba"));
        double sum = 0;
        for (int y = 0; y < Checks.HEIGHT; y++) {
            for (int x = 0; x < Checks.WIDTH; x++) {
                int from = 4 * (y * Checks.WIDTH + x);
                // A quarter turn clockwise: (x, y) of a picture of height h goes to (h - 1 - y, x) of one as wide as the other was high.
                int to = turned ? 4 * (x * Checks.HEIGHT + Checks.HEIGHT - 1 - y) : from;
                for (int c = 0; c < 3; c++) {
                    double background = c == 2 ? BLUE * 255 : 0;
                    double wanted = (alone[from + c] & 0xff) + background * (1 - (alone[from + 3] & 0xff) / 255.0);
                    double off = wanted - (shown[to + c] & 0xff);
                    sum += off * off;
                }
            }
        }
        return 10 * Math.log10(255 * 255 / (sum / (3.0 * Checks.WIDTH * Checks.HEIGHT) + 1e-9));
    }

    private void pictureIsThatOfTheCApi() throws Exception {
        FakeWindow window = new FakeWindow(Checks.WIDTH, Checks.HEIGHT);
        show(window);
        for (int i = 0; i < 5; i++) expect(draw() == SHOWN, "frame " + i);
        double db = agreement(window.shown(), false);
        expect(Checks.redPixels(window.shown()) > 500, "the picture is not empty");
        expect(db > LEAST_PSNR_DB, "and is that of the C API over the background: " + Math.round(db * 10) / 10.0 + " dB");
        expect(window.shownCount() == 5, "every frame was shown once");
        end(window, "a window");
    }

    private static final double LEAST_PSNR_DB = 50;

    private void turnedDisplayShowsTheSamePicture() throws Exception {
        FakeWindow window = new FakeWindow(Checks.WIDTH, Checks.HEIGHT);
        window.set("transform", FakeWindow.QUARTER_TURN);
        show(window);
        expect(draw() == SHOWN && window.shownWidth() == Checks.HEIGHT && window.shownHeight() == Checks.WIDTH,
                "a display that turns images gets them turned");
        double db = agreement(window.shown(), true);
        expect(db > LEAST_PSNR_DB, "and they show the same: " + Math.round(db * 10) / 10.0 + " dB");
        window.set("transform", FakeWindow.UPRIGHT); // the user turns the phone: the next present says so
        draw();
        expect(draw() == SHOWN && window.shownWidth() == Checks.WIDTH, "a phone that is turned gets other images");
        expect(agreement(window.shown(), false) > LEAST_PSNR_DB, "which show the same");
        end(window, "a turned window");
    }

    /** The square lies on its floor. Beside its wide splats the background is darker at the corners, on displays of both kinds. */
    private void aShadowDarkensTheBackground() {
        float turned = (float) Math.sqrt(0.5);
        float[] before = new float[8];
        float[] root = new float[3];
        Native.getPose(avatar, before, root);
        Native.setPose(avatar, new float[] {-turned, 0, 0, turned, 0, 0, 0, 1}, new float[] {0, -1, 0});
        Native.setTransform(avatar, new float[] {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, -1.5f});
        for (int transform : new int[] {FakeWindow.UPRIGHT, FakeWindow.QUARTER_TURN}) {
            FakeWindow window = new FakeWindow(Checks.WIDTH, Checks.HEIGHT);
            window.set("transform", transform);
            show(window);
            expect(drawOnBright(false) == SHOWN, "a person without a shadow");
            byte[] without = window.shown();
            expect(drawOnBright(true) == SHOWN, "and with one");
            byte[] with = window.shown();
            int darker = 0;
            int lighter = 0;
            for (int i = 2; i < with.length; i += 4) {
                int change = (with[i] & 0xff) - (without[i] & 0xff);
                if (change < -4) darker++;
                if (change > 1) lighter++;
            }
            expect(darker > 5 && lighter == 0, "it darkens what lies around the feet: " + darker + " pixels");
            end(window, "a window with a shadow");
        }
        Native.setPose(avatar, before, root);
        Native.setTransform(avatar, new float[] {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0});
    }

    private int drawOnBright(boolean shadows) {
        return Native.drawView(view, new long[] {avatar}, Checks.CAMERA, null, 0, 0, 0.8f, shadows);
    }

    /** A wall before the upper half of the view, on a display that turns images and on one that does not. */
    private void theScenesDepthHidesTheAvatar() {
        FloatBuffer wall = floats(Checks.WIDTH * Checks.HEIGHT);
        for (int i = 0; i < Checks.WIDTH * Checks.HEIGHT / 2; i++) wall.put(i, 1);
        for (int transform : new int[] {FakeWindow.UPRIGHT, FakeWindow.QUARTER_TURN}) {
            FakeWindow window = new FakeWindow(Checks.WIDTH, Checks.HEIGHT);
            window.set("transform", transform);
            show(window);
            draw();
            byte[] whole = window.shown();
            Native.drawView(view, new long[] {avatar}, Checks.CAMERA, wall, 0, 0, BLUE, false);
            byte[] hidden = window.shown();
            boolean right = Checks.redPixels(whole) > 500;
            for (int y = 0; y < Checks.HEIGHT; y++) {
                for (int x = 0; x < Checks.WIDTH; x++) {
                    boolean turned = transform == FakeWindow.QUARTER_TURN;
                    int at = 4 * (turned ? x * Checks.HEIGHT + Checks.HEIGHT - 1 - y : y * Checks.WIDTH + x);
                    right &= (hidden[at] & 0xff) == (y < Checks.HEIGHT / 2 ? 0 : whole[at] & 0xff);
                }
            }
            expect(right, "a wall of the app's scene hides what lies behind it, and nothing else; display " + transform);
            expectError(DoppelException.INVALID_ARGUMENT, "sceneDepth", "a depth that is too small",
                    () -> Native.drawView(view, new long[] {avatar}, Checks.CAMERA, floats(7), 0, 0, BLUE, false));
            expectError(DoppelException.INVALID_ARGUMENT, "FloatBuffer", "a depth on the heap",
                    () -> Native.drawView(view, new long[] {avatar}, Checks.CAMERA, FloatBuffer.allocate(96 * 128), 0, 0, BLUE, false));
            expect(draw() == SHOWN, "and the next frame is drawn");
            end(window, "a window with a scene's depth");
        }
    }

    private void windowChangesItsSize() {
        FakeWindow window = new FakeWindow(Checks.WIDTH, Checks.HEIGHT);
        show(window);
        draw();
        window.set("width", 60); // before surfaceChanged tells
        expect(draw() == SHOWN && window.shownWidth() == 60 && Checks.redPixels(window.shown()) > 300,
                "a window that shrinks in mid-frame");
        Native.setWindow(view, window, 60, Checks.HEIGHT);
        expect(draw() == SHOWN, "and tells afterwards");
        Native.setWindow(view, window, 0, 0);
        expect(draw() == NO_WINDOW, "a window of no size is no window");
        expectError(DoppelException.INVALID_ARGUMENT, "negative", "a negative size", () -> Native.setWindow(view, window, -1, 5));
        window.set("nextAcquire", FakeWindow.OUT_OF_DATE);
        show(window);
        expect(draw() == SHOWN, "images out of date are made anew within the frame");
        end(window, "a window that changed");
    }

    private void surfaceLostInMidFrame() {
        for (String call : new String[] {"nextAcquire", "nextPresent", "nextSwapchain"}) {
            FakeWindow window = new FakeWindow(Checks.WIDTH, Checks.HEIGHT);
            show(window);
            if (!call.equals("nextSwapchain")) draw();
            window.set(call, FakeWindow.SURFACE_LOST);
            expect(draw() == SURFACE_LOST, "a surface that is lost at " + call + " is an outcome");
            expect(window.surfaces() == 0 && window.swapchains() == 0, "and is let go at once");
            expect(draw() == SHOWN && Checks.redPixels(window.shown()) > 500, "the next frame makes another");
            end(window, "a lost surface");
        }
    }

    private void windowGoesAndComes() {
        for (int i = 0; i < 4; i++) {
            FakeWindow window = new FakeWindow(Checks.WIDTH, Checks.HEIGHT);
            show(window);
            expect(draw() == SHOWN && Checks.redPixels(window.shown()) > 500,
                    "window " + i + " shows the avatar, which was not loaded again");
            end(window, "window " + i);
            expect(draw() == NO_WINDOW, "in the background nothing is drawn");
        }
    }

    private void formatThatCannotBeShown() {
        FakeWindow window = new FakeWindow(Checks.WIDTH, Checks.HEIGHT);
        window.set("format", FakeWindow.RGB565);
        show(window);
        expectError(DoppelException.UNSUPPORTED, "RGBA8", "a window of 16 bits a pixel", this::draw);
        window.set("format", FakeWindow.RGBA8);
        expect(draw() == SHOWN, "the same window with another format");
        end(window, "a window of 16 bits");
    }

    private void memoryIsShort() {
        FakeWindow window = new FakeWindow(Checks.WIDTH, Checks.HEIGHT);
        window.set("nextSwapchain", FakeWindow.OUT_OF_HOST_MEMORY);
        show(window);
        expectError(DoppelException.OUT_OF_MEMORY, "memory", "no memory for images", this::draw);
        expect(draw() == SHOWN, "and room for them in the next frame");
        long[] counts = new long[6];
        Native.frameStats(avatar, counts, new double[3]);
        Native.setMemoryLimit(Native.viewContext(view), counts[2]); // as on a memory warning: no more than now
        expectError(DoppelException.OUT_OF_MEMORY, "", "a load beyond the memory limit",
                () -> Native.loadAvatar(Native.viewContext(view), file, 0, file.capacity()));
        Native.setMemoryLimit(Native.viewContext(view), 0);
        expect(draw() == SHOWN, "what is loaded stays");
        end(window, "memory");
    }

    private void backgroundWhileLoading() throws Exception {
        FakeWindow window = new FakeWindow(Checks.WIDTH, Checks.HEIGHT);
        show(window);
        long load = Native.startLoad(Native.viewContext(view), file, 0, file.capacity());
        end(window, "a load that began in another window");
        float[] status = new float[2];
        for (int i = 0; i < 20; i++) {
            expect(draw() == NO_WINDOW, "no frames in the background");
            Native.loadStatus(load, status);
            Thread.sleep(10);
        }
        expect(status[0] < 3, "a load waits there before its upload ends: state " + status[0] + ", " + status[1]);
        FakeWindow again = new FakeWindow(Checks.WIDTH, Checks.HEIGHT);
        show(again);
        boolean ended = Checks.waitUntil(() -> {
            Native.drawView(view, new long[0], Checks.CAMERA, null, 0, 0, BLUE, false);
            Native.loadStatus(load, status);
            return status[0] >= 3;
        });
        expect(ended && status[0] == 3, "and is ready after it has come back");
        Native.destroyAvatar(Native.finishLoad(load));
        end(again, "a load that ended");
    }

    private void deviceIsLost() {
        FakeWindow window = new FakeWindow(Checks.WIDTH, Checks.HEIGHT);
        show(window);
        draw();
        window.set("nextSubmit", FakeWindow.DEVICE_LOST);
        expect(draw() == DEVICE_LOST_OUTCOME, "a lost device is an outcome");
        expect(window.surfaces() == 0 && window.swapchains() == 0, "and lets its window go");
        expect(draw() == SHOWN && Checks.redPixels(window.shown()) > 500, "the next frame opens another, with the avatar on it");
        end(window, "a lost device");
        FakeWindow waiting = new FakeWindow(Checks.WIDTH, Checks.HEIGHT);
        show(waiting);
        waiting.set("nextAcquire", FakeWindow.DEVICE_LOST);
        expect(draw() == DEVICE_LOST_OUTCOME, "a device that is lost at the image");
        Native.setWindow(view, null, 0, 0);
        expect(draw() == NO_WINDOW, "is opened again in the background too");
        waiting.close();
    }

    private void closedViewIsAnError() {
        FakeWindow window = new FakeWindow(Checks.WIDTH, Checks.HEIGHT);
        show(window);
        draw();
        long closed = view;
        Native.destroyAvatar(avatar);
        Native.destroyView(closed);
        expect(window.users() == 0 && window.surfaces() == 0 && window.swapchains() == 0, "a view that is closed lets its window go");
        window.close();
        int invalid = DoppelException.INVALID_ARGUMENT;
        expectError(invalid, "closed", "a frame of a closed view",
                () -> Native.drawView(closed, new long[0], Checks.CAMERA, null, 0, 0, 0, false));
        expectError(invalid, "closed", "a window for a closed view", () -> Native.setWindow(closed, null, 0, 0));
        expectError(invalid, "closed", "a view that is closed twice", () -> Native.destroyView(closed));
        Native.destroyView(0);
    }
}
