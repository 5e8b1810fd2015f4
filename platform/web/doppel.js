// SPDX-License-Identifier: Apache-2.0
// Doppel in browsers and in Node: loads a person, poses them, draws them. An ES module without dependencies; doppel.wasm lies beside it.
//
//   import { Doppel } from './doppel.js';
//   const ada = await Doppel.load('ada.glb');
//   ada.setClip(0, 1.25);
//   const camera = ada.lookAt({ eye: [0, 1, 3], target: [0, 1, 0], width: 512, height: 768 });
//   context2d.putImageData(new ImageData(ada.draw(camera, { straight: true }), 512, 768), 0, 0);
//
// Units and frames are those of the C API (doppel.h): metres, seconds, radians; +Y up, the person faces +Z; quaternions are x, y, z, w.
// Each person has an instance of the module, and so memory of their own, which ends with the person. The module is compiled once.

/** What went wrong, in a sentence of the library. `code`: a name such as 'DPL_ERROR_CORRUPT_DATA'; 'NETWORK' where a file did not come. */
export class DoppelError extends Error {
  constructor(message, code) {
    super(message);
    this.name = 'DoppelError';
    this.code = code;
  }
}

const RESULTS = ['DPL_OK', 'DPL_ERROR_INVALID_ARGUMENT', 'DPL_ERROR_NOT_FOUND', 'DPL_ERROR_CORRUPT_DATA', 'DPL_ERROR_VERSION',
  'DPL_ERROR_UNSUPPORTED', 'DPL_ERROR_OUT_OF_MEMORY', 'DPL_ERROR_IO', 'DPL_ERROR_DEVICE', 'DPL_ERROR_INTERNAL'];
const OUT_OF_MEMORY = 6, UNSUPPORTED = RESULTS[5];
const wrong = sentence => new DoppelError(sentence, 'DPL_ERROR_INVALID_ARGUMENT');
const checkTime = timeMs => {
  if (!(Math.abs(timeMs) <= MOST_MS)) throw wrong(`a time of ${timeMs} ms; it must be a finite number`);
};
const isByteCount = number => Number.isInteger(number) && number >= 0 && number <= MOST_BYTES;
const MAX_FILE_BYTES = 512 * 1024 * 1024;
const PAGE_BYTES = 65536, FIRST_PAGES = 64, MOST_PAGES = 32768;  // the limits of memory in CMakeLists.txt
const MEMORY_LIMIT = 1 << 30;
const MAX_SIDE_PX = 8192;
const STRAIGHT_ALPHA = 1;  // DPL_IMAGE_STRAIGHT_ALPHA
const SCRATCH_BYTES = 640;
const LANDMARKS = 33;       // of MediaPipe Pose
const EXPRESSIONS = 52;     // DPL_EXPRESSION_COUNT
const MOST_STATE_BYTES = 8192;  // of dplGetMotionState
const MOST_MS = 9e12;       // of a time: its nanoseconds fit 64 bits
const IN_PLACE = 4, OVER_POSE = 8;  // DplTrackerFlag
const TRACKER_STATES = ['waiting', 'tracking', 'lost'];
const GENERAL_SPLATS = /^(ply|\x1f\x8b|NGSP|glTF)/;  // beginnings of files of general splats; those of persons are glTF too
const CAMERA_NUMBERS = 18;
const SPLAT_PROPERTIES = { position: 3, rotation: 4, scale: 3, covariance: 6, opacity: 1, colour: 3, sh: 0, rotationWxyz: 4 };  // numbers; as DplSplatProperty
const NUMBER_BYTES = { float: 4, half: 2 };  // as DplNumber
const PROPERTY_NAMES = Object.keys(SPLAT_PROPERTIES);
const MOST_ELEMENTS = 16;  // DPL_MAX_BUFFER_ELEMENTS
const MOST_BYTES = 2 ** 31;
const SPLAT_BYTES = 32;   // DplScreenSplat
export const SPLATS_A_ROW = 512;  // a projection has room for whole rows of a texture of so many splats
const UP = [0, 1, 0];

const decoder = new TextDecoder();
const encoder = new TextEncoder();

/** The bytes of a URL, a Response, a Blob or a buffer. onProgress(loaded, total): bytes; total is 0 where nobody says. */
export async function fetchBytes(source, { onProgress, signal } = {}) {
  if (source instanceof ArrayBuffer) return new Uint8Array(source);
  if (ArrayBuffer.isView(source)) return new Uint8Array(source.buffer, source.byteOffset, source.byteLength);
  if (typeof Blob !== 'undefined' && source instanceof Blob) return new Uint8Array(await source.arrayBuffer());
  let name = 'the file';
  try {
    let response = source;
    if (!(typeof Response !== 'undefined' && source instanceof Response)) {
      name = String(source);
      if (name.startsWith('file:') && typeof process !== 'undefined' && process.versions?.node) {  // Node's fetch knows no file:
        const { readFile } = await import('node:fs/promises');
        return new Uint8Array(await readFile(new URL(name)));
      }
      response = await fetch(name, { signal });
    }
    if (!response.ok) throw new DoppelError(`${name}: the server answers ${response.status} ${response.statusText}`.trimEnd(), 'NETWORK');
    return await readAll(response, name, onProgress);
  } catch (error) {
    if (error instanceof DoppelError || error?.name === 'AbortError') throw error;
    const why = error?.message ?? error;
    throw new DoppelError(`${name}: cannot be fetched (${why}); is the address right, and does its server allow this page (CORS)?`,
      'NETWORK');
  }
}

async function readAll(response, name, onProgress) {
  const total = Number(response.headers.get('content-length')) || 0;
  const tooLarge = () => new DoppelError(`${name}: more than ${MAX_FILE_BYTES / 1048576} MB; a page takes no larger file`, 'NETWORK');
  if (total > MAX_FILE_BYTES) throw tooLarge();
  if (!response.body) return new Uint8Array(await response.arrayBuffer());
  const parts = [];
  let loaded = 0;
  for (const reader = response.body.getReader(); ;) {
    const { done, value } = await reader.read();
    if (done) break;
    parts.push(value);
    loaded += value.length;
    if (loaded > MAX_FILE_BYTES) {
      reader.cancel();
      throw tooLarge();
    }
    onProgress?.(loaded, Math.max(total, loaded));
  }
  const bytes = new Uint8Array(loaded);
  let at = 0;
  for (const part of parts) {
    bytes.set(part, at);
    at += part.length;
  }
  return bytes;
}

const compiled = new Map();

/** The compiled module, shared by all that name the same address. from: a URL, bytes, a Promise of bytes, or a WebAssembly.Module. */
async function compile(from) {
  if (from instanceof WebAssembly.Module) return from;
  if (typeof from !== 'string' && !(from instanceof URL)) return WebAssembly.compile(await fetchBytes(await from));
  const key = new URL(from, globalThis.document?.baseURI ?? import.meta.url).href;
  if (!compiled.has(key)) {
    const made = fetchBytes(key).then(bytes => WebAssembly.compile(bytes));
    compiled.set(key, made);
    made.catch(() => compiled.delete(key));  // the next person may try again
  }
  return compiled.get(key);
}

/** The address of doppel-splats.wasm where doppel.wasm has one that it can lie beside. */
function besideModule(from) {
  if (typeof from !== 'string' && !(from instanceof URL)) return null;
  const address = new URL(from, globalThis.document?.baseURI ?? import.meta.url);
  return /^(https?|file):/.test(address.protocol) ? new URL('doppel-splats.wasm', address) : null;
}

/** Imports that a WASI module without files asks for. text(pointer) reads a C string of the instance. */
function importsOf(module, memory, text, onLog) {
  const BAD_FILE = 8, NO_FUNCTION = 52;
  const known = {
    clock_time_get(id, precision, at) {
      const ms = id === 0 ? Date.now() : performance.now();
      new DataView(memory().buffer).setBigUint64(at, BigInt(Math.round(ms * 1e6)), true);
      return 0;
    },
    environ_sizes_get(count, bytes) {
      const view = new DataView(memory().buffer);
      view.setUint32(count, 0, true);
      view.setUint32(bytes, 0, true);
      return 0;
    },
    environ_get: () => 0,
    fd_prestat_get: () => BAD_FILE,
    fd_write(file, vectors, count, written) {  // the log of the library, which goes to stderr
      const view = new DataView(memory().buffer);
      let line = '', bytes = 0;
      for (let i = 0; i < count; ++i) {
        const at = view.getUint32(vectors + 8 * i, true), size = view.getUint32(vectors + 8 * i + 4, true);
        line += decoder.decode(new Uint8Array(memory().buffer, at, size));
        bytes += size;
      }
      if (line.trim()) onLog(line.trim());
      view.setUint32(written, bytes, true);
      return 0;
    },
    proc_exit(code) {
      throw new Error(`the module ended with ${code}`);
    },
  };
  const imports = {};
  for (const { module: from, name, kind } of WebAssembly.Module.imports(module)) {
    imports[from] ??= {};
    if (kind === 'memory') imports[from][name] = memory();
    else imports[from][name] = from === 'doppel' ? type => { throw new Error(text(type)); } : known[name] ?? (() => NO_FUNCTION);
  }
  return imports;
}

/** A person, or general splats. Functions throw DoppelError. */
export class Doppel {
  #exports; #memory; #context = 0; #avatar = 0; #scratch = 0; #image = 0; #imageBytes = 0; #lost = null; #tracker = 0;
  #floats; #doubles; #words;  // views of all memory, made anew when it has grown: viewMemory()
  #splats = 0; #capacity = 0; #projection = { words: null, at: 0, counts: [0, 0], samples: 1, rows: 0 };
  #meshAt = 0; #mesh = { positions: null, triangles: null };
  #writtenAt = 0; #writtenCapacity = 0; #written = { count: 0, saturated: 0, bytes: null };

  /** Loads an avatar (.glb) or general splats.
   *  source: a URL, a Response, a Blob, or bytes. options.module: where doppel.wasm is, its bytes, or the compiled module; otherwise beside
   *  this file. options.splatsModule: the same of doppel-splats.wasm, which is needed for general splats alone; otherwise beside
   *  doppel.wasm. options.onProgress(loaded, total): bytes of the file. options.signal: an AbortSignal. options.memoryLimit: most memory
   *  for this person, bytes; usually 1 GiB. options.onLog(line): warnings of the library; otherwise they go to the console. */
  static async load(source, options = {}) {
    const where = options.module ?? new URL('./doppel.wasm', import.meta.url);
    const [module, bytes] = await Promise.all([compile(where), fetchBytes(source, options)]);
    try {
      return await Doppel.#of(module, bytes, options);
    } catch (error) {
      const splats = options.splatsModule ?? besideModule(where);
      const head = String.fromCharCode(...bytes.subarray(0, 4));
      if (error.code !== UNSUPPORTED || !splats || !GENERAL_SPLATS.test(head)) throw error;
      return Doppel.#of(await compile(splats), bytes, options);
    }
  }

  static async #of(module, bytes, options) {
    options.signal?.throwIfAborted();
    const person = new Doppel();
    await person.#start(module, options.memoryLimit ?? MEMORY_LIMIT, options.onLog ?? (line => console.warn(line)));
    person.#load(bytes);
    return person;
  }

  async #start(module, memoryLimit, onLog) {
    let instance;
    try {
      const maximum = Math.min(MOST_PAGES, Math.max(FIRST_PAGES, Math.floor(memoryLimit / PAGE_BYTES)));
      this.#memory = new WebAssembly.Memory({ initial: FIRST_PAGES, maximum });
      const imports = importsOf(module, () => this.#memory, at => this.#text(at), onLog);
      instance = await WebAssembly.instantiate(module, imports);
    } catch (error) {
      const code = error instanceof RangeError ? RESULTS[OUT_OF_MEMORY] : UNSUPPORTED;
      throw new DoppelError(`the module does not start: ${error.message}`, code);
    }
    this.#exports = instance.exports;
    this.#call('_initialize');
    this.#scratch = this.#call('webAllocate', SCRATCH_BYTES);
    this.#context = this.#call('webCreateContext');
    if (!this.#context) throw this.#error(-1);
  }

  #load(bytes) {
    const data = this.#put(bytes);
    this.#avatar = this.#call('webLoadAvatar', this.#context, data, bytes.length, this.#scratch);
    if (!this.#avatar) throw this.#error(this.#int());
    this.#call('webFree', data);
    this.#check(this.#call('webAvatarNumbers', this.#avatar, this.#scratch));
    const [joints, splats, clips, vertices, triangles, shDegree, ...box] = this.#numbers(12);
    /** Name of the person in the file. A stranger may have written it: it is text, never HTML. */
    this.name = this.#text(this.#call('webAvatarName', this.#avatar));
    this.splatCount = splats;
    this.vertexCount = vertices;
    this.triangleCount = triangles;
    this.shDegree = shDegree;
    /** Bounding box at rest, metres. */
    this.restMin = box.slice(0, 3);
    this.restMax = box.slice(3);
    /** {name, bone, parent, restPosition} of each joint; bone: of the VRM humanoid, or ''. */
    this.joints = Array.from({ length: joints }, (_, i) => {
      this.#check(this.#call('webJointNumbers', this.#avatar, i, this.#scratch));
      const [parent, ...restPosition] = this.#numbers(4);
      const name = bone => this.#text(this.#call('webJointName', this.#avatar, i, bone));
      return { name: name(0), bone: name(1), parent, restPosition };
    });
    /** {name, duration} of each clip; duration in seconds. */
    this.clips = Array.from({ length: clips }, (_, i) => this.#clip(i));
    /** {name, role, triangleCount} of each layer; role: 'body', 'garment' or 'hair'. */
    this.layers = Array.from({ length: this.#call('webLayerCount', this.#avatar) }, (_, i) => ({
      name: this.#text(this.#call('webLayerText', this.#avatar, i, 0)), role: this.#text(this.#call('webLayerText', this.#avatar, i, 1)),
      triangleCount: this.#call('webLayerTriangles', this.#avatar, i),
    }));
    /** {name, drawn} of each expression, by ARKit's names and in its order. drawn: the person holds it, else its weight changes nothing. */
    this.expressions = Array.from({ length: EXPRESSIONS }, (_, i) => ({
      name: this.#text(this.#call('webExpressionName', this.#avatar, i)), drawn: this.#call('webExpressionDrawn', this.#avatar, i) === 1,
    }));
  }

  #clip(i) {
    return { name: this.#text(this.#call('webClipName', this.#avatar, i)), duration: this.#call('webClipDuration', this.#avatar, i) };
  }

  // [not in pages]
  /** Poses the person: a quaternion for each joint, 4 · joints.length numbers; the identity is the rest pose. translation: of the root,
   *  metres. timeMs: when the picture is shown, of any one clock such as performance.now(); clothes then remember. Without it they are
   *  those of the pose alone. */
  setPose(rotations, translation = [0, 0, 0], { timeMs } = {}) {
    const count = this.joints.length;
    if (rotations.length !== 4 * count)
      throw wrong(`${rotations.length} numbers for the rotations of ${count} joints; 4 for each are needed`);
    if (translation.length !== 3) throw wrong(`a translation of ${translation.length} numbers; 3 are needed`);
    if (timeMs !== undefined) checkTime(timeMs);
    const at = this.#call('webAllocate', 16 * count + 12);
    if (!at) throw this.#refused(16 * count);
    const floats = new Float32Array(this.#memory.buffer, at, 4 * count + 3);
    floats.set(rotations);
    floats.set(translation, 4 * count);
    const result = timeMs === undefined ? this.#call('dplSetPose', this.#avatar, at, count, at + 16 * count)
      : this.#call('webSetPoseAtTime', this.#avatar, at, count, at + 16 * count, timeMs);
    this.#call('webFree', at);
    this.#check(result);
  }

  /** Clothes forget: they are those of the current pose alone. */
  settle() { this.#check(this.#call('dplSettle', this.#avatar)); }

  /** What the clothes remember in the current pose, and its time: bytes for setMotionState() of a person of the same file. */
  motionState() {
    const at = this.#call('webAllocate', MOST_STATE_BYTES);
    if (!at) throw this.#refused(MOST_STATE_BYTES);
    const result = this.#call('dplGetMotionState', this.#avatar, at, MOST_STATE_BYTES, this.#scratch);
    const state = result === 0 ? new Uint8Array(this.#memory.buffer, at, this.#int()).slice() : null;
    this.#call('webFree', at);
    this.#check(result);
    return state;
  }
  /** Restores it: poses that follow in time are drawn as after the one that was saved. */
  setMotionState(state) {
    const at = this.#put(state), result = this.#call('dplSetMotionState', this.#avatar, at, state.length);
    this.#call('webFree', at);
    this.#check(result);
  }

  /** Sets the face, until it is changed; poses do not touch it. weights: a number of 0 to 1 for each of `expressions`, in their order; or an
   *  object by names, such as { jawOpen: 0.5 }, as of setExpressionNamed(). All zero: the neutral face. */
  setExpression(weights) {
    if (weights.length === undefined) return this.setExpressionNamed(Object.keys(weights), Object.values(weights));
    if (weights.length !== EXPRESSIONS) throw wrong(`${weights.length} weights; there are ${EXPRESSIONS} expressions`);
    this.#viewMemory();
    this.#floats.set(weights, this.#scratch >> 2);
    this.#check(this.#call('dplSetExpression', this.#avatar, this.#scratch, EXPRESSIONS));
  }

  /** The same from a stream, by its names: those of ARKit, MediaPipe, Live Link, VRM or OpenXR; what is not named becomes zero. Of MediaPipe's
   *  result these are categoryName and score of faceBlendshapes[0].categories. */
  setExpressionNamed(names, weights) {
    const count = names.length;
    if (weights.length !== count) throw wrong(`${count} names and ${weights.length} weights; a weight is needed for each name`);
    const texts = Array.from(names, name => encoder.encode(`${name}\0`));
    const bytes = texts.reduce((sum, text) => sum + text.length, 8 * count + 1), at = this.#call('webAllocate', bytes);
    if (!at) throw this.#refused(bytes);
    this.#viewMemory();
    this.#floats.set(weights, (at >> 2) + count);
    let to = at + 8 * count;  // behind the pointers to the names and the weights
    for (let i = 0; i < count; ++i) {
      this.#words[(at >> 2) + i] = to;
      new Uint8Array(this.#memory.buffer, to, texts[i].length).set(texts[i]);
      to += texts[i].length;
    }
    const result = this.#call('dplSetExpressionNamed', this.#avatar, at, at + 4 * count, count);
    this.#call('webFree', at);
    this.#check(result);
  }

  /** Blinks and glances of a face, 0 to 1, on top of what is set, and the end of a stream, for a picture at `timeMs`, such as
   *  performance.now(): before each picture. Those of other seeds blink at other times. A stream that spoke last at `heardMs` and is silent
   *  for `holdS` seconds has stopped, and fades; 0: what was set stays. Without this call the face is still. */
  setFaceMotion(timeMs, { seed = 0, blinks = 1, glances = 1, holdS = 0, heardMs = 0 } = {}) {
    this.#check(this.#call('webSetFaceMotion', this.#avatar, timeMs, seed, blinks, glances, holdS, heardMs));
  }

  /** What the face shows: a weight for each of `expressions`. */
  expression() {
    this.#check(this.#call('dplGetExpression', this.#avatar, this.#scratch, EXPRESSIONS));
    return new Float32Array(this.#memory.buffer, this.#scratch, EXPRESSIONS).slice();
  }

  // [in pages]
  /** Poses the person as a clip does at `time`, seconds. clip: its number or its name. */
  setClip(clip, time, options) {
    let index = clip;
    if (typeof clip === 'string') {
      index = this.clips.findIndex(c => c.name === clip);
      const names = this.clips.map(c => c.name).join(', ') || 'none';
      if (index < 0) throw new DoppelError(`there is no clip '${clip}'; there are: ${names}`, RESULTS[2]);
    }
    this.#alive();
    let result;
    try {
      result = this.#exports.dplSetPoseFromClip(this.#avatar, index, time, options?.loop ?? true ? 1 : 0);
    } catch (error) {
      throw this.#died(error);
    }
    this.#check(result);
  }

  // [not in pages]
  /** Reads a motion (BVH or GLB) for this person and returns the number of the new clip. source: as of Doppel.load. inPlace: without
   *  travel. */
  async loadClip(source, { name = '', animation = 0, inPlace = false, ...options } = {}) {
    const bytes = await fetchBytes(source, options);
    const data = this.#put(bytes), title = name ? this.#put(encoder.encode(name + '\0')) : 0;
    const result = this.#call('webLoadClip', this.#avatar, data, bytes.length, inPlace ? 4 : 0, animation, title, this.#scratch);
    this.#call('webFree', data);
    this.#call('webFree', title);
    this.#check(result);
    const clip = this.#int();
    this.clips.push(this.#clip(clip));
    return clip;
  }

  /** How stiff the clothes are, until it is changed: 0 to 100, 1 as learned; stiffer ones swing and lag less. */
  setClothStiffness(stiffness) { this.#check(this.#call('dplSetClothStiffness', this.#avatar, stiffness)); }

  /** Places the person in the world: 12 numbers, a 3×4 matrix row by row; null: where they were at first. */
  setTransform(worldFromAvatar) {
    if (worldFromAvatar && worldFromAvatar.length !== 12) throw wrong(`a transform of ${worldFromAvatar.length} numbers; 12 are needed`);
    this.#viewMemory();
    for (let k = 0; worldFromAvatar && k < 12; ++k) this.#floats[(this.#scratch >> 2) + k] = worldFromAvatar[k];
    this.#check(this.#call('dplSetTransform', this.#avatar, worldFromAvatar ? this.#scratch : 0));
  }

  /** Hides a layer, or shows it again. layer: its number or its name. Most layers of a scan cannot be hidden; the error says why. */
  hideLayer(layer, hidden = true) {
    const index = typeof layer === 'string' ? this.layers.findIndex(l => l.name === layer) : layer;
    const names = this.layers.map(l => l.name).join(', ') || 'none';
    if (index < 0) throw new DoppelError(`there is no layer '${layer}'; there are: ${names}`, RESULTS[2]);
    this.#check(this.#call('dplHideLayer', this.#avatar, index, hidden ? 1 : 0));
    this.#mesh.triangles = null;
  }

  /** Begins to follow somebody before a camera: then give track() what MediaPipe Pose sees, and pose by setPoseFromTracker(). Begun again,
   *  it forgets who was seen. inPlace: the person stays on the spot. overPose: what the camera does not see follows the pose that is set
   *  before each picture, such as setClip(); otherwise the rest pose. */
  startTracking({ inPlace = false, overPose = false } = {}) {
    const made = this.#call('webCreateTracker', this.#avatar, (inPlace ? IN_PLACE : 0) | (overPose ? OVER_POSE : 0), this.#scratch);
    if (!made) throw this.#error(this.#int());
    this.#call('dplDestroyTracker', this.#tracker);
    this.#tracker = made;
  }

  /** landmarks: the 33 world landmarks {x, y, z, visibility} of MediaPipe Pose. One with a number that is not finite, or with a visibility
   *  below 0.5, is not seen. timeMs: when the camera saw them, of any one clock such as performance.now(). Those that are not later than
   *  the last are left out; those more than a second earlier begin anew. */
  track(landmarks, timeMs) {
    if (landmarks?.length !== LANDMARKS) throw wrong(`${landmarks?.length ?? 'no'} landmarks; MediaPipe Pose has ${LANDMARKS}`);
    this.#checkFollowed(timeMs);
    this.#viewMemory();
    const at = this.#scratch >> 2, floats = this.#floats;
    for (let i = 0; i < LANDMARKS; ++i) {
      const { x, y, z, visibility = 1 } = landmarks[i] ?? {};
      floats[at + 3 * i] = x, floats[at + 3 * i + 1] = y, floats[at + 3 * i + 2] = z, floats[at + 3 * LANDMARKS + i] = visibility;
    }
    this.#check(this.#call('webTrack', this.#tracker, this.#scratch, LANDMARKS, timeMs));
  }

  /** Poses the person for a picture that is shown at timeMs, of the clock of track(). Returns {state, drivenJoints, rateHz, delay}. state:
   *  'waiting' for the first landmarks, 'tracking', or 'lost' for more than 0.3 s. drivenJoints: that follow now. delay: by which the
   *  smoothing lags, seconds. */
  setPoseFromTracker(timeMs) {
    this.#checkFollowed(timeMs);
    this.#check(this.#call('webSetPoseFromTracker', this.#tracker, timeMs, this.#scratch));
    const [state, drivenJoints, rateHz, delay] = this.#numbers(4);
    return { state: TRACKER_STATES[state], drivenJoints, rateHz, delay };
  }

  #checkFollowed(timeMs) {
    this.#alive();
    if (!this.#tracker) throw wrong('nobody is followed yet; call startTracking() first');
    checkTime(timeMs);
  }

  /** The posed mesh {positions, triangles}, which the next call overwrites: 3 numbers a vertex, metres, before setTransform; 3 vertices a
   *  triangle. triangles is another array once a layer was hidden or shown. A warm call allocates nothing. */
  posedMesh() {
    const vertices = 3 * this.vertexCount, corners = 3 * this.triangleCount, mesh = this.#mesh, triangles = mesh.triangles;
    this.#meshAt ||= this.#call('webAllocate', 4 * (vertices + corners) + 4);
    if (!this.#meshAt) throw this.#refused(4 * (vertices + corners));
    const at = this.#meshAt, cornersAt = triangles ? 0 : at + 4 * vertices;
    this.#alive();
    let result;
    try {
      result = this.#exports.dplGetPosedMesh(this.#avatar, at, this.vertexCount, cornersAt, triangles ? 0 : this.triangleCount);
    } catch (error) {
      throw this.#died(error);
    }
    this.#check(result);
    this.#viewMemory();
    mesh.positions ??= new Float32Array(vertices);
    for (let k = 0, from = at >> 2; k < vertices; ++k) mesh.positions[k] = this.#floats[from + k];
    if (!triangles) mesh.triangles = this.#words.slice(cornersAt >> 2, (cornersAt >> 2) + corners);
    return mesh;
  }

  /** Splats of the pose for an engine that draws splats itself, in the layout that it wants: elements {property, number, offset, stride}.
   *  property: 'position', 'rotation', 'scale', 'covariance', 'opacity', 'colour', 'sh' or 'rotationWxyz' (doppel_posed.h tells what they are); number:
   *  'float', as usual, or 'half'; offset: bytes to the first splat's; stride: bytes from one to the next, 0: without gaps.
   *  eye: where the viewer is, 3 numbers, world: splats that turn their inside to it are left out, and colours are those that it sees.
   *  splatBudget: most splats, 0: all. Their number and order depend on the person and splatBudget alone.
   *  Returns {count, saturated, bytes}, which the next call overwrites. saturated: numbers too large for a half. bytes: a Uint8Array in the
   *  person's memory, as long as the layout needs; the same object until that memory moves. */
  writeSplats(layout, { eye = null, splatBudget = 0, shDegree = 0 } = {}) {
    if (!layout.length || layout.length > MOST_ELEMENTS) throw wrong(`a layout of ${layout.length} elements; 1 to ${MOST_ELEMENTS} are possible`);
    if (eye && eye.length !== 3) throw wrong(`an eye of ${eye.length} numbers; 3 are needed`);
    this.#viewMemory();
    // The scratch holds the elements, then the eye, then what comes back.
    const eyeAt = this.#scratch + 32 * MOST_ELEMENTS, numbersAt = eyeAt + 16;
    for (let k = 0; eye && k < 3; ++k) this.#floats[(eyeAt >> 2) + k] = eye[k];
    const write = (data, bytes) => {
      this.#check(this.#call('webWriteSplats', this.#avatar, this.#scratch, layout.length, eye ? eyeAt : 0, splatBudget, shDegree, data,
        bytes, numbersAt));
      this.#viewMemory();
    };
    write(0, 0);
    const count = this.#doubles[numbersAt >> 3];
    let bytes = 0;
    for (let i = 0; i < layout.length; ++i) {
      const { property, number = 'float', offset = 0, stride = 0 } = layout[i], kind = PROPERTY_NAMES.indexOf(property);
      if (kind < 0) throw wrong(`there is no property '${property}' of splats; there are: ${PROPERTY_NAMES.join(', ')}`);
      if (!NUMBER_BYTES[number]) throw wrong(`there is no number '${number}'; there are: float, half`);
      if (!isByteCount(offset) || !isByteCount(stride))
        throw wrong(`${property} at offset ${offset}, stride ${stride}; these are whole numbers of bytes, at most ${MOST_BYTES}`);
      const size = NUMBER_BYTES[number] * (SPLAT_PROPERTIES[property] || 3 * (shDegree + 1) ** 2), at = (this.#scratch >> 3) + 4 * i;
      bytes = Math.max(bytes, offset + (stride || size) * (count - 1) + size);
      this.#doubles[at] = kind, this.#doubles[at + 1] = number === 'half' ? 1 : 0;
      this.#doubles[at + 2] = offset, this.#doubles[at + 3] = stride;
    }
    this.#makeRoomToWrite(bytes);
    write(this.#writtenAt, bytes);
    const made = this.#written, { buffer } = this.#memory;
    made.count = count, made.saturated = this.#doubles[(numbersAt >> 3) + 1];
    if (made.bytes?.buffer !== buffer || made.bytes.length !== bytes) made.bytes = new Uint8Array(buffer, this.#writtenAt, bytes);
    return made;
  }
  #makeRoomToWrite(bytes) {
    if (bytes <= this.#writtenCapacity) return;
    this.#call('webFree', this.#writtenAt);
    this.#writtenCapacity = 0;
    this.#written.bytes = null;
    this.#writtenAt = this.#call('webAllocate', bytes);
    if (!this.#writtenAt) throw this.#refused(bytes);
    this.#writtenCapacity = bytes;
    this.#viewMemory();
  }

  // [in pages]
  /** Draws fewer splats where they are not seen (splatsPerPixel; 12 is usual) and never more than splatBudget. 0: no limit. */
  setDetail({ splatsPerPixel = 0, splatBudget = 0 } = {}) {
    this.#check(this.#call('webSetDetail', this.#context, splatsPerPixel, splatBudget));
  }

  /** World positions of all joints: 3 numbers each, metres. */
  jointPositions() {
    const count = this.joints.length, at = this.#call('webAllocate', 12 * count + 4);
    if (!at) throw this.#refused(12 * count);
    const result = this.#call('dplGetJointPositions', this.#avatar, at, count);
    const positions = new Float32Array(this.#memory.buffer, at, 3 * count).slice();
    this.#call('webFree', at);
    this.#check(result);
    return positions;
  }

  /** A camera {width, height, fx, fy, cx, cy, viewFromWorld} for draw(). It looks along its +z, with y down. fovY: vertical field of view,
   *  radians. into: a camera to overwrite instead of a new one. */
  lookAt(options, into = { viewFromWorld: new Array(12) }) {
    const { eye, target, width, height } = options, up = options.up ?? UP;
    this.#viewMemory();
    const at = this.#scratch >> 2, numbers = (this.#scratch + 48) >> 3;
    for (let k = 0; k < 3; ++k) this.#floats[at + k] = eye[k], this.#floats[at + 3 + k] = target[k], this.#floats[at + 6 + k] = up[k];
    let result;
    try {
      result = this.#exports.webLookAt(this.#scratch, options.fovY ?? 0.8, width, height, this.#scratch + 48);
    } catch (error) {
      throw this.#died(error);
    }
    this.#check(result);
    const from = this.#doubles;
    into.width = from[numbers], into.height = from[numbers + 1], into.fx = from[numbers + 2], into.fy = from[numbers + 3];
    into.cx = from[numbers + 4], into.cy = from[numbers + 5];
    for (let k = 0; k < 12; ++k) into.viewFromWorld[k] = from[numbers + 6 + k];
    return into;
  }

  /** The nearest distance from which a detail that the scan just shows is drawn over `magnification` pixels, metres; 0: the file does not
   *  say. point: what the camera looks at. focalPx: fx of the camera. */
  nearestDistance(point, eye, focalPx, magnification) {
    this.#viewMemory();
    const at = this.#scratch, floats = this.#floats;
    for (let k = 0; k < 3; ++k) floats[(at >> 2) + k] = point[k], floats[(at >> 2) + 3 + k] = eye[k];
    let result;
    try {
      result = this.#exports.dplGetNearestDistance(this.#avatar, at, at + 12, focalPx, magnification, at + 24);
    } catch (error) {
      throw this.#died(error);
    }
    this.#check(result);
    this.#viewMemory();
    return this.#floats[(at >> 2) + 6];
  }

  /** Draws on the CPU: 4 bytes a pixel, R first, top row first. straight: colour divided by alpha, as ImageData wants it; otherwise
   *  premultiplied. into: a buffer of width · height · 4 bytes to fill instead of a new one. */
  draw(camera, { straight = false, into } = {}) {
    const bytes = this.#setCamera(camera);
    if (this.#imageBytes < bytes) {
      this.#call('webFree', this.#image);
      this.#imageBytes = 0;
      this.#image = this.#call('webAllocate', bytes);
      if (!this.#image) throw this.#refused(bytes);
      this.#imageBytes = bytes;
    }
    this.#check(this.#call('webRender', this.#context, this.#avatar, this.#scratch, straight ? STRAIGHT_ALPHA : 0, this.#image, bytes));
    const pixels = new Uint8ClampedArray(this.#memory.buffer, this.#image, bytes);
    if (!into) return pixels.slice();
    into.set(pixels);
    return into;
  }

  /** Poses, culls, projects and sorts the splats of a picture for someone who blends them (webgl-renderer.js), instead of drawing. second:
   *  a camera of the same size, for another eye; both see one pose and one level of detail. Returns an object that the next call
   *  overwrites. words: all memory of the person, a Uint32Array. at: the index there of the first splat. counts: splats of both views, which
   *  follow each other. samples: a pixel. rows: of SPLATS_A_ROW splats, that hold them all. A splat is 8 words (DplScreenSplat in
   *  doppel_splats.h), the farthest is first. A warm call allocates nothing. */
  project(camera, second = null) {
    this.#setCamera(camera);
    if (second) this.#setCamera(second, 1);
    this.#makeRoom(second ? 2 : 1);
    const at = this.#scratch, numbers = at + 2 * CAMERA_NUMBERS * 8;
    let result;
    try {
      result = this.#exports.webProject(this.#context, this.#avatar, at, second ? 2 : 1, this.#splats, this.#capacity, numbers);
    } catch (error) {
      throw this.#died(error);
    }
    this.#check(result);
    this.#viewMemory();
    const made = this.#projection, words = made.words = this.#words;
    made.at = this.#splats >> 2;
    made.counts[0] = words[numbers >> 2], made.counts[1] = words[(numbers >> 2) + 1], made.samples = words[(numbers >> 2) + 2];
    made.rows = Math.ceil((made.counts[0] + made.counts[1]) / SPLATS_A_ROW);
    return made;
  }

  /** Room for all splats of `views` views, in whole rows. */
  #makeRoom(views) {
    const splats = Math.ceil(views * this.splatCount / SPLATS_A_ROW) * SPLATS_A_ROW;
    if (splats <= this.#capacity) return;
    this.#call('webFree', this.#splats);
    this.#capacity = 0;
    this.#splats = this.#call('webAllocate', splats * SPLAT_BYTES);
    if (!this.#splats) throw this.#refused(splats * SPLAT_BYTES);
    this.#capacity = splats;
  }

  /** Drops the person and their memory. */
  dispose() {
    this.#forget();
    this.#lost = wrong('this person was disposed of');
  }

  /** Writes camera number `view` to the scratch memory. Returns the bytes of its picture. */
  #setCamera(camera, view = 0) {
    const { width, height } = camera;
    for (const side of [width, height])
      if (!Number.isInteger(side) || side < 1 || side > MAX_SIDE_PX)
        throw wrong(`a picture of ${width} × ${height} pixels; sides are whole numbers from 1 to ${MAX_SIDE_PX}`);
    if (camera.viewFromWorld?.length !== 12) throw wrong('viewFromWorld of the camera must have 12 numbers');
    this.#viewMemory();
    const numbers = this.#doubles, at = (this.#scratch >> 3) + CAMERA_NUMBERS * view;
    numbers[at] = width, numbers[at + 1] = height, numbers[at + 2] = camera.fx, numbers[at + 3] = camera.fy;
    numbers[at + 4] = camera.cx, numbers[at + 5] = camera.cy;
    for (let k = 0; k < 12; ++k) numbers[at + 6 + k] = camera.viewFromWorld[k];
    return width * height * 4;
  }

  /** Before memory is read or written by #floats, #doubles, #words. */
  #viewMemory() {
    this.#alive();
    const { buffer } = this.#memory;
    if (this.#words?.buffer === buffer) return;
    this.#floats = new Float32Array(buffer), this.#doubles = new Float64Array(buffer), this.#words = new Uint32Array(buffer);
  }
  #forget() { this.#exports = this.#memory = this.#floats = this.#doubles = this.#words = this.#projection.words = null; }

  #alive() {
    if (this.#lost) throw this.#lost;
  }

  /** Calls an export. Whatever it throws ends this instance: its memory may be in any state. */
  #call(name, ...values) {
    this.#alive();
    try {
      return this.#exports[name](...values);
    } catch (error) {
      throw this.#died(error);
    }
  }
  #died(error) {
    const memory = error.message === 'out of memory';
    this.#lost = memory ? new DoppelError('there is not enough memory for this person in this browser', RESULTS[OUT_OF_MEMORY])
      : new DoppelError(`the module failed (${error.message}); please report this`, 'DPL_ERROR_INTERNAL');
    this.#forget();
    return this.#lost;
  }

  #put(bytes) {
    const at = this.#call('webAllocate', bytes.length || 1);
    if (!at) throw this.#refused(bytes.length);
    new Uint8Array(this.#memory.buffer, at, bytes.length).set(bytes);
    return at;
  }
  #numbers(count) { return [...new Float64Array(this.#memory.buffer, this.#scratch, count)]; }
  #int() { return new Int32Array(this.#memory.buffer, this.#scratch, 1)[0]; }
  #text(at) {
    const bytes = new Uint8Array(this.#memory.buffer, at);
    return decoder.decode(bytes.slice(0, bytes.indexOf(0)));
  }
  #refused(bytes) { return new DoppelError(`the browser gives no ${bytes} bytes more to this person`, RESULTS[OUT_OF_MEMORY]); }
  #error(result) { return new DoppelError(this.#text(this.#call('dplGetLastError')), RESULTS[-result] ?? 'DPL_ERROR_INTERNAL'); }
  #check(result) {
    if (result !== 0) throw this.#error(result);
  }
}
