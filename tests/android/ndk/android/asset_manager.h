// SPDX-License-Identifier: Apache-2.0
// A declaration of what we use of the NDK's android/asset_manager.h, as its public reference documents it.
#pragma once

#include <cstdint>

struct AAssetManager;
struct AAsset;
enum { AASSET_MODE_UNKNOWN = 0, AASSET_MODE_RANDOM = 1, AASSET_MODE_STREAMING = 2, AASSET_MODE_BUFFER = 3 };
extern "C" AAsset* AAssetManager_open(AAssetManager* manager, const char* name, int mode);
extern "C" const void* AAsset_getBuffer(AAsset* asset);
extern "C" int64_t AAsset_getLength64(AAsset* asset);
extern "C" void AAsset_close(AAsset* asset);
