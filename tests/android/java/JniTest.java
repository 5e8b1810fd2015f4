// SPDX-License-Identifier: Apache-2.0
package org.doppel;

import static org.doppel.Checks.expect;
import static org.doppel.Checks.expectError;

import java.lang.ref.WeakReference;
import java.nio.ByteBuffer;
import java.nio.file.Files;
import java.nio.file.Path;
import java.util.Arrays;

/** The natives without a window: a frame equals that of the C API, errors are exceptions, handles are checked, nothing leaks. */
final class JniTest {
    private static final int SOFTWARE = 1;
    private static final int VULKAN = 2;
    private static final int QUADS = 1;

    private final Path work;
    private final ByteBuffer file;
    private final long context = Native.createContext(SOFTWARE, 1, QUADS, null);

    private JniTest(Path work) throws Exception {
        this.work = work;
        file = Checks.mapped(work.resolve("avatar.glb"));
    }

    public static void main(String[] arguments) throws Exception {
        JniTest test = new JniTest(Checks.work(arguments));
        test.frameEqualsTheCApi(SOFTWARE, "software.rgba");
        if (Files.exists(test.work.resolve("vulkan.rgba"))) test.frameEqualsTheCApi(VULKAN, "vulkan.rgba");
        else System.out.println("no frame by Vulkan: draw_with_c found no device");
        test.avatarTellsWhatItIs();
        test.posesGoThereAndBack();
        test.clipsAreMixedAndAHeadlessAvatarDoesNotLook();
        test.theFaceStaysBesideThePose();
        test.mistakesAreExceptions();
        test.everyTruncationIsAnException();
        test.handlesAreChecked();
        test.namesOfPeopleAndOfDamagedFilesAreText();
        test.loadGoesOnInTheBackground();
        test.cancelledLoadGivesTheBufferBack();
        test.bufferStaysWhileItIsRead();
        Native.destroyContext(test.context);
        System.exit(Checks.exitCode());
    }

    private long load() {
        return Native.loadAvatar(context, file, 0, file.capacity());
    }

    private void frameEqualsTheCApi(int renderer, String expected) throws Exception {
        long mine = Native.createContext(renderer, 1, QUADS, null);
        long avatar = Native.loadAvatar(mine, file, 0, file.capacity());
        Native.setPoseFromClip(avatar, 0, 0.5, true);
        ByteBuffer pixels = ByteBuffer.allocateDirect(Checks.WIDTH * Checks.HEIGHT * 4);
        Checks.render(mine, new long[] {avatar}, Checks.CAMERA, pixels);
        byte[] drawn = new byte[pixels.capacity()];
        pixels.get(drawn);
        expect(Checks.redPixels(drawn) > 500, "a frame is not empty: " + Native.rendererName(mine));
        expect(Arrays.equals(drawn, Checks.read(work.resolve(expected))), "and has the bytes of the C API's");
        Native.destroyAvatar(avatar);
        Native.destroyContext(mine);
    }

    private void avatarTellsWhatItIs() {
        long avatar = load();
        long[] counts = new long[10];
        float[] bounds = new float[6];
        Native.avatarInfo(avatar, counts, bounds);
        expect(counts[0] == 2 && counts[1] == 128 && counts[3] == 2 && counts[5] == 1 && counts[9] == 1,
                "counts: " + Arrays.toString(counts));
        expect(Math.abs(bounds[1] - 0.5f) < 1e-3f && Math.abs(bounds[4] - 1.5f) < 1e-3f, "bounds: " + Arrays.toString(bounds));
        expect(Native.avatarName(avatar).equals("tiny"), "name");
        expect(Arrays.asList(Native.jointNames(avatar)).equals(Arrays.asList("pelvis", "hips", "left_shoulder", "leftUpperArm")),
                "names of the joints");
        float[] tree = Native.jointTree(avatar);
        expect(tree.length == 8 && tree[0] == -1 && tree[4] == 0 && tree[6] == 1.25f, "tree of the joints");
        expect(Native.findJoint(avatar, "leftUpperArm") == 1, "a joint by its humanoid bone");
        expect(Native.clipName(avatar, 0).equals("turn") && Native.clipDuration(avatar, 0) == 1, "clip");
        Native.destroyAvatar(avatar);
    }

    private void posesGoThereAndBack() {
        long avatar = load();
        float[] rotations = {0, 0.6f, 0, 0.8f, 0, 0, 0, 1};
        Native.setPose(avatar, rotations, new float[] {1, 2, 3});
        float[] back = new float[8];
        float[] root = new float[3];
        Native.getPose(avatar, back, root);
        boolean same = true;
        for (int i = 0; i < 8; i++) same &= Math.abs(back[i] - rotations[i]) < 1e-6f;
        expect(same && Arrays.equals(root, new float[] {1, 2, 3}), "a pose comes back");
        float[] positions = new float[6];
        Native.jointPositions(avatar, positions);
        expect(Math.abs(positions[1] - 3) < 1e-5f, "joints stand where the root puts them");
        float[] above = {0, 0, 2, 0, 0, 2, 0, 5, -2, 0, 0, 0}; // turned about +Y, twice as large, 5 m up
        Native.setTransform(avatar, above);
        float[] rows = new float[12];
        Native.getTransform(avatar, rows);
        expect(Arrays.equals(rows, above), "a transform comes back");
        Native.jointPositions(avatar, positions);
        expect(Math.abs(positions[1] - 11) < 1e-5f && Math.abs(positions[2] + 2) < 1e-5f, "joints stand where it puts them");
        expectError(DoppelException.INVALID_ARGUMENT, "12 numbers", "too few numbers", () -> Native.setTransform(avatar, new float[9]));
        expectError(DoppelException.INVALID_ARGUMENT, "mirrors", "a mirror",
                () -> Native.setTransform(avatar, new float[] {-1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0}));
        float[] place = new float[10];
        byte[] alpha = Native.contactShadow(avatar, true, 3.8f, place);
        expect(alpha.length == 64 * 64 && Math.abs(place[1] - 3.8f) < 1e-5f && Math.abs(place[5]) >= 2, "a shadow lies on the floor");
        expectError(DoppelException.INVALID_ARGUMENT, "the floor is at", "no floor",
                () -> Native.contactShadow(avatar, true, Float.NaN, place));
        expect(Arrays.equals(Native.layerNames(avatar), new String[] {"body", "body"}) && !Native.isLayerHidden(avatar, 0), "layers");
        expectError(DoppelException.UNSUPPORTED, "is the body", "hiding the body", () -> Native.hideLayer(avatar, 0, true));
        expectError(DoppelException.NOT_FOUND, "no layer 3", "no such layer", () -> Native.isLayerHidden(avatar, 3));
        int[] indices = {9, 9, 9};
        boolean met = Native.pick(new long[] {avatar}, new float[] {0, positions[1], 0, 0, 0, -1}, indices, place);
        expect(!met || indices[0] == 0, "a ray meets this avatar or none");
        expectError(DoppelException.INVALID_ARGUMENT, "direction is 0", "a ray to nowhere",
                () -> Native.pick(new long[] {avatar}, new float[6], indices, place));
        Native.setPoseAtTime(avatar, rotations, null, 5_000_000_000L);
        Native.getPose(avatar, back, root);
        expect(Arrays.equals(root, new float[3]), "a pose with a time is a pose");
        byte[] state = Native.motionState(avatar);
        expect(state.length > 0, "what clothes remember is bytes");
        Native.settle(avatar);
        Native.setMotionState(avatar, state);
        expect(Arrays.equals(Native.motionState(avatar), state), "and comes back");
        expectError(DoppelException.INVALID_ARGUMENT, "motion state", "other bytes", () -> Native.setMotionState(avatar, new byte[9]));
        Native.setClothStiffness(avatar, 3);
        expectError(DoppelException.INVALID_ARGUMENT, "1 is as learned", "a stiffness below 0", () -> Native.setClothStiffness(avatar, -1));
        Native.destroyAvatar(avatar);
    }

    private void clipsAreMixedAndAHeadlessAvatarDoesNotLook() {
        long avatar = load();
        float[] plain = new float[8];
        float[] mixed = new float[8];
        float[] root = new float[3];
        Native.setPoseFromClip(avatar, 0, 0.5, true);
        Native.getPose(avatar, plain, null);
        double[] one = {0, 2.5, 1, 0, 1, 0, 0, 0}; // clip, time, weight, joint, loop, heading, shift
        Native.setPoseFromClips(avatar, one, 5_000_000_000L);
        Native.getPose(avatar, mixed, root);
        expect(Arrays.equals(plain, mixed), "one layer is its clip");
        double[] two = {0, 0.25, 1, 0, 1, 0, 3, 0, 0, 0.75, 1, 0, 1, 0, 3, 0};
        Native.setPoseFromClips(avatar, two, 5_100_000_000L);
        Native.getPose(avatar, mixed, root);
        expect(Math.abs(mixed[1] - plain[1]) < 1e-6f && Math.abs(root[0] - 3) < 1e-6f, "the mean of two times, shifted");
        double[] moved = {0, 0, 1, 0, 1, 0, 5, 7};
        double[] joined = {0, 0, 1, 0, 1, 9, 9, 9};
        Native.joinClipLayer(avatar, moved, joined);
        expect(Math.abs(joined[5]) < 1e-6 && Math.abs(joined[6] - 5) < 1e-6 && Math.abs(joined[7] - 7) < 1e-6, "a layer is joined");
        int invalid = DoppelException.INVALID_ARGUMENT;
        expectError(invalid, "8 numbers", "half a layer", () -> Native.setPoseFromClips(avatar, new double[4], 0));
        expectError(invalid, "NULL", "no layers", () -> Native.setPoseFromClips(avatar, new double[0], 0));
        expectError(invalid, "one layer", "two layers joined to one", () -> Native.joinClipLayer(avatar, two, joined));
        expectError(DoppelException.NOT_FOUND, "no clip 4294967295", "a clip below 0",
                () -> Native.setPoseFromClips(avatar, new double[] {-1, 0, 1, 0, 0, 0, 0, 0}, 0));
        expectError(invalid, "9 numbers", "a gaze that is too short", () -> Native.lookAtPoint(avatar, new float[3]));
        expectError(invalid, "3 numbers", "a face's motion that is too short", () -> Native.setFaceMotion(avatar, 0, 1, new float[2], 0));
        expectError(DoppelException.UNSUPPORTED, "head", "an avatar without a head looks", () -> Native.lookAtPoint(avatar, new float[9]));
        Native.destroyAvatar(avatar);
    }

    private void theFaceStaysBesideThePose() throws Exception {
        ByteBuffer person = Checks.mapped(work.resolve("person.glb"));
        long avatar = Native.loadAvatar(context, person, 0, person.capacity());
        String[] names = Native.expressionNames(avatar);
        expect(names.length == 52 && names[0].equals("eyeBlinkLeft") && names[51].equals("tongueOut"), "names of the expressions");
        expect(Native.isExpressionDrawn(avatar, 0) && !Native.isExpressionDrawn(avatar, 1), "which of them the avatar holds");
        float[] weights = new float[52];
        weights[3] = 0.5f;
        Native.setExpression(avatar, weights);
        Native.setPoseFromClip(avatar, 0, 0.5, true);
        expect(Arrays.equals(Native.expression(avatar), weights), "a face comes back, whatever the pose");
        Native.setExpressionNamed(avatar, new String[] {"_neutral", "EyeBlinkLeft"}, new float[] {1, 2});
        Arrays.fill(weights, 0);
        weights[0] = 1;
        expect(Arrays.equals(Native.expression(avatar), weights), "weights by names, held in 0 to 1");
        int invalid = DoppelException.INVALID_ARGUMENT;
        expectError(invalid, "there are 52", "too few weights", () -> Native.setExpression(avatar, new float[3]));
        expectError(invalid, "weight is needed", "a name without a weight",
                () -> Native.setExpressionNamed(avatar, new String[] {"jawOpen"}, new float[0]));
        expectError(invalid, "did you mean 'jawOpen'", "a name that is none",
                () -> Native.setExpressionNamed(avatar, new String[] {"jawOpne"}, new float[] {1}));
        expectError(invalid, "there is no expression ''", "no name",
                () -> Native.setExpressionNamed(avatar, new String[] {null}, new float[] {1}));
        expectError(DoppelException.NOT_FOUND, "no expression 52", "an expression beyond the last",
                () -> Native.isExpressionDrawn(avatar, 52));
        String[] many = new String[1000];
        Arrays.fill(many, "blink");
        Native.setExpressionNamed(avatar, many, new float[1000]);
        Native.setExpressionNamed(avatar, new String[0], new float[0]);
        expect(Arrays.equals(Native.expression(avatar), new float[52]), "no names show nothing");
        Native.destroyAvatar(avatar);
    }

    private void mistakesAreExceptions() {
        long avatar = load();
        expectError(DoppelException.NOT_FOUND, "pelvis", "a joint that is not there; the text lists all",
                () -> Native.findJoint(avatar, "tail"));
        expectError(DoppelException.INVALID_ARGUMENT, "joint", "a pose of another rig", () -> Native.setPose(avatar, new float[4], null));
        expectError(DoppelException.INVALID_ARGUMENT, "", "a pose that is not finite",
                () -> Native.setPose(avatar, new float[] {Float.NaN, 0, 0, 1, 0, 0, 0, 1}, null));
        expectError(DoppelException.INVALID_ARGUMENT, "3 numbers", "a root of two numbers",
                () -> Native.setPose(avatar, new float[8], new float[2]));
        expectError(DoppelException.INVALID_ARGUMENT, "direct", "a buffer on the heap",
                () -> Native.loadAvatar(context, ByteBuffer.allocate(64), 0, 64));
        expectError(DoppelException.INVALID_ARGUMENT, "direct", "no buffer", () -> Native.loadAvatar(context, null, 0, 0));
        expectError(DoppelException.INVALID_ARGUMENT, "not in a buffer", "bytes beyond the buffer",
                () -> Native.loadAvatar(context, file, 10, file.capacity()));
        expectError(DoppelException.INVALID_ARGUMENT, "not in a buffer", "an offset that overflows",
                () -> Native.loadAvatar(context, file, Long.MAX_VALUE, Long.MAX_VALUE));
        expectError(DoppelException.INVALID_ARGUMENT, "18 numbers", "a camera that is too short",
                () -> Checks.render(context, new long[] {avatar}, new float[3], ByteBuffer.allocateDirect(64)));
        float[] huge = Checks.CAMERA.clone();
        huge[0] = Float.NaN;
        expectError(DoppelException.INVALID_ARGUMENT, "", "a camera of no width",
                () -> Checks.render(context, new long[] {avatar}, huge, ByteBuffer.allocateDirect(64)));
        expectError(DoppelException.INVALID_ARGUMENT, "", "an image that is too small",
                () -> Checks.render(context, new long[] {avatar}, Checks.CAMERA, ByteBuffer.allocateDirect(64)));
        expectError(DoppelException.INVALID_ARGUMENT, "negative", "a negative memory limit", () -> Native.setMemoryLimit(context, -1));
        expectError(DoppelException.INVALID_ARGUMENT, "", "a detail that is not a number", () -> Native.setDetail(context, Float.NaN, 0));
        expectError(DoppelException.NOT_FOUND, "", "a clip that is not there", () -> Native.clipName(avatar, -1));
        Native.destroyAvatar(avatar);
    }

    private void everyTruncationIsAnException() {
        int refused = 0;
        int step = 37; // a prime, so that all parts of the file are met
        int tried = 0;
        for (int size = 0; size < file.capacity(); size += step, tried++) {
            try {
                Native.destroyAvatar(Native.loadAvatar(context, file, 0, size));
            } catch (DoppelException e) {
                refused += e.getMessage().isEmpty() ? 0 : 1;
            }
        }
        expect(refused == tried && tried > 20, refused + " of " + tried + " truncated files are refused with a sentence");
    }

    private void handlesAreChecked() {
        long avatar = load();
        Native.destroyAvatar(avatar);
        int invalid = DoppelException.INVALID_ARGUMENT;
        expectError(invalid, "", "an avatar that was destroyed", () -> Native.setPoseFromClip(avatar, 0, 0, true));
        expectError(invalid, "", "an avatar that was destroyed twice", () -> Native.destroyAvatar(avatar));
        expectError(invalid, "", "a context given as an avatar", () -> Native.avatarName(context));
        expectError(invalid, "", "an avatar given as a context", () -> Native.rendererName(avatar));
        expectError(invalid, "", "a number that is no handle", () -> Native.avatarName(0x1234567890L));
        expectError(invalid, "", "no handle", () -> Native.avatarName(0));
        expectError(invalid, "no such view", "a view that was never made",
                () -> Native.drawView(7, new long[0], Checks.CAMERA, null, 0, 0, 0, false));
        expectError(invalid, "no such view", "the context of no view", () -> Native.viewContext(-1));
        expectError(invalid, "", "a load that was never started", () -> Native.finishLoad(99));
        long other = Native.createContext(SOFTWARE, 1, QUADS, null);
        long foreign = load();
        expectError(invalid, "", "an avatar of another context",
                () -> Checks.render(other, new long[] {foreign}, Checks.CAMERA, ByteBuffer.allocateDirect(96 * 128 * 4)));
        Native.destroyAvatar(foreign);
        Native.destroyContext(other);
    }

    private void namesOfPeopleAndOfDamagedFilesAreText() throws Exception {
        long avatar = load();
        expectError(DoppelException.NOT_FOUND, "\uD83D\uDE42", "a name beyond 16 bits comes back in the sentence",
                () -> Native.findJoint(avatar, "smile \uD83D\uDE42"));
        expectError(DoppelException.NOT_FOUND, "\uFFFD", "half a character is replaced", () -> Native.findJoint(avatar, "half \uD83D"));
        Native.destroyAvatar(avatar);
        byte[] bytes = Checks.read(work.resolve("avatar.glb"));
        String text = new String(bytes, java.nio.charset.StandardCharsets.ISO_8859_1);
        int at = text.indexOf("left_shoulder");
        bytes[at] = (byte) 0xF0; // no UTF-8
        try {
            long damaged = Native.loadAvatar(context, Checks.direct(bytes), 0, bytes.length);
            String name = Native.jointNames(damaged)[2];
            expect(name.startsWith("\uFFFD"), "a name that is no UTF-8: " + name);
            Native.destroyAvatar(damaged);
        } catch (DoppelException e) {
            expect(!e.getMessage().isEmpty(), "a name that is no UTF-8 is refused: " + e.getMessage());
        }
    }

    private static float[] statusOf(long load) {
        float[] status = new float[2];
        Native.loadStatus(load, status);
        return status;
    }

    private void loadGoesOnInTheBackground() throws Exception {
        long load = Native.startLoad(context, file, 0, file.capacity());
        float[] progress = {0};
        boolean[] falls = {false};
        boolean ended = Checks.waitUntil(() -> {
            float[] now = statusOf(load);
            falls[0] |= now[1] < progress[0];
            progress[0] = now[1];
            return now[0] >= 3;
        });
        expect(ended && statusOf(load)[0] == 3 && statusOf(load)[1] == 1 && !falls[0],
                "a load becomes ready, and its progress never falls");
        long avatar = Native.finishLoad(load);
        expect(Native.avatarName(avatar).equals("tiny"), "and gives the avatar");
        expectError(DoppelException.INVALID_ARGUMENT, "", "a load that is finished", () -> statusOf(load));
        Native.destroyAvatar(avatar);
        long bad = Native.startLoad(context, Checks.direct(new byte[100]), 0, 100);
        expectError(DoppelException.UNSUPPORTED, "", "a load of something else fails at its end", () -> Native.finishLoad(bad));
    }

    /** Whether an object without other references is collected. */
    private static boolean isCollected(WeakReference<?> reference) throws Exception {
        return Checks.waitUntil(() -> {
            System.gc();
            return reference.get() == null;
        });
    }

    private WeakReference<ByteBuffer> startAndCancel() throws Exception {
        ByteBuffer buffer = Checks.direct(Checks.read(work.resolve("avatar.glb")));
        long load = Native.startLoad(context, buffer, 0, buffer.capacity());
        Native.cancelLoad(load);
        expectError(DoppelException.INVALID_ARGUMENT, "", "a load that was cancelled", () -> Native.finishLoad(load));
        return new WeakReference<>(buffer);
    }

    private void cancelledLoadGivesTheBufferBack() throws Exception {
        expect(isCollected(startAndCancel()), "a cancelled load holds its buffer no more");
    }

    private void bufferStaysWhileItIsRead() throws Exception {
        // The only reference to the buffer is that of native code.
        long load = Native.startLoad(context, Checks.direct(Checks.read(work.resolve("avatar.glb"))), 0, file.capacity());
        for (int i = 0; i < 5; i++) System.gc();
        long avatar = Native.finishLoad(load);
        expect(Native.avatarName(avatar).equals("tiny"), "a buffer that only a load knows stays until it is read");
        Native.destroyAvatar(avatar);
    }
}
