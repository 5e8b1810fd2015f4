// SPDX-License-Identifier: Apache-2.0
// How the persons of one picture of three.js are drawn (three-group.js): what all groups of a renderer share.
//
//   project each person ─► merge by depth ─► one texture ─► blend behind a copy of the scene's depth ─► onto the scene, then its depth
//
// Colours are blended as in training, in display values, apart from the scene; three encodes them for where it draws. Everything goes
// through three's own targets, materials and state, so a lost context and other users of the renderer are three's business. A frame
// makes no object once targets and texture are large enough.
import {
  BufferGeometry, CustomBlending, DataTexture, DepthFormat, DepthStencilFormat, DepthTexture, DoubleSide, FloatType, GLSL3, HalfFloatType,
  Mesh, MeshBasicMaterial, NearestFilter, OneFactor, OneMinusSrcAlphaFactor, RGBAIntegerFormat, RawShaderMaterial, RedFormat,
  ShaderMaterial, UnsignedByteType, UnsignedInt248Type, UnsignedIntType, UnsignedShortType, Vector2, Vector4, WebGLRenderTarget,
} from 'three';
import { DoppelError, SPLATS_A_ROW } from './doppel.js';
import { FINAL_VERTEX, SAMPLE_X, SAMPLE_Y, SPLAT_FRAGMENT, SPLAT_VERTEX } from './webgl-renderer.js';

const SPLAT_WORDS = 8, DEPTH_WORD = 2, AT_CENTRE = 0x80000000;  // DplScreenSplat; the mark is the sign of its depth
// Depth can be copied only into the same format, and nobody tells that of a canvas: they are tried in this order.
const DEPTHS = [
  [DepthStencilFormat, UnsignedInt248Type], [DepthFormat, UnsignedIntType], [DepthFormat, FloatType], [DepthFormat, UnsignedShortType],
];
const NOTHING = new Float32Array(4), FARTHEST = new Float32Array([1]);
const unsupported = sentence => new DoppelError(sentence, 'DPL_ERROR_UNSUPPORTED');

const blended = { blending: CustomBlending, blendSrc: OneFactor, blendDst: OneMinusSrcAlphaFactor, toneMapped: false, side: DoubleSide };
const uniforms = names => Object.fromEntries(names.map(name => [name, { value: null }]));

/** Draws the picture of the persons over a scene. Opaque, so that three draws it before glass and what is transparent. */
export const paintMaterial = new ShaderMaterial({
  ...blended, depthTest: false, depthWrite: false, uniforms: uniforms(['picture']), vertexShader: FINAL_VERTEX,
  fragmentShader: `
uniform sampler2D picture;
void main() {
  vec4 sum = texelFetch(picture, ivec2(gl_FragCoord.xy), 0);
  if (!(sum.a > 0.0)) discard;
  vec3 display = min(sum.rgb / sum.a, vec3(1.0));
  gl_FragColor = vec4(mix(pow((display + 0.055) / 1.055, vec3(2.4)), display / 12.92, vec3(lessThanEqual(display, vec3(0.04045)))), sum.a);
  #include <colorspace_fragment>
  gl_FragColor.rgb *= gl_FragColor.a;
}`,
});

const splatMaterial = new RawShaderMaterial({
  ...blended, depthWrite: false, glslVersion: GLSL3, defines: { IN_SCENE: '' }, vertexShader: SPLAT_VERTEX, fragmentShader: SPLAT_FRAGMENT,
  uniforms: { ...uniforms(['splats']), first: { value: 0 }, sizePx: { value: new Vector2() }, samplePx: { value: new Vector2() },
    corner: { value: new Vector2() }, clipZ: { value: new Vector2() }, depths: { value: new Vector2() } },
});

// Adds a quarter of one sample to the sum of four.
const sampleMaterial = new RawShaderMaterial({
  ...blended, blendDst: OneFactor, depthTest: false, depthWrite: false, glslVersion: GLSL3, uniforms: uniforms(['picture', 'depth']),
  vertexShader: FINAL_VERTEX, fragmentShader: `
precision highp float;
uniform sampler2D picture, depth;
layout(location = 0) out vec4 colour;
layout(location = 1) out vec4 depthSum;
void main() {
  colour = 0.25 * texelFetch(picture, ivec2(gl_FragCoord.xy), 0);
  depthSum = 0.25 * texelFetch(depth, ivec2(gl_FragCoord.xy), 0);
}`,
});

// The mean depth of the splats of a pixel, where they hide at least half of what lies behind.
const depthMaterial = new RawShaderMaterial({
  colorWrite: false, side: DoubleSide, glslVersion: GLSL3, vertexShader: FINAL_VERTEX,
  uniforms: { ...uniforms(['picture', 'depth']), clipZ: splatMaterial.uniforms.clipZ, depths: splatMaterial.uniforms.depths },
  fragmentShader: `
precision highp float;
uniform sampler2D picture, depth;
uniform vec2 clipZ, depths;
out vec4 colour;
void main() {
  ivec2 at = ivec2(gl_FragCoord.xy);
  float alpha = texelFetch(picture, at, 0).a;
  if (!(alpha >= 0.5)) discard;
  float viewZ = depths.x + texelFetch(depth, at, 0).r / alpha / depths.y;
  gl_FragDepth = 0.5 + 0.5 * (clipZ.x + clipZ.y / viewZ);
  colour = vec4(0.0);
}`,
});
/** Of the mesh that only casts a shadow. */
export const unseenMaterial = new MeshBasicMaterial({ colorWrite: false, depthWrite: false, side: DoubleSide });
const MATERIALS = [paintMaterial, unseenMaterial, splatMaterial, sampleMaterial, depthMaterial];

/** Draws `vertices` vertices that a shader makes of their number. */
const numbered = vertices => {
  const mesh = new Mesh(new BufferGeometry());
  mesh.geometry.setDrawRange(0, vertices);
  return mesh;
};

/** The camera of three for Doppel.project, of a picture of width × height px. */
function cameraOf(camera, width, height, into) {
  const p = camera.projectionMatrix.elements, m = camera.matrixWorldInverse.elements, to = into.viewFromWorld;
  into.width = width, into.height = height;
  into.fx = p[0] * width / 2, into.fy = p[5] * height / 2;
  into.cx = (1 - p[8]) * width / 2, into.cy = (1 + p[9]) * height / 2;
  for (let row = 0; row < 3; ++row)  // three looks along −z with y up, the camera along +z with y down
    for (let column = 0; column < 4; ++column) to[4 * row + column] = (row === 0 ? 1 : -1) * m[4 * column + row];
}

/** Splats of several persons in one order, and textures of them. */
class MergedSplats {
  #words = new Uint32Array(0); #textures = []; #most = 0;
  /** Splats, samples a pixel, view z of the nearest and of the farthest. */
  count = 0; samples = 1; nearest = 0; farthest = 0;

  /** views: {words, at, count, samples} of each person, the farthest splat first; `at` is moved. used: how many of them count. */
  merge(views, used) {
    this.count = 0, this.samples = 1;
    for (let i = 0; i < used; ++i) this.count += views[i].count, this.samples = Math.max(this.samples, views[i].samples);
    if (this.count === 0) return;
    if (this.count * SPLAT_WORDS > this.#words.length) this.#grow();
    const to = this.#words;
    for (let done = 0; done < this.count;) {
      let first = -1, second = -1;  // the farthest next splat, and that of another person
      for (let i = 0; i < used; ++i) {
        const depth = views[i].count > 0 ? views[i].words[views[i].at + DEPTH_WORD] : -1;  // bits of floats above 0 have their order
        if (depth < 0) continue;
        if (first < 0 || depth > views[first].words[views[first].at + DEPTH_WORD]) second = first, first = i;
        else if (second < 0 || depth > views[second].words[views[second].at + DEPTH_WORD]) second = i;
      }
      const view = views[first], { words } = view, until = second < 0 ? 0 : views[second].words[views[second].at + DEPTH_WORD];
      const mark = view.samples < this.samples ? AT_CENTRE : 0;
      do {
        for (let k = 0; k < SPLAT_WORDS; ++k) to[SPLAT_WORDS * done + k] = words[view.at + k];
        if (mark) to[SPLAT_WORDS * done + DEPTH_WORD] |= mark;
        ++done, view.at += SPLAT_WORDS;
      } while (--view.count > 0 && words[view.at + DEPTH_WORD] >= until);
    }
    this.farthest = this.#depth(0), this.nearest = this.#depth(this.count - 1);
  }

  #depth(splat) {
    bits[0] = this.#words[SPLAT_WORDS * splat + DEPTH_WORD] & ~AT_CENTRE;
    return asFloat[0];
  }

  #grow() {
    const rows = Math.ceil(this.count * 1.25 / SPLATS_A_ROW);
    this.#words = new Uint32Array(rows * SPLATS_A_ROW * SPLAT_WORDS);
    this.dispose();
    this.#most = rows;
  }

  /** A texture with the splats, to be uploaded: the smallest of a few that share the memory. */
  texture() {
    const rows = Math.ceil(this.count / SPLATS_A_ROW);
    let level = 0;
    while (this.#most >> (level + 1) >= rows) ++level;
    let texture = this.#textures[level];
    if (!texture) {
      const height = this.#most >> level, width = SPLATS_A_ROW * SPLAT_WORDS / 4;
      texture = new DataTexture(this.#words.subarray(0, 4 * width * height), width, height, RGBAIntegerFormat, UnsignedIntType);
      texture.internalFormat = 'RGBA32UI';
      this.#textures[level] = texture;
    }
    texture.needsUpdate = true;
    return texture;
  }

  dispose() {
    for (const texture of this.#textures) texture?.dispose();
    this.#textures.length = 0;
  }
}
const bits = new Uint32Array(1), asFloat = new Float32Array(bits.buffer);

/** What the groups that one renderer draws share. */
export class ScenePass {
  #renderer; #type; #groups = new Set(); #present = []; #camera = null; #frame = -1;
  #views = []; #splats = new MergedSplats(); #targets = []; #sum = null; #drawn = null;
  #depthOf = new WeakMap(); #depthOfCanvas = -1;  // number in DEPTHS, of a framebuffer
  #seen = { width: 0, height: 0, fx: 0, fy: 0, cx: 0, cy: 0, viewFromWorld: new Array(12).fill(0) };
  #viewport = new Vector4(); #triangle = numbered(3); #triangles = numbered(0);

  constructor(renderer) {
    this.#renderer = renderer;
  }

  /** A group is in the picture that is being drawn. */
  expect(group, camera) {
    const { frame } = this.#renderer.info.render;
    if (this.#camera !== camera || this.#frame !== frame) this.#present.length = 0;
    this.#camera = camera, this.#frame = frame;
    this.#groups.add(group);
    this.#present.push(group);
  }

  /** Draws all groups that are in the picture into a target of their own, from which paintMaterial takes them. False: nothing is to be
   *  painted, as they are painted already, or cannot be seen. */
  prepare(camera) {
    const present = this.#present;
    if (present.length === 0 || camera !== this.#camera) return false;
    let painted = false;
    try {
      painted = this.#draw(camera);
    } catch (error) {
      if (!(error instanceof DoppelError)) throw error;
      for (const group of present) group.tell(error);
    } finally {
      present.length = 0;
    }
    return painted;
  }

  /** After paintMaterial has drawn: writes the depth of the persons. */
  writeDepth(camera) { this.#paint(camera, depthMaterial, this.#drawn); }

  #draw(camera) {
    const renderer = this.#renderer, { x, y, z: width, w: height } = renderer.getCurrentViewport(this.#viewport);
    this.#check(camera);
    if (width < 1 || height < 1) return false;
    cameraOf(camera, width, height, this.#seen);
    const views = this.#project();
    this.#splats.merge(this.#views, views);
    if (this.#splats.count === 0) return false;
    const rows = Math.ceil(this.#splats.count / SPLATS_A_ROW), most = renderer.capabilities.maxTextureSize;
    if (1.25 * rows > most) throw unsupported(`${this.#splats.count} splats are more than this device draws in one picture; see setDetail`);

    const target = renderer.getRenderTarget(), face = renderer.getActiveCubeFace(), level = renderer.getActiveMipmapLevel();
    try {
      this.#setUniforms(camera, x, y, width, height);
      const work = this.#withDepth(x, y, width, height);
      if (this.#splats.samples > 1) this.#blendSamples(camera, work, x, y, width, height);
      else this.#blend(camera, work, 0, 0);
    } finally {
      renderer.setRenderTarget(target, face, level);
      if (camera.viewport !== undefined) renderer.state.viewport(camera.viewport);
    }
    paintMaterial.uniforms.picture.value = this.#drawn.textures[0];
    paintMaterial.uniformsNeedUpdate = true;
    return true;
  }

  #check(camera) {
    const { capabilities } = this.#renderer, p = camera.projectionMatrix.elements;
    if (capabilities.isWebGL2 === false) throw unsupported('persons are drawn by WebGL2 alone');
    if (capabilities.logarithmicDepthBuffer || capabilities.reversedDepthBuffer || capabilities.reverseDepthBuffer)
      throw unsupported('persons cannot be drawn into a logarithmic or reversed depth buffer');
    if (p[11] !== -1 || p[15] !== 0) throw unsupported('persons are drawn for perspective cameras alone');
  }

  /** Projects those that are in the picture. Returns how many of #views are of them. */
  #project() {
    let used = 0;
    for (const group of this.#present) {
      try {
        group.place();
        const made = group.person.project(this.#seen);
        if (used === this.#views.length) this.#views.push({ words: null, at: 0, count: 0, samples: 1 });
        const view = this.#views[used++];
        view.words = made.words, view.at = made.at, view.count = made.counts[0], view.samples = made.samples;
        group.tell(null);
      } catch (error) {
        if (!(error instanceof DoppelError)) throw error;
        group.tell(error);
      }
    }
    return used;
  }

  #setUniforms(camera, x, y, width, height) {
    const p = camera.projectionMatrix.elements, { uniforms: to } = splatMaterial, { nearest, farthest } = this.#splats;
    to.splats.value = this.#splats.texture();
    to.sizePx.value.set(width, height);
    to.corner.value.set(x, y + height);
    to.clipZ.value.set(-p[10], p[14]);
    to.depths.value.set(nearest, 1 / Math.max(1e-3, farthest - nearest));
    this.#triangles.geometry.setDrawRange(0, 3 * this.#splats.count);
  }

  /** Binds a target whose depth is that of the scene in a rectangle, px. */
  #withDepth(x, y, width, height) {
    const gl = this.#renderer.getContext(), scene = gl.getParameter(gl.DRAW_FRAMEBUFFER_BINDING);
    const known = scene ? this.#depthOf.get(scene) ?? -1 : this.#depthOfCanvas;
    if (known >= 0) return this.#copyDepth(gl, scene, known, x, y, width, height);
    for (let tried = 0; tried < DEPTHS.length; ++tried) {
      for (let old = 0; old < 16 && gl.getError(); ++old);
      const work = this.#copyDepth(gl, scene, tried, x, y, width, height), error = gl.getError();
      if (error && error !== gl.CONTEXT_LOST_WEBGL) continue;
      if (scene) this.#depthOf.set(scene, tried);
      else this.#depthOfCanvas = tried;
      return work;
    }
    throw unsupported('the depth of this render target cannot be copied on this device, so persons cannot stand among its meshes');
  }

  #copyDepth(gl, scene, number, x, y, width, height) {
    const work = this.#targets[number] ??= this.#target(number);
    this.#bind(work, x, y, width, height);
    this.#clear(gl);
    gl.clearBufferfv(gl.DEPTH, 0, FARTHEST);  // where the scene has no depth, nothing is copied
    const own = gl.getParameter(gl.DRAW_FRAMEBUFFER_BINDING), right = x + width, top = y + height;
    gl.bindFramebuffer(gl.READ_FRAMEBUFFER, scene);
    gl.blitFramebuffer(x, y, right, top, x, y, right, top, gl.DEPTH_BUFFER_BIT, gl.NEAREST);
    gl.bindFramebuffer(gl.READ_FRAMEBUFFER, own);
    return work;
  }

  /** depth: a number in DEPTHS; below 0: none. Of bytes where the device refuses half floats. */
  #target(depth) {
    const { extensions } = this.#renderer, gl = this.#renderer.getContext();
    const halves = extensions.has('EXT_color_buffer_float') || extensions.has('EXT_color_buffer_half_float');
    this.#type ??= halves ? HalfFloatType : UnsignedByteType;
    const target = new WebGLRenderTarget(1, 1, {
      count: 2, type: this.#type, minFilter: NearestFilter, magFilter: NearestFilter, depthBuffer: depth >= 0,
      stencilBuffer: depth >= 0 && DEPTHS[depth][0] === DepthStencilFormat,
    });
    target.textures[1].format = RedFormat;
    if (depth >= 0) {
      target.depthTexture = new DepthTexture(1, 1, DEPTHS[depth][1]);
      target.depthTexture.format = DEPTHS[depth][0];
    }
    target.scissorTest = true;
    this.#renderer.setRenderTarget(target);
    const drawn = gl.checkFramebufferStatus(gl.FRAMEBUFFER) === gl.FRAMEBUFFER_COMPLETE;
    if (drawn || this.#type === UnsignedByteType || gl.isContextLost()) return target;
    target.depthTexture?.dispose(), target.dispose();
    this.#type = UnsignedByteType;
    return this.#target(depth);
  }

  /** Draws into a target from now on, within a rectangle. */
  #bind(target, x, y, width, height) {
    if (x + width > target.width || y + height > target.height)
      target.setSize(Math.max(target.width, x + width), Math.max(target.height, y + height));
    target.viewport.set(x, y, width, height);
    target.scissor.copy(target.viewport);
    this.#renderer.setRenderTarget(target);
  }

  #clear(gl) {
    const { color, depth } = this.#renderer.state.buffers;
    color.setMask(true);
    depth.setMask(true);
    gl.clearBufferfv(gl.COLOR, 0, NOTHING);
    gl.clearBufferfv(gl.COLOR, 1, NOTHING);
  }

  /** Blends the splats into the target that is bound. */
  #blend(camera, target, sampleX, sampleY) {
    splatMaterial.uniforms.samplePx.value.set(sampleX, sampleY);
    splatMaterial.uniformsNeedUpdate = true;
    this.#renderer.renderBufferDirect(camera, null, this.#triangles.geometry, splatMaterial, this.#triangles, null);
    this.#drawn = target;
  }

  /** Blends each sample in `work`, and their mean into another target. */
  #blendSamples(camera, work, x, y, width, height) {
    const gl = this.#renderer.getContext();
    this.#sum ??= this.#target(-1);
    for (let k = 0; k < this.#splats.samples; ++k) {
      this.#bind(work, x, y, width, height);
      if (k > 0) this.#clear(gl);
      this.#blend(camera, work, SAMPLE_X[k], SAMPLE_Y[k]);
      this.#bind(this.#sum, x, y, width, height);
      if (k === 0) this.#clear(gl);
      this.#paint(camera, sampleMaterial, work);
    }
    this.#drawn = this.#sum;
  }

  #paint(camera, material, from) {
    material.uniforms.picture.value = from.textures[0], material.uniforms.depth.value = from.textures[1];
    material.uniformsNeedUpdate = true;
    this.#renderer.renderBufferDirect(camera, null, this.#triangle.geometry, material, this.#triangle, null);
  }

  /** A group is gone. With the last one goes all that the device holds. */
  leave(group) {
    this.#groups.delete(group);
    if (this.#groups.size > 0) return;
    for (const target of [...this.#targets, this.#sum]) target?.depthTexture?.dispose(), target?.dispose();
    this.#targets.length = 0, this.#sum = this.#drawn = null;
    this.#splats.dispose();
    this.#triangle.geometry.dispose(), this.#triangles.geometry.dispose();
    for (const material of MATERIALS) material.dispose();  // another renderer makes its programs anew
  }
}
