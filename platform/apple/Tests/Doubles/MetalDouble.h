/* SPDX-License-Identifier: Apache-2.0 */
/* Plays the functions of doppel_metal.h on Linux: writes down each call and fails on demand. Contexts are those of the CPU renderer. */
#ifndef METAL_DOUBLE_H
#define METAL_DOUBLE_H

/** The calls since the last look, such as "prepare 0; compose 0; ". Valid until the next call of Doppel. */
const char* doubleTakeCalls(void);
/** Lets the next `times` calls of prepare, rebuild or composer return `result`. */
void doubleFail(const char* call, int result, int times);

#endif
