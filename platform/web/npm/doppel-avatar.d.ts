// SPDX-License-Identifier: Apache-2.0
import type { Doppel } from './doppel.js';

export interface DoppelAvatarEventMap {
  progress: CustomEvent<{ loaded: number; total: number }>;
  load: CustomEvent<{ name: string; splatCount: number }>;
  'first-picture': CustomEvent<void>;
  error: CustomEvent<{ message: string; code: string }>;
}

/** `<doppel-avatar>`. Attributes: src, clip, autoplay, auto-rotate, camera-controls, poster, module, alt. */
export class DoppelAvatarElement extends HTMLElement {
  readonly person: Doppel | null;
  readonly paused: boolean;
  /** Seconds from the start of the clip. */
  currentTime: number;
  play(): void;
  pause(): void;
  redraw(): void;
}

declare global {
  interface HTMLElementTagNameMap {
    'doppel-avatar': DoppelAvatarElement;
  }
}
