// SPDX-License-Identifier: Apache-2.0
// Declares and reads buffers that a kernel only reads: words, pairs or fours of words. DPL_TEXELS: as typed buffers, which a Vulkan
// driver on the CPU gathers eight lanes at a time, where it reads a plain buffer lane by lane (DeviceInfo::texels). shaderpack builds
// NAME.texels beside every kernel NAME that uses this file. Both give the same bytes.
#ifdef DPL_TEXELS
#define DPL_WORDS(number, block, name) layout(r32ui, binding = number) uniform readonly uimageBuffer name
#define DPL_PAIRS(number, block, name) layout(rg32ui, binding = number) uniform readonly uimageBuffer name
#define DPL_FOURS(number, block, name) layout(rgba32ui, binding = number) uniform readonly uimageBuffer name
#define DPL_WORD(name, at) imageLoad(name, int(at)).x
#define DPL_PAIR(name, at) imageLoad(name, int(at)).xy
#define DPL_FOUR(name, at) imageLoad(name, int(at))
#else
#define DPL_WORDS(number, block, name) layout(std430, binding = number) readonly buffer block { uint name[]; }
#define DPL_PAIRS(number, block, name) layout(std430, binding = number) readonly buffer block { uvec2 name[]; }
#define DPL_FOURS(number, block, name) layout(std430, binding = number) readonly buffer block { uvec4 name[]; }
#define DPL_WORD(name, at) name[at]
#define DPL_PAIR(name, at) name[at]
#define DPL_FOUR(name, at) name[at]
#endif
vec4 dplFloats(uvec4 bits) { return uintBitsToFloat(bits); }
