// SPDX-License-Identifier: Apache-2.0
/* Loads an avatar, poses it by its clip, draws two views, checks the pixel in the middle and writes AVATAR.glb.png. */
#include <doppel/doppel.h>
#include <doppel/doppel_convert.h>
#include <doppel/doppel_png.h>

#include <stdio.h>

static int failed(const char* what) {
    printf("%s: %s\n", what, dplGetLastError());
    return 1;
}

int main(int argc, char** argv) {
    static unsigned char left[64 * 64 * 4], right[64 * 64 * 4];
    static float depth[64 * 64];
    const float eyes[2][3] = {{-0.03f, 1, 3}, {0.03f, 1, 3}}, ahead[2][3] = {{-0.03f, 1, 0}, {0.03f, 1, 0}}, up[3] = {0, 1, 0};
    DplContext context;
    DplAvatar avatar;
    DplAvatarInfo info = {0};
    DplCamera views[2] = {{.structSize = sizeof(DplCamera)}, {.structSize = sizeof(DplCamera)}};
    DplImage images[2] = {{0}};
    char picture[4096];
    size_t middle = (32 * 64 + 32);
    int eye;
    if (argc != 2) return printf("usage: consumer_c AVATAR.glb\n"), 2;
    if (dplCreateContext(NULL, &context) != DPL_OK) return failed("context");
    if (dplLoadAvatarFile(context, argv[1], &avatar) != DPL_OK) return failed("avatar");
    info.structSize = sizeof info;
    if (dplGetAvatarInfo(avatar, &info) != DPL_OK) return failed("info");
    if (dplSetPoseFromClip(avatar, 0, 0.0, DPL_FALSE) != DPL_OK) return failed("clip");
    for (eye = 0; eye < 2; ++eye)
        if (dplCameraLookAt(eyes[eye], ahead[eye], up, 0.98f, 64, 64, &views[eye]) != DPL_OK) return failed("camera");
    images[0].structSize = images[1].structSize = sizeof images[0];
    images[0].rgba = left, images[0].rgbaBytes = sizeof left;
    images[1].rgba = right, images[1].rgbaBytes = sizeof right;
    images[0].depthM = depth, images[0].depthCount = 64 * 64;
    if (dplRender(context, avatar, views, 2, images) != DPL_OK) return failed("render");
    printf("%s: %u joints, %u splats; middle pixel %u %u %u %u at %.2f m\n", info.name, info.jointCount, info.splatCount, left[middle * 4],
           left[middle * 4 + 1], left[middle * 4 + 2], left[middle * 4 + 3], depth[middle]);
    if (left[middle * 4] < 200 || left[middle * 4 + 1] > 20 || left[middle * 4 + 3] < 200) return printf("the middle is not red\n"), 1;
    if (right[middle * 4] < 200 || left[3] != 0) return printf("the right view or the corner is wrong\n"), 1;
    if (depth[middle] < 2.9f || depth[middle] > 3.1f) return printf("the depth is not 3 m\n"), 1;
    if (snprintf(picture, sizeof picture, "%s.png", argv[1]) >= (int)sizeof picture) return printf("the path is too long\n"), 1;
    if (dplWritePng(picture, left, 64, 64) != DPL_OK) return perror(picture), 1;
    if (dplDestroyContext(context) != DPL_OK || dplDestroyAvatar(avatar) != DPL_OK) return failed("destroy");
    return 0;
}
