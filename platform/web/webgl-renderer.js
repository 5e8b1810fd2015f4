// SPDX-License-Identifier: Apache-2.0
// Draws on a canvas by WebGL2 what the module has posed, culled, projected and sorted.
//
//   Doppel.project ─► one upload into a texture ─► a triangle a splat, farthest first, blended into RGBA16F ─► final pass ─► canvas
//
// Farthest first, as the engine's own quads on GPUs (shaders/passes/draw): near splats come last, so they weaken what rounding did to the
// sums below them. Nearest first would add the last splats to an alpha near 1, where half floats are 5e-4 apart.
// α of a splat at a pixel: doppel_splats.h. A frame neither allocates nor asks WebGL2 for anything that makes it wait.
import { DoppelError, SPLATS_A_ROW } from './doppel.js';

// Coverage samples: sdk/math/formulas/constants.h. From the centre of the pixel, px.
export const SAMPLE_X = [-0.125, 0.375, -0.375, 0.125], SAMPLE_Y = [-0.375, -0.125, 0.125, 0.375];
const MOST_LAYERS = 4;

// IN_SCENE (three-group.js): within the depth of a scene, upside up, and with a second target for the mean depth.
export const SPLAT_VERTEX = `
precision highp float;
precision highp int;
precision highp usampler2D;
uniform usampler2D splats;  // two texels a splat
uniform vec2 sizePx, samplePx;
uniform int first;
flat out vec4 centreForm;   // centre px; -½ log₂e conicA; slope
flat out vec2 formOpacity;  // -½ log₂e inverseVarianceY; log₂ opacity
flat out vec3 rgb;
#ifdef IN_SCENE
uniform vec2 clipZ, depths;  // z of clip space: x + y / view z; depth: x is 0, 1 / y more is 1
flat out float depth;
#endif
void main() {
  const float log2e = 1.4426950408889634;
  int splat = first + gl_VertexID / 3, corner = gl_VertexID % 3;
  ivec2 at = ivec2(2 * (splat % ${SPLATS_A_ROW}), splat / ${SPLATS_A_ROW});
  uvec4 a = texelFetch(splats, at, 0), b = texelFetch(splats, at + ivec2(1, 0), 0);
  vec2 centre = uintBitsToFloat(a.xy), shape = uintBitsToFloat(b.xy);
  float conicA = uintBitsToFloat(a.w), slope = shape.x, inverseVarianceY = shape.y;
  float opacity = float(b.w >> 16) / 65535.0;
#ifdef IN_SCENE
  float viewZ = abs(uintBitsToFloat(a.z));
  depth = (viewZ - depths.x) * depths.y;
  if (a.z >> 31 == 0u)
#endif
  centre -= samplePx;
  rgb = vec3(b.z & 65535u, b.z >> 16, b.w & 65535u) / 65535.0;
  centreForm = vec4(centre, -0.5 * log2e * conicA, slope);
  formOpacity = vec2(-0.5 * log2e * inverseVarianceY, log2(opacity));
  // Standard deviations at which α falls to 1/255; a little more, because triangles snap to a grid within the pixel.
  float reach = sqrt(max(0.0, 2.0 * log(255.0 * opacity))) + 0.02;
  float deviationY = inversesqrt(inverseVarianceY), acrossX = inversesqrt(conicA);
  vec2 radius = reach * vec2(sqrt(acrossX * acrossX + slope * slope * deviationY * deviationY), deviationY);
  vec2 px;
  if (radius.x < sizePx.x && radius.y < sizePx.y) {  // the smallest triangle around the unit circle, mapped to the ellipse
    vec2 around = reach * (corner == 0 ? vec2(0.0, 2.0) : vec2(corner == 1 ? 1.7320509 : -1.7320509, -1.0));
    px = centre + vec2(acrossX * around.x - slope * deviationY * around.y, deviationY * around.y);
  } else {  // around the bounding box, clipped to the picture
    vec2 low = clamp(centre - radius, vec2(0.0), sizePx), high = clamp(centre + radius, vec2(0.0), sizePx);
    px = low + 2.0 * (high - low) * vec2(corner == 1 ? 1.0 : 0.0, corner == 2 ? 1.0 : 0.0);
  }
  gl_Position = vec4(2.0 * px / sizePx - 1.0, 0.0, 1.0);  // top row first, so gl_FragCoord has its origin at the top left
#ifdef IN_SCENE
  gl_Position.yz = vec2(-gl_Position.y, clipZ.x + clipZ.y / viewZ);
#endif
}`;

export const SPLAT_FRAGMENT = `
precision highp float;
flat in vec4 centreForm;
flat in vec2 formOpacity;
flat in vec3 rgb;
#ifdef IN_SCENE
uniform vec2 corner;  // upper left, in the target
flat in float depth;
layout(location = 0) out vec4 colour;
layout(location = 1) out vec4 depthSum;
#else
const vec2 corner = vec2(0.0);
out vec4 colour;
#endif
void main() {
  vec2 d = abs(gl_FragCoord.xy - corner) - centreForm.xy;  // the picture lies below the corner of a scene, above that of a texture
  float across = d.x + centreForm.w * d.y;
  float alpha = min(0.99, exp2(formOpacity.y + centreForm.z * across * across + formOpacity.x * d.y * d.y));
  if (!(alpha >= 1.0 / 255.0)) discard;
  colour = vec4(rgb * alpha, alpha);
#ifdef IN_SCENE
  depthSum = vec4(depth * alpha, 0.0, 0.0, alpha);
#endif
}`;

export const FINAL_VERTEX = `
void main() { gl_Position = vec4(gl_VertexID == 1 ? 3.0 : -1.0, gl_VertexID == 2 ? 3.0 : -1.0, 0.0, 1.0); }`;

// The mean of the samples, upside up. origin: of the picture on the canvas.
const FINAL_FRAGMENT = `
precision highp float;
precision highp sampler2DArray;
uniform sampler2DArray picture;
uniform ivec2 origin;
uniform int samples;
out vec4 colour;
void main() {
  ivec2 at = ivec2(gl_FragCoord.xy) - origin;
  at.y = textureSize(picture, 0).y - 1 - at.y;
  colour = texelFetch(picture, ivec3(at, 0), 0);
  for (int k = 1; k < samples; ++k) colour += texelFetch(picture, ivec3(at, k), 0);
  colour /= float(samples);
}`;

const unsupported = sentence => new DoppelError(sentence, 'DPL_ERROR_UNSUPPORTED');

function programOf(gl, vertex, fragment) {
  const program = gl.createProgram();
  for (const [type, source] of [[gl.VERTEX_SHADER, vertex], [gl.FRAGMENT_SHADER, fragment]]) {
    const shader = gl.createShader(type);
    gl.shaderSource(shader, `#version 300 es${source}`);
    gl.compileShader(shader);
    gl.attachShader(program, shader);
    gl.deleteShader(shader);
  }
  gl.linkProgram(program);
  if (gl.getProgramParameter(program, gl.LINK_STATUS) || gl.isContextLost()) return program;
  const logs = gl.getAttachedShaders(program).map(shader => gl.getShaderInfoLog(shader)).join(' ');
  throw unsupported(`the shaders do not compile on this device: ${logs} ${gl.getProgramInfoLog(program)}`.trim());
}

/** Blends projected splats into the framebuffer that is bound. Sets the state that it needs and restores none: blending, no depth test, no
 *  culling, no scissor, its program, no vertex array, texture unit 0. */
export class SplatBlender {
  #gl; #program; #texture; #rows = 0; #vertices; #sizePx; #samplePx; #first;
  /** Bytes of the last upload. */
  uploadedBytes = 0;

  constructor(gl) {
    this.#gl = gl;
    this.#program = programOf(gl, SPLAT_VERTEX, SPLAT_FRAGMENT);
    this.#sizePx = gl.getUniformLocation(this.#program, 'sizePx');
    this.#samplePx = gl.getUniformLocation(this.#program, 'samplePx');
    this.#first = gl.getUniformLocation(this.#program, 'first');
    this.#vertices = gl.createVertexArray();
  }

  /** Uploads what Doppel.project returned. */
  upload(projection) {
    const gl = this.#gl, { rows } = projection;
    this.uploadedBytes = rows * SPLATS_A_ROW * 32;
    gl.activeTexture(gl.TEXTURE0);
    if (rows > this.#rows) this.#grow(rows);
    gl.bindTexture(gl.TEXTURE_2D, this.#texture);
    if (rows === 0) return;
    gl.bindBuffer(gl.PIXEL_UNPACK_BUFFER, null);
    gl.pixelStorei(gl.UNPACK_FLIP_Y_WEBGL, false);
    gl.pixelStorei(gl.UNPACK_ALIGNMENT, 4);
    gl.texSubImage2D(gl.TEXTURE_2D, 0, 0, 0, 2 * SPLATS_A_ROW, rows, gl.RGBA_INTEGER, gl.UNSIGNED_INT, projection.words, projection.at);
  }

  #grow(rows) {
    const gl = this.#gl, most = gl.getParameter(gl.MAX_TEXTURE_SIZE);
    if (rows > most) throw unsupported(`${rows * SPLATS_A_ROW} splats; this device draws ${most * SPLATS_A_ROW} (see setDetail)`);
    gl.deleteTexture(this.#texture);
    this.#rows = Math.min(most, rows + (rows >> 2));
    this.#texture = gl.createTexture();
    gl.bindTexture(gl.TEXTURE_2D, this.#texture);
    gl.texStorage2D(gl.TEXTURE_2D, 1, gl.RGBA32UI, 2 * SPLATS_A_ROW, this.#rows);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MIN_FILTER, gl.NEAREST);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MAG_FILTER, gl.NEAREST);
  }

  /** Draws `count` of the uploaded splats from number `first` on, into a picture of width × height px whose top row is first, over what is
   *  there. sampleX, sampleY: where in a pixel, px from its centre. After upload(). */
  blend(first, count, width, height, sampleX = 0, sampleY = 0) {
    if (count === 0) return;
    const gl = this.#gl;
    gl.useProgram(this.#program);
    gl.bindVertexArray(this.#vertices);
    gl.activeTexture(gl.TEXTURE0);
    gl.bindTexture(gl.TEXTURE_2D, this.#texture);
    gl.disable(gl.DEPTH_TEST);
    gl.disable(gl.CULL_FACE);
    gl.disable(gl.SCISSOR_TEST);
    gl.enable(gl.BLEND);
    gl.blendEquation(gl.FUNC_ADD);
    gl.blendFunc(gl.ONE, gl.ONE_MINUS_SRC_ALPHA);
    gl.uniform2f(this.#sizePx, width, height);
    gl.uniform2f(this.#samplePx, sampleX, sampleY);
    gl.uniform1i(this.#first, first);
    gl.drawArrays(gl.TRIANGLES, 0, 3 * count);
  }

  dispose() {
    this.#gl.deleteProgram(this.#program);
    this.#gl.deleteTexture(this.#texture);
    this.#gl.deleteVertexArray(this.#vertices);
  }
}

/** Pictures of persons on a canvas. It takes the canvas: no other context can be made of it. */
export class SplatRenderer {
  #canvas; #gl; #blender; #final; #origin; #samplesAt; #empty; #format; #picture = null; #layers = 0; #width = 0; #height = 0;
  #framebuffers = []; #samples = 1; #onLost; #onRestored;
  #lose = event => {
    event.preventDefault();  // else the browser never gives it back
    this.#onLost?.();
  };
  #restore = () => {
    this.#build();
    this.#onRestored?.();
  };

  /** onLost(): the browser took the graphics device away; draw() draws nothing. onRestored(): draw again. xrCompatible: for
   *  XRWebGLLayer. DoppelError with code DPL_ERROR_UNSUPPORTED where there is no WebGL2 or it cannot draw this. */
  constructor(canvas, { onLost, onRestored, xrCompatible = false } = {}) {
    this.#canvas = canvas, this.#onLost = onLost, this.#onRestored = onRestored;
    this.#gl = canvas.getContext('webgl2', {
      alpha: true, premultipliedAlpha: true, antialias: false, depth: false, stencil: false, xrCompatible,
    });
    if (!this.#gl) throw unsupported('this browser or device has no WebGL2');
    this.#build();
    canvas.addEventListener('webglcontextlost', this.#lose);
    canvas.addEventListener('webglcontextrestored', this.#restore);
  }

  /** 'RGBA16F', or 'RGBA8' where the device refuses float targets: rounding after every splat then costs 9 to 27 dB (tests/web). */
  get target() { return this.#format === this.#gl.RGBA16F ? 'RGBA16F' : 'RGBA8'; }
  get lost() { return this.#gl.isContextLost(); }
  /** The WebGL2RenderingContext of the canvas. */
  get context() { return this.#gl; }
  /** Bytes that the last frame sent to the graphics device. */
  get uploadedBytes() { return this.#blender.uploadedBytes; }

  #build() {
    const gl = this.#gl;
    this.#picture = null;
    this.#layers = this.#width = this.#height = 0;
    this.#framebuffers.length = 0;
    this.#blender = new SplatBlender(gl);
    this.#final = programOf(gl, FINAL_VERTEX, FINAL_FRAGMENT);
    this.#origin = gl.getUniformLocation(this.#final, 'origin');
    this.#samplesAt = gl.getUniformLocation(this.#final, 'samples');
    this.#empty = gl.createVertexArray();
    const floats = gl.getExtension('EXT_color_buffer_float') || gl.getExtension('EXT_color_buffer_half_float');
    this.#format = floats ? gl.RGBA16F : gl.RGBA8;
    if (this.#resize(1, 1, 1)) return;
    this.#format = gl.RGBA8;
    this.#width = 0;
    if (!this.#resize(1, 1, 1)) throw unsupported('this device draws into no texture');
  }

  /** Makes the targets of a picture: one layer a sample. False: the device refuses them. */
  #resize(width, height, layers) {
    if (width === this.#width && height === this.#height && layers <= this.#layers) return true;
    const gl = this.#gl;
    for (const framebuffer of this.#framebuffers) gl.deleteFramebuffer(framebuffer);
    gl.deleteTexture(this.#picture);
    this.#framebuffers.length = 0;
    this.#picture = gl.createTexture();
    gl.activeTexture(gl.TEXTURE0);
    gl.bindTexture(gl.TEXTURE_2D_ARRAY, this.#picture);
    gl.texStorage3D(gl.TEXTURE_2D_ARRAY, 1, this.#format, width, height, layers);
    gl.texParameteri(gl.TEXTURE_2D_ARRAY, gl.TEXTURE_MIN_FILTER, gl.NEAREST);
    gl.texParameteri(gl.TEXTURE_2D_ARRAY, gl.TEXTURE_MAG_FILTER, gl.NEAREST);
    for (let k = 0; k < layers; ++k) {
      const framebuffer = gl.createFramebuffer();
      this.#framebuffers.push(framebuffer);
      gl.bindFramebuffer(gl.FRAMEBUFFER, framebuffer);
      gl.framebufferTextureLayer(gl.FRAMEBUFFER, gl.COLOR_ATTACHMENT0, this.#picture, 0, k);
    }
    this.#width = width, this.#height = height, this.#layers = layers;
    return gl.isContextLost() || gl.checkFramebufferStatus(gl.FRAMEBUFFER) === gl.FRAMEBUFFER_COMPLETE;
  }

  /** Draws a person, posed, onto the transparent canvas, which gets the size of the camera. False: the graphics device is lost. Errors of
   *  Doppel.project. */
  draw(person, camera) {
    if (this.lost) return false;
    const { width, height } = camera, made = person.project(camera);
    if (this.#canvas.width !== width || this.#canvas.height !== height) this.#canvas.width = width, this.#canvas.height = height;
    this.#blender.upload(made);
    this.#blendView(made, 0, width, height);
    this.#show(null, 0, 0);
    return true;
  }

  // [not in pages]
  /** Draws one or two views into another framebuffer of this context, each replacing a rectangle there; webxr.js calls it. right,
   *  rightAt: null for one view. leftAt, rightAt: {x, y}, lower left corners, px. Returns as draw(). */
  drawEyes(person, left, right, framebuffer, leftAt, rightAt) {
    if (this.lost) return false;
    const made = person.project(left, right);
    this.#blender.upload(made);
    for (let view = 0; view < (right ? 2 : 1); ++view) {
      this.#blendView(made, view, left.width, left.height);
      const at = view === 0 ? leftAt : rightAt;
      this.#show(framebuffer, at.x, at.y);
    }
    return true;
  }

  // [in pages]
  /** Blends the splats of view 0 or 1 into the layers. */
  #blendView(made, view, width, height) {
    const gl = this.#gl, first = view === 0 ? 0 : made.counts[0];
    this.#samples = made.samples;
    if (!this.#resize(width, height, made.samples > 1 ? MOST_LAYERS : 1)) {
      this.#width = 0;
      throw unsupported(`this device cannot draw pictures of ${width} × ${height} pixels`);
    }
    gl.viewport(0, 0, width, height);
    for (let k = 0; k < made.samples; ++k) {
      gl.bindFramebuffer(gl.FRAMEBUFFER, this.#framebuffers[k]);
      gl.disable(gl.SCISSOR_TEST);
      gl.clearColor(0, 0, 0, 0);
      gl.clear(gl.COLOR_BUFFER_BIT);
      this.#blender.blend(first, made.counts[view], width, height, made.samples > 1 ? SAMPLE_X[k] : 0, made.samples > 1 ? SAMPLE_Y[k] : 0);
    }
  }

  /** Writes the picture to a framebuffer at x, y, which count from its lower left corner. */
  #show(framebuffer, x, y) {
    const gl = this.#gl;
    gl.bindFramebuffer(gl.FRAMEBUFFER, framebuffer);
    gl.viewport(x, y, this.#width, this.#height);
    gl.disable(gl.BLEND);
    gl.useProgram(this.#final);
    gl.bindVertexArray(this.#empty);
    gl.activeTexture(gl.TEXTURE0);
    gl.bindTexture(gl.TEXTURE_2D_ARRAY, this.#picture);
    gl.uniform2i(this.#origin, x, y);
    gl.uniform1i(this.#samplesAt, this.#samples);
    gl.drawArrays(gl.TRIANGLES, 0, 3);
  }

  /** The last picture, as Doppel.draw gives it: 4 bytes a pixel, premultiplied, top row first. Waits for the device. */
  read() {
    const gl = this.#gl, width = this.#width, height = this.#height, row = width * 4;
    const upsideDown = new Uint8Array(row * height), rgba = new Uint8ClampedArray(row * height);
    this.#show(null, 0, 0);
    gl.bindFramebuffer(gl.FRAMEBUFFER, null);
    gl.readPixels(0, 0, width, height, gl.RGBA, gl.UNSIGNED_BYTE, upsideDown);
    for (let y = 0; y < height; ++y) rgba.set(upsideDown.subarray((height - 1 - y) * row, (height - y) * row), y * row);
    return rgba;
  }

  /** Gives the graphics device back: browsers keep few contexts. */
  dispose() {
    this.#canvas.removeEventListener('webglcontextlost', this.#lose);
    this.#canvas.removeEventListener('webglcontextrestored', this.#restore);
    this.#onLost = this.#onRestored = null;
    this.#gl.getExtension('WEBGL_lose_context')?.loseContext();
  }
}
