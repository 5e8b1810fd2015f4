// SPDX-License-Identifier: Apache-2.0
// An empty translation unit, needed to build a precompiled header (DoppelTargets.cmake).
