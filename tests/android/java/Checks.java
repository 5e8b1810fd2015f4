// SPDX-License-Identifier: Apache-2.0
package org.doppel;

import java.io.IOException;
import java.nio.ByteBuffer;
import java.nio.ByteOrder;
import java.nio.FloatBuffer;
import java.nio.channels.FileChannel;
import java.nio.file.Files;
import java.nio.file.Path;
import java.nio.file.Paths;
import java.nio.file.StandardOpenOption;

/** What the tests of Java and of Kotlin share: expectations that are counted, and files. */
public final class Checks {
    /** The camera of draw_with_c.c. */
    public static final float[] CAMERA = {96, 128, 120, 120, 48, 64, 1, 0, 0, 0, 0, -1, 0, 1.2f, 0, 0, -1, 2};
    public static final int WIDTH = 96;
    public static final int HEIGHT = 128;

    private static int failures = 0;
    private static int passed = 0;

    private Checks() {}

    public static void expect(boolean truth, String what) {
        System.out.println((truth ? "ok: " : "FAILED: ") + what);
        if (truth) passed++;
        else failures++;
    }

    public interface Action {
        void run() throws Exception;
    }

    /** Expects a DoppelException with this code, whose sentence contains `part`. */
    public static void expectError(int code, String part, String what, Action action) {
        try {
            action.run();
            expect(false, what + ": no exception");
        } catch (DoppelException e) {
            expect(e.getCode() == code && e.getMessage().contains(part), what + ": " + e.getCode() + " \"" + e.getMessage() + "\"");
        } catch (Exception e) {
            expect(false, what + ": " + e);
        }
    }

    /** A condition that looks at the world, and may change it. */
    public interface Condition {
        boolean holds() throws Exception;
    }

    /** Looks again and again until the condition holds. False: it did not within ten minutes, which only what hangs takes. */
    public static boolean waitUntil(Condition condition) throws Exception {
        long end = System.nanoTime() + 600_000_000_000L;
        while (!condition.holds()) {
            if (System.nanoTime() - end > 0) return false;
            Thread.sleep(2);
        }
        return true;
    }

    /** A file as the view maps an asset: no copy. */
    public static ByteBuffer mapped(Path file) throws IOException {
        try (FileChannel channel = FileChannel.open(file, StandardOpenOption.READ)) {
            return channel.map(FileChannel.MapMode.READ_ONLY, 0, channel.size());
        }
    }

    public static ByteBuffer direct(byte[] bytes) {
        ByteBuffer buffer = ByteBuffer.allocateDirect(bytes.length);
        buffer.put(bytes).flip();
        return buffer;
    }

    /** One camera, without depth. */
    static void render(long context, long[] avatars, float[] camera, ByteBuffer rgba) {
        Native.render(context, avatars, camera, null, new ByteBuffer[] {rgba}, null);
    }

    /** Zeros, direct. */
    public static FloatBuffer floats(int count) {
        return ByteBuffer.allocateDirect(4 * count).order(ByteOrder.nativeOrder()).asFloatBuffer();
    }

    public static Path work(String[] arguments) {
        return Paths.get(arguments[0]);
    }

    public static byte[] read(Path file) throws IOException {
        return Files.readAllBytes(file);
    }

    /** Pixels of RGBA8 whose alpha, or red over a background of blue, says that something was drawn. */
    public static int redPixels(byte[] rgba) {
        int count = 0;
        for (int i = 0; i < rgba.length; i += 4) if ((rgba[i] & 0xff) > 200 && (rgba[i + 1] & 0xff) < 60) count++;
        return count;
    }

    public static int exitCode() {
        System.out.println(passed + " passed, " + failures + " failed");
        return failures == 0 && passed > 0 ? 0 : 1;
    }

    /** Ends with code 77, which tests take as skipped. */
    public static void skip(String reason) {
        System.out.println("skipped: " + reason);
        System.exit(77);
    }
}
