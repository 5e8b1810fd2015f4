// SPDX-License-Identifier: Apache-2.0
// <doppel-avatar src="ada.glb" clip="walk" autoplay camera-controls poster="ada.png"></doppel-avatar>
//
// Attributes: src, the file. clip: name or number of the clip; without it the first one. autoplay: plays, unless the visitor asks for
// reduced motion. camera-controls: drag, wheel, two fingers, arrow keys, + and -. poster: a picture until the first one is drawn, and where
// none can be. auto-rotate: turns slowly while the clip plays, until the visitor turns. module: where doppel.wasm is. alt: what the picture
// shows, for those who do not see it. renderer: `cpu` is without WebGL2.
// device-restored (the browser took the graphics device away and gave it back). Slot `poster` takes other contents.
// It draws by WebGL2, and on the CPU where that is missing. Moving pictures that come too slowly get fewer splats by WebGL2 (SplatPacer),
// and fewer pixels on the CPU, which the browser enlarges. A picture that stands gets all of both.
import { Doppel, DoppelError } from './doppel.js';
import { SplatPacer } from './splat-pacer.js';
import { SplatRenderer } from './webgl-renderer.js';

const FOV_Y = 0.6;
const FRAME_MS = 30;          // of a picture of the CPU
const ROTATION_PER_S = 0.35;  // radians, with auto-rotate
const LEAST_SCALE = 0.35;  // of the pixels of the screen, in each direction
const MOST_DENSITY = 2;    // pixels a CSS pixel
const ORBIT_PER_PX = 0.01, ORBIT_PER_KEY = 0.15, ZOOM_PER_KEY = 1.15;
const HIGHEST = 1.4;       // radians above or below the horizon
const NEAREST = 0.25, FARTHEST = 3;  // of the distance at which the whole person is seen
const RESTORE_MS = 5000;   // a graphics device that does not come back within it is given up
const MAGNIFICATION = 3;   // a detail that the scan just shows is never drawn over more pixels
const LOOKS_AT_CLIP = 24;    // times of a clip at which it is seen how far the person reaches

const STYLE = `
:host { display: inline-block; position: relative; width: 300px; height: 400px; overflow: hidden; }
:host([hidden]) { display: none; }
:host([camera-controls]) canvas { touch-action: none; cursor: grab; }
canvas, img, slot { position: absolute; inset: 0; width: 100%; height: 100%; display: block; }
img { object-fit: contain; }
[hidden] { display: none; }
`;

// On a server, where pages are only put together, there is no HTMLElement.
export class DoppelAvatarElement extends (globalThis.HTMLElement ?? class {}) {
  static observedAttributes =
    ['src', 'clip', 'autoplay', 'camera-controls', 'poster', 'module', 'alt', 'renderer'];

  #canvas; #poster; #slot; #renderer = null; #pacer = new SplatPacer(); #givingUp = 0; #cpuOnly = false; #context2d = null;
  #person = null; #loading = null; #resize; #sight; #frame = 0;
  #playing = false; #inSight = true; #time = 0; #last = 0; #stale = true; #shown = false; #scale = 1;
  #azimuth = 0.35; #elevation = 0.05; #zoom = 1; #pointers = new Map(); #turnedByHand = false; #clip = 0; #box = null;
  #view = { eye: [0, 0, 0], target: [0, 0, 0], fovY: FOV_Y, width: 0, height: 0 }; #camera = { viewFromWorld: new Array(12) };
  #onFrame = now => this.#drawFrame(now);
  #onVisibility = () => this.#wake();

  constructor() {
    super();
    const root = this.attachShadow({ mode: 'open' });
    const style = document.createElement('style');
    style.textContent = STYLE;
    this.#makeCanvas();
    this.#poster = document.createElement('img');
    this.#poster.hidden = true;
    this.#poster.alt = '';
    this.#slot = document.createElement('slot');
    this.#slot.name = 'poster';
    root.append(style, this.#canvas, this.#poster, this.#slot);
  }

  /** The Doppel of doppel.js, once it is loaded; null before and after. */
  get person() { return this.#person; }
  /** What draws: 'WebGL2 RGBA16F', 'WebGL2 RGBA8' (the device refuses float targets: coarser), 'CPU'; '' before the first picture. */
  get drawnBy() { return this.#renderer ? `WebGL2 ${this.#renderer.target}` : this.#context2d ? 'CPU' : ''; }
  /** The last picture: width, height, and rgba as of Doppel.draw. Null before the first one. Waits for the graphics device. */
  readPicture() {
    const { width, height } = this.#canvas;
    if (!this.#shown) return null;
    const rgba = this.#renderer ? this.#renderer.read() : this.#person.draw(this.#camera);
    return { width, height, rgba };
  }
  /** Whether the clip does not run. */
  get paused() { return !this.#playing; }
  /** Seconds from the start of the clip. */
  get currentTime() { return this.#time; }
  set currentTime(seconds) {
    if (!Number.isFinite(seconds)) throw new TypeError('currentTime must be a finite number');
    this.#time = seconds;
    this.redraw();
  }
  play() {
    this.#playing = true;
    this.#last = 0;
    this.#wake();
  }
  pause() {
    this.#playing = false;
    this.redraw();  // a picture that stands is drawn whole
  }
  /** Draws again, for example after the pose was set by `person`. */
  redraw() {
    this.#stale = true;
    this.#wake();
  }

  connectedCallback() {
    this.#resize = new ResizeObserver(() => this.redraw());
    this.#resize.observe(this);
    this.#sight = new IntersectionObserver(seen => {
      this.#inSight = seen.at(-1).isIntersecting;
      this.#wake();
    });
    this.#sight.observe(this);
    document.addEventListener('visibilitychange', this.#onVisibility);
    this.#load();
  }

  disconnectedCallback() {
    this.#resize.disconnect();
    this.#sight.disconnect();
    document.removeEventListener('visibilitychange', this.#onVisibility);
    cancelAnimationFrame(this.#frame);
    this.#frame = 0;
    this.#drop();
    if (this.#renderer) this.#leaveCanvas();  // browsers keep few contexts
  }

  attributeChangedCallback(name, before, now) {
    if (before === now) return;
    if (name === 'poster') {
      if (now) this.#poster.src = now;
      this.#showPoster(!this.#shown);
    } else if (name === 'alt') {
      this.#canvas.setAttribute('aria-label', now ?? '');
    } else if (name === 'autoplay') {
      this.#playing = now !== null && !matchMedia('(prefers-reduced-motion: reduce)').matches;
      this.#wake();
    } else if (name === 'camera-controls') {
      if (now === null) this.#canvas.removeAttribute('tabindex');
      else this.#canvas.tabIndex = 0;
    } else if (name === 'renderer') {
      if (this.#renderer || this.#context2d) this.#leaveCanvas();
      this.redraw();
    } else if (name === 'clip') {
      this.#clip = now === null ? 0 : /^\d+$/.test(now) ? Number(now) : now;
      this.#time = 0;
      this.#box = null;
      this.redraw();
    } else if (this.isConnected) {
      this.#load();
    }
  }

  #drop() {
    this.#loading?.abort();
    this.#loading = null;
    this.#person?.dispose();
    this.#person = this.#box = null;
    this.#shown = false;
    this.#showPoster(true);
  }

  #showPoster(on) {
    this.#poster.hidden = !on || !this.getAttribute('poster');
    this.#slot.hidden = !on;
    this.#canvas.style.visibility = on ? 'hidden' : '';
  }

  #tell(type, detail) { this.dispatchEvent(new CustomEvent(type, { detail })); }

  #fail(error) {
    this.#drop();
    this.#tell('error', { message: String(error.message), code: error.code ?? 'DPL_ERROR_INTERNAL' });
  }

  async #load() {
    this.#drop();
    const src = this.getAttribute('src');
    if (!src) return;
    const loading = this.#loading = new AbortController();
    await null;  // so that attributes which are set together load once
    if (loading.signal.aborted) return;
    const module = this.getAttribute('module');
    try {
      const person = await Doppel.load(new URL(src, document.baseURI), {
        signal: loading.signal,
        ...(module ? { module: new URL(module, document.baseURI) } : {}),
        onProgress: (loaded, total) => { if (!loading.signal.aborted) this.#tell('progress', { loaded, total }); },
      });
      if (loading.signal.aborted) return person.dispose();
      this.#person = person;
      this.#pacer.reset(person);
      this.#time = 0;
      this.#last = 0;
      this.#tell('load', { name: person.name, splatCount: person.splatCount });
      this.redraw();
    } catch (error) {
      if (loading.signal.aborted) return;
      const isAddress = !(error instanceof TypeError);
      this.#fail(isAddress ? error : new DoppelError(`src or module is no address: ${error.message}`, 'NETWORK'));
    }
  }

  /** Asks for a frame if there is something to draw and somebody may see it. */
  #wake() {
    if (this.#frame || !this.#person || !this.#inSight || document.hidden || !(this.#playing || this.#stale)) return;
    this.#frame = requestAnimationFrame(this.#onFrame);
  }

  #drawFrame(now) {
    this.#frame = 0;
    if (!this.#person) return;
    const moving = this.#playing || this.#pointers.size > 0, interval = moving && this.#last ? now - this.#last : 0;
    if (this.#playing) {
      const passed = Math.min(100, interval) / 1000;
      this.#time += passed;
      if (this.hasAttribute('auto-rotate') && !this.#turnedByHand) this.#azimuth += ROTATION_PER_S * passed;
    }
    this.#last = moving ? now : 0;
    this.#stale = false;
    try {
      this.#draw(interval);
    } catch (error) {
      this.#fail(error);
      return;
    }
    this.#wake();
  }

  /** Draws and shows the person. interval: since the last frame of a motion, ms; 0: a picture by itself. */
  #draw(interval) {
    if (!this.#renderer && !this.#context2d) this.#chooseRenderer();
    if (this.#renderer?.lost) return;
    const density = Math.min(MOST_DENSITY, globalThis.devicePixelRatio || 1) * (this.#renderer ? 1 : this.#scale);
    const width = Math.round(this.clientWidth * density), height = Math.round(this.clientHeight * density);
    if (width < 1 || height < 1) return;
    const person = this.#person, started = performance.now();
    this.#box ??= this.#reach();
    if (person.clips.length) person.setClip(this.#clip, this.#time);
    this.#aim(width, height);
    if (this.#renderer) {
      this.#pacer.pace(person, interval);
      this.#renderer.draw(person, this.#camera);
    } else {
      const picture = person.draw(this.#camera, { straight: true });
      if (this.#canvas.width !== width || this.#canvas.height !== height) this.#canvas.width = width, this.#canvas.height = height;
      this.#context2d.putImageData(new ImageData(picture, width, height), 0, 0);
      this.#adapt(performance.now() - started);
    }
    if (this.#shown) return;
    this.#shown = true;
    this.#showPoster(false);
    this.#tell('first-picture', { renderer: this.drawnBy });
  }

  /** WebGL2, or the CPU where it is missing, refused or not wanted. */
  #chooseRenderer() {
    if (!this.#cpuOnly && this.getAttribute('renderer') !== 'cpu') {
      try {
        this.#renderer = new SplatRenderer(this.#canvas, { onLost: () => this.#lostDevice(), onRestored: () => this.#restoredDevice() });
        return;
      } catch (error) {
        if (error.code !== 'DPL_ERROR_UNSUPPORTED') throw error;
        this.#makeCanvas();  // the old one may have a context of WebGL2, and then gives no other
      }
    }
    this.#context2d = this.#canvas.getContext('2d');
    if (!this.#context2d) throw new DoppelError('this browser draws neither by WebGL2 nor on a canvas', 'DPL_ERROR_UNSUPPORTED');
  }

  #lostDevice() {
    this.#tell('device-lost');
    this.#showPoster(true);
    this.#givingUp = setTimeout(() => {
      this.#cpuOnly = true;
      this.#leaveCanvas();
      this.redraw();
    }, RESTORE_MS);
  }
  #restoredDevice() {
    clearTimeout(this.#givingUp);
    this.#showPoster(!this.#shown);
    this.#tell('device-restored');
    this.redraw();
  }

  /** Gives the graphics device back and starts with a new canvas. */
  #leaveCanvas() {
    clearTimeout(this.#givingUp);
    this.#renderer?.dispose();
    this.#renderer = this.#context2d = null;
    this.#shown = false;
    this.#makeCanvas();
    this.#showPoster(true);
  }

  #makeCanvas() {
    const before = this.#canvas, canvas = this.#canvas = document.createElement('canvas');
    canvas.setAttribute('role', 'img');
    if (before) {
      for (const name of ['aria-label', 'tabindex', 'style'])
        if (before.hasAttribute(name)) canvas.setAttribute(name, before.getAttribute(name));
      before.replaceWith(canvas);
    }
    this.#pointers.clear();
    this.#listen();
  }

  /** Fewer pixels where pictures of the CPU take too long while they move, all of them for one that stands. */
  #adapt(ms) {
    const before = this.#scale;
    if (!this.#playing && !this.#pointers.size) this.#scale = 1;
    else if (ms > FRAME_MS) this.#scale = Math.max(LEAST_SCALE, this.#scale * Math.max(0.7, Math.sqrt(FRAME_MS / ms)));
    else if (ms < FRAME_MS / 2) this.#scale = Math.min(1, this.#scale * 1.05);
    if (!this.#playing && before < this.#scale) this.#stale = true;
  }

  /** The corners of what must be in the picture: the person at rest, and in the clip as far beyond the joints as at rest. */
  #reach() {
    const { restMin, restMax, joints, clips } = this.#person, low = [...restMin], high = [...restMax];
    const ofJoints = (places, choose) => [0, 1, 2].map(k => choose(...places.map(place => place[k])));
    const atRest = joints.map(({ restPosition }) => restPosition), least = ofJoints(atRest, Math.min), most = ofJoints(atRest, Math.max);
    const clip = clips[this.#clip] ?? clips.find(({ name }) => name === this.#clip);
    for (let i = 0; clip && i < LOOKS_AT_CLIP; ++i) {
      this.#person.setClip(this.#clip, clip.duration * i / LOOKS_AT_CLIP);
      this.#person.jointPositions().forEach((place, at) => {
        const k = at % 3;
        low[k] = Math.min(low[k], place + restMin[k] - least[k]), high[k] = Math.max(high[k], place + restMax[k] - most[k]);
      });
    }
    return { low, high };
  }

  /** Sets #camera for a picture of width × height. */
  #aim(width, height) {
    const { low, high } = this.#box, view = this.#view, { eye, target } = view;
    const halfHeight = (high[1] - low[1]) / 2 || 1;
    const halfWidth = Math.max(0.3 * halfHeight, Math.min((high[0] - low[0]) / 2, halfHeight));
    const tangent = Math.tan(FOV_Y / 2), whole = 1.15 * Math.max(halfHeight, halfWidth * height / width) / tangent;
    for (let k = 0; k < 3; ++k) target[k] = (low[k] + high[k]) / 2;
    this.#stepBack(whole);
    const nearest = this.#person.nearestDistance(target, eye, height / (2 * tangent), MAGNIFICATION);
    this.#zoom = Math.min(FARTHEST, Math.max(NEAREST, Math.min(1, nearest / whole), this.#zoom));
    this.#stepBack(whole * this.#zoom);
    view.width = width, view.height = height;
    this.#person.lookAt(view, this.#camera);
  }

  /** Puts the eye `distance` away from the target. */
  #stepBack(distance) {
    const { eye, target } = this.#view, level = Math.cos(this.#elevation);
    eye[0] = target[0] + distance * level * Math.sin(this.#azimuth);
    eye[1] = target[1] + distance * Math.sin(this.#elevation);
    eye[2] = target[2] + distance * level * Math.cos(this.#azimuth);
  }

  #turn(azimuth, elevation) {
    this.#turnedByHand = true;
    this.#azimuth += azimuth;
    this.#elevation = Math.min(HIGHEST, Math.max(-HIGHEST, this.#elevation + elevation));
    this.redraw();
  }
  #zoomBy(factor) {
    this.#zoom *= factor;
    this.redraw();
  }

  #listen() {
    const canvas = this.#canvas, controlled = () => this.hasAttribute('camera-controls');
    const spread = () => {
      const [a, b] = [...this.#pointers.values()];
      return Math.hypot(a.x - b.x, a.y - b.y) || 1;
    };
    canvas.addEventListener('pointerdown', event => {
      if (!controlled()) return;
      canvas.setPointerCapture(event.pointerId);
      this.#pointers.set(event.pointerId, { x: event.clientX, y: event.clientY });
    });
    canvas.addEventListener('pointermove', event => {
      const pointer = this.#pointers.get(event.pointerId);
      if (!pointer) return;
      const two = this.#pointers.size === 2, before = two ? spread() : 0, { x, y } = pointer;
      pointer.x = event.clientX, pointer.y = event.clientY;
      if (two) this.#zoomBy(before / spread());
      else if (this.#pointers.size === 1) this.#turn((x - pointer.x) * ORBIT_PER_PX, (pointer.y - y) * ORBIT_PER_PX);
    });
    for (const type of ['pointerup', 'pointercancel'])
      canvas.addEventListener(type, event => {
        if (this.#pointers.delete(event.pointerId)) this.redraw();
      });
    canvas.addEventListener('wheel', event => {
      if (!controlled()) return;
      event.preventDefault();
      this.#zoomBy(Math.exp(Math.max(-1, Math.min(1, event.deltaY * 0.002))));
    }, { passive: false });
    canvas.addEventListener('keydown', event => {
      if (!controlled()) return;
      const moves = {
        ArrowLeft: () => this.#turn(-ORBIT_PER_KEY, 0), ArrowRight: () => this.#turn(ORBIT_PER_KEY, 0),
        ArrowUp: () => this.#turn(0, ORBIT_PER_KEY), ArrowDown: () => this.#turn(0, -ORBIT_PER_KEY),
        '+': () => this.#zoomBy(1 / ZOOM_PER_KEY), '-': () => this.#zoomBy(ZOOM_PER_KEY),
      };
      if (!moves[event.key]) return;
      event.preventDefault();
      moves[event.key]();
    });
  }
}

if (globalThis.customElements && !customElements.get('doppel-avatar')) customElements.define('doppel-avatar', DoppelAvatarElement);
