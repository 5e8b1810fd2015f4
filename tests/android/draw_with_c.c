/* SPDX-License-Identifier: Apache-2.0 */
/* Draws an avatar by the C API alone, for comparison: draw_with_c AVATAR RENDERER OUT. One picture of 96 x 128 pixels, RGBA, premultiplied,
 * half-way through the avatar's first clip. */
#include <doppel/doppel.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

int main(int argc, char** argv) {
    static uint8_t pixels[128 * 96 * 4];
    const DplCamera camera = {sizeof camera, 96, 128, 120, 120, 48, 64, {1, 0, 0, 0, 0, -1, 0, 1.2f, 0, 0, -1, 2}, NULL, 0};
    const DplImage image = {sizeof image, 0, pixels, sizeof pixels, 0, NULL, 0, DPL_FORMAT_RGBA8, NULL, 0};
    DplContextInfo info;
    DplContext context = 0;
    DplAvatar avatar = 0;
    FILE* file = argc == 4 ? fopen(argv[1], "rb") : NULL;
    uint8_t* bytes = malloc(1u << 20);
    size_t size = 0;
    DplResult result;
    if (!file || !bytes) return 2;
    size = fread(bytes, 1, 1u << 20, file);
    fclose(file);
    memset(&info, 0, sizeof info);
    info.structSize = sizeof info;
    info.renderer = (DplRenderer)atoi(argv[2]);
    info.fill = DPL_FILL_QUADS;
    result = dplCreateContext(&info, &context);
    if (result == DPL_OK) result = dplLoadAvatar(context, bytes, size, &avatar);
    if (result == DPL_OK) result = dplSetPoseFromClip(avatar, 0, 0.5, DPL_TRUE);
    if (result == DPL_OK) result = dplRender(context, avatar, &camera, 1, &image);
    if (result != DPL_OK) fprintf(stderr, "%s\n", dplGetLastError());
    dplDestroyAvatar(avatar);
    dplDestroyContext(context);
    free(bytes);
    file = result == DPL_OK ? fopen(argv[3], "wb") : NULL;
    if (!file || fwrite(pixels, sizeof pixels, 1, file) != 1 || fclose(file) != 0) return 1;
    return 0;
}
