/* SPDX-License-Identifier: Apache-2.0 */
/* Calls every exported function from strict C99; check_calls.py compares with exports.txt. Argument: the file of make_person. It draws on
 * the CPU, so the functions of doppel_vulkan.h give the errors that they promise without a device. */
#include <doppel/doppel.h>
#include <doppel/doppel_convert.h>
#include <doppel/doppel_splats.h>
#ifdef WITH_VULKAN
#include <doppel/doppel_vulkan.h>
#endif

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static int failures = 0;

#define CHECK(condition)                                                                           \
    do {                                                                                           \
        if (!(condition)) {                                                                        \
            printf("%s:%d: failed: %s (%s)\n", __FILE__, __LINE__, #condition, dplGetLastError()); \
            ++failures;                                                                            \
        }                                                                                          \
    } while (0)
#define OK(call) CHECK((call) == DPL_OK)

enum { kWidth = 24, kHeight = 32, kPixels = kWidth * kHeight, kMostJoints = 64, kMostFile = 1 << 20 };

static unsigned char file[kMostFile], pixels[4 * kPixels];
static float depth[kPixels];
static int released = 0, logged = 0;

static void release(void* user) {
    (void)user;
    ++released;
}
static void receiveLog(void* user, DplLogLevel level, const char* text) {
    (void)user, (void)level;
    logged += text[0] != 0;
}

static const char* const kBvh =
    "HIERARCHY\nROOT Hips\n{\n OFFSET 0 95 0\n CHANNELS 3 Zrotation Xrotation Yrotation\n"
    " JOINT LeftUpLeg\n {\n  OFFSET 9 -5 0\n  CHANNELS 3 Zrotation Xrotation Yrotation\n"
    "  JOINT LeftLeg\n  {\n   OFFSET 0 -41 0\n   CHANNELS 3 Zrotation Xrotation Yrotation\n   End Site\n   {\n    OFFSET 0 -41 0\n   }\n  "
    "}\n }\n"
    " JOINT RightUpLeg\n {\n  OFFSET -9 -5 0\n  CHANNELS 3 Zrotation Xrotation Yrotation\n"
    "  JOINT RightLeg\n  {\n   OFFSET 0 -41 0\n   CHANNELS 3 Zrotation Xrotation Yrotation\n   End Site\n   {\n    OFFSET 0 -41 0\n   }\n  "
    "}\n }\n}\n"
    "MOTION\nFrames: 2\nFrame Time: 0.5\n0 0 0 0 0 0 0 0 0 0 0 0 0 0 0\n0 0 0 0 20 0 0 0 0 0 -20 0 0 0 0\n";

static void callPoses(DplAvatar avatar, uint32_t joints) {
    float rotations[4 * kMostJoints], read[4 * kMostJoints], root[3] = {1, 0, 0}, positions[3 * kMostJoints], distances[kMostJoints];
    DplPoseTrust trust = {0};
    DplCaptureDetail detail = {0};
    const float twiceAsLarge[12] = {2, 0, 0, 0, 0, 2, 0, 3, 0, 0, 2, 0};
    float eye[3] = {0, 0, 9}, distanceM = -1, placed[12];
    DplClipInfo clip = {0};
    DplJointInfo joint = {0};
    DplFileAxes axes = {0};
    DplExpressionInfo expression = {0};
    DplFaceMotion faceMotion = {0};
    float weights[DPL_EXPRESSION_COUNT] = {0};
    const float noWeights[DPL_EXPRESSION_COUNT] = {0}, half[1] = {0.5f};
    const char* const smile[1] = {"happy"};
    DplClipLayer layers[2] = {{0}, {0}};
    DplGaze gaze = {0};
    static uint8_t state[8192];
    size_t stateSize = 0;
    uint32_t added = 99, found = 99, j;
    for (j = 0; j < joints; ++j) rotations[4 * j] = rotations[4 * j + 1] = rotations[4 * j + 2] = 0, rotations[4 * j + 3] = 1;
    OK(dplSetPose(avatar, rotations, joints, root));
    OK(dplGetPose(avatar, read, joints, root));
    CHECK(memcmp(read, rotations, joints * 16) == 0 && root[0] == 1);
    OK(dplSetPoseAtTime(avatar, rotations, joints, root, 5000000000));
    OK(dplGetMotionState(avatar, NULL, 0, &stateSize));
    CHECK(stateSize > 0 && stateSize <= sizeof state);
    OK(dplGetMotionState(avatar, state, sizeof state, &stateSize));
    OK(dplSettle(avatar));
    OK(dplSetMotionState(avatar, state, stateSize));
    CHECK(dplSetMotionState(avatar, state, stateSize - 1) == DPL_ERROR_INVALID_ARGUMENT);
    OK(dplSetClothStiffness(avatar, 3));
    CHECK(dplSetClothStiffness(avatar, -1) == DPL_ERROR_INVALID_ARGUMENT);
    OK(dplSetClothStiffness(avatar, 1));
    OK(dplFindExpression("mouthSmileLeft", &found));
    CHECK(found < DPL_EXPRESSION_COUNT && dplFindExpression("smirk", &found) == DPL_ERROR_NOT_FOUND);
    weights[found] = 0.5f;
    OK(dplSetExpression(avatar, weights, DPL_EXPRESSION_COUNT));
    weights[found] = 0;
    OK(dplGetExpression(avatar, weights, DPL_EXPRESSION_COUNT));
    CHECK(weights[found] == 0.5f);
    OK(dplSetExpression(avatar, noWeights, DPL_EXPRESSION_COUNT));
    OK(dplSetExpressionNamed(avatar, smile, half, 1));
    OK(dplSetExpressionNamed(avatar, NULL, noWeights, DPL_EXPRESSION_COUNT));
    faceMotion.structSize = sizeof faceMotion, faceMotion.blinks = 1;
    OK(dplSetFaceMotion(avatar, &faceMotion, 7000000000));
    faceMotion.blinks = 2;
    CHECK(dplSetFaceMotion(avatar, &faceMotion, 0) == DPL_ERROR_INVALID_ARGUMENT);
    expression.structSize = sizeof expression;
    OK(dplGetExpressionInfo(avatar, found, &expression));
    CHECK(strcmp(expression.name, "mouthSmileLeft") == 0);
    axes.structSize = sizeof axes;
    OK(dplGetFileAxes(avatar, &axes));
    CHECK(axes.stated == DPL_TRUE && axes.loadedFromFile[0] == 1 && axes.loadedFromFile[1] == 0 && axes.loadedFromFile[8] == 1);
    joint.structSize = sizeof joint;
    OK(dplGetJointInfo(avatar, 0, &joint));
    CHECK(joint.parent == -1 && strcmp(joint.humanoidBone, "hips") == 0);
    OK(dplSetTransform(avatar, twiceAsLarge));
    OK(dplGetTransform(avatar, placed));
    CHECK(memcmp(placed, twiceAsLarge, sizeof placed) == 0);
    OK(dplGetJointPositions(avatar, positions, joints));
    CHECK(fabsf(positions[0] - 2 * (joint.restPosition[0] + 1)) < 1e-5f && fabsf(positions[1] - 2 * joint.restPosition[1] - 3) < 1e-5f);
    OK(dplSetTransform(avatar, NULL));
    OK(dplGetJointPositions(avatar, positions, joints));
    CHECK(fabsf(positions[0] - joint.restPosition[0] - 1) < 1e-5f);
    OK(dplFindJoint(avatar, "leftHand", &found));
    CHECK(found < joints && dplFindJoint(avatar, "tail", &found) == DPL_ERROR_NOT_FOUND);
    trust.structSize = sizeof trust;
    OK(dplGetPoseTrust(avatar, &trust, distances, joints));
    CHECK(trust.offsets >= 0 && trust.offsets <= 1 && trust.farthestJoint < joints);
    OK(dplHoldPose(avatar, 4));
    detail.structSize = sizeof detail;
    OK(dplGetCaptureDetail(avatar, 0, &detail));
    CHECK(fabsf(detail.detailM[0] - 0.004f) < 0.0002f && detail.views[0] == 7 && detail.detailM[2] == 0);
    OK(dplGetNearestDistance(avatar, positions, eye, 1000, 8, &distanceM));
    CHECK(fabsf(distanceM - detail.detailM[0] * 1000 / 8) < 0.01f);
    OK(dplLoadClip(avatar, (const uint8_t*)kBvh, strlen(kBvh), NULL, &added));
    clip.structSize = sizeof clip;
    OK(dplGetClipInfo(avatar, added, &clip));
    CHECK(clip.durationS == 0.5 && clip.keyCount == 2);
    OK(dplSetPoseFromClip(avatar, added, 0.5, DPL_FALSE));
    OK(dplGetPose(avatar, read, joints, NULL));
    CHECK(memcmp(read, rotations, joints * 16) != 0);
    for (j = 0; j < 2; ++j) layers[j].structSize = sizeof layers[j], layers[j].clip = added, layers[j].timeS = 0.25, layers[j].weight = 1;
    layers[1].timeS = 0.5, layers[1].flags = DPL_LAYER_LOOP;
    OK(dplJoinClipLayer(avatar, &layers[0], &layers[1]));
    CHECK(fabsf(layers[1].headingRad) < 0.1f);
    OK(dplSetPoseFromClips(avatar, layers, 2, 6000000000));
    layers[0].weight = layers[1].weight = 0;
    CHECK(dplSetPoseFromClips(avatar, layers, 2, 6000000000) == DPL_ERROR_INVALID_ARGUMENT);
    OK(dplFindJoint(avatar, "head", &found));
    OK(dplGetPose(avatar, read, joints, NULL));
    gaze.structSize = sizeof gaze, gaze.target[0] = 2, gaze.target[1] = 1.6f, gaze.target[2] = 1;
    gaze.headWeight = 0.7f, gaze.eyeWeight = 1;
    OK(dplLookAtPoint(avatar, &gaze));
    OK(dplGetPose(avatar, rotations, joints, NULL));
    CHECK(rotations[4 * found + 1] > read[4 * found + 1] + 0.1f);
}

static void callSurface(DplAvatar avatar) {
    static uint8_t alpha[DPL_CONTACT_SHADOW_PX * DPL_CONTACT_SHADOW_PX];
    DplContactShadow shadow = {0};
    const float floorM = 1, above[3] = {0, 50, 0}, upwards[3] = {0, 1, 0};
    DplLayerInfo layer = {0};
    DplPick pick = {0};
    DplAvatarInfo info = {0};
    static float positions[3 * (1 << 16)];
    static uint32_t triangles[3 * (1 << 17)];
    shadow.structSize = sizeof shadow;
    OK(dplGetContactShadow(avatar, &floorM, alpha, sizeof alpha, &shadow));
    CHECK(fabsf(shadow.corner[1] - 1) < 1e-5f && shadow.across[0] >= 1 && shadow.along[2] == shadow.across[0] && alpha[0] == 0);
    CHECK(dplGetContactShadow(avatar, &floorM, alpha, sizeof alpha - 1, &shadow) == DPL_ERROR_INVALID_ARGUMENT);
    layer.structSize = sizeof layer, pick.structSize = sizeof pick, pick.hit = 7;
    OK(dplGetLayerInfo(avatar, 0, &layer));
    CHECK(strcmp(layer.role, "body") == 0 && layer.triangleCount > 0 && layer.hidden == DPL_FALSE);
    CHECK(dplHideLayer(avatar, 0, DPL_TRUE) == DPL_ERROR_UNSUPPORTED && strstr(dplGetLastError(), "is the body") != NULL);
    OK(dplHideLayer(avatar, 0, DPL_FALSE));
    OK(dplPick(&avatar, 1, above, upwards, &pick));
    CHECK(pick.hit == DPL_FALSE && pick.distanceM == 0);
    info.structSize = sizeof info;
    OK(dplGetAvatarInfo(avatar, &info));
    CHECK(info.vertexCount <= 1 << 16 && info.triangleCount <= 1 << 17);
    OK(dplGetPosedMesh(avatar, positions, info.vertexCount, triangles, info.triangleCount));
    CHECK(triangles[0] < info.vertexCount && triangles[0] != triangles[1]);
    CHECK(dplGetPosedMesh(avatar, NULL, info.vertexCount, triangles, info.triangleCount) == DPL_ERROR_INVALID_ARGUMENT);
}

static void callProject(DplContext context, DplAvatar avatar) {
    static DplScreenSplat splats[1 << 14];
    const DplCamera camera = {
        sizeof(DplCamera), kWidth, kHeight, 30, 30, kWidth / 2.f, kHeight / 2.f, {1, 0, 0, 0, 0, -1, 0, 1, 0, 0, -1, 3}, NULL, 0};
    DplProjection projection = {0};
    projection.structSize = sizeof projection;
    OK(dplProject(context, &avatar, 1, &camera, 1, splats, 1 << 14, &projection));
    CHECK(projection.counts[0] > 0 && projection.counts[1] == 0 && splats[0].opacity > 0);
}

static void callPosed(DplAvatar avatar) {
    static float numbers[1 << 16];
    const float eye[3] = {0, 1, 3};
    DplAvatarInfo info = {0};
    DplBufferElement place[2] = {{0}};
    DplBuffer buffer = {0};
    DplSplatOptions options = {0};
    DplWritten written = {0};
    info.structSize = sizeof info;
    OK(dplGetAvatarInfo(avatar, &info));
    place[0].structSize = place[1].structSize = sizeof place[0], place[0].strideBytes = place[1].strideBytes = 16;
    place[0].property = DPL_SPLAT_POSITION, place[1].property = DPL_SPLAT_OPACITY, place[1].offsetBytes = 12;
    buffer.structSize = sizeof buffer, buffer.elementCount = 2, buffer.elements = place, buffer.data = numbers;
    buffer.dataBytes = sizeof numbers;
    options.structSize = sizeof options, options.eye = eye, written.structSize = sizeof written;
    OK(dplWriteSplats(avatar, &options, &buffer, &written));
    CHECK(written.count == info.splatCount && written.saturated == 0 && numbers[3] >= 0 && numbers[3] <= 1);
    place[1].offsetBytes = 8;
    CHECK(dplWriteSplats(avatar, &options, &buffer, &written) == DPL_ERROR_INVALID_ARGUMENT && strstr(dplGetLastError(), "overlap"));
    place[0].property = DPL_VERTEX_NORMAL, buffer.elementCount = 1;
    OK(dplWriteMesh(avatar, &buffer, &written));
    CHECK(written.count == info.vertexCount);
    CHECK(fabsf(numbers[0] * numbers[0] + numbers[1] * numbers[1] + numbers[2] * numbers[2] - 1) < 1e-5f);
}

static void callTracker(DplAvatar avatar) {
    float rotations[4 * 53] = {0}, positions[3 * 53] = {0}, confidence[53] = {0};
    DplTrackerInfo info = {0};
    DplTrackFrame frame = {0};
    DplTrackerStatus status = {0};
    DplTracker tracker = NULL;
    const char* name = NULL;
    OK(dplGetTrackJointName(DPL_TRACK_OPENXR_HANDS, 0, &name));
    CHECK(strcmp(name, "HEAD") == 0);
    info.structSize = sizeof info, info.format = DPL_TRACK_OPENXR_HANDS;
    OK(dplCreateTracker(avatar, &info, &tracker));
    rotations[3] = 1, positions[1] = 1.6f, confidence[0] = 1; /* a head alone */
    frame.structSize = sizeof frame, frame.jointCount = 53, frame.timeNs = 1000;
    frame.rotations = rotations, frame.positions = positions, frame.confidence = confidence;
    OK(dplTrackFrame(tracker, &frame));
    status.structSize = sizeof status;
    OK(dplSetPoseFromTracker(tracker, 1000, &status));
    CHECK(status.state == DPL_TRACKER_TRACKING && status.framesTaken == 1 && status.drivenJoints >= 2);
    OK(dplDestroyTracker(tracker));
}

static void callLoads(DplContext context, size_t size) {
    DplLoadInfo info = {0};
    DplLoadStatus status = {0};
    DplLoad load = NULL;
    DplAvatar avatar = NULL;
    info.structSize = sizeof info, info.data = file, info.size = size, info.release = release;
    status.structSize = sizeof status;
    OK(dplStartLoad(context, &info, &load));
    OK(dplGetLoadStatus(load, &status));
    CHECK(status.progress >= 0 && status.progress <= 1);
    OK(dplFinishLoad(load, &avatar));
    CHECK(avatar != NULL && released == 1);
    OK(dplDestroyAvatar(avatar));
    OK(dplStartLoad(context, &info, &load));
    OK(dplCancelLoad(load));
}

static void callDrawing(DplContext context, DplAvatar avatar, DplAvatar other) {
    DplCamera camera = {sizeof camera, kWidth, kHeight, 30, 30, kWidth / 2.0f, kHeight / 2.0f, {1, 0, 0, 0, 0, -1, 0, 1, 0, 0, -1, 3},
                        NULL,          0};
    DplImage image = {sizeof image, 0, pixels, sizeof pixels, 0, depth, kPixels, DPL_FORMAT_RGBA8, NULL, 0};
    DplDetail detail = {sizeof detail, DPL_DETAIL_USUAL, 100};
    DplFrameStats stats = {0};
    DplPassTime time = {0};
    DplAvatar both[2];
    const int middle = (kHeight / 2) * kWidth + kWidth / 2;
    both[0] = avatar, both[1] = other;
    OK(dplRender(context, avatar, &camera, 1, &image));
    CHECK(pixels[4 * middle + 3] > 200 && fabsf(depth[middle] - 3) < 0.5f);
    memset(pixels, 0, sizeof pixels);
    OK(dplDraw(context, avatar, &camera, 1, DPL_DRAW_DEPTH));
    OK(dplReadImages(context, avatar, &image, 1));
    CHECK(pixels[4 * middle + 3] > 200);
    memset(pixels, 0, sizeof pixels);
    OK(dplRenderTogether(context, both, 2, &camera, 1, &image));
    CHECK(pixels[4 * middle + 3] > 200);
    OK(dplDrawTogether(context, both, 2, &camera, 1, 0));
    OK(dplSetDetail(context, &detail));
    OK(dplSetFrameBudget(context, 100));
    OK(dplSetMemoryLimit(context, 0));
    stats.structSize = sizeof stats, time.structSize = sizeof time;
    OK(dplGetFrameStats(avatar, &stats));
    CHECK(stats.viewCount == 1 && stats.splatsDrawn > 0);
    CHECK(dplGetPassTime(avatar, stats.passCount, &time) == DPL_ERROR_NOT_FOUND);
}

static void callConversions(void) {
    const float turn[4] = {0, 0, 0, 1}, place[3] = {1, 2, 3}, angles[4] = {-0.5f, 0.5f, 0.5f, -0.5f}, up[3] = {0, 1, 0};
    const float projection[16] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, -1, -1, 0, 0, -0.1f, 0};
    float outTurn[4], outPlace[3], stored[2];
    DplCamera camera = {0};
    camera.structSize = sizeof camera;
    OK(dplCameraLookAt(place, up, up, 0.8f, 100, 50, &camera));
    CHECK(camera.cx == 50 && camera.cy == 25 && camera.fx == camera.fy);
    OK(dplCameraFromAngles(turn, place, angles, 100, 100, &camera));
    CHECK(fabsf(camera.cx - 50) < 1e-3f);
    OK(dplCameraFromProjection(turn, place, projection, DPL_CLIP_DEPTH_ZERO_TO_ONE, 100, 100, &camera, stored));
    CHECK(fabsf(camera.fx - 50) < 1e-3f);
    OK(dplDepthFromPlanes(0.1f, 100, stored));
    CHECK(fabsf(stored[0] + stored[1] / 0.1f) < 1e-4f && fabsf(stored[0] + stored[1] / 100 - 1) < 1e-4f);
    OK(dplPoseFromAxes(DPL_AXES_UNITY, turn, place, outTurn, outPlace));
    CHECK(outPlace[2] == -3);
    CHECK(dplSecondsBetween(1, 1000000001) == 1);
}

#ifdef WITH_VULKAN
static void callVulkan(DplContext context, DplAvatar avatar) {
    DplVulkanRequirement requirement = {0};
    DplVulkanDevice device = {0};
    DplVulkanPass pass = {0};
    DplVulkanTarget target = {0};
    DplVulkanSubmission how = {0};
    DplVulkanBuffer rows = {0};
    DplWritten written = {sizeof written, 0, 0};
    DplCamera camera = {sizeof camera, kWidth, kHeight, 30, 30, kWidth / 2.0f, kHeight / 2.0f, {1, 0, 0, 0, 0, -1, 0, 1, 0, 0, -1, 3},
                        NULL,          0};
    DplContext none = NULL;
    uint32_t number = 99;
    requirement.structSize = sizeof requirement, device.structSize = sizeof device, pass.structSize = sizeof pass;
    target.structSize = sizeof target, how.structSize = sizeof how;
    OK(dplGetVulkanRequirement(0, &requirement));
    CHECK(requirement.name[0] != 0 && requirement.buys[0] != 0);
    CHECK(dplGetVulkanRequirement(1000, &requirement) == DPL_ERROR_NOT_FOUND);
    CHECK(dplCreateVulkanContext(&device, NULL, &none) == DPL_ERROR_INVALID_ARGUMENT && none == NULL);
    CHECK(dplRebuildVulkan(context, NULL) == DPL_ERROR_INVALID_ARGUMENT);
    CHECK(dplCreateVulkanComposer(context, &pass, &number) != DPL_OK && number == 99);
    CHECK(dplDestroyVulkanComposer(context, 0) != DPL_OK);
    CHECK(dplVulkanPrepare(context, NULL, 0, &avatar, 1, &camera, 1, NULL) == DPL_ERROR_INVALID_ARGUMENT);
    CHECK(dplVulkanUpload(context, NULL, 0) == DPL_ERROR_INVALID_ARGUMENT);
    CHECK(dplVulkanWriteSplats(avatar, NULL, 0, NULL, &rows, &written) == DPL_ERROR_INVALID_ARGUMENT && written.count == 0);
    CHECK(dplVulkanDropSlot(context, DPL_VULKAN_SLOTS) == DPL_ERROR_INVALID_ARGUMENT);
    CHECK(dplVulkanCompose(context, 0, NULL, 0, 0, 0, 0) != DPL_OK);
    CHECK(dplVulkanComposeDepth(context, 0, NULL, 0, 0, 0, 0, 1, -1) != DPL_OK);
    CHECK(dplCreateVulkanTarget(context, &target, &number) != DPL_OK && number == 99);
    CHECK(dplDestroyVulkanTarget(context, 0) != DPL_OK);
    CHECK(dplVulkanSubmit(context, 0, 0, &avatar, 1, &camera, 1, NULL, &how) != DPL_OK);
}
#endif

int main(int argc, char** argv) {
    DplContextInfo info = {0};
    DplAvatarInfo about = {0};
    DplContext context = NULL;
    DplAvatar avatar = NULL, other = NULL;
    const char* name = NULL;
    size_t size = 0;
    FILE* in = argc > 1 ? fopen(argv[1], "rb") : NULL;
    if (!in) return printf("usage: call_everything FILE\n"), 2;
    size = fread(file, 1, sizeof file, in);
    fclose(in);
    OK(dplSetLogCallback(receiveLog, NULL));
    CHECK(dplGetVersion() >> 16 == DPL_VERSION_MAJOR);
    CHECK(strcmp(dplGetResultName(DPL_OK), "DPL_OK") == 0);
    info.structSize = sizeof info, info.renderer = DPL_RENDERER_SOFTWARE, info.threadCount = 1;
    OK(dplCreateContext(&info, &context));
    OK(dplGetRendererName(context, &name));
    CHECK(strstr(name, "software") != NULL);
    OK(dplLoadAvatar(context, file, size, &avatar));
    OK(dplLoadAvatarFile(context, argv[1], &other));
    about.structSize = sizeof about;
    OK(dplGetAvatarInfo(avatar, &about));
    CHECK(about.jointCount > 20 && about.jointCount <= kMostJoints && about.clipCount == 1);
    if (failures == 0) {
        callDrawing(context, avatar, other);
        callPoses(avatar, about.jointCount);
        callSurface(avatar);
        callProject(context, avatar);
        callPosed(avatar);
        callTracker(avatar);
        callLoads(context, size);
        callConversions();
#ifdef WITH_VULKAN
        callVulkan(context, avatar);
#endif
    }
    CHECK(dplRender(context, NULL, NULL, 1, NULL) == DPL_ERROR_INVALID_ARGUMENT && dplGetLastError()[0] != 0 && logged > 0);
    OK(dplDestroyAvatar(other));
    OK(dplDestroyAvatar(avatar));
    OK(dplDestroyContext(context));
    CHECK(released == 2);
    OK(dplSetLogCallback(NULL, NULL));
    if (failures == 0) printf("every exported function was called from C\n");
    return failures != 0;
}
