// SPDX-License-Identifier: Apache-2.0
/* Writes a picture as a PNG file, so that a first program needs no other library to show what it drew. It is a helper for debugging, not a
 * codec: nothing is compressed, so a file is a little larger than its pixels. C99 and C++; all functions are static inline, and no symbol
 * of the library is used. DPL_EXPERIMENTAL, as the functions of doppel.h so marked: it may change in a minor version. */
#ifndef DOPPEL_DOPPEL_PNG_H
#define DOPPEL_DOPPEL_PNG_H

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <doppel/doppel.h>

#ifdef __cplusplus
extern "C" {
#endif

/** Used by dplWritePng: a file, and the checksums of what was written to it. */
struct dplPngOut {
    FILE* file;
    uint32_t crc;                 /**< of the chunk, before its last inversion */
    uint32_t adlerLow, adlerHigh; /**< of the rows */
    uint32_t rowBytesLeft;        /**< of all rows together, still to be written */
    uint32_t blockBytesLeft;      /**< of them, in the block at hand */
};

/** Used by dplWritePng: writes bytes of a chunk. Errors stay in the file's error flag. */
static inline void dplPngPut(struct dplPngOut* out, const uint8_t* bytes, size_t count) {
    /* The CRC of four bits; polynomial 0xedb88320. */
    static const uint32_t kCrc[16] = {0x00000000, 0x1db71064, 0x3b6e20c8, 0x26d930ac, 0x76dc4190, 0x6b6b51f4, 0x4db26158, 0x5005713c,
                                      0xedb88320, 0xf00f9344, 0xd6d6a3e8, 0xcb61b38c, 0x9b64c2b0, 0x86d3d2d4, 0xa00ae278, 0xbdbdf21c};
    uint32_t crc = out->crc;
    size_t i;
    for (i = 0; i < count; ++i) {
        crc = crc >> 4 ^ kCrc[(crc ^ bytes[i]) & 15];
        crc = crc >> 4 ^ kCrc[(crc ^ (uint32_t)bytes[i] >> 4) & 15];
    }
    out->crc = crc;
    fwrite(bytes, 1, count, out->file);
}

/** Used by dplWritePng: writes a number, most significant byte first. */
static inline void dplPngNumber(struct dplPngOut* out, uint32_t number) {
    uint8_t bytes[4];
    bytes[0] = (uint8_t)(number >> 24), bytes[1] = (uint8_t)(number >> 16 & 255);
    bytes[2] = (uint8_t)(number >> 8 & 255), bytes[3] = (uint8_t)(number & 255);
    dplPngPut(out, bytes, 4);
}

/** Used by dplWritePng: begins a chunk. type: four letters. */
static inline void dplPngBegin(struct dplPngOut* out, const char* type, uint32_t bytes) {
    dplPngNumber(out, bytes);
    out->crc = 0xffffffffu;
    dplPngPut(out, (const uint8_t*)type, 4);
}

/** Used by dplWritePng: ends a chunk. */
static inline void dplPngEnd(struct dplPngOut* out) {
    dplPngNumber(out, out->crc ^ 0xffffffffu);
}

/** Used by dplWritePng: writes bytes of rows, cut into blocks of at most 65,535 bytes as deflate stores them. */
static inline void dplPngRow(struct dplPngOut* out, const uint8_t* bytes, size_t count) {
    size_t i, part;
    for (i = 0; i < count; ++i) {
        out->adlerLow = (out->adlerLow + bytes[i]) % 65521;
        out->adlerHigh = (out->adlerHigh + out->adlerLow) % 65521;
    }
    for (; count > 0; bytes += part, count -= part) {
        if (out->blockBytesLeft == 0) {
            uint8_t head[5];
            out->blockBytesLeft = out->rowBytesLeft < 65535 ? out->rowBytesLeft : 65535;
            head[0] = out->blockBytesLeft == out->rowBytesLeft; /* the last block */
            head[1] = (uint8_t)(out->blockBytesLeft & 255), head[2] = (uint8_t)(out->blockBytesLeft >> 8);
            head[3] = (uint8_t)(head[1] ^ 255), head[4] = (uint8_t)(head[2] ^ 255);
            dplPngPut(out, head, 5);
        }
        part = count < out->blockBytesLeft ? count : out->blockBytesLeft;
        dplPngPut(out, bytes, part);
        out->blockBytesLeft -= (uint32_t)part, out->rowBytesLeft -= (uint32_t)part;
    }
}

/** Used by dplWritePng: writes the whole picture. */
static inline void dplPngPicture(FILE* file, const uint8_t* rgba, uint32_t widthPx, uint32_t heightPx) {
    static const uint8_t kSignature[8] = {0x89, 'P', 'N', 'G', '\r', '\n', 0x1a, '\n'};
    static const uint8_t kFormat[5] = {8, 6, 0, 0, 0}; /* bits, RGBA, deflate, filters of rows, not interlaced */
    static const uint8_t kDeflate[2] = {0x78, 0x01}, kNoFilter = 0;
    struct dplPngOut out;
    uint32_t y;
    memset(&out, 0, sizeof out);
    out.file = file;
    out.adlerLow = 1;
    out.rowBytesLeft = (1 + 4 * widthPx) * heightPx;
    dplPngPut(&out, kSignature, 8);
    dplPngBegin(&out, "IHDR", 13);
    dplPngNumber(&out, widthPx);
    dplPngNumber(&out, heightPx);
    dplPngPut(&out, kFormat, 5);
    dplPngEnd(&out);
    dplPngBegin(&out, "IDAT", 2 + out.rowBytesLeft + (out.rowBytesLeft + 65534) / 65535 * 5 + 4);
    dplPngPut(&out, kDeflate, 2);
    for (y = 0; y < heightPx; ++y) {
        dplPngRow(&out, &kNoFilter, 1);
        dplPngRow(&out, rgba + (size_t)y * widthPx * 4, (size_t)widthPx * 4);
    }
    dplPngNumber(&out, out.adlerHigh << 16 | out.adlerLow);
    dplPngEnd(&out);
    dplPngBegin(&out, "IEND", 0);
    dplPngEnd(&out);
}

/** Writes pixels of DPL_FORMAT_RGBA8 with DPL_IMAGE_STRAIGHT_ALPHA, as dplRender gives them, to a PNG file. A file of this name is
 * replaced. It is written beside it first, as path.part, and then renamed: whoever looks sees the old file or the whole new one, but on
 * Windows, for a moment, none. path: as for fopen. rgba: 4·widthPx·heightPx bytes, rows without padding, top row first. Any thread.
 *  DPL_ERROR_INVALID_ARGUMENT: NULL, or a side of 0 or above DPL_MAX_IMAGE_SIDE_PX. DPL_ERROR_IO: the file cannot be written; errno says
 * why. DPL_ERROR_OUT_OF_MEMORY: for the other name. dplGetLastError says nothing about these errors. */
static inline DplResult dplWritePng(const char* path, const uint8_t* rgba, uint32_t widthPx, uint32_t heightPx) {
    char* part;
    FILE* file;
    int failed, reason;
    if (!path || !rgba || widthPx == 0 || heightPx == 0 || widthPx > DPL_MAX_IMAGE_SIDE_PX || heightPx > DPL_MAX_IMAGE_SIDE_PX)
        return DPL_ERROR_INVALID_ARGUMENT;
    part = (char*)malloc(strlen(path) + sizeof ".part");
    if (!part) return DPL_ERROR_OUT_OF_MEMORY;
    strcpy(part, path);
    strcat(part, ".part");
    file = fopen(part, "wb");
    failed = file == NULL;
    reason = errno;
    if (file) {
        dplPngPicture(file, rgba, widthPx, heightPx);
        failed = ferror(file);
        reason = errno;
        if (fclose(file) != 0 && !failed) failed = 1, reason = errno;
#ifdef _WIN32
        if (!failed) remove(path); /* rename replaces nothing there */
#endif
        if (!failed && rename(part, path) != 0) failed = 1, reason = errno;
        if (failed) remove(part);
    }
    free(part);
    if (failed) errno = reason;
    return failed ? DPL_ERROR_IO : DPL_OK;
}

#ifdef __cplusplus
}
#endif
#endif
