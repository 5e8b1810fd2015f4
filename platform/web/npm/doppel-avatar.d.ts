// SPDX-License-Identifier: Apache-2.0
import type { Doppel } from './doppel.js';

export interface DoppelAvatarEventMap {
  progress: CustomEvent<{ loaded: number; total: number }>;
  load: CustomEvent<{ name: string; splatCount: number }>;
  'first-picture': CustomEvent<{ renderer: string }>;
  error: CustomEvent<{ message: string; code: string }>;
  'device-lost': CustomEvent<void>;
  'device-restored': CustomEvent<void>;
}

/** `<doppel-avatar>`. Attributes: src, clip, autoplay, auto-rotate, camera-controls, poster, module, alt, renderer. */
export class DoppelAvatarElement extends HTMLElement {
  readonly person: Doppel | null;
  readonly paused: boolean;
  /** Seconds from the start of the clip. */
  currentTime: number;
  /** 'WebGL2 RGBA16F', 'WebGL2 RGBA8' or 'CPU'; '' before the first picture. */
  readonly drawnBy: string;
  /** The last picture: premultiplied, 4 bytes a pixel, top row first. Null before the first one. */
  readPicture(): { width: number; height: number; rgba: Uint8ClampedArray } | null;
  play(): void;
  pause(): void;
  redraw(): void;
}

declare global {
  interface HTMLElementTagNameMap {
    'doppel-avatar': DoppelAvatarElement;
  }
}
